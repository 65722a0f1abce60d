"""Operations on lists of robots, in LLVM instructions: choose from them, and store the chosen ones."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from feasibee.engine.intrinsics import (
    BIT,
    INT,
    INTS,
    LANES,
    LONG,
    WORD,
    as_word,
    constants,
    declared,
    spread,
    vector_at,
)


@intrinsic
def store_few(
    _typing: Any, numbers: Any, first: Any, chosen: Any, target: Any, place: Any, same: Any, others: Any
) -> Any:
    """Store the chosen ones of the 8 numbers from ``first`` on, from ``place`` on; return how many these are.

    Store as often the number ``same`` in ``others``. What follows them in both targets is lost.
    """
    kinds = numbers, types.int64, types.uint32, target, types.int64, types.int32, others
    return types.int64(*kinds), storing(LANES)


@intrinsic
def store_many(
    _typing: Any, numbers: Any, first: Any, chosen: Any, target: Any, place: Any, same: Any, others: Any
) -> Any:
    """Store of 32 numbers what `store_few` stores of 8."""
    kinds = numbers, types.int64, types.uint32, target, types.int64, types.int32, others
    return types.int64(*kinds), storing(WORD)


@intrinsic
def store_members(
    _typing: Any, who: Any, numbers: Any, place: Any, robot: Any, members: Any, first: Any
) -> Any:
    """Store the members of a word, whose lowest has number ``first``; return how many these are.

    The robot is written to 32 entries of ``who``, whatever their number.
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        words, truths = ir.VectorType(INT, WORD), ir.VectorType(BIT, WORD)
        who, target = (
            builder.gep(context.make_array(kind)(context, builder, each).data, [arguments[2]])
            for kind, each in zip(signature.args[:2], arguments[:2], strict=True)
        )
        same = spread(builder, arguments[3], words)
        builder.store(same, builder.bitcast(who, words.as_pointer()), align=4)
        numbers = builder.add(constants(words, range(WORD)), spread(builder, arguments[5], words))
        kind = ir.FunctionType(ir.VoidType(), [words, INT.as_pointer(), truths])
        store = declared(builder.module, kind, f"llvm.masked.compressstore.v{WORD}i32")
        builder.call(store, [numbers, target, builder.bitcast(arguments[4], truths)])
        return builder.zext(builder.ctpop(arguments[4]), LONG)

    return types.int64(who, numbers, types.int64, types.int32, types.uint32, types.int32), generate


def storing(count: int) -> Any:
    """Return the generator of an intrinsic that stores the chosen ones of ``count`` numbers."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        words, truths = ir.VectorType(INT, count), ir.VectorType(BIT, count)
        source, target, others = (
            context.make_array(signature.args[k])(context, builder, arguments[k]).data for k in (0, 3, 6)
        )
        found = vector_at(builder, source, arguments[1], words)
        bits = arguments[2] if count == WORD else builder.trunc(arguments[2], ir.IntType(count))
        kind = ir.FunctionType(ir.VoidType(), [words, INT.as_pointer(), truths])
        store = declared(builder.module, kind, f"llvm.masked.compressstore.v{count}i32")
        builder.call(store, [found, builder.gep(target, [arguments[4]]), builder.bitcast(bits, truths)])
        # One store of all: LLVM leaves a loop of stores as it is.
        start = builder.bitcast(builder.gep(others, [arguments[4]]), words.as_pointer())
        builder.store(spread(builder, arguments[5], words), start, align=4)
        return builder.zext(builder.ctpop(bits), LONG)

    return generate


@intrinsic
def few_odd(_typing: Any, numbers: Any, first: Any, other: Any) -> Any:
    """Return which of the 8 numbers from ``first`` on are odd and not a certain one."""
    return types.uint32(numbers, types.int64, types.int32), odd_numbers(LANES)


@intrinsic
def many_odd(_typing: Any, numbers: Any, first: Any, other: Any) -> Any:
    """Return of 32 numbers what `few_odd` returns of 8."""
    return types.uint32(numbers, types.int64, types.int32), odd_numbers(WORD)


def odd_numbers(count: int) -> Any:
    """Return the generator of an intrinsic: the set of odd numbers but one."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        words = ir.VectorType(INT, count)
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        found = vector_at(builder, data, arguments[1], words)
        differs = builder.icmp_unsigned("!=", found, spread(builder, arguments[2], words))
        return as_word(builder, builder.and_(differs, builder.trunc(found, ir.VectorType(BIT, count))))

    return generate


@intrinsic
def same_or_free(_typing: Any, labels: Any, first: Any, number: Any) -> Any:
    """Return which of 8 labels have a number, as bits 0 to 7, and which are negative, as the next 8 bits."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        found, two = vector_at(builder, data, arguments[1], INTS), spread(builder, INT(2), INTS)
        same = builder.icmp_signed("==", builder.ashr(found, two), spread(builder, arguments[2], INTS))
        free = builder.icmp_signed("<", found, ir.Constant(INTS, None))
        return builder.or_(as_word(builder, same), builder.shl(as_word(builder, free), INT(LANES)))

    return types.uint32(labels, types.int64, types.int32), generate

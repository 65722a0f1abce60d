"""Operations on lists of robots, in LLVM instructions: choose from them, and store the chosen ones."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types

from feasibee.engine.intrinsics import (
    ARRAY,
    BIT,
    INT,
    INTS,
    LANES,
    LONG,
    WORD,
    as_word,
    constants,
    declared,
    instruction,
    spread,
    vector_at,
)

PIECE = 16
"""Numbers that a register of 512 bits compresses."""


def compress(builder: Any, numbers: Any, chosen: Any, target: Any) -> Any:
    """Store the chosen ones of a vector's numbers one after another; return how many these are.

    Whole registers are stored, with anything behind the chosen ones: processors of AMD take 100 cycles to
    compress into memory.
    """
    count, lanes, stored = numbers.type.count, min(numbers.type.count, PIECE), LONG(0)
    piece, truths, word = ir.VectorType(INT, lanes), ir.VectorType(BIT, lanes), ir.IntType(lanes)
    kind = ir.FunctionType(piece, [piece, truths, piece])
    packed = declared(builder.module, kind, f"llvm.experimental.vector.compress.v{lanes}i32")
    for first in range(0, count, lanes):
        some = builder.shuffle_vector(numbers, numbers, constants(piece, range(first, first + lanes)))
        bits = builder.trunc(builder.lshr(chosen, INT(first)), word)
        found = builder.call(packed, [some, builder.bitcast(bits, truths), ir.Constant(piece, ir.Undefined)])
        builder.store(found, builder.bitcast(builder.gep(target, [stored]), piece.as_pointer()), align=4)
        stored = builder.add(stored, builder.zext(builder.ctpop(bits), LONG))
    return stored


def repeat(builder: Any, number: Any, words: Any, target: Any) -> None:
    """Store a number in all lanes of a vector: LLVM would leave a loop of stores as it is."""
    builder.store(spread(builder, number, words), builder.bitcast(target, words.as_pointer()), align=4)


def storing(count: int) -> Any:
    """Return an instruction: store the chosen ones of ``count`` numbers from ``first`` on, from ``place`` on.

    It stores as often the number ``same`` in ``others``, and returns how many these are. What follows them in
    both targets is lost.
    """

    def build(
        builder: Any, numbers: Any, first: Any, chosen: Any, target: Any, place: Any, same: Any, others: Any
    ) -> Any:
        found = vector_at(builder, numbers, first, ir.VectorType(INT, count))
        stored = compress(builder, found, chosen, builder.gep(target, [place]))
        repeat(builder, same, found.type, builder.gep(others, [place]))
        return stored

    kinds = ARRAY, types.int64, types.uint32, ARRAY, types.int64, types.int32, ARRAY
    return instruction(types.int64, *kinds)(build)


store_few, store_many = storing(LANES), storing(WORD)


@instruction(types.int64, ARRAY, ARRAY, types.int64, types.int32, types.uint32, types.int32)
def store_members(
    builder: Any, who: Any, numbers: Any, place: Any, robot: Any, members: Any, first: Any
) -> Any:
    """Store the members of a word, whose lowest has number ``first``; return how many these are.

    The robot is written to 32 entries of ``who``, whatever their number.
    """
    words = ir.VectorType(INT, WORD)
    repeat(builder, robot, words, builder.gep(who, [place]))
    listed = builder.add(constants(words, range(WORD)), spread(builder, first, words))
    return compress(builder, listed, members, builder.gep(numbers, [place]))


def odd_numbers(count: int) -> Any:
    """Return an instruction: which of ``count`` numbers from ``first`` on are odd and not a certain one."""

    def build(builder: Any, numbers: Any, first: Any, other: Any) -> Any:
        found = vector_at(builder, numbers, first, ir.VectorType(INT, count))
        differs = builder.icmp_unsigned("!=", found, spread(builder, other, found.type))
        return as_word(builder, builder.and_(differs, builder.trunc(found, ir.VectorType(BIT, count))))

    return instruction(types.uint32, ARRAY, types.int64, types.int32)(build)


few_odd, many_odd = odd_numbers(LANES), odd_numbers(WORD)


def other_robots(count: int) -> Any:
    """Return an instruction: which of ``count`` numbers from ``first`` on don't stand for a certain robot."""

    def build(builder: Any, numbers: Any, first: Any, robot: Any) -> Any:
        found = vector_at(builder, numbers, first, ir.VectorType(INT, count))
        places = builder.ashr(found, spread(builder, INT(1), found.type))
        return as_word(builder, builder.icmp_unsigned("!=", places, spread(builder, robot, found.type)))

    return instruction(types.uint32, ARRAY, types.int64, types.int32)(build)


few_others, many_others = other_robots(LANES), other_robots(WORD)


@instruction(types.uint32, ARRAY, types.int64, types.int32)
def same_or_free(builder: Any, labels: Any, first: Any, number: Any) -> Any:
    """Return which of 8 labels have a number, as bits 0 to 7, and which are negative, as the next 8 bits."""
    found, two = vector_at(builder, labels, first, INTS), spread(builder, INT(2), INTS)
    same = builder.icmp_signed("==", builder.ashr(found, two), spread(builder, number, INTS))
    free = builder.icmp_signed("<", found, ir.Constant(INTS, None))
    return builder.or_(as_word(builder, same), builder.shl(as_word(builder, free), INT(LANES)))

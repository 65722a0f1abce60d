"""Operations that processors have and Python lacks, as LLVM instructions; bits and sets of robots by name.

LLVM finds some of these in loops and shifts, but not everywhere, and only by long optimisation.

Robot i is bit i % 32 of word i // 32 of a set. A label holds a robot's number or id, the opinion that it
sends, and whether it broadcasts.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from functools import wraps
from typing import Any, Final

from llvmlite import ir
from numba import int32, int64, types, uint32, uint64
from numba.core import cgutils
from numba.core.datamodel import models
from numba.extending import intrinsic, lower_builtin, overload_method, register_model

from feasibee.engine.compile import inlined

BIT, INT, LONG = ir.IntType(1), ir.IntType(32), ir.IntType(64)
allocate: Any = cgutils.alloca_once
declared: Any = cgutils.get_or_insert_function
unpacked: Any = cgutils.unpack_tuple
WORD = 32  # robots in a set
LANES = 8  # 64-bit squared distances in a 512-bit register
INTS, LONGS = ir.VectorType(INT, LANES), ir.VectorType(LONG, LANES)


ARRAY: Final = None
"""Kind of an argument of `instruction`: an array of any type."""


def instruction(returned: Any, *kinds: Any) -> Callable[[Callable[..., Any]], Any]:
    """Let compiled code call a function that builds LLVM instructions.

    Parameters
    ----------
    returned : numba type
        Type of what it returns.
    *kinds : numba type or ARRAY
        Types of the arguments behind the builder; for an array, it is given a pointer to its data.
    """

    def decorate(build: Any) -> Any:
        @wraps(build)  # numba reads the names of the arguments from `build`
        def define(_typing: Any, *given: Any) -> Any:
            def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
                taken = [
                    context.make_array(kind)(context, builder, each).data
                    if isinstance(kind, types.Array)
                    else each
                    for kind, each in zip(signature.args, arguments, strict=True)
                ]
                return build(builder, *taken)

            return returned(*(each or kind for each, kind in zip(kinds, given, strict=True))), generate

        return intrinsic(define)

    return decorate


@instruction(types.int64, types.uint32)
def popcount(builder: Any, word: Any) -> Any:
    """Return the number of set bits of a 32-bit word."""
    return builder.zext(builder.ctpop(word), LONG)


@instruction(types.int64, types.int64)
def _ones(builder: Any, word: Any) -> Any:
    """Return the number of set bits of a 64-bit word."""
    return builder.ctpop(word)


@instruction(types.int64, types.int64)
def _digits(builder: Any, word: Any) -> Any:
    """Return the number of binary digits of a 64-bit word."""
    return builder.sub(LONG(64), builder.ctlz(word, BIT(0)))


@overload_method(types.Integer, "bit_count", inline="always")
def _bit_count(number):
    """Compile ``number.bit_count()``, which strategies may call, for up to 64 bits."""
    return lambda number: _ones(abs(int64(number)))


@overload_method(types.Integer, "bit_length", inline="always")
def _bit_length(number):
    """Compile ``number.bit_length()`` likewise."""
    return lambda number: _digits(abs(int64(number)))


class Row(types.Array):
    """An array with one axis, whose indices are 0 or more.

    numba tests the sign of each index, and counts from the end if it is negative. LLVM can't always tell that
    none is. It then takes words in a row for words anywhere: roster took 1.6 times as long.
    """


def _place(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    """Return the pointer to an entry of a `Row`."""
    row = context.make_array(kinds[0])(context, builder, arguments[0])
    return builder.gep(row.data, [context.cast(builder, arguments[1], kinds[1], types.int64)], inbounds=True)


def _read(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return builder.load(_place(context, builder, signature.args, arguments))


def _write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    row, _, kind = signature.args
    word = context.cast(builder, arguments[2], kind, row.dtype)
    return builder.store(word, _place(context, builder, signature.args, arguments))


register_model(Row)(models.ArrayModel)
lower_builtin(operator.getitem, Row, types.Integer)(_read)
lower_builtin(operator.setitem, Row, types.Integer, types.Integer)(_write)


@intrinsic
def row_of(_typing: Any, table: Any, k: Any, i: Any, length: Any) -> Any:
    """Return the first ``length`` entries of a row of a contiguous table with three axes.

    A slice also tests its bounds and counts from the end: 10 instructions for each axis.
    """
    return _row(types.Array(table.dtype, 1, "C"), table)


@intrinsic
def sure_row_of(_typing: Any, table: Any, k: Any, i: Any, length: Any) -> Any:
    """Return what `row_of` does, as a `Row`."""
    return _row(Row(table.dtype, 1, "C"), table)


def _row(kind: Any, table: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        whole = context.make_array(signature.args[0])(context, builder, arguments[0])
        _, rows, columns = unpacked(builder, whole.shape)
        place = builder.mul(builder.add(builder.mul(arguments[1], rows), arguments[2]), columns)
        row = context.make_array(kind)(context, builder)
        context.populate_array(
            row,
            data=builder.gep(whole.data, [place]),
            shape=[arguments[3]],
            strides=[whole.itemsize],
            itemsize=whole.itemsize,
            meminfo=None,
        )
        return row._getvalue()

    return kind(table, types.int64, types.int64, types.int64), generate


@intrinsic(prefer_literal=True)
def tuple_of(_typing: Any, row: Any, length: Any) -> Any:
    """Return the first entries of an array as a tuple."""
    kind = types.UniTuple(row.dtype, length.literal_value)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        entries = [builder.load(builder.gep(data, [INT(k)])) for k in range(kind.count)]
        return context.make_tuple(builder, kind, entries)

    return kind(row, length), generate


@instruction(types.int64, types.uint32)
def lowest(builder: Any, word: Any) -> Any:
    """Return the place of the lowest set bit; the word isn't 0."""
    return builder.zext(builder.cttz(word, BIT(1)), LONG)


@instruction(types.int64, types.float64)
def bits_of(builder: Any, number: Any) -> Any:
    """Return the 64 bits of a float."""
    return builder.bitcast(number, LONG)


@instruction(types.float64, types.int64)
def float_of(builder: Any, bits: Any) -> Any:
    """Return the float of 64 bits."""
    return builder.bitcast(bits, ir.DoubleType())


def square_on_square(builder: Any, centre: Any, coordinates: Any, side: Any) -> Any:
    """Return squared differences in 32 bits, which wrap by themselves."""
    wide = builder.sext(builder.sub(spread(builder, centre, INTS), coordinates), LONGS)
    return builder.mul(wide, wide)


def square_on_rectangle(builder: Any, centre: Any, coordinates: Any, side: Any) -> Any:
    """Return squared differences on a torus whose sides differ, the short way round."""
    ahead = builder.sub(builder.zext(coordinates, LONGS), builder.zext(spread(builder, centre, INTS), LONGS))
    back = builder.neg(ahead)
    straight = builder.select(builder.icmp_signed(">", ahead, back), ahead, back)
    around = builder.sub(spread(builder, side, LONGS), straight)
    way = builder.select(builder.icmp_signed("<", straight, around), straight, around)
    # At most half a side: LLVM takes a faster product of numbers that it knows to fit in 32 bits.
    way = builder.zext(builder.trunc(way, INTS), LONGS)
    return builder.mul(way, way)


POINTS: Final = ARRAY, ARRAY, types.int64, types.int32, types.int32, types.uint64, types.int64, types.int64


def near_points(count: int, square: Any) -> Any:
    """Return an instruction: which of ``count`` points from ``first`` on are nearer than a squared limit."""

    def build(
        builder: Any, xs: Any, ys: Any, first: Any, x: Any, y: Any, limit: Any, width: Any, height: Any
    ) -> Any:
        limits, near = spread(builder, limit, LONGS), INT(0)
        for lane in range(0, count, LANES):
            start = builder.add(first, LONG(lane))
            squares = [
                square(builder, centre, vector_at(builder, data, start, INTS), side)
                for data, centre, side in ((xs, x, width), (ys, y, height))
            ]
            some = builder.icmp_unsigned("<", builder.add(*squares), limits)
            near = builder.or_(near, builder.shl(as_word(builder, some), INT(lane)))
        return near

    return instruction(types.uint32, *POINTS)(build)


within, few_within = (near_points(count, square_on_square) for count in (WORD, LANES))
"""Return the set of the 32 or 8 points from a first one on that are near; differences wrap in 32 bits."""
within_on, few_within_on = (near_points(count, square_on_rectangle) for count in (WORD, LANES))
"""Return the same sets on a torus whose sides differ: there 32 bits don't wrap by themselves.

A loop that LLVM vectorized itself cost a fifth more of a step.
"""


def vector_at(builder: Any, data: Any, place: Any, vector: Any) -> Any:
    """Return a vector of consecutive numbers."""
    return builder.load(builder.bitcast(builder.gep(data, [place]), vector.as_pointer()), align=4)


def spread(builder: Any, value: Any, vector: Any) -> Any:
    """Return a vector with the same value in all lanes."""
    one = builder.insert_element(ir.Constant(vector, ir.Undefined), value, INT(0))
    return builder.shuffle_vector(one, one, ir.Constant(ir.VectorType(INT, vector.count), None))


@instruction(
    types.boolean, ARRAY, ARRAY, ARRAY, types.int64, types.int64, types.int64, types.uint32, types.uint32
)
def find_near(
    builder: Any, xs: Any, ys: Any, sight: Any, first: Any, other: Any, count: Any, low: Any, width: Any
) -> Any:
    """Store which robots of a word are near each of another or the same word; return whether all are sure.

    ``first`` is the first robot of those whose sight is stored, and ``count`` of the others begin at
    ``other``. By 16 bits an axis: squared distances below ``low`` are near, those less than ``width`` above
    are in doubt.
    """
    words = ir.VectorType(INT, WORD)
    places, others = (
        upper_halves(builder, *(vector_at(builder, data, start, words) for data in (xs, ys)))
        for start in (first, other)
    )
    lows = spread(builder, low, words)
    stored, near, least = (allocate(builder, words) for _ in range(3))
    builder.store(others, stored)
    builder.store(ir.Constant(words, None), near)
    builder.store(constants(words, [-1] * WORD), least)
    with cgutils.for_range(builder, count) as loop:
        # The last robot first: each shift moves the robots before it to higher bits.
        robot = builder.sub(builder.sub(count, LONG(1)), loop.index)
        here = builder.load(builder.gep(builder.bitcast(stored, INT.as_pointer()), [robot]))
        beyond = builder.sub(squared_ways(builder, places, here), lows)
        builder.store(vector_call(builder, "umin", builder.load(least), beyond), least)
        # The highest bit of what is below ``low`` is 1.
        shifted = vector_call(builder, "fshl", builder.load(near), beyond, constants(words, [1] * WORD))
        builder.store(shifted, near)
    not_itself = constants(words, [~(1 << lane) for lane in range(WORD)])
    is_same = builder.icmp_unsigned("==", first, other)
    allowed = builder.select(is_same, not_itself, constants(words, [-1] * WORD))
    found = builder.bitcast(builder.gep(sight, [first]), words.as_pointer())
    builder.store(builder.and_(builder.load(near), allowed), found, align=4)
    doubtful = builder.icmp_unsigned("<", builder.load(least), spread(builder, width, words))
    return builder.icmp_unsigned("==", as_word(builder, doubtful), INT(0))


@instruction(types.uint64, ARRAY, types.int64, types.uint32, types.uint32, types.uint32)
def near_and_doubtful(builder: Any, places: Any, first: Any, place: Any, low: Any, width: Any) -> Any:
    """Return which of 16 places are near, in the lower bits, and which are in doubt, from bit 32 on."""
    squared = squared_ways(builder, vector_at(builder, places, first, ir.VectorType(INT, 16)), place)
    low = spread(builder, low, squared.type)
    near = builder.icmp_unsigned("<", squared, low)
    doubtful = builder.icmp_unsigned("<", builder.sub(squared, low), spread(builder, width, squared.type))
    sets = [builder.zext(as_word(builder, each), LONG) for each in (near, doubtful)]
    return builder.or_(sets[0], builder.shl(sets[1], LONG(WORD)))


@inlined
def within_roughly(places, first, place, low, width):
    """Return which of the 16 places from ``first`` on are near a place, and which are in doubt, as words."""
    both = near_and_doubtful(places, first, place, low, width)
    return uint32(both), uint32(both >> uint64(WORD))


def upper_halves(builder: Any, x: Any, y: Any) -> Any:
    """Return a vector of places, words of the upper 16 bits of x and, above them, of y."""
    half, upper = spread(builder, INT(16), x.type), spread(builder, INT(0xFFFF0000), x.type)
    return builder.or_(builder.lshr(x, half), builder.and_(y, upper))


def squared_ways(builder: Any, places: Any, here: Any) -> Any:
    """Return the squared distances of a vector of places from one; differences wrap in 16 bits.

    LLVM finds the instruction of x86 that adds two products of 16 bits: in this order, not if the axes are
    separated before they are multiplied.
    """
    words, shorts = places.type, ir.VectorType(ir.IntType(16), 2 * places.type.count)
    here = builder.bitcast(spread(builder, here, words), shorts)
    way = builder.sext(builder.sub(builder.bitcast(places, shorts), here), ir.VectorType(INT, shorts.count))
    products = builder.mul(way, way)
    x, y = (constants(words, range(axis, shorts.count, 2)) for axis in range(2))
    return builder.add(
        builder.shuffle_vector(products, products, x), builder.shuffle_vector(products, products, y)
    )


def vector_call(builder: Any, name: str, *arguments: Any) -> Any:
    """Call LLVM's own function of vectors."""
    kind = arguments[0].type
    function = ir.FunctionType(kind, [each.type for each in arguments])
    full_name = f"llvm.{name}.v{kind.count}i{kind.element.width}"
    return builder.call(declared(builder.module, function, full_name), arguments)


def constants(vector: Any, values: Any) -> Any:
    """Return a vector of constants."""
    return ir.Constant(vector, [vector.element(value) for value in values])


def as_word(builder: Any, truths: Any) -> Any:
    """Return a vector of up to 32 truths as a word."""
    bits = builder.bitcast(truths, ir.IntType(truths.type.count))
    return bits if truths.type.count == WORD else builder.zext(bits, INT)


@inlined
def bit(i):
    """Return the word in which only robot i's bit is set."""
    return uint32(uint32(1) << uint32(i & 31))


@inlined
def has_bit(word, i):
    """Return whether robot i's bit is set in its word."""
    return uint32(word >> uint32(i & 31)) & uint32(1) == uint32(1)


@inlined
def bit_if(member, i):
    """Return robot i's bit if it is a member, else the empty word."""
    return uint32(uint32(member) << uint32(i & 31))


@inlined
def without_lowest(word):
    """Return a word without its lowest set bit."""
    return uint32(word & uint32(word - uint32(1)))


@inlined
def first_bits(count):
    """Return the word of the first ``count`` robots of 32, or of all of them."""
    return uint32((uint64(1) << uint64(min(count, 32))) - uint64(1))


@inlined
def lowest_member(w, word):
    """Return the number of the first robot in word ``w`` of a set; the word isn't 0."""
    return int64(32 * w + lowest(word))


@inlined
def contains(words, i):
    """Return whether a set has robot i."""
    return has_bit(words[i >> 5], i)


@inlined
def set_member(sets, kind, i, member):
    """Put robot i in a set, or remove it."""
    if member:
        sets[kind, i >> 5] |= bit(i)
    else:
        sets[kind, i >> 5] &= ~bit(i)


@inlined
def pack_label(robot, feasible, speaks):
    """Return a label: the opinion sent is bit 1, whether it is sent bit 0, and the robot is above."""
    return int32(robot << 2) | int32(feasible) << int32(1) | int32(speaks)


@inlined
def number_of(label):
    """Return the number of a robot by its label."""
    return int64(label >> int32(2))


@inlined
def sender_of(message):
    """Return the robot, or id, in the label that a message has."""
    return int64(message >> int32(2))


@inlined
def says_feasible(label):
    """Return whether the opinion in a label is *feasible*, as 1 or 0."""
    return int64(label >> int32(1)) & 1


@inlined
def place_of(numbered):
    """Return the place of a robot in the arrays, by what stands for it in the cells."""
    return int64(numbered >> int32(1))

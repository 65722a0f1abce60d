"""Operations that processors have and Python lacks, written as LLVM instructions.

LLVM finds some of these in loops and shifts, but not everywhere, and only by long optimisation.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import int64, types
from numba.core import cgutils
from numba.extending import intrinsic, overload_method

BIT, INT, LONG = ir.IntType(1), ir.IntType(32), ir.IntType(64)
as_tuple: Any = types.Tuple
unpacked: Any = cgutils.unpack_tuple
LANES = 8  # 64-bit squared distances in a 512-bit register
INTS, LONGS = ir.VectorType(INT, LANES), ir.VectorType(LONG, LANES)


@intrinsic
def popcount(_typing: Any, word: Any) -> Any:
    """Return the number of set bits of a 32-bit word."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.zext(builder.ctpop(arguments[0]), LONG)

    return types.int64(types.uint32), generate


@intrinsic
def _ones(_typing: Any, word: Any) -> Any:
    """Return the number of set bits of a 64-bit word."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.ctpop(arguments[0])

    return types.int64(types.int64), generate


@intrinsic
def _digits(_typing: Any, word: Any) -> Any:
    """Return the number of binary digits of a 64-bit word."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.sub(LONG(64), builder.ctlz(arguments[0], BIT(0)))

    return types.int64(types.int64), generate


@overload_method(types.Integer, "bit_count", inline="always")
def _bit_count(number):  # type: ignore[no-untyped-def]  # numba compares it with what it returns
    """Compile ``number.bit_count()``, which strategies may call, for up to 64 bits."""
    return lambda number: _ones(abs(int64(number)))  # type: ignore[call-arg,arg-type]


@overload_method(types.Integer, "bit_length", inline="always")
def _bit_length(number):  # type: ignore[no-untyped-def]
    """Compile ``number.bit_length()`` likewise."""
    return lambda number: _digits(abs(int64(number)))  # type: ignore[call-arg,arg-type]


@intrinsic
def row_of(_typing: Any, table: Any, k: Any, i: Any, length: Any) -> Any:
    """Return the first ``length`` entries of a row of a contiguous table with three axes.

    A slice also tests its bounds and counts from the end: 10 instructions for each axis.
    """
    kind = types.Array(table.dtype, 1, "C")

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


@intrinsic
def lowest(_typing: Any, word: Any) -> Any:
    """Return the place of the lowest set bit; the word isn't 0."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.zext(builder.cttz(arguments[0], BIT(1)), LONG)

    return types.int64(types.uint32), generate


@intrinsic
def bits_of(_typing: Any, number: Any) -> Any:
    """Return the 64 bits of a float."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.bitcast(arguments[0], LONG)

    return types.int64(types.float64), generate


@intrinsic
def float_of(_typing: Any, bits: Any) -> Any:
    """Return the float of 64 bits."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.bitcast(arguments[0], ir.DoubleType())

    return types.float64(types.int64), generate


@intrinsic
def within(_typing: Any, xs: Any, ys: Any, first: Any, x: Any, y: Any, limit: Any) -> Any:
    """Return the set of the 32 points from ``first`` on whose squared distance is below ``limit``.

    Differences are taken in 32 bits, so that they wrap.
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        def square(coordinates: Any, axis: int) -> Any:
            centre = spread(builder, arguments[3 + axis], INTS)
            wide = builder.sext(builder.sub(centre, coordinates), LONGS)
            return builder.mul(wide, wide)

        return near_points(context, builder, signature.args, arguments, square)

    return types.uint32(xs, ys, types.int64, types.int32, types.int32, types.uint64), generate


@intrinsic
def within_on(_typing: Any, xs: Any, ys: Any, first: Any, x: Any, y: Any, limit: Any, sides: Any) -> Any:
    """Return the set that `within` returns, on a torus whose sides differ.

    There 32 bits don't wrap by themselves. A loop that LLVM vectorized itself cost a fifth more of a step.
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        def square(coordinates: Any, axis: int) -> Any:
            centre = builder.zext(spread(builder, arguments[3 + axis], INTS), LONGS)
            side = spread(builder, builder.extract_value(arguments[6], axis), LONGS)
            ahead = builder.sub(builder.zext(coordinates, LONGS), centre)
            back = builder.neg(ahead)
            straight = builder.select(builder.icmp_signed(">", ahead, back), ahead, back)
            around = builder.sub(side, straight)
            way = builder.select(builder.icmp_signed("<", straight, around), straight, around)
            # At most half a side: LLVM takes a faster product of numbers that it knows to fit in 32 bits.
            way = builder.zext(builder.trunc(way, INTS), LONGS)
            return builder.mul(way, way)

        return near_points(context, builder, signature.args, arguments, square)

    pair = types.int64, types.int64
    return types.uint32(xs, ys, types.int64, types.int32, types.int32, types.uint64, as_tuple(pair)), generate


def near_points(context: Any, builder: Any, kinds: Any, arguments: Any, square: Any) -> Any:
    """Return the set of 32 points for which the sum of both axes' ``square`` is below a limit."""
    first, limit = arguments[2], arguments[5]
    axes = [
        context.make_array(kind)(context, builder, value).data
        for kind, value in zip(kinds[:2], arguments[:2], strict=True)
    ]
    limits = spread(builder, limit, LONGS)
    near = INT(0)
    for lane in range(0, 32, LANES):
        start = builder.add(first, LONG(lane))
        squares = [square(stretch(builder, data, start), axis) for axis, data in enumerate(axes)]
        some = builder.icmp_unsigned("<", builder.add(*squares), limits)
        bits = builder.zext(builder.bitcast(some, ir.IntType(LANES)), INT)
        near = builder.or_(near, builder.shl(bits, INT(lane)))
    return near


def stretch(builder: Any, data: Any, start: Any) -> Any:
    """Return a vector of consecutive coordinates."""
    return builder.load(builder.bitcast(builder.gep(data, [start]), INTS.as_pointer()), align=4)


def spread(builder: Any, value: Any, vector: Any) -> Any:
    """Return a vector with the same value in all lanes."""
    one = builder.insert_element(ir.Constant(vector, ir.Undefined), value, INT(0))
    return builder.shuffle_vector(one, one, ir.Constant(INTS, None))

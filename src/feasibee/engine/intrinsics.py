"""Operations that processors have and Python lacks, written as LLVM instructions.

LLVM finds some of these in loops and shifts, but not everywhere, and only by long optimisation.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import int64, types
from numba.extending import intrinsic, overload_method

BIT, INT, LONG = ir.IntType(1), ir.IntType(32), ir.IntType(64)
as_tuple: Any = types.Tuple
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
def lowest(_typing: Any, word: Any) -> Any:
    """Return the place of the lowest set bit; the word isn't 0."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.zext(builder.cttz(arguments[0], BIT(1)), LONG)

    return types.int64(types.uint32), generate


def square_on_square(builder: Any, centre: Any, coordinates: Any, side: Any) -> Any:
    """Return squared differences in 32 bits, which wrap by themselves."""
    wide = builder.sext(builder.sub(spread(builder, centre, INTS), coordinates), LONGS)
    return builder.mul(wide, wide)


def square_on_rectangle(builder: Any, centre: Any, coordinates: Any, side: Any) -> Any:
    """Return squared differences on a torus whose sides differ, the short way round."""
    ahead = builder.sub(
        builder.zext(coordinates, LONGS), builder.zext(spread(builder, centre, INTS), LONGS)
    )
    back = builder.neg(ahead)
    straight = builder.select(builder.icmp_signed(">", ahead, back), ahead, back)
    around = builder.sub(spread(builder, side, LONGS), straight)
    way = builder.select(builder.icmp_signed("<", straight, around), straight, around)
    # At most half a side: LLVM takes a faster product of numbers that it knows to fit in 32 bits.
    way = builder.zext(builder.trunc(way, INTS), LONGS)
    return builder.mul(way, way)


def near_points(points: int, square: Any) -> Any:
    """Return the generator of an intrinsic: the set of points with squared distances below a limit."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        first, centre, limit, sides = arguments[2], arguments[3:5], arguments[5], arguments[6:]
        axes = [
            context.make_array(kind)(context, builder, value).data
            for kind, value in zip(signature.args[:2], arguments[:2], strict=True)
        ]
        limits = spread(builder, limit, LONGS)
        near = INT(0)
        for lane in range(0, points, LANES):
            start = builder.add(first, LONG(lane))
            squares = [
                square(builder, centre[axis], stretch(builder, data, start), sides and sides[axis])
                for axis, data in enumerate(axes)
            ]
            some = builder.icmp_unsigned("<", builder.add(*squares), limits)
            bits = builder.zext(builder.bitcast(some, ir.IntType(LANES)), INT)
            near = builder.or_(near, builder.shl(bits, INT(lane)))
        return near

    return generate


@intrinsic
def within(_typing: Any, xs: Any, ys: Any, first: Any, x: Any, y: Any, limit: Any) -> Any:
    """Return the set of the 32 points from ``first`` on whose squared distance is below ``limit``.

    Differences are taken in 32 bits, so that they wrap.
    """
    kinds = types.int64, types.int32, types.int32, types.uint64
    return types.uint32(xs, ys, *kinds), near_points(32, square_on_square)


@intrinsic
def few_within(_typing: Any, xs: Any, ys: Any, first: Any, x: Any, y: Any, limit: Any) -> Any:
    """Return the set that `within` returns, of 8 points."""
    kinds = types.int64, types.int32, types.int32, types.uint64
    return types.uint32(xs, ys, *kinds), near_points(LANES, square_on_square)


@intrinsic
def within_on(
    _typing: Any, xs: Any, ys: Any, first: Any, x: Any, y: Any, limit: Any, width: Any, height: Any
) -> Any:
    """Return the set that `within` returns, on a torus whose sides differ.

    There 32 bits don't wrap by themselves. A loop that LLVM vectorized itself cost a fifth more of a step.
    """
    kinds = types.int64, types.int32, types.int32, types.uint64, types.int64, types.int64
    return types.uint32(xs, ys, *kinds), near_points(32, square_on_rectangle)


@intrinsic
def few_within_on(
    _typing: Any, xs: Any, ys: Any, first: Any, x: Any, y: Any, limit: Any, width: Any, height: Any
) -> Any:
    """Return the set that `within_on` returns, of 8 points."""
    kinds = types.int64, types.int32, types.int32, types.uint64, types.int64, types.int64
    return types.uint32(xs, ys, *kinds), near_points(LANES, square_on_rectangle)


@intrinsic
def few_odd(_typing: Any, numbers: Any, first: Any) -> Any:
    """Return which of the 8 numbers from ``first`` on are odd."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        odd = builder.trunc(stretch(builder, data, arguments[1]), ir.VectorType(BIT, LANES))
        return builder.zext(builder.bitcast(odd, ir.IntType(LANES)), INT)

    return types.uint32(numbers, types.int64), generate


def stretch(builder: Any, data: Any, start: Any) -> Any:
    """Return a vector of consecutive coordinates."""
    return builder.load(builder.bitcast(builder.gep(data, [start]), INTS.as_pointer()), align=4)


def spread(builder: Any, value: Any, vector: Any) -> Any:
    """Return a vector with the same value in all lanes."""
    one = builder.insert_element(ir.Constant(vector, ir.Undefined), value, INT(0))
    return builder.shuffle_vector(one, one, ir.Constant(INTS, None))


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

"""What a processor does in few instructions and Python has no words for, written as LLVM's own.

LLVM would find these in loops and shifts, but not everywhere, and only by long optimisation.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

BIT, INT, LONG = ir.IntType(1), ir.IntType(32), ir.IntType(64)
LANES = 8  # as many squared distances as fit in the widest registers
INTS, LONGS = ir.VectorType(INT, LANES), ir.VectorType(LONG, LANES)


@intrinsic
def popcount(_typing: Any, word: Any) -> Any:
    """Return the number of set bits of a 32-bit word."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.zext(builder.ctpop(arguments[0]), LONG)

    return types.int64(types.uint32), generate


@intrinsic
def lowest(_typing: Any, word: Any) -> Any:
    """Return the place of the lowest set bit; the word isn't 0."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.zext(builder.cttz(arguments[0], BIT(1)), LONG)

    return types.int64(types.uint32), generate


@intrinsic
def within(_typing: Any, xs: Any, ys: Any, first: Any, x: Any, y: Any, limit: Any) -> Any:
    """Return the set of those of the 32 points from ``first`` on whose squared distance is below ``limit``.

    Differences are taken in 32 bits, so that they wrap.
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        first, x, y, limit = arguments[2:]
        axes = [
            (context.make_array(array)(context, builder, value).data, spread(builder, centre, INTS))
            for array, value, centre in ((xs, arguments[0], x), (ys, arguments[1], y))
        ]
        limits = spread(builder, limit, LONGS)
        near = INT(0)
        for lane in range(0, 32, LANES):
            start = builder.add(first, LONG(lane))
            squares = [square(builder, builder.gep(data, [start]), centre) for data, centre in axes]
            some = builder.icmp_unsigned("<", builder.add(*squares), limits)
            bits = builder.zext(builder.bitcast(some, ir.IntType(LANES)), INT)
            near = builder.or_(near, builder.shl(bits, INT(lane)))
        return near

    return types.uint32(xs, ys, types.int64, types.int32, types.int32, types.uint64), generate


def square(builder: Any, start: Any, centre: Any) -> Any:
    """Return the squared differences of a stretch of coordinates from a place."""
    coordinates = builder.load(builder.bitcast(start, INTS.as_pointer()), align=4)
    wide = builder.sext(builder.sub(centre, coordinates), LONGS)
    return builder.mul(wide, wide)


def spread(builder: Any, value: Any, vector: Any) -> Any:
    """Return a vector with the same value in all lanes."""
    one = builder.insert_element(ir.Constant(vector, ir.Undefined), value, INT(0))
    return builder.shuffle_vector(one, one, ir.Constant(INTS, None))

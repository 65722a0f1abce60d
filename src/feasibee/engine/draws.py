"""Random numbers as coordinates, and the quantities drawn from them.

A draw is Philox4x32-10 of the key (seed) and the counter (number of the draw, robot, run, purpose). There is
no generator and no state. Headings use IEEE sums and products only, so they are the same on every platform
that follows IEEE 754. The logarithm of a duration is rounded up to whole steps, which hides its last bit.

References
----------
Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC 2011.
"""

from __future__ import annotations

import math

from numba import float64, int32, int64, uint32, uint64

from feasibee.engine.compile import called, inlined
from feasibee.engine.layout import Clock
from feasibee.model.codes import LONGEST


@inlined
def rounds(counter0, counter1, counter2, counter3, key0, key1):
    """Return the four 32-bit words of Philox4x32-10 (Salmon et al., section 4.3).

    In words of 64 bits, of which a processor multiplies several at once.
    """
    mask = uint64(0xFFFFFFFF)
    c0, c1 = uint64(uint32(counter0)), uint64(uint32(counter1))
    c2, c3 = uint64(uint32(counter2)), uint64(uint32(counter3))
    k0, k1 = uint64(uint32(key0)), uint64(uint32(key1))
    for _ in range(10):
        product0 = c0 * uint64(0xD2511F53)
        product1 = c2 * uint64(0xCD9E8D57)
        c0, c1, c2, c3 = (
            (product1 >> uint64(32)) ^ c1 ^ k0,
            product1 & mask,
            (product0 >> uint64(32)) ^ c3 ^ k1,
            product0 & mask,
        )
        k0 = (k0 + uint64(0x9E3779B9)) & mask
        k1 = (k1 + uint64(0xBB67AE85)) & mask
    return uint32(c0), uint32(c1), uint32(c2), uint32(c3)


@called
def philox(counter0, counter1, counter2, counter3, key0, key1):
    """Return the words of `rounds`, by a call."""
    return rounds(counter0, counter1, counter2, counter3, key0, key1)


@called
def duration(word, mean):
    """Return max(1, ceil(x)) for the exponential x = -mean log u, u = (word + 1) / 2**32 (model.md 3.4)."""
    length = -mean * math.log((float64(word) + 1.0) * (1.0 / 4294967296.0))
    return int32(max(1.0, math.ceil(min(length, float64(LONGEST)))))


@inlined
def direction(word):
    """Return cosine and sine of the angle 2 pi word / 2**32.

    The angle is taken to the nearest quarter turn; what is left, at most pi / 4, goes through the Taylor
    polynomials of degree 16 and 17 in nested form, whose error there is below the last bit. There is no
    branch, so that a loop computes several at once.
    """
    shifted = uint32(word + uint32(1 << 29))
    quarter = int64(shifted >> uint32(30))
    rest = float64(int64(shifted & uint32((1 << 30) - 1))) - 536870912.0
    x = rest * (0.5 * math.pi / 1073741824.0)
    z = x * x
    sine = 1.0 - z * (1.0 / 272.0)
    sine = 1.0 - z * (1.0 / 210.0) * sine
    sine = 1.0 - z * (1.0 / 156.0) * sine
    sine = 1.0 - z * (1.0 / 110.0) * sine
    sine = 1.0 - z * (1.0 / 72.0) * sine
    sine = 1.0 - z * (1.0 / 42.0) * sine
    sine = 1.0 - z * (1.0 / 20.0) * sine
    sine = 1.0 - z * (1.0 / 6.0) * sine
    sine = x * sine
    cosine = 1.0 - z * (1.0 / 240.0)
    cosine = 1.0 - z * (1.0 / 182.0) * cosine
    cosine = 1.0 - z * (1.0 / 132.0) * cosine
    cosine = 1.0 - z * (1.0 / 90.0) * cosine
    cosine = 1.0 - z * (1.0 / 56.0) * cosine
    cosine = 1.0 - z * (1.0 / 30.0) * cosine
    cosine = 1.0 - z * (1.0 / 12.0) * cosine
    cosine = 1.0 - z * (1.0 / 2.0) * cosine
    across = sine if quarter & 1 else cosine
    up = cosine if quarter & 1 else sine
    return -across if (quarter + 1) & 2 else across, -up if quarter & 2 else up


@inlined
def draw_words(params, run, robot, counter, purpose):
    """Return the four words of the draw at a coordinate."""
    key = params.seed
    return philox(int64(counter), int64(robot), int64(run), int64(purpose), key.low, key.high)


@inlined
def draw(params, run, robot, counter, purpose):
    """Return the first word of the draw at a coordinate."""
    return draw_words(params, run, robot, counter, purpose)[0]


@inlined
def draw_now(params, state, robot, purpose):
    """Return the first word of a draw whose counter is the number of the present step."""
    return draw(params, state.clock[Clock.RUN], robot, state.clock[Clock.STEP] + 1, purpose)


@inlined
def coin(word):
    """Return 0 or 1 with equal probability."""
    return int64(word >> uint32(31))


@inlined
def choose(word, count):
    """Return a number below ``count``, uniformly."""
    return int64((uint64(word) * uint64(count)) >> uint64(32))


@called
def poisson(word, mean):
    """Return a Poisson number by inverting its distribution function."""
    number = 0
    probability = math.exp(-mean)
    below = probability
    while float64(word) >= below * 4294967296.0 and number < 200:
        number += 1
        probability = probability * mean / number
        below = below + probability
    return number


@called
def shuffle(params, run, order, count, purpose):
    """Write 0 to ``count`` - 1 in random order (Fisher and Yates)."""
    for k in range(count):
        order[k] = k
    for k in range(count):
        other = k + choose(draw(params, run, 0, k, purpose), count - k)
        order[k], order[other] = order[other], order[k]

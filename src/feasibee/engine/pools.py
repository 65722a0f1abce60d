"""Pools of draws: a robot's next headings and phases, computed several at a time.

A draw is a coordinate, so drawing early changes no result. One draw is a chain of dependent operations;
eight together take about three times as long. Swarms of more than `POOLED` robots have no pools: there memory
costs more than arithmetic.

A logarithm to 12 digits suffices for nearly every duration. Where it leaves open to which whole step a
duration is rounded up, `duration` computes it by the platform's own.
"""

from __future__ import annotations

import math

from numba import float64, int32, int64, uint32

from feasibee.engine.compile import called, inlined
from feasibee.engine.draws import direction, draw_words, duration, rounds
from feasibee.engine.intrinsics import bits_of, float_of
from feasibee.engine.layout import POOL, Clock, Pool, Robot
from feasibee.model.codes import LONGEST
from feasibee.model.purposes import PHASE, WALK

LESS, MORE = 1.0 - 1e-12, 1.0 + 1e-12


@inlined
def draw_heading(params, state, i, number):
    """Return the steps along x and y and the duration of a robot's heading of some number (model.md 2.1)."""
    run = state.clock[Clock.RUN]
    if state.pools.shape[0] == 0:
        return compute_heading(params, run, i, number)
    place = number & (POOL - 1)
    if place == 0:
        fill_headings(params, state.pools, run, i, number, POOL)
    pool = state.pools[i]
    return int32(pool[Pool.STEP_X, place]), int32(pool[Pool.STEP_Y, place]), int32(pool[Pool.WALK, place])


@called
def compute_heading(params, run, i, number):
    """Return a heading and its duration, from its own draw."""
    words = draw_words(params, run, i, number, WALK)
    x, y = step_along(words[0], params.robots.reach)
    return int32(x), int32(y), duration(words[1], params.walk.mean_run)


@inlined
def step_along(word, reach):
    """Return a step of some length in a random direction, in whole units."""
    cosine, sine = direction(word)
    return math.floor(reach * cosine + 0.5), math.floor(reach * sine + 0.5)


@called
def fill_headings(params, pools, run, i, first, count):
    """Fill a robot's pool with its headings from ``first`` on.

    ``count`` is `POOL`, as an argument: LLVM unrolls a loop of known length instead of vectorizing it.
    """
    # Read once: the compiler must assume that writing to the pool changes them.
    reach, mean, low, high = params.robots.reach, params.walk.mean_run, params.seed.low, params.seed.high
    pool = pools[i]
    doubtful = int64(0)
    for k in range(count):
        words = rounds(first + k, i, run, WALK, low, high)
        pool[Pool.STEP_X, k], pool[Pool.STEP_Y, k] = step_along(words[0], reach)
        length = mean * exponential(words[1])
        least = rounded_up(length * LESS)
        pool[Pool.WALK, k] = least
        doubtful += int64(least != rounded_up(length * MORE))
    if doubtful > 0:
        for k in range(count):
            pool[Pool.WALK, k] = duration(draw_words(params, run, i, first + k, WALK)[1], mean)


@inlined
def rounded_up(length):
    """Return a duration in whole steps."""
    return max(1.0, float64(math.ceil(min(length, float64(LONGEST)))))


@inlined
def draw_phase(params, state, i):
    """Return the draw of a robot's present phase: the rows of `Pool` that are of a phase."""
    run, number = state.clock[Clock.RUN], int64(state.robots[Robot.PHASES, i])
    if state.pools.shape[0] == 0:
        words = draw_words(params, run, i, number, PHASE)
        return exponential(words[0]), words[1] * (1.0 / 4294967296.0), words[2]
    place = number & (POOL - 1)
    if place == 0:
        fill_phases(params, state.pools, run, i, number, POOL)
    pool = state.pools[i]
    return pool[Pool.LENGTH, place], pool[Pool.CHANCE, place], uint32(pool[Pool.TIE, place])


@called
def fill_phases(params, pools, run, i, first, count):
    """Fill a robot's pool with the draws of its phases from ``first`` on; see `fill_headings`."""
    low, high = params.seed.low, params.seed.high
    pool = pools[i]
    for k in range(count):
        words = rounds(first + k, i, run, PHASE, low, high)
        pool[Pool.LENGTH, k] = exponential(words[0])
        pool[Pool.CHANCE, k] = words[1] * (1.0 / 4294967296.0)
        pool[Pool.TIE, k] = words[2]


@inlined
def phase_duration(params, state, i, length, mean):
    """Return the duration of a robot's present phase from its exponential of mean 1, to 12 digits."""
    least = math.ceil(mean * length * LESS)
    if mean * length < float64(LONGEST) and least == math.ceil(mean * length * MORE):
        return int32(max(int64(1), least))
    word = draw_words(params, state.clock[Clock.RUN], i, state.robots[Robot.PHASES, i], PHASE)[0]
    return duration(word, mean)


@inlined
def exponential(word):
    """Return -log((word + 1) / 2**32) to 12 digits, without a branch.

    The logarithm of the number's binary exponent, and of the rest by 2 artanh((rest - 1) / (rest + 1)).
    """
    number = float64(int64(word)) + 1.0
    bits = bits_of(number)
    exponent = (bits - int64(0x3FE6A09E667F3BCD)) >> 52  # the rest is between the roots of 1/2 and 2
    rest = float_of(bits - (exponent << 52))
    s = (rest - 1.0) / (rest + 1.0)
    z = s * s
    artanh = 1.0 / 15.0
    artanh = artanh * z + 1.0 / 13.0
    artanh = artanh * z + 1.0 / 11.0
    artanh = artanh * z + 1.0 / 9.0
    artanh = artanh * z + 1.0 / 7.0
    artanh = artanh * z + 1.0 / 5.0
    artanh = artanh * z + 1.0 / 3.0
    artanh = artanh * z + 1.0
    return float64(32 - exponent) * 0.6931471805599453 - 2.0 * s * artanh

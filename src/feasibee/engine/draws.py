"""Random numbers as coordinates, and the quantities drawn from them, several at a time.

A draw is Philox4x32-10 of the key (seed) and the counter (number of the draw, robot, run, purpose). There is
no generator and no state. Headings use IEEE sums and products only, so they are the same on every platform
that follows IEEE 754. The logarithm of a duration is rounded up to whole steps, which hides its last bit.

A draw is a coordinate, so when it is computed changes no result. In a small swarm each robot has a pool of
its next draws of each kind. Eight together take about three times as long as one. In a swarm of more than
`POOLED` robots, memory costs more than arithmetic. There the robots whose heading or phase ends in a step
are listed, and draw together.

A logarithm to 12 digits suffices for nearly every duration. Where it leaves open to which whole step one is
rounded up, `duration` computes it by the platform's own.

References
----------
Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC 2011.
"""

from __future__ import annotations

import math

from numba import float64, int32, int64, uint32, uint64

from feasibee.engine.compile import called, inlined
from feasibee.engine.intrinsics import bits_of, float_of, lowest_member, number_of, without_lowest
from feasibee.engine.layout import BATCH, POOL, POOLED, WORD, Clock, Heard, Pool, Robot
from feasibee.model.codes import LONGEST
from feasibee.model.purposes import PHASE, WALK


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


LESS, MORE = 1.0 - 1e-12, 1.0 + 1e-12


@inlined
def is_pooled(params):
    """Return whether each robot has a pool."""
    return params.robots.count <= POOLED


@inlined
def list_members(state, thread, members, w, last):
    """List robots that draw, of the words of a set from ``w`` on; return the next word and their number."""
    listed, count = state.heard[thread, Heard.RECEIVER], int64(0)
    while w < last and count <= BATCH - WORD:
        left = members[w]
        while left:
            listed[uint64(count)] = int32(lowest_member(w, left))
            count += 1
            left = without_lowest(left)
        w += 1
    return w, count


@inlined
def draw_headings(params, state, thread, count):
    """Draw the next heading of each listed robot, unless they have pools."""
    if not is_pooled(params):
        list_coordinates(state, thread, state.robots[Robot.WALKS], count)
        fill_headings(params, state.pools[thread], state.heard[thread], state.clock[Clock.RUN], count)


@inlined
def draw_phases(params, state, thread, count):
    """Draw the present phase of each listed robot, unless they have pools."""
    if not is_pooled(params):
        list_coordinates(state, thread, state.robots[Robot.PHASES], count)
        fill_phases(params, state.pools[thread], state.heard[thread], state.clock[Clock.RUN], count)


@inlined
def list_coordinates(state, thread, counters, count):
    """List the coordinates of the draws of listed robots."""
    heard, labels = state.heard[thread], state.robots[Robot.LABEL]
    for k in range(count):
        i = uint64(heard[Heard.RECEIVER, k])
        heard[Heard.NUMBER, k] = int32(number_of(labels[i]))
        heard[Heard.COUNTER, k] = counters[i]


@inlined
def pool_of(params, state, thread, i, k, counters, fill):
    """Return the pool that holds a robot's draw, and the place in it; fill its own pool if that is empty.

    Without pools, the robot is that of entry ``k`` of those listed.
    """
    row, place = thread, k
    if is_pooled(params):
        first = int64(counters[i])
        row, place = int64(i), first & (POOL - 1)
        if place == 0:
            heard, count = state.heard[thread], state.pools.shape[2]
            for draw in range(count):  # `POOL`, but LLVM would unroll a known length instead of vectorizing
                heard[Heard.NUMBER, draw] = int32(i)
                heard[Heard.COUNTER, draw] = int32(first + draw)
            fill(params, state.pools[i], heard, state.clock[Clock.RUN], count)
    return state.pools[uint64(row)], uint64(place)


@called
def normal(params, run, i, counter, purpose, scale):
    """Return a nearly normal deviate with standard deviation ``scale``.

    It is the sum of the twelve words of three draws, less its mean.
    """
    total = int64(0)
    for part in range(3):
        words = draw_words(params, run, i, counter + part, purpose)
        total += int64(words[0]) + int64(words[1]) + int64(words[2]) + int64(words[3])
    return (((total - 6 * 4294967296) >> 8) * scale) >> 24


@inlined
def next_heading(params, state, thread, i, k):
    """Return the steps along x and y and the duration of a robot's next heading (model.md 2.1)."""
    pool, place = pool_of(params, state, thread, i, k, state.robots[Robot.WALKS], fill_headings)
    return int32(pool[Pool.STEP_X, place]), int32(pool[Pool.STEP_Y, place]), int32(pool[Pool.WALK, place])


@inlined
def present_phase(params, state, thread, i, k):
    """Return the draw of a robot's present phase: the rows of `Pool` that are of a phase."""
    pool, place = pool_of(params, state, thread, i, k, state.robots[Robot.PHASES], fill_phases)
    return pool[Pool.LENGTH, place], pool[Pool.CHANCE, place], uint32(pool[Pool.TIE, place])


@called
def fill_headings(params, pool, heard, run, count):
    """Draw the headings of ``count`` coordinates, and their durations."""
    # Read once: the compiler must assume that writing to the pool changes them.
    reach, mean, low, high = params.robots.reach, params.walk.mean_run, params.seed.low, params.seed.high
    numbers, counters = heard[Heard.NUMBER], heard[Heard.COUNTER]
    doubtful = int64(0)
    for k in range(count):
        words = rounds(counters[k], numbers[k], run, WALK, low, high)
        cosine, sine = direction(words[0])
        pool[Pool.STEP_X, k] = math.floor(reach * cosine + 0.5)
        pool[Pool.STEP_Y, k] = math.floor(reach * sine + 0.5)
        length = mean * exponential(words[1])
        least = rounded_up(length * LESS)
        pool[Pool.WALK, k] = least
        doubtful += int64(least != rounded_up(length * MORE))
    if doubtful > 0:
        for k in range(count):
            word = philox(int64(counters[k]), int64(numbers[k]), run, int64(WALK), low, high)[1]
            pool[Pool.WALK, k] = duration(word, mean)


@called
def fill_phases(params, pool, heard, run, count):
    """Draw the phases of ``count`` coordinates."""
    low, high = params.seed.low, params.seed.high
    numbers, counters = heard[Heard.NUMBER], heard[Heard.COUNTER]
    for k in range(count):
        words = rounds(counters[k], numbers[k], run, PHASE, low, high)
        pool[Pool.LENGTH, k] = exponential(words[0])
        pool[Pool.CHANCE, k] = words[1] * (1.0 / 4294967296.0)
        pool[Pool.TIE, k] = words[2]


@inlined
def phase_duration(params, state, i, length, mean):
    """Return the duration of a robot's present phase from its exponential of mean 1, to 12 digits."""
    length *= mean
    least = rounded_up(length * LESS)
    if length < float64(LONGEST) and least == rounded_up(length * MORE):
        return int32(least)
    run, number = state.clock[Clock.RUN], number_of(state.robots[Robot.LABEL, i])
    return duration(draw_words(params, run, number, state.robots[Robot.PHASES, i], PHASE)[0], mean)


@inlined
def rounded_up(length):
    """Return a duration in whole steps."""
    return max(1.0, float64(math.ceil(min(length, float64(LONGEST)))))


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

"""Random numbers: four words per coordinate, and the quantities drawn from them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction

from feasibee.base.codes import LONGEST, exact

TURN = 2**32
"""Number of words; as an angle, a full turn."""


def philox(seed: int, run: int, robot: int, counter: int, purpose: int) -> tuple[int, int, int, int]:
    """Return four random 32-bit words: Philox4x32-10 (Salmon et al., SC 2011, section 4.3)."""
    mask = 0xFFFFFFFF
    a, b, c, d = counter, robot, run, purpose
    low, high = seed & mask, seed >> 32
    for _ in range(10):
        left, right = a * 0xD2511F53, c * 0xCD9E8D57
        a, b, c, d = (right >> 32) ^ b ^ low, right & mask, (left >> 32) ^ d ^ high, left & mask
        low, high = (low + 0x9E3779B9) & mask, (high + 0xBB67AE85) & mask
    return a, b, c, d


def duration(word: int, mean: float) -> int:
    """Return an exponential duration in whole steps, at least 1 (model.md 3.4)."""
    uniform = (word + 1) / TURN
    return min(max(1, math.ceil(-mean * math.log(uniform))), LONGEST)


def cos_sin(heading: int) -> tuple[float, float]:
    """Return cosine and sine of a heading, 2**32 being a full turn.

    Not ``math.cos``: its last bit differs between platforms. This is Taylor's polynomial about the nearest
    quarter turn, innermost term first; its error is below the last bit.
    """
    quarter, rest = divmod(heading + TURN // 8, TURN // 4)
    angle = (rest - TURN // 8) * (math.pi / 2 / (TURN // 4))
    square = angle * angle
    sine = cosine = 1.0
    for k in range(16, 0, -2):
        sine = 1.0 - square * (1.0 / (k * (k + 1))) * sine
        cosine = 1.0 - square * (1.0 / (k * (k - 1))) * cosine
    sine *= angle
    return [(cosine, sine), (-sine, cosine), (-cosine, -sine), (sine, -cosine)][quarter % 4]


def happens(word: int, probability: float) -> bool:
    """Return whether an event of this probability happens; never for 0, always for 1."""
    return word < exact(probability) * TURN


def choose(word: int, count: int) -> int:
    """Return a number below ``count``, each as likely as the others."""
    return word * count // TURN


def poisson(word: int, mean: float) -> int:
    """Return a Poisson number by inversion of its distribution function."""
    number = 0
    probability = math.exp(-mean)
    below = probability
    while word >= below * TURN and number < 200:
        number += 1
        probability = probability * mean / number
        below = below + probability
    return number


def normal(words: Sequence[int], scale: int) -> int:
    """Return a normal deviation times a scale: the sum of twelve uniform words less its mean.

    Sums of whole numbers only, so that it is the same on every platform; never beyond six deviations.
    """
    return ((sum(words) - 6 * TURN) // 256) * scale // 2**24


def shuffle(count: int, draw: Callable[[int], int]) -> list[int]:
    """Return 0 to ``count`` - 1 in random order (Fisher and Yates); ``draw(k)`` gives the k-th word."""
    order = list(range(count))
    for k in range(count):
        other = k + choose(draw(k), count - k)
        order[k], order[other] = order[other], order[k]
    return order


def rounded(share: Fraction, count: int) -> int:
    """Return the whole number nearest to a share of a count; halves are rounded up."""
    return math.floor(share * count + Fraction(1, 2))

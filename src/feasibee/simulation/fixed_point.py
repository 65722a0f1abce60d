"""Lengths and probabilities of a scenario as the engine takes them: whole numbers."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from feasibee.engine.params import Band
from feasibee.model.codes import exact
from feasibee.scenario.scenario import Scenario

TURN = 2**32


def unit_of(scenario: Scenario) -> Fraction:
    """Return the unit of fixed point: the longer side is 2**32 of them on the torus, 2**31 within walls."""
    longer = max(exact(side) for side in scenario.arena.size)
    return longer / (TURN // 2 if scenario.arena.boundary == "walls" else TURN)


def fixed(length: float, unit: Fraction) -> int:
    """Return a length in whole units of fixed point, rounded down."""
    return math.floor(exact(length) / unit)


def squared(length: float, unit: Fraction) -> int:
    """Return the square of a length in units of fixed point, rounded down."""
    return math.floor((exact(length) / unit) ** 2)


def limit_of(squared: int) -> np.uint64:
    """Return a bound of squared distances; none is larger than 2**63."""
    return np.uint64(min(squared, 2**63 + 1))


def band_of(limit: int, shift: int) -> Band:
    """Return the squared distances that leave open whether a point is in range, without ``shift`` bits.

    A rounded coordinate is off by less than 1, a difference of two likewise, and a distance by less than 1.5.
    All points are in doubt for a range too short or too long for 16 bits.
    """
    reach = math.sqrt(limit) / 2**shift
    low = math.floor(max(reach - 1.5, 0) ** 2)
    high = math.ceil((reach + 1.5) ** 2)
    if low == 0 or high > TURN // 2:
        return Band(np.uint32(0), np.uint32(TURN - 1))
    return Band(np.uint32(low), np.uint32(min(high - low, TURN - 1)))


def probability(share: float) -> np.uint64:
    """Return a probability times 2**32; 1 for any above 0."""
    return np.uint64(math.ceil(exact(share) * TURN))

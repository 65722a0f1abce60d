"""Compute mean durations in steps of phases and straight movement (model.md 3.4): docs/model.md, fields."""

from __future__ import annotations

import json

from feasibee.reference.draws import TURN, duration

WORDS = 200_000


def mean_of(mean: float) -> float:
    """Return the mean of the durations drawn for a mean, over evenly spaced random words."""
    return sum(duration((2 * k + 1) * TURN // (2 * WORDS), mean) for k in range(WORDS)) / WORDS


print(json.dumps({"ten": mean_of(10.0), "told": {"high": mean_of(10 * 0.9), "low": mean_of(10 * 0.1)}}))

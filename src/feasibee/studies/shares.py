"""Shares of swarms: in words, and the step from which enough swarms are right."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from feasibee.model.codes import exact
from feasibee.results.statistics import Interval
from feasibee.studies.comparison import Outcome

SURE: Final = 0.95
"""Share of swarms that must be right for a time to be called sufficient."""


def wait_for(outcome: Outcome, share: float = SURE) -> int | None:
    """Return the first step from which a share of the swarms is right until the end; None without one."""
    short = np.flatnonzero(outcome.right_at < math.ceil(exact(share) * outcome.runs))
    step = int(short[-1]) + 1 if short.size else 0
    return step if step < outcome.right_at.size else None


def percent(share: Interval) -> str:
    """Return a share with its interval, in percent."""
    return f"{100 * share.estimate:.1f} % ({100 * share.low:.1f} to {100 * share.high:.1f})"


def points(difference: Interval) -> str:
    """Return a difference of shares with its interval, in percentage points."""
    middle, low, high = (100 * value for value in difference)
    return f"{middle:+.1f} points ({low:+.1f} to {high:+.1f})"

"""Checks of what a user's strategy returns, in every call; built-in strategies are tested instead.

Each function here replaces one of the strategy's, which it calls by the name ``own``. Users do not see these
messages: the reference plays the run again, and its errors name line, arguments and value.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from feasibee.engine.compile import rebound
from feasibee.model.codes import LONGEST


def own(*arguments: Any) -> Any:
    """Stand for the strategy's function until `guarded` replaces it."""
    raise NotImplementedError


def _quality(robots_seen, tasks_seen):
    result = own(robots_seen, tasks_seen)
    if not 0.0 <= result <= 1.0:
        raise ValueError("quality must return a number from 0 to 1")
    return result


def _dissemination(quality, gain):
    result = own(quality, gain)
    if not 0.0 <= result <= LONGEST:
        raise ValueError("dissemination must return a number of steps from 0 to 2**30")
    return result


def _lasting(mind, gain):
    result = own(mind, gain)
    if not 0.0 <= result <= LONGEST:
        raise ValueError("lasting must return a number of steps from 0 to 2**30")
    return result


def _decide(mind, inbox):
    result = own(mind, inbox)
    if result != 1 and result != 0 and result != -1:  # noqa: PLR1714  # numba compiles this to comparisons
        raise ValueError("decide must return 1, 0, or -1 for none")
    return result


def _say(mind):
    result = own(mind)
    if result != 1 and result != 0 and result != -1:  # noqa: PLR1714
        raise ValueError("say must return 1, 0, or -1 for none")
    return result


def _value(mind):
    result = own(mind)
    if not -1e300 < result < 1e300:
        raise ValueError("value must return a number")
    return result


GUARDS: Final = {
    "quality": _quality,
    "dissemination": _dissemination,
    "decide": _decide,
    "say": _say,
    "value": _value,
    "lasting": _lasting,
}


def guarded(name: str, compiled: Callable[..., Any]) -> Callable[..., Any]:
    """Return a copy of a guard that calls a strategy's compiled function."""
    return rebound(GUARDS[name], own=compiled)

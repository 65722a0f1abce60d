"""Checks of what a user's strategy returns, in every call; built-in strategies are tested instead.

A check replaces one of the strategy's functions, which it calls by the name ``own``. Users do not see these
messages: the reference plays the run again, and its errors name line, arguments and value.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from feasibee.engine import overflow  # noqa: F401  # lets numba compile checked operations
from feasibee.engine.compile import careful, rebound
from feasibee.strategies.contract import LIMITS

own: Any = None
checked: Any = None
least = most = 0.0
must: str = ""
"""What stands for a strategy's function, and for the rule of its result, until `guarded` replaces them."""


def _of_one(first):
    return checked(own(first))


def _of_two(first, second):
    return checked(own(first, second))


def _of_three(first, second, third):
    return checked(own(first, second, third))


def _number(result):
    if not least <= result <= most:
        raise ValueError(must)
    return result


def _opinion(result):
    if result != 1 and result != 0 and result != -1:  # noqa: PLR1714  # numba compiles this to comparisons
        raise ValueError(must)
    return result


SHARE: Final = _number, *LIMITS["quality"], "a number from 0 to 1"
STEPS: Final = _number, *LIMITS["lasting"], "a number of steps from 0 to 2**30"
OPINION: Final = _opinion, -1, 1, "1, 0, or -1 for none"
GUARDS: Final = {
    "quality": SHARE,
    "dissemination": STEPS,
    "decide": OPINION,
    "say": OPINION,
    "value": (_number, *LIMITS["value"], "a number"),
    "lasting": STEPS,
    "probability": SHARE,
}


def guarded(name: str, compiled: Any) -> Callable[..., Any]:
    """Return a function that calls a strategy's compiled function, and checks what it returns."""
    rule, low, high, words = GUARDS[name]
    check = careful(rebound(rule, least=low, most=high, must=f"{name} must return {words}"))
    caller = (_of_one, _of_two, _of_three)[compiled.py_func.__code__.co_argcount - 1]
    return rebound(caller, f"_{name}", own=compiled, checked=check)

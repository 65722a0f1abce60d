"""The functions of a user's strategy: run once from the text, tried, and checked in every later call."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable, Mapping
from functools import wraps
from hashlib import sha256
from itertools import product
from pathlib import Path
from types import ModuleType
from typing import Any, Final

from feasibee.errors import FeasibeeError
from feasibee.model.codes import LONGEST
from feasibee.strategies.contract import ARGUMENTS, CONSTANTS, Inbox, Manifest, Mind, Strategy

OPINIONS: Final = "must be 1, 0, or -1 for none"
RULES: Final[Mapping[str, tuple[str, Callable[[Any], bool]]]] = {
    "quality": ("must be a number from 0 to 1", lambda value: _is_number(value) and 0 <= value <= 1),
    "dissemination": (
        f"must be a number of steps from 0 to {LONGEST}",
        lambda value: _is_number(value) and 0 <= value <= LONGEST,
    ),
    "decide": (OPINIONS, lambda value: _is_number(value) and value in (1, 0, -1)),
    "say": (OPINIONS, lambda value: _is_number(value) and value in (1, 0, -1)),
    "value": ("must be a number", lambda value: _is_number(value)),  # noqa: PLW0108  # it is defined below
}
"""What each function must return."""
FAILURES: Final = (Exception, SystemExit)
SHOWN: Final = 300
"""Characters of the arguments that an error shows."""


def tried(manifest: Manifest) -> Strategy:
    """Run the text of a user's strategy; return the strategy, after a trial of each function.

    Raises
    ------
    FeasibeeError
        If the file fails, or a function fails or returns nonsense: function, line, arguments and value.
    """
    file = Path(manifest.name).name
    module = _executed(manifest, file)
    functions: dict[str, Any] = {
        name: _checked(getattr(module, name), name, file) for name in ARGUMENTS if hasattr(module, name)
    }
    declared: dict[str, Any] = {field: getattr(manifest, field) for field in CONSTANTS.values()}
    strategy = Strategy(name=manifest.name, source=manifest.source, **declared, **functions)
    _try(strategy)
    return strategy


def own_function(strategy: Strategy, name: str) -> Callable[..., Any]:
    """Return a function as the user wrote it, without our check around it, or the default."""
    function: Callable[..., Any] = getattr(strategy, name)
    return getattr(function, "__wrapped__", function)


def _executed(manifest: Manifest, file: str) -> ModuleType:
    """Run the text as a module, which is named after the text: two texts never share compiled code."""
    digest = sha256(manifest.source.encode()).hexdigest()[:16]
    module = ModuleType(f"feasibee_strategy_{digest}")
    module.__file__ = manifest.name
    sys.modules[module.__name__] = module
    try:
        exec(compile(manifest.source, file, "exec"), module.__dict__)
    except FAILURES as error:
        raise FeasibeeError(f"{_where(error, file)}: {_said(error)}") from None
    for name, field in CONSTANTS.items():
        if getattr(module, name, getattr(manifest, field)) != getattr(manifest, field):
            raise FeasibeeError(f"{file}: {name} changes while the file runs; write its value out once")
    return module


def _checked(function: Any, name: str, file: str) -> Callable[..., Any]:
    """Return a function that raises an error in a line for what it can't return."""
    if not isinstance(function, type(_checked)):
        raise FeasibeeError(f"{file}: {name} isn't a plain function; write def {name}(...)")
    rule, holds = RULES[name]

    @wraps(function)
    def call(*arguments: Any) -> Any:
        try:
            result = function(*arguments)
        except FAILURES as error:
            raise FeasibeeError(
                f"{_where(error, file)}: {_call(name, arguments)} fails: {_said(error)}"
            ) from None
        if not holds(result):
            line = function.__code__.co_firstlineno
            shown = repr(result)[:SHOWN]
            raise FeasibeeError(f"{file}, line {line}: {_call(name, arguments)} returns {shown}; {rule}")
        return result

    return call


def _try(strategy: Strategy) -> None:
    """Call the functions as a simulation does: with nothing seen or heard, little, and much."""
    counts = ((0, 0), (0, 1), (1, 0), (3, 2), (5, 2), (1000, 3), (3, 1000), (1000, 1000))
    rated = sorted({strategy.quality(*seen) for seen in counts})
    for quality, gain in product({0.5, *rated, *(1.0 - each for each in rated)}, (1e-3, 10.0, 1e6)):
        strategy.dissemination(quality, gain)
    inboxes = (
        Inbox(2, 1, 1, 0.5, 0.5, 0.25),
        Inbox(0, 0, -1, 0.0, 0.0, 0.0),
        Inbox(0, 3, 0, 0.0, 0.1, 0.99),
        Inbox(1000, 1000, 1, 1.0, 0.5, 0.5),
    )
    for opinion, feasible_quality in product((1, 0, -1) if strategy.starts_neutral else (1, 0), rated):
        quality = {1: feasible_quality, 0: 1.0 - feasible_quality, -1: 0.5}[opinion]
        for own_vote, inbox in product((1, 0), inboxes):
            mind = _mind(strategy, opinion, quality, feasible_quality, own_vote)
            strategy.say(mind)
            strategy.value(mind)
            strategy.decide(mind, inbox)


def _mind(strategy: Strategy, opinion: int, quality: float, feasible_quality: float, own_vote: int) -> Mind:
    parameters = [float(number) for number in strategy.parameters.values()]
    return Mind(opinion, quality, feasible_quality, own_vote, [0.0] * strategy.memory, parameters)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and abs(value) < 1e300  # what is larger overflows sooner or later


def _call(name: str, arguments: tuple[Any, ...]) -> str:
    return f"{name}({', '.join(map(repr, arguments))[:SHOWN]})"


def _where(error: BaseException, file: str) -> str:
    """Return the last line of the file that an error passed through."""
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == file]
    return f"{file}, line {lines[-1]}" if lines else file


def _said(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}".splitlines()[0][:SHOWN]

"""Fields to vary and their ranges, for `feasibee predict --over` and searches."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, get_args

from feasibee.base.errors import FeasibeeError, ScenarioError
from feasibee.scenario.paths import read_value
from feasibee.scenario.scenario import Scenario

FACTOR = 5.0
"""The default range of a field is from its value divided by this to its value times this."""


@dataclass(frozen=True)
class Dimension:
    """A field and its values: numbers from ``low`` to ``high``, or ``choices``.

    Numbers are spaced evenly, or by ratio if they are all above 0.
    """

    path: str
    low: float = 0.0
    high: float = 0.0
    whole: bool = False
    choices: tuple[Any, ...] = ()

    @property
    def by_ratio(self) -> bool:
        """Whether values are spaced by ratio."""
        return self.low > 0

    def at(self, share: float) -> Any:
        """Return the value at a share of the way from the low end to the high end, 0 to 1."""
        if self.choices:
            return self.choices[min(len(self.choices) - 1, int(share * len(self.choices)))]
        if self.by_ratio:
            value = self.low * (self.high / self.low) ** share
        else:
            value = self.low + share * (self.high - self.low)
        return round(value) if self.whole else value


def dimension(scenario: Scenario, text: str) -> Dimension:
    """Parse a field to vary: ``decision.gain``, ``decision.gain=2:50``, or ``decision.own_vote=true|false``.

    Raises
    ------
    FeasibeeError
        If there is no such field, or its values can't be read.
    """
    path, _, given = text.partition("=")
    section, _, key = path.partition(".")
    try:
        kind = type(scenario.get(section)).model_fields[key].annotation
        now = scenario.get(path)
    except (AttributeError, LookupError):
        raise FeasibeeError(f"{path}: isn't a field; such as decision.gain") from None
    if given:
        return _checked(scenario, _read(scenario, path, given, now))
    if isinstance(now, bool):
        return Dimension(path, choices=(False, True))
    if isinstance(now, int | float):
        return _checked(scenario, _around(path, now, "0:0.5"))
    choices = tuple(each for each in get_args(kind) if isinstance(each, str))
    if not choices:
        raise FeasibeeError(f"{path}: name its values, such as {path}=a|b|c")
    return Dimension(path, choices=choices)


def _around(path: str, now: float, such: str) -> Dimension:
    """Return a number's default range; of 0, there is none."""
    if now <= 0:
        raise FeasibeeError(f"{path} = {now:g}: has no default range; give one, such as {path}={such}")
    whole = isinstance(now, int)
    return Dimension(path, max(1, now / FACTOR) if whole else now / FACTOR, now * FACTOR, whole)


def _read(scenario: Scenario, path: str, given: str, now: Any) -> Dimension:
    low, colon, high = given.partition(":")
    if colon:
        try:
            first, last = (float(_typed(scenario, path, each)) for each in (low, high))
        except ValueError:
            first = last = math.nan
        if not first < last:
            raise FeasibeeError(f"{path}={given}: must be LOW:HIGH; such as {path}=2:50")
        return Dimension(path, first, last, isinstance(now, int) and not isinstance(now, bool))
    return Dimension(path, choices=tuple(_typed(scenario, path, text) for text in given.split("|")))


def _typed(scenario: Scenario, path: str, text: str) -> Any:
    """Return a value that a user typed; texts such as "6 m" as numbers."""
    value = read_value(text)
    return scenario.replace({path: value}).get(path) if isinstance(value, str) else value


def _checked(scenario: Scenario, varied: Dimension) -> Dimension:
    """Raise an error if a choice, or an end of the range, is invalid in the scenario."""
    for value in varied.choices:
        scenario.replace({varied.path: value})
    if varied.choices:
        return varied
    for share in (0.0, 1.0):
        try:
            scenario.replace({varied.path: varied.at(share)})
        except ScenarioError as error:
            problem = error.problems[0]
            raise FeasibeeError(
                f"{varied.path} up to {varied.at(share):g}: {problem.rule}; give a range, "
                f"such as {varied.path}={varied.low:g}:{varied.low * 2:g}"
            ) from None
    return varied


STEPS = 96
"""Number of values to which a range of floats is rounded, spaced by ratio if they are all above 0."""


def ladder(scenario: Scenario, text: str) -> tuple[str, list[Any]]:
    """Parse a field and a range, such as ``radio.range=1:6``; return its path and its values, ascending.

    Without a range, the values go on from the scenario's own, divided by 5, up to 5 times that, as far as the
    scenario is valid.

    Raises
    ------
    FeasibeeError
        If there is no such field, it holds no numbers, or its range can't be read.
    """
    path, given = text.partition("=")[::2]
    now = _number(scenario, path)
    if given and ":" not in given:
        raise FeasibeeError(f"{text}: must be a range, such as {path}={now or 1:g}:{2 * now or 100:g}")
    if given:
        found = _checked(scenario, _read(scenario, path, given, now))
    else:
        found = _around(path, now, "20:400" if path.startswith("decision.parameters.") else "0:0.5")
    if found.whole:
        values: list[Any] = list(range(max(1, round(found.low)), round(found.high) + 1))
    else:
        values = [float(f"{found.at(step / (STEPS - 1)):.3g}") for step in range(STEPS)]
    return path, values[: valid_values(scenario, path, values)]


def _number(scenario: Scenario, path: str) -> Any:
    """Return the value of a field that holds a number."""
    try:
        now = scenario.get(path)
    except (AttributeError, LookupError):
        now = None
    if isinstance(now, bool) or not isinstance(now, int | float):
        raise FeasibeeError(f"{path}: isn't a field with a number; such as robots.count or radio.range")
    return now


def valid_values(scenario: Scenario, path: str, values: Sequence[Any]) -> int:
    """Return how many of ascending values the scenario can have; the others are too large."""
    low, high = 0, len(values)
    while low < high:
        middle = (low + high) // 2
        try:
            scenario.replace({path: values[middle]})
        except ScenarioError:
            high = middle
        else:
            low = middle + 1
    return low

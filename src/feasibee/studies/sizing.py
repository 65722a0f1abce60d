"""Sizings of swarms: the least value of a field that is enough, the blind band, and both in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, Final

from feasibee.model.codes import MODEL_VERSION
from feasibee.results.crossing import Crossing, Rule, Tested
from feasibee.scenario.scenario import Scenario

ROBOTS: Final = "robots.count"


@dataclass(frozen=True)
class Edge:
    """Where along some values a swarm becomes right often enough.

    Parameters
    ----------
    path : str
        Field that varies.
    values : sequence of float or int
        Values in the order of the search: it begins at the hardest.
    crossing : Crossing
        Tested places among the values.
    """

    path: str
    values: Sequence[Any]
    crossing: Crossing

    @property
    def enough(self) -> Any:
        """First value from which on the swarm is shown to be right often enough; None if none is."""
        place = self.crossing.enough
        return None if place is None else self.values[place]

    @property
    def interval(self) -> tuple[Any, Any]:
        """Interval of the first value that is truly enough; its second end is None without a value."""
        possible = self.crossing.possible
        return (self.values[possible] if possible < len(self.values) else None), self.enough

    @property
    def tested(self) -> list[tuple[Any, Tested]]:
        """Tested values, ascending, and what came of each."""
        return sorted((self.values[each.place], each) for each in self.crossing.tested)


@dataclass(frozen=True)
class Band:
    """Numbers of tasks for which a swarm isn't right often enough, on both sides of the truth.

    Parameters
    ----------
    below, above : Edge
        Searches from the largest feasible number of tasks down, and from the next one up.
    """

    below: Edge
    above: Edge

    @property
    def first(self) -> int:
        """Least number of tasks in the band; one more than the largest feasible one if there is none."""
        return int(self.below.values[-1] if self.below.enough is None else self.below.enough + 1)

    @property
    def last(self) -> int:
        """Largest number of tasks in the band, of those tried."""
        return int(self.above.values[-1] if self.above.enough is None else self.above.enough - 1)

    @property
    def empty(self) -> bool:
        """Whether the swarm is right often enough for all numbers of tasks."""
        return self.first > self.last

    @property
    def firsts(self) -> tuple[int | None, int | None]:
        """Interval of the first number of tasks in the band; None if there is no such number among those tried."""
        possible, enough = self.below.interval
        return (None if enough is None else enough + 1), (None if possible is None else possible + 1)

    @property
    def lasts(self) -> tuple[int | None, int | None]:
        """Interval of the last number of tasks in the band; None if there is no such number among those tried."""
        possible, enough = self.above.interval
        return (None if possible is None else possible - 1), (None if enough is None else enough - 1)

    def to_dict(self) -> dict[str, Any]:
        """Return the band as plain tables, for programs."""
        return {
            "from": None if self.empty else self.first,
            "to": None if self.empty else self.last,
            "intervals": None if self.empty else {"from": list(self.firsts), "to": list(self.lasts)},
            "tested": _rows(self.below) + _rows(self.above),
        }


@dataclass(frozen=True)
class Sizing:
    """How large a swarm must be, and for which numbers of tasks it is blind.

    Parameters
    ----------
    scenario : Scenario
        The scenario, whose last step is the one at which swarms must be right.
    rule : Rule
        Share of swarms that must be right, numbers of runs, and confidence of the whole answer.
    edge : Edge
        Least value of the field.
    band : Band or None
        The blind band; None if tasks have classes or given places.
    """

    scenario: Scenario
    rule: Rule
    edge: Edge
    band: Band | None
    seed: int

    def to_dict(self) -> dict[str, Any]:
        """Return the answer as plain tables, for programs."""
        name = "robots" if self.edge.path == ROBOTS else self.edge.path
        return {
            name: {
                "least": self.edge.enough,
                "interval": list(self.edge.interval),
                "tested": _rows(self.edge),
            },
            "blind_band": None if self.band is None else self.band.to_dict(),
            "over": self.edge.path,
            "right": self.rule.target,
            "by": self.scenario.run.steps,
            "strategy": self.scenario.decision.strategy,
            "confidence": self.rule.confidence,
            "seed": self.seed,
            "scenario_hash": self.scenario.hash,
            "version": version("feasibee"),
            "model_version": MODEL_VERSION,
        }


def _rows(edge: Edge) -> list[dict[str, Any]]:
    return [
        {
            "value": value,
            "right": each.interval._asdict(),
            "runs": each.trials,
            "answer": each.answer,
        }
        for value, each in edge.tested
    ]


def in_words(tested: Tested) -> str:
    """Return what came of a test, in words."""
    answer = {"enough": "often enough", "too few": "too rarely", "open": "too close to tell"}[tested.answer]
    return f"right in {tested.successes} of {tested.trials}, {answer}"


def sentences(sizing: Sizing) -> list[str]:
    """Return the answer in words: the field, then the blind band."""
    return [_edge_in_words(sizing), *([] if sizing.band is None else [_band_in_words(sizing, sizing.band)])]


def _edge_in_words(sizing: Sizing) -> str:
    edge, share = sizing.edge, f"{100 * sizing.rule.target:g} %"
    first, last = edge.values[0], edge.values[-1]
    step, strategy = sizing.scenario.run.steps, sizing.scenario.decision.strategy
    what = "robots" if edge.path == ROBOTS else edge.path
    if edge.enough is None:
        return (
            f"With {strategy}, no tried number of robots is enough: up to {last}, fewer than {share} of the swarms, "
            f"or too close to tell, are right at step {step}."
            if edge.path == ROBOTS
            else f"With {strategy}, no {what} up to {last} is shown to be enough for {share} right at step {step}."
        )
    value = f"{edge.enough} robots" if edge.path == ROBOTS else f"{what} = {edge.enough}"
    low = edge.interval[0]
    between = "" if low == edge.enough else f" The least that is enough lies between {low} and {edge.enough}."
    already = f", the least that can do all tasks" if edge.path == ROBOTS and edge.enough == first else ""
    return f"With {strategy}, at least {share} of the swarms are right at step {step} from {value} on{already}.{between}"


def _band_in_words(sizing: Sizing, band: Band) -> str:
    robots, share = sizing.scenario.robots.count, f"{100 * sizing.rule.target:g} %"
    if band.empty:
        return f"Blind band: none. {robots} robots are right often enough for any number of tasks."
    ends = f"from {band.first} to {band.last} tasks" if band.first < band.last else f"with {band.first} tasks"
    return (
        f"Blind band of {robots} robots: {ends}, they are not shown to be right in {share} of the swarms."
        + _uncertain("first", band.firsts)
        + _uncertain("last", band.lasts)
    )


def _uncertain(which: str, ends: tuple[int | None, int | None]) -> str:
    low, high = ends
    if low == high:
        return ""
    if low is None:
        return f" Its {which} number of tasks is {high} or less." if which == "first" else ""
    if high is None:
        return f" Its {which} number of tasks is {low} or more."
    return f" Its {which} number of tasks lies between {low} and {high}."

"""Sizings of swarms: the least value of a field that is enough, the blind band, and both in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, Final

from feasibee.figures.sizing import Panel
from feasibee.model.codes import MODEL_VERSION
from feasibee.results.crossing import Crossing, Finding, Rule
from feasibee.results.statistics import Interval
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.units import axis_of, step_in_words, value_in_words

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
        Finding places among the values.
    """

    path: str
    values: Sequence[Any]
    crossing: Crossing

    @property
    def enough(self) -> Any:
        """First value from which on the swarm is right often enough; None if none is, or the share falls."""
        place = self.crossing.enough
        return None if place is None or self.crossing.refuted else self.values[place]

    @property
    def interval(self) -> tuple[Any, Any]:
        """Interval of the first value that is truly enough; its second end is None without a value."""
        possible = self.crossing.possible
        return (self.values[possible] if possible < len(self.values) else None), self.enough

    @property
    def tested(self) -> list[tuple[Any, Finding]]:
        """Finding values, ascending, and what came of each."""
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
        """Least number of tasks in the band; one more than the largest feasible one if it is empty."""
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
        """Interval of the first number of tasks in the band; None for an end that wasn't found."""
        possible, enough = self.below.interval
        return (None if enough is None else enough + 1), (None if possible is None else possible + 1)

    @property
    def lasts(self) -> tuple[int | None, int | None]:
        """Interval of the last number of tasks in the band; None for an end that wasn't found."""
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

    @property
    def assumption(self) -> str:
        """What the answer takes for granted, in words."""
        text = f"the share of right swarms doesn't fall as {self.edge.path} grows"
        if self.band is None:
            return text
        return f"{text}, nor as tasks.count goes away from {self.scenario.robots.count}"

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
            "assumes": {"text": self.assumption, "refuted": self.edge.crossing.refuted is not None},
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


def in_words(tested: Finding) -> str:
    """Return what came of a test, in words."""
    answer = {"enough": "often enough", "too few": "too rarely", "open": "too close to tell"}[tested.answer]
    return f"right in {tested.successes} of {tested.trials}, {answer}"


def sentences(sizing: Sizing) -> list[str]:
    """Return the answer in words: the field, then the blind band."""
    band, robots = sizing.band, sizing.scenario.robots.count
    return [
        edge_sentence(sizing),
        *([] if band is None else [band_sentence(band, robots, sizing.rule.target)]),
    ]


def edge_sentence(sizing: Sizing) -> str:
    """Return in words from which value of the field the swarm is right often enough."""
    edge, step = sizing.edge, sizing.scenario.run.steps
    first, last = edge.values[0], edge.values[-1]
    of_robots = edge.path == ROBOTS
    when = step_in_words(sizing.scenario, step)
    right = f"{100 * sizing.rule.target:g} % of the swarms are right at {when}"
    start = f"With {sizing.scenario.decision.strategy}, "
    if edge.crossing.refuted:
        return f"{start}at least {right} {_fall(sizing)}"
    if edge.enough is None:
        tried = f"from {first} to {last} robots" if of_robots else f"{edge.path} from {first} to {last}"
        return f"{start}nothing that was tried is shown to be enough ({tried}), so that {right}."
    value = f"{edge.enough} robots" if of_robots else value_in_words(sizing.scenario, edge.path, edge.enough)
    least = edge.interval[0]
    text = f"{start}at least {right} from {value} on."
    if of_robots and edge.enough == first:
        text += " Fewer robots could not do all tasks."
    return text if least == edge.enough else f"{text} The least that is enough is {least} to {edge.enough}."


def _fall(sizing: Sizing) -> str:
    """Return in words where the share reaches the target and where it falls again, and a shorter range."""
    edge, found = sizing.edge, sizing.edge.crossing
    first, last = found.enough or 0, found.tested[-1].place
    reached, fallen = (
        value_in_words(sizing.scenario, edge.path, edge.values[place]) for place in (first, last)
    )
    shorter = edge.values[max(1, (first + last) // 2)]
    return (
        f"with {reached}, but not with {fallen}: the share falls again, so that there is no least value. "
        f"Search a shorter range, such as --over {edge.path}={edge.values[0]:g}:{shorter:g}."
    )


def band_sentence(band: Band, robots: int, target: float) -> str:
    """Return the blind band of a number of robots in words."""
    share = f"{100 * target:g} %"
    if band.empty:
        return f"Blind band: none. {robots} robots are right often enough for any number of tasks."
    ends = f"from {band.first} to {band.last} tasks" if band.first < band.last else f"with {band.first} tasks"
    text = f"Blind band of {robots} robots: {ends}, they are not shown to be right in {share} of the swarms."
    (_, late), (early, _) = band.firsts, band.lasts
    if late is not None and early is not None and late > early:
        return f"{text} It may be empty."
    return text + _uncertain("first", band.firsts) + _uncertain("last", band.lasts)


def _uncertain(which: str, ends: tuple[int | None, int | None]) -> str:
    low, high = ends
    if low == high:
        return ""
    if low is None:
        return f" Its {which} number of tasks is {high} or less." if which == "first" else ""
    if high is None:
        return f" Its {which} number of tasks is {low} or more."
    return f" Its {which} number of tasks lies between {low} and {high}."


def panels_of(sizing: Sizing) -> list[Panel]:
    """Return what the figure of a sizing shows: its field, and tasks with the blind band."""

    def points(*edges: Edge) -> list[tuple[float, Interval]]:
        return sorted((value, each.interval) for edge in edges for value, each in edge.tested)

    label, factor = axis_of(sizing.scenario, sizing.edge.path)
    least = None if sizing.edge.enough is None else factor * sizing.edge.enough
    tested = [(factor * value, share) for value, share in points(sizing.edge)]
    panels = [Panel(label, tested, least=least)]
    band = sizing.band
    if band is not None:
        ends = None if band.empty else (band.first, band.last)
        panels.append(
            Panel(
                "tasks.count", points(band.below, band.above), band=ends, truth=sizing.scenario.robots.count
            )
        )
    return panels

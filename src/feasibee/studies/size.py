"""Size a swarm: the least value of a field from which it is right often enough, and its blind band.

The values are in order, and the rate of right swarms is assumed not to fall along them. Each value is tested
with as many trials as it takes, by a confidence sequence, which is valid at any number of them. The tests
share the error rate of the whole answer (Bonferroni), so that it doesn't matter which values are tested.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Final, get_args

from feasibee.base.errors import FeasibeeError, ScenarioError
from feasibee.results.measures import ended_right
from feasibee.results.statistics import CONFIDENCE, Interval
from feasibee.scenario.feasibility import truth
from feasibee.scenario.fields import dimension_of
from feasibee.scenario.paths import read_value
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.units import outside, step_in_words, value_in_words
from feasibee.simulation.plan import DesignPoint, Study
from feasibee.simulation.schedule import run_work
from feasibee.simulation.sequential import EARLY, IN_WORDS, Finding, SequentialDesign
from feasibee.simulation.sweep import Enough, Execution, Rounds
from feasibee.studies.comparison import check_stays, ending_early, origin, rounds_of
from feasibee.studies.needs import possible

if TYPE_CHECKING:
    from feasibee.figures.comparison import Side


@dataclass(frozen=True)
class Rule:
    """How values are tested."""

    target: float
    """The rate that is asked for, between 0 and 1."""
    first: int = 100
    most: int = 2000
    """Number of trials before the first look at a value, and the largest number."""
    confidence: float = CONFIDENCE
    """Probability that the whole answer is right, at least."""
    resolution: float = 0.08
    """A gap is not searched if it is at most this share of the distance from the first value."""
    early: tuple[int, ...] = EARLY
    """Numbers of trials of looks before the first one."""
    band: bool = True
    """Whether to search the blind band; the tests share the error rate with its tests in any case."""

    def design(self, tests: int) -> SequentialDesign:
        """Return the design of so many tests that share the error rate."""
        return SequentialDesign(
            self.most, self.first, tests=tests, confidence=self.confidence, early=self.early
        )


@dataclass(frozen=True)
class Edge:
    """Where along some values a swarm becomes right often enough."""

    path: str
    """Field that varies."""
    values: Sequence[Any]
    """Values in the order of the search: it begins at the hardest."""
    findings: Sequence[Finding]
    """Findings of the tested values, in that order."""
    reached: int | None
    """First place from which on the rate is shown to reach the target; None if it isn't shown of any."""
    possible: int
    """First place of which the rate isn't shown to be below the target. The first place that reaches it lies
    between this one and ``reached``."""

    @property
    def refuted(self) -> bool:
        """Whether the rate is shown to be below the target again at the last tested place."""
        last = self.findings[-1]
        return self.reached is not None and last.place > self.reached and last.answer == "too few"

    @property
    def enough(self) -> Any:
        """First value from which on the swarm is right often enough; None if none is, or the share falls."""
        return None if self.reached is None or self.refuted else self.values[self.reached]

    @property
    def interval(self) -> tuple[Any, Any]:
        """Interval of the first value that is truly enough; its second end is None without a value."""
        return (self.values[self.possible] if self.possible < len(self.values) else None), self.enough

    @property
    def tested(self) -> list[tuple[Any, Finding]]:
        """Tested values, ascending, and what came of each."""
        return sorted((self.values[each.place], each) for each in self.findings)


def most_tests(places: int) -> int:
    """Return the largest number of values that `find_edge` tests of so many."""
    return 3 * places.bit_length()


def finding_at(place: int, count: Callable[[int], int], rule: Rule, tests: int) -> Finding:
    """Test one value.

    Parameters
    ----------
    place : int
        Its place.
    count : callable
        Returns the number of successes in the first so many trials.
    rule : Rule
        How to test.
    tests : int
        Largest number of tests that share the error rate.
    """
    design = rule.design(tests)
    found = design.run(
        {place: count},
        lambda _, trials: {place: design.tested(rule.target, count(trials), trials, place)},
        lambda each: design.is_settled(rule.target, each),
    )
    if not found:
        raise Enough
    return found[place]


def find_edge(
    path: str,
    values: Sequence[Any],
    test: Callable[[int], Finding],
    resolution: float = 0.0,
    look_last: bool = False,
) -> Edge:
    """Find the first of some values from which on the rate reaches the target.

    The first place is tested, then places at twice the distance each until one reaches the target. The gap
    between the last that doesn't and the first that does is halved until no place between can change the
    answer. A place that stays open parts the gap in two.

    Parameters
    ----------
    path : str
        Field that varies.
    values : sequence
        Its values, at least one; the rate doesn't fall along them.
    test : callable
        Tests the value at a place; see `finding_at`.
    resolution : float
        Gaps of at most this share of their upper place are left.
    look_last : bool
        Whether to test the last place in any case, since the rate may fall again.
    """
    found: dict[int, Finding] = {}
    places, place = len(values), 0
    while place not in found:
        try:
            found[place] = test(place)
        except Enough:  # an answer so far: its interval is wider
            if not found:
                raise
            look_last = False
            break
        below = max((at for at, each in found.items() if each.answer == "too few"), default=-1)
        enough = min((at for at, each in found.items() if each.answer == "enough"), default=None)
        if enough is None and places - 1 not in found:
            place = min(2 * place + 1, places - 1)
        else:
            low, high = _gap(found, below, enough, places)
            place = (low + high) // 2 if high - low > max(1, resolution * high) else place
    if look_last and places - 1 not in found:
        found[places - 1] = test(places - 1)
    return Edge(path, values, [found[at] for at in sorted(found)], enough, below + 1)


def _gap(found: Collection[int], below: int, enough: int | None, places: int) -> tuple[int, int]:
    """Return the larger gap without tests: above the last below, or below the first that is enough."""
    upper = places if enough is None else enough
    opened = [place for place in found if below < place < upper]
    gaps = [(below, min(opened, default=upper))]
    if enough is not None:
        gaps.append((max(opened, default=below), upper))
    return max(gaps, key=lambda gap: gap[1] - gap[0])


ROBOTS: Final = "robots.count"


@dataclass(frozen=True)
class Band:
    """Numbers of tasks for which a swarm isn't right often enough, on both sides of the truth."""

    below: Edge
    above: Edge
    """Searches from the largest feasible number of tasks down, and from the next one up."""

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
    """How large a swarm must be, and for which numbers of tasks it is blind."""

    scenario: Scenario
    """The scenario, whose last step is the one at which swarms must be right."""
    rule: Rule
    """Share of swarms that must be right, numbers of runs, and confidence of the whole answer."""
    edge: Edge
    """Least value of the field."""
    band: Band | None
    """The blind band; None if tasks have classes or given places."""
    seed: int
    stopped: str = ""
    """Why the search ended early, if it did."""

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
            "stopped": self.stopped,
            "assumes": {"text": self.assumption, "refuted": self.edge.refuted},
            **origin(self.seed, self.scenario),
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


def sentences(sizing: Sizing) -> list[str]:
    """Return the answer in words: the field, then the blind band."""
    band, robots = sizing.band, sizing.scenario.robots.count
    early = f"The search ended early ({sizing.stopped}); more time would narrow the answer."
    return [
        edge_sentence(sizing),
        *([early] if sizing.stopped else []),
        *([] if band is None else [band_sentence(band, robots, sizing.rule.target)]),
    ]


def edge_sentence(sizing: Sizing) -> str:
    """Return in words from which value of the field the swarm is right often enough."""
    edge, step = sizing.edge, sizing.scenario.run.steps
    first, last = edge.values[0], edge.values[edge.findings[-1].place]
    of_robots, strategy = edge.path == ROBOTS, sizing.scenario.decision.strategy
    when = step_in_words(sizing.scenario, step)
    right = f"{100 * sizing.rule.target:g} % of the runs are right at {when}, with {strategy}"
    if edge.refuted:
        return f"At least {right}, {_fall(sizing)}"
    if edge.enough is None:
        tried = f"from {first} to {last} robots" if of_robots else f"{edge.path} from {first} to {last}"
        return f"None of the values tried ({tried}) is shown to be enough, so that {right}."
    value = f"{edge.enough} robots" if of_robots else value_in_words(sizing.scenario, edge.path, edge.enough)
    least = edge.interval[0]
    few = ", and fewer could not do all tasks" if of_robots and edge.enough == first else ""
    at_least = "" if least == edge.enough else f" The least that is enough is {least} to {edge.enough}."
    return f"Enough: {value}{few}. At least {right}.{at_least}"


def _fall(sizing: Sizing) -> str:
    """Return in words where the share reaches the target and where it falls again, and a shorter range."""
    edge = sizing.edge
    first, last = edge.reached or 0, edge.findings[-1].place
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
    if band.empty:
        return f"Blind band: none. {robots} robots are right often enough for any number of tasks."
    ends = f"{band.first} to {band.last} tasks" if band.first < band.last else f"{band.first} tasks"
    share = f"{100 * target:g} % of the runs"
    text = f"Blind band: with {ends}, {robots} robots are not shown to be right in {share}"
    (_, late), (early, _) = band.firsts, band.lasts
    if late is not None and early is not None and late > early:
        return f"{text}. It may be empty."
    unsure = [_end("begins", *band.firsts, "or less"), _end("ends", *band.lasts, "or more")]
    return f"{text}. It {' and '.join(filter(None, unsure))}." if any(unsure) else f"{text}."


def _end(verb: str, low: int | None, high: int | None, beyond: str) -> str:
    """Return where an end of a band lies, in words; empty if it is known, or if nothing is."""
    known = [value for value in (low, high) if value is not None]
    if low == high or not known:
        return ""
    return f"{verb} at {known[0]} {beyond}" if len(known) == 1 else f"{verb} between {low} and {high}"


def panels_of(sizing: Sizing) -> list[Side]:
    """Return what the figure of a sizing shows: its field, and tasks with the blind band."""
    from feasibee.figures.comparison import Side
    from feasibee.figures.style import name_of_axis

    def points(*edges: Edge) -> list[tuple[float, Interval]]:
        return sorted((value, each.interval) for edge in edges for value, each in edge.tested)

    unit, factor = outside(sizing.scenario, dimension_of(sizing.edge.path))
    label = name_of_axis(sizing.edge.path, unit=unit)
    least = None if sizing.edge.enough is None else factor * sizing.edge.enough
    tested = [(factor * value, share) for value, share in points(sizing.edge)]
    panels = [Side(label, tested, least=least)]
    band = sizing.band
    if band is not None:
        ends = None if band.empty else (band.first, band.last)
        tested, most = points(band.below, band.above), sizing.scenario.robots.count
        panels.append(Side(name_of_axis(TASKS), tested, band=ends, truth=most))
    return panels


TASKS: Final = "tasks.count"
REACH: Final = 8
"""A search goes by default up to so many times the number of robots or tasks."""

Tell = Callable[[str], None]


def size(
    scenario: Scenario,
    over: str = ROBOTS,
    rule: Rule | None = None,
    seed: int = 0,
    execution: Execution | Rounds | None = None,
    tell: Tell | None = None,
    reach: int = REACH,
) -> Sizing:
    """Search the least value of a field from which a swarm is right often enough, and its blind band.

    The share of swarms that are right at the last step is assumed not to fall as the field grows, nor with
    the distance of the number of tasks from the largest feasible one.

    Parameters
    ----------
    scenario : Scenario
        The swarm and its tasks.
    over : str
        Field to search, perhaps with a range: ``"radio.range=1:6"``.
    rule : Rule, optional
        Share of swarms that must be right, and numbers of runs; by default 0.95 and up to 2,000.
    seed : int
        64 bits.
    execution : Execution or Rounds, optional
        Where to compute and keep the runs; by default on threads, and in memory.
    tell : callable, optional
        Called with a line of text after each tested value.
    reach : int
        Largest multiple of the number of robots or tasks.

    Examples
    --------
    >>> import feasibee
    >>> swarm = feasibee.Scenario(arena={"side": 8.0}, tasks={"count": 5}, decision={"strategy": "census"})
    >>> feasibee.size(swarm).to_dict()["robots"]["interval"]
    [5, 5]
    """
    rule = rule or Rule(0.95)
    check_stays(scenario, "size")
    scenario = scenario.replace({"run.stop_at_decision": False})
    path = over.partition("=")[0]
    field = _robots(scenario, over, reach) if path == ROBOTS else ladder(scenario, over)
    with rounds_of(execution, "searching sizes") as rounds:
        lists = [field, *_task_lists(scenario, reach)]
        edge, *ends = _search_all(rounds, scenario, rule, seed, lists, tell)
    return Sizing(scenario, rule, edge, Band(*ends) if len(ends) == 2 else None, seed, rounds.stopped)


def band_of(
    scenario: Scenario, rule: Rule, seed: int, execution: Execution | Rounds | None = None, reach: int = REACH
) -> Band | None:
    """Search the blind band of a swarm; None if its tasks can't vary. The arguments are those of `size`."""
    with rounds_of(execution, "searching sizes") as rounds:
        ends = _search_all(rounds, scenario, rule, seed, _task_lists(scenario, reach))
    return Band(*ends) if len(ends) == 2 else None


def _search_all(
    rounds: Rounds,
    scenario: Scenario,
    rule: Rule,
    seed: int,
    lists: Sequence[tuple[str, Sequence[Any]]],
    tell: Tell | None = None,
) -> list[Edge]:
    """Search along several fields, all on the same runs; the answers share the error rate.

    The last value of fields other than robots and tasks is tested, too. That of these is 8 times the first,
    and costs as much.
    """
    tests, scenario = sum(most_tests(len(values)) for _, values in lists), ending_early(scenario)

    def test(path: str, values: Sequence[Any], place: int) -> Finding:
        value = values[place]
        design = DesignPoint({path: value}, scenario.replace({path: value}))
        found = finding_at(place, lambda runs: _right(rounds, design, runs, seed), rule, tests)
        if tell is not None:
            rounds.so_far = ""  # the lines that are told
            tell(f"{path} = {value}: right in {found.successes} of {found.trials}, {IN_WORDS[found.answer]}")
        return found

    if not rounds.phases:
        longest = max(run_work(scenario.replace({path: values[-1]})) for path, values in lists)
        rounds.phases = {rounds.phase: tests * rule.most * longest}
    edges: list[Edge] = []
    for path, values in lists if rule.band else lists[:1]:
        look_last = path not in (ROBOTS, TASKS)
        try:
            edges.append(find_edge(path, values, partial(test, path, values), rule.resolution, look_last))
        except Enough:
            break
    if not edges and rounds.stopped:
        raise Enough
    return edges


def _right(rounds: Rounds, design: DesignPoint, runs: int, seed: int) -> int:
    (record,) = rounds.run(Study([design], runs, seed))
    return int(ended_right(record, design.scenario).sum())


def _robots(scenario: Scenario, over: str, reach: int) -> tuple[str, list[int]]:
    """Return the numbers of robots to try: those with which the tasks are feasible."""
    if scenario.robots.classes or scenario.robots.points:
        given = "classes" if scenario.robots.classes else "points"
        raise FeasibeeError(
            f"robots.count: can't vary, since robots.{given} says how many there are; choose another field, "
            "such as --over radio.range"
        )
    given = over.partition("=")[2]
    most = reach * max(scenario.robots.count, _places(scenario))
    numbers = range(max(1, _places(scenario)), most)  # some must work and be honest
    least = next((each for each in numbers if possible(scenario, {ROBOTS: each})), 1)
    path, values = ladder(scenario, over if given else f"{ROBOTS}={least}:{most}")
    feasible = [value for value in values if truth(scenario.replace({ROBOTS: value}))]
    if not feasible:
        raise FeasibeeError(
            f"robots.count = {values[0]} to {values[-1]}: too few for the tasks; search higher, such as "
            f"--over robots.count={_places(scenario)}:{2 * _places(scenario)}"
        )
    return path, feasible


def _places(scenario: Scenario) -> int:
    """Return how many robots the tasks need at least."""
    classes = scenario.tasks.classes
    return sum(each.count * sum(each.needs.values()) for each in classes) if classes else scenario.tasks.count


def _task_lists(scenario: Scenario, reach: int) -> list[tuple[str, list[int]]]:
    """Return the numbers of tasks below the edge of the truth, from there down, and those above it."""
    if scenario.robots.classes or scenario.tasks.classes or scenario.tasks.points:
        return []
    robots = scenario.robots.count
    above = list(range(robots + 1, reach * max(robots, scenario.tasks.count) + 1))
    valid = valid_values(scenario, TASKS, [robots, *above]) - 1
    return [(TASKS, list(range(robots, 0, -1))), (TASKS, above[:valid])] if valid > 0 else []


FACTOR = 5.0
"""The default range of a field is from its value divided by this to its value times this."""


@dataclass(frozen=True)
class Axis:
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


def dimension(scenario: Scenario, text: str) -> Axis:
    """Parse a field to vary: ``decision.gain``, ``decision.gain=2:50``, or ``decision.own_vote=true|false``.

    Raise a FeasibeeError if there is no such field, or its values can't be read.
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
        return Axis(path, choices=(False, True))
    if isinstance(now, int | float):
        return _checked(scenario, _around(path, now, "0:0.5"))
    choices = tuple(each for each in get_args(kind) if isinstance(each, str))
    if not choices:
        raise FeasibeeError(f"{path}: name its values, such as {path}=a|b|c")
    return Axis(path, choices=choices)


def _around(path: str, now: float, such: str) -> Axis:
    """Return a number's default range; of 0, there is none."""
    if now <= 0:
        raise FeasibeeError(f"{path} = {now:g}: has no default range; give one, such as {path}={such}")
    whole = isinstance(now, int)
    return Axis(path, max(1, now / FACTOR) if whole else now / FACTOR, now * FACTOR, whole)


def _read(scenario: Scenario, path: str, given: str, now: Any) -> Axis:
    low, colon, high = given.partition(":")
    if colon:
        try:
            first, last = (float(_typed(scenario, path, each)) for each in (low, high))
        except ValueError:
            first = last = math.nan
        if not first < last:
            raise FeasibeeError(f"{path}={given}: must be LOW:HIGH; such as {path}=2:50")
        return Axis(path, first, last, isinstance(now, int) and not isinstance(now, bool))
    return Axis(path, choices=tuple(_typed(scenario, path, text) for text in given.split("|")))


def _typed(scenario: Scenario, path: str, text: str) -> Any:
    """Return a value that a user typed; texts such as "6 m" as numbers."""
    value = read_value(text)
    return scenario.replace({path: value}).get(path) if isinstance(value, str) else value


def _checked(scenario: Scenario, varied: Axis) -> Axis:
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

    Raise a FeasibeeError if there is no such field, it holds no numbers, or its range can't be read.
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
    now = scenario.get(path)
    if isinstance(now, bool) or not isinstance(now, int | float):
        raise FeasibeeError(f"{path}: isn't a field with a number; such as robots.count or radio.range")
    return now


def valid_values(scenario: Scenario, path: str, values: Sequence[Any]) -> int:
    """Return how many of ascending values the scenario can have; the others are too large."""
    return bisect_left(values, True, key=lambda value: possible(scenario, {path: value}) is None)

"""Size a swarm: search the least value of a field from which it is right often enough, and its blind band."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final

from feasibee.errors import FeasibeeError
from feasibee.results.crossing import Finding, Rule, find_crossing, finding_at, most_tests
from feasibee.scenario.feasibility import truth
from feasibee.scenario.scenario import Scenario
from feasibee.studies.comparison import right_at_end
from feasibee.studies.sizing import ROBOTS, Band, Edge, Sizing, in_words
from feasibee.studies.space import ladder, valid_values
from feasibee.studies.suitable import check_stays
from feasibee.sweeps.plan import DesignPoint
from feasibee.sweeps.sweep import Execution, Rounds

TASKS: Final = "tasks.count"
REACH, SHORT_REACH = 8, 3
"""A search goes up to so many times the number of robots or tasks; as a part of another study, to less."""
EXPECTED: Final = 20
"""Tests of a search as short as its first look, about: for the progress only."""

Tell = Callable[[str], None]


def size(
    scenario: Scenario,
    over: str = ROBOTS,
    rule: Rule | None = None,
    seed: int = 0,
    execution: Execution | None = None,
    tell: Tell | None = None,
) -> Sizing:
    """Search the least value of a field from which a swarm is right often enough, and its blind band.

    Right means right at the last step. The share of right swarms is assumed not to fall as the field grows,
    nor with the distance of the number of tasks from the largest feasible one. If so, all intervals of
    the answer hold together with the probability ``rule.confidence`` at least. Of a field other than the
    number of robots, the largest value is tested, too. If the share has fallen there, no value is the least.

    Parameters
    ----------
    scenario : Scenario
        The swarm and its tasks.
    over : str
        Field to search, perhaps with a range: ``"radio.range=1:6"``. Of the number of robots, only values are
        tried for which the tasks are feasible.
    rule : Rule, optional
        Share of swarms that must be right, and numbers of runs; by default 0.95, 100 and 2,000.
    seed : int
        64 bits.
    execution : Execution, optional
        Where to compute and keep the runs; by default on threads, and in memory.
    tell : callable, optional
        Called with a line of text after each tested value.

    Raises
    ------
    FeasibeeError
        If the field can't be searched.
    """
    rule = rule or Rule(0.95)
    check_stays(scenario, "size")
    scenario = scenario.replace({"run.stop_at_decision": False})
    path = over.partition("=")[0]
    field = _robots(scenario, over, REACH) if path == ROBOTS else ladder(scenario, over)
    lists = [field, *_task_lists(scenario, REACH)]
    with Rounds(execution, EXPECTED * len(lists) * rule.first) as rounds:
        edge, *ends = _search_all(rounds, scenario, rule, seed, lists, tell)
    return Sizing(scenario, rule, edge, Band(*ends) if ends else None, seed)


def size_within(rounds: Rounds, scenario: Scenario, rule: Rule, seed: int) -> Sizing | None:
    """Size a swarm by its number of robots, as a part of another study; None if it can't vary."""
    if scenario.robots.classes or scenario.robots.points:
        return None
    lists = [_robots(scenario, ROBOTS, SHORT_REACH), *_task_lists(scenario, SHORT_REACH)]
    edge, *ends = _search_all(rounds, scenario, rule, seed, lists)
    return Sizing(scenario, rule, edge, Band(*ends) if ends else None, seed)


def band_within(rounds: Rounds, scenario: Scenario, rule: Rule, seed: int) -> Band | None:
    """Search the blind band of a swarm, as a part of another study; None if its tasks can't vary."""
    ends = _search_all(rounds, scenario, rule, seed, _task_lists(scenario, SHORT_REACH))
    return Band(*ends) if ends else None


def _search_all(
    rounds: Rounds,
    scenario: Scenario,
    rule: Rule,
    seed: int,
    lists: Sequence[tuple[str, Sequence[Any]]],
    tell: Tell | None = None,
) -> list[Edge]:
    """Search along several fields; the answers share the error rate."""
    tests = sum(most_tests(len(values)) for _, values in lists)
    swarms = Swarms(rounds, scenario, rule, seed, tests, tell)
    return [swarms.search(path, values) for path, values in lists]


@dataclass(frozen=True)
class Swarms:
    """Tests a scenario with changed values of a field, all of them on the same runs."""

    rounds: Rounds
    scenario: Scenario
    rule: Rule
    seed: int
    tests: int
    tell: Tell | None

    def search(self, path: str, values: Sequence[Any]) -> Edge:
        """Search where along the values the swarm becomes right often enough.

        The last value of other fields is tested, too. That of robots or tasks is 8 times the first, and costs
        as much.
        """

        def test(place: int) -> Finding:
            changes = {path: values[place]}
            design = DesignPoint(changes, self.scenario.replace(changes))
            found = finding_at(place, lambda runs: self._right(design, runs), self.rule, self.tests)
            if self.tell is not None:
                self.tell(f"{path} = {values[place]}: {in_words(found)}")
            return found

        look_last = path not in (ROBOTS, TASKS)
        return Edge(path, values, find_crossing(len(values), test, self.rule.resolution, look_last))

    def _right(self, design: DesignPoint, runs: int) -> int:
        (right,) = right_at_end(self.rounds, [design], runs, self.seed)
        return int(right.sum())


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
    path, values = ladder(scenario, over if given else f"{ROBOTS}=1:{most}")
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

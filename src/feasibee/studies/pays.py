"""Whether asking first pays: what missions cost by when robots start, with simulated help (model.md 6.25).

A mission ends when all tasks are taken. It costs its steps, a penalty for each robot that took a task while
the tasks were infeasible, and calls for help. Swarms that hold infeasible call the missing robots (6.19). An
operator who has waited in vain until the end of its patience calls them, too, and knows the right number.
Numbers of tasks are Poisson: missions with each number are simulated, and weighted.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.errors import FeasibeeError
from feasibee.results.statistics import CONFIDENCE, Interval, normal_quantile, plain
from feasibee.scenario.scenario import Scenario
from feasibee.studies.comparison import check_stays, origin, rounds_of
from feasibee.studies.flooding import flooded
from feasibee.sweeps.plan import DesignPoint, Study
from feasibee.sweeps.sweep import Execution, Rounds

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from feasibee.model.record import Record

POLICIES: Final[Mapping[str, Mapping[str, Any]]] = {
    "start at once": {"acting.start": 0, "acting.hold": "stand"},
    "search first": {"acting.start": "search", "acting.hold": "stand"},
    "ask first": {"acting.start": "safe", "acting.hold": "stand"},
    "tag, then search": {"acting.start": "search", "acting.hold": "tag", "acting.choose": "nearest"},
    "tag, then ask": {"acting.start": "safe", "acting.hold": "tag", "acting.choose": "nearest"},
}
"""When robots start, in words, and the fields that say so."""
WITHOUT_TAGS: Final = tuple(POLICIES)[:3]
RATIOS: Final = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0)
PENALTIES: Final = (0.0, 1.0, 3.0, 10.0, 30.0, 100.0)
STRATEGY: Final = "roster"
"""Strategy of a scenario whose own one doesn't say how many robots are missing."""
PATIENCE: Final = 20
"""Steps for which a swarm holds infeasible before the operator believes it, unless the scenario says so."""
TAIL: Final = 2000
"""Steps of a mission after the operator's help has come, at most."""
SURELY: Final = 4.0
"""Deviations of the Poisson number of tasks that are simulated on either side of its mean."""


class Costs(NamedTuple):
    """What a mission costs, in any unit."""

    step: float = 1.0
    vain: float = 10.0
    """Of each robot that took a task while the tasks were infeasible."""
    call: float = 0.0
    """Of each call for help."""


class Missions(NamedTuple):
    """Runs with one policy and one number of tasks; each array has the shape (runs,)."""

    steps: NDArray[np.float64]
    """Step at which all tasks were taken; of a mission that never ended, the last one."""
    vain: NDArray[np.float64]
    calls: NDArray[np.float64]
    ended: NDArray[np.bool_]

    def cost(self, costs: Costs) -> NDArray[np.float64]:
        """Return the cost of each run."""
        return costs.step * self.steps + costs.vain * self.vain + costs.call * self.calls


@dataclass(frozen=True)
class Pays:
    """What missions cost by policy, number of tasks, and penalty."""

    scenario: Scenario
    costs: Costs
    patience: int
    seed: int
    missions: Mapping[str, Mapping[int, Missions]]
    """By policy and number of tasks."""

    @property
    def ratio(self) -> float:
        """Robots per task of the scenario."""
        return self.scenario.robots.count / max(1, self.scenario.tasks.count)

    def cost(self, policy: str, ratio: float, costs: Costs, baseline: str = "") -> Interval:
        """Return the mean cost of a mission, less that with a baseline in the same worlds, if any."""
        found = self.missions[policy]
        weights = poisson_weights(self.scenario.robots.count / ratio, sorted(found))
        mean, variance = 0.0, 0.0
        for tasks, weight in weights.items():
            values = found[tasks].cost(costs)
            values = values - self.missions[baseline][tasks].cost(costs) if baseline else values
            mean += weight * float(values.mean())
            variance += weight**2 * float(values.var(ddof=1)) / values.size
        half = normal_quantile(CONFIDENCE) * math.sqrt(variance)
        return Interval(mean, mean - half, mean + half)

    def best(self, ratio: float, costs: Costs, policies: Sequence[str] = tuple(POLICIES)) -> tuple[str, bool]:
        """Return the cheapest policy, and whether it is surely cheaper than each other."""
        ordered = sorted(policies, key=lambda each: self.cost(each, ratio, costs).estimate)
        sure = all(self.cost(each, ratio, costs, ordered[0]).low > 0 for each in ordered[1:])
        return ordered[0], sure

    def regions(self, vain: float, policies: Sequence[str] = WITHOUT_TAGS) -> list[tuple[str, float, float]]:
        """Return the cheapest policies along the ratios, each with the first and the last of its ratios."""
        best = [(self.best(each, self.costs._replace(vain=vain), policies)[0], each) for each in RATIOS]
        ends = [0, *(i for i in range(1, len(best)) if best[i][0] != best[i - 1][0]), len(best)]
        return [(best[first][0], best[first][1], best[after - 1][1]) for first, after in pairwise(ends)]

    def to_dict(self) -> dict[str, Any]:
        """Return costs and regions as plain tables, for programs."""
        rows = [
            {
                "ratio": ratio,
                "vain": vain,
                "cheapest": best,
                "sure": sure,
                "costs": {each: self.cost(each, ratio, costs)._asdict() for each in POLICIES},
            }
            for vain in PENALTIES
            for costs in [self.costs._replace(vain=vain)]
            for ratio in RATIOS
            for best, sure in [self.best(ratio, costs)]
        ]
        return {
            **origin(self.seed, self.scenario),
            "costs": self.costs._asdict(),
            "patience": self.patience,
            "ratio": self.ratio,
            "own": {each: plain(self.cost(each, self.ratio, self.costs)) for each in POLICIES},
            "ended": {
                each: min(float(one.ended.mean()) for one in found.values())
                for each, found in self.missions.items()
            },
            "regions": {f"{vain:g}": self.regions(vain) for vain in PENALTIES},
            "diagram": rows,
        }


def poisson_weights(mean: float, numbers: Sequence[int]) -> dict[int, float]:
    """Return the Poisson probabilities, each shared by the two nearest of these numbers, in rising order."""
    every = np.arange(math.ceil(mean + 10 * math.sqrt(mean)) + 10)
    mass = np.exp(every * math.log(mean) - mean - np.cumsum(np.log(np.maximum(1, every))))
    shares = zip(numbers, np.eye(len(numbers)), strict=True)
    return {number: float(mass @ np.interp(every, numbers, share)) for number, share in shares}


def task_numbers(robots: int) -> list[int]:
    """Return the numbers of tasks that are simulated: the closer, the nearer to that of the robots."""
    least, most = (robots / each for each in (RATIOS[-1], RATIOS[0]))
    first = max(1, math.floor(least - SURELY * math.sqrt(least)))
    last = math.ceil(most + SURELY * math.sqrt(most))
    wide = max(1, robots // 10)
    near = range(max(first, robots - wide), robots + wide + 1)
    return sorted({*range(first, last + 1, wide), last, *near})


def mission(scenario: Scenario, policy: str, tasks: int, patience: int) -> Scenario:
    """Return the world of a mission: robots that act by a policy, and an operator who helps.

    The operator calls whom the swarm says are missing. After its patience it calls those that are, also for
    robots that don't act.
    """
    robots, response, (stopped, byzantine, _) = scenario.robots.count, scenario.response, scenario.faulty
    missing, comes = max(0, tasks - (robots - stopped - byzantine)), patience + response.delay
    return scenario.replace(
        {
            **POLICIES[policy],
            "tasks.count": tasks,
            "robots.know_count": True,
            "robots.most": robots + 2 * missing + 2 * response.margin + robots // 2,
            "decision.strategy": scenario.decision.strategy if scenario.manifest.knows_gap else STRATEGY,
            "response.patience": response.patience or PATIENCE,
            "run.steps": comes + TAIL,
            "run.stop_when_taken": True,
            "events": [{"step": comes, "robots": missing}] if missing else [],
        }
    )


def pays(
    scenario: Scenario,
    costs: Costs | None = None,
    *,
    runs: int = 40,
    patience: int = 500,
    seed: int = 0,
    execution: Execution | Rounds | None = None,
) -> Pays:
    """Simulate missions by each policy, with numbers of tasks from far below that of robots to far above.

    Parameters
    ----------
    scenario : Scenario
        The swarm and its world, which doesn't change; its number of tasks says only which ratio is its own.
    costs : Costs, optional
        What a mission costs; by default a step 1, a start in vain 10 per robot, and a call nothing.
    runs : int
        Number of runs by each policy and with each number of tasks, at least 2.
    patience : int
        Steps after which the operator calls the missing robots by itself.
    seed : int
        64 bits.
    execution : Execution or Rounds, optional
        Where to compute and keep the runs; by default on threads, and in memory.

    Raises
    ------
    FeasibeeError
        If the world changes by itself, or has classes or points of tasks.
    """
    if scenario.tasks.classes or scenario.tasks.points:
        raise FeasibeeError("pays: varies tasks.count; leave out tasks.classes and tasks.points")
    check_stays(scenario.replace({"response.patience": None}), "pays")
    numbers, world = task_numbers(scenario.robots.count), flooded(scenario.replace(POLICIES["ask first"]))
    places = [(policy, tasks) for policy in POLICIES for tasks in numbers]
    designs = [
        DesignPoint({"policy": policy, "tasks.count": tasks}, mission(world, policy, tasks, patience))
        for policy, tasks in places
    ]
    found: dict[str, dict[int, Missions]] = {policy: {} for policy in POLICIES}
    with rounds_of(execution, "simulating missions") as rounds:
        for (policy, tasks), design, record in zip(
            places, designs, rounds.run(Study(designs, runs, seed)), strict=True
        ):
            found[policy][tasks] = _missions(record, design.scenario, patience)
    return Pays(scenario, costs or Costs(), patience, seed, found)


def _missions(record: Record, scenario: Scenario, patience: int) -> Missions:
    ended = record.all_taken_step >= 0
    steps = np.where(ended, record.all_taken_step, scenario.run.steps)
    late = (steps > patience) & bool(scenario.events)
    calls = (record.calls + late).astype(np.float64)
    return Missions(steps.astype(np.float64), record.starts_in_vain.astype(np.float64), calls, ended)


def diagram(found: Pays) -> Figure:
    """Draw the phase diagram, without tags and with them."""
    from feasibee.figures.paying import draw_diagram

    def cell(ratio: float, costs: Costs, policies: Sequence[str]) -> tuple[str, float, bool]:
        best, sure = found.best(ratio, costs, policies)
        return best, found.cost(best, ratio, costs).estimate, sure

    panels = {
        title: [
            [cell(ratio, found.costs._replace(vain=vain), policies) for ratio in RATIOS] for vain in PENALTIES
        ]
        for title, policies in (("Without tags", WITHOUT_TAGS), ("With tags", tuple(POLICIES)))
    }
    return draw_diagram(panels, RATIOS, PENALTIES, tuple(POLICIES))


def sentences(found: Pays) -> list[str]:
    """Return the answer in words: what to do at the scenario's own ratio, and where it changes."""
    names = list(POLICIES)
    costs = {each: found.cost(each, found.ratio, found.costs) for each in names}
    best, sure = found.best(found.ratio, found.costs)
    others = ", ".join(f"{each} {_cost(costs[each])}" for each in names if each != best)
    certain = "" if sure else " The difference to the next is within the intervals."
    regions = "; ".join(
        f"{name} at {_ratios(first, last)}" for name, first, last in found.regions(found.costs.vain)
    )
    ratio, (step, vain, call) = f"{found.ratio:.3g} robots per task", found.costs
    return [
        f"{best[0].upper()}{best[1:]}: with {ratio}, a mission costs {_cost(costs[best])} on average. "
        f"Otherwise: {others}.{certain}",
        f"Without tags, by the number of robots per task: {regions}.",
        f"A mission costs {step:g} per step, {vain:g} per robot that starts in vain, and {call:g} per call "
        f"for help. The operator waits for {found.patience} steps. Numbers of tasks: Poisson.",
    ]


def _cost(cost: Interval) -> str:
    return f"{cost.estimate:,.0f} ({cost.low:,.0f} to {cost.high:,.0f})"


def _ratios(first: float, last: float) -> str:
    return f"{first:g}" if first == last else f"{first:g} to {last:g}"

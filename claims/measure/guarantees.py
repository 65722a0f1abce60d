"""Measure how often swarms declare rightly, in worlds of several shapes, walks and sizes.

The limit of a share is the lower one-sided limit of Clopper and Pearson at 95 %.
"""

from __future__ import annotations

import json
from typing import Any

from scipy.stats import beta

import feasibee
from feasibee.results.measures import declared_right, declared_wrong
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.strategies import turns
from feasibee.strategies.certified import steps_for
from feasibee.strategies.quiet_census import patience

SEED = 23
WORLDS: tuple[tuple[str, int, dict[str, Any], int], ...] = (
    ("as in the paper", 20, {}, 40_000),
    ("40 by 10", 20, {"arena.side": [40, 10]}, 1_000),
    ("100 by 4", 20, {"arena.side": [100, 4]}, 4_000),
    ("walls", 20, {"arena.boundary": "walls"}, 4_000),
    ("100 by 4, walls", 20, {"arena.side": [100, 4], "arena.boundary": "walls"}, 400),
    ("mean run 1", 20, {"walk.mean_run": 1}, 4_000),
    ("mean run 100", 20, {"walk.mean_run": 100}, 1_000),
    ("5 robots, side 10", 5, {"arena.side": 10}, 1_000),
    ("100 robots, side 44.7", 100, {"arena.side": 44.7}, 200),
)
"""Name, number of robots, what else differs from the paper, and number of runs of each strategy."""
STRATEGIES = (
    ("known", "quiet-census", True),
    ("unknown", "quiet-census", False),
    ("turns", "turns", True),
    ("map", "map", True),
)
"""Name in the output, strategy, and whether robots know n."""


def scenario_of(strategy: str, knows: bool, robots: int, tasks: int, changes: dict[str, Any]) -> Any:
    """Return a scenario whose runs last until all robots have declared, in all but a few runs if any."""
    world = {"decision.strategy": strategy, "robots.know_count": knows, "robots.count": robots} | changes
    scenario = feasibee.Scenario().replace({**world, "tasks.count": tasks})
    if strategy == "turns":
        return scenario.replace({"run.steps": 5 * turns.quiet_steps(scenario.setting)})
    return scenario.replace({"run.steps": 4 * quiet_of(scenario)})


def quiet_of(scenario: Any) -> int:
    """Return the quiet time of `quiet-census` in the world of a scenario, for robots that know n."""
    robots = scenario.robots.count
    return steps_for(patience(robots, 0), robots, scenario.setting)


def measured(scenario: Any, runs: int) -> dict[str, Any]:
    """Return the numbers of swarms that declared rightly and wrongly, and the lower limit of the share."""
    record = simulate_record(scenario, Runs(runs, SEED))
    feasible = scenario.robots.count >= scenario.tasks.count
    right = int(declared_right(record, scenario, feasible).sum())
    wrong = int(declared_wrong(record, scenario, feasible).sum())
    return {"right": right, "wrong": wrong, "at_least": float(beta.ppf(0.05, right, runs - right + 1))}


def main() -> None:
    """Print the measures of each world, number of tasks and strategy."""
    rows = []
    for name, robots, changes, runs in WORLDS:
        for tasks in (robots, robots + 1):
            scenarios = {
                short: scenario_of(strategy, knows, robots, tasks, changes)
                for short, strategy, knows in STRATEGIES
            }
            row = {"world": name, "tasks": tasks, "runs": runs, "quiet": quiet_of(scenarios["known"])}
            rows.append(row | {short: measured(scenario, runs) for short, scenario in scenarios.items()})
    print(json.dumps({"rows": rows}, indent=2))


if __name__ == "__main__":
    main()

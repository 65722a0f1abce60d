"""Find out whether it pays if robots ask first, search first, or start at once.

A mission ends when all tasks are taken. It costs its steps, and a penalty for each robot that took a task
while robots were missing. If the swarm holds infeasible for HOLD steps, the missing robots come DELAY steps
later. An operator who hears nothing sends them at the end of its patience. Numbers of tasks are Poisson.
"""

from __future__ import annotations

import argparse
import json
from typing import Any

import numpy as np

import feasibee

EXAMPLE = "example: python research/pays.py --ratio 1 --penalty 10 --missions 100"
POLICIES: dict[str, Any] = {"start at once": 0, "search first": "search", "ask first": "safe"}
HOLD, DELAY, TAIL = 20, 100, 2000  # steps


def mission(robots: int, tasks: int, policy: str, patience: int, seed: int, run: int) -> tuple[int, int]:
    """Return the steps of a mission, and the number of robots that started in vain."""
    scenario = feasibee.Scenario(
        robots={"count": robots, "know_count": True},
        tasks={"count": tasks},
        arena={"side": (20.0 * robots) ** 0.5},  # the paper's density
        decision={"strategy": "roster"},
        acting={"start": POLICIES[policy]},
        run={"steps": patience + DELAY + TAIL},
    )
    missing = max(0, tasks - robots)
    if missing:
        alone = feasibee.simulate(scenario, 1, seed, first_run=run, curves=True).isel(run=0)
        held = alone.infeasible_count.values[:patience] > scenario.decision.threshold * robots
        since = np.convolve(held, np.ones(HOLD, int), "valid") == HOLD  # from this step on, for HOLD steps
        called = int(since.argmax()) + HOLD if since.any() else patience
        scenario = scenario.replace({"events": [{"step": called + DELAY, "robots": missing}]})
    swarm = feasibee.Swarm(scenario, seed, run)
    while (swarm.holders < 0).any() and swarm.step < scenario.run.steps:
        swarm.advance()
    return swarm.step, int(feasibee.simulate(scenario, 1, seed, first_run=run).starts_in_vain[0])


def main() -> None:
    """Print the mean cost of a mission by each policy, with its 95 % interval."""
    parser = argparse.ArgumentParser(description=__doc__, epilog=EXAMPLE)
    parser.add_argument("--robots", type=int, default=20)
    parser.add_argument("--ratio", type=float, default=1.0, help="robots per task, on average")
    parser.add_argument("--penalty", type=float, default=10.0, help="cost of a robot that starts in vain")
    parser.add_argument("--patience", type=int, default=500, help="steps for which the operator waits")
    parser.add_argument("--missions", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    drawn = np.random.default_rng(given.seed).poisson(given.robots / given.ratio, given.missions)
    tasks, found = np.maximum(1, drawn), {}
    for policy in POLICIES:
        missions = [
            mission(given.robots, int(number), policy, given.patience, given.seed, run)
            for run, number in enumerate(tasks)
        ]
        costs = np.array([steps + given.penalty * vain for steps, vain in missions])
        mean, half = float(costs.mean()), 1.96 * float(costs.std(ddof=1)) / len(costs) ** 0.5
        found[policy] = {"cost": mean, "low": mean - half, "high": mean + half}
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()

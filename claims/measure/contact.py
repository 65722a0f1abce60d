"""Measure how much longer decisions take if blocked robots stand still than if they deflect."""

from __future__ import annotations

import json

import feasibee

TASKS = (4, 10, 16, 20, 25, 40, 100)
RUNS = 2000


def main() -> None:
    """Print the least and the largest ratio of mean steps over numbers of tasks, as JSON."""
    ratios = [mean_step("stand", tasks) / mean_step("deflect", tasks) for tasks in TASKS]
    print(json.dumps({"low": min(ratios), "high": max(ratios)}))


def mean_step(contact: str, tasks: int) -> float:
    """Return the mean step of the decision in a walled arena, of the swarms that decide."""
    changes = {"arena.boundary": "walls", "robots.avoid_collisions": True, "robots.contact": contact}
    scenario = feasibee.Scenario().replace({**changes, "tasks.count": tasks, "run.stop_at_decision": True})
    steps = feasibee.simulate(scenario, runs=RUNS, seed=1).decision_step.values
    return float(steps[steps >= 0].mean())


if __name__ == "__main__":
    main()

"""Measure the lengths of messages and the share of silent steps: docs/opinions.md."""

from __future__ import annotations

import json

import feasibee
from feasibee.strategies.census import Knowledge as Census
from feasibee.studies.comparison import TASKS

ROBOTS, STEPS, RUNS = 20, 1000, 5
ID_BITS = 5


def main() -> None:
    """Print the mean length of a tally's message, the share of silent steps, a census's longest message."""
    bits = messages = 0
    for tasks in TASKS:
        scenario = feasibee.Scenario(tasks={"count": tasks}, decision={"strategy": "tally"})
        for run in range(RUNS):
            swarm = feasibee.Swarm(scenario, seed=1, run=run)
            for _ in range(STEPS):
                messages += int(swarm.disseminating.sum())
                swarm.advance()
            bits += swarm.bits_sent
    silent = 1 - messages / (len(TASKS) * RUNS * STEPS * ROBOTS)
    print(json.dumps({"tally": bits / messages, "silent": silent, "census": longest_census(ROBOTS, 21)}))


def longest_census(robots: int, tasks: int) -> int:
    """Return the length in bits of the census message of a robot that knows all robots and tasks."""
    census = Census((0, 0, 0), (1, 1))
    for robot in range(robots):
        census.see_robot(robot, 0, 0)
    for task in range(tasks):
        census.see_task(task, 0, 0)
    return census.bits(census.message(), ID_BITS)


if __name__ == "__main__":
    main()

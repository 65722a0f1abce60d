"""Measure the lengths of messages and the share of silent steps: docs/opinions.md."""

from __future__ import annotations

import json

import feasibee
from feasibee.scenario.messages import message_bits
from feasibee.studies.comparison import TASKS

ROBOTS, STEPS, RUNS = 20, 1000, 5


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
    census = feasibee.Scenario(tasks={"count": 21}, decision={"strategy": "census"})
    longest = message_bits(census).full  # of a robot that knows all
    print(json.dumps({"tally": bits / messages, "silent": silent, "census": longest}))


if __name__ == "__main__":
    main()

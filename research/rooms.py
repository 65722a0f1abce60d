"""Find out how often a door splits a swarm: two rooms, each with its own majority.

A robot that judges by what it meets decides on the ratio of its room. A swarm ends split if the two rooms
have opposite majorities of two thirds. Robots within 1.1 units of the wall between the rooms belong to the
room that they were in last.
"""

from __future__ import annotations

import argparse
import json
from typing import Any

import numpy as np

import feasibee

EXAMPLE = "example: python research/rooms.py --door 1 --runs 200"
SIDE, STEPS, STRIDE = 20.0, 500, 10


def two_rooms(door: float, strategy: str, **changes: Any) -> feasibee.Scenario:
    """Return 20 robots and 16 tasks in two rooms, with a door in the middle of the wall between them."""
    low, high = (SIDE - door) / 2, (SIDE + door) / 2
    ends = (0.0, low), (high, SIDE)
    walls = [[[9.9, first], [10.1, first], [10.1, last], [9.9, last]] for first, last in ends]
    scenario = feasibee.Scenario(
        arena={"side": SIDE, "boundary": "walls"},
        place={"walls": walls},
        robots={"diameter": 0.5, "avoid_collisions": True, "contact": "deflect", "know_count": True},
        tasks={"count": 16},
        decision={"strategy": strategy},
        run={"steps": STEPS, "stop_at_decision": False},
    )
    return scenario.replace(changes)


def run_of(scenario: feasibee.Scenario, seed: int, run: int) -> tuple[bool, float]:
    """Return whether a swarm ends split, and how often a robot changes rooms, on average."""
    swarm, room, changes = feasibee.Swarm(scenario, seed, run), None, 0
    while True:
        x = swarm.positions[:, 0]
        here = x > SIDE / 2
        if room is not None:
            here = np.where(abs(x - SIDE / 2) < 1.1, room, here)
            changes += int((here != room).sum())
        room = here
        if swarm.step >= STEPS:
            break
        swarm.advance(STRIDE)
    shares = [
        (swarm.opinions[room == each] == 1).mean() if (room == each).sum() > 1 else 0.5 for each in (0, 1)
    ]
    return min(shares) <= 1 / 3 and max(shares) >= 2 / 3, changes / len(room)


def measured(scenario: feasibee.Scenario, runs: int, seed: int) -> dict[str, float]:
    """Return the share of split swarms with its 95 % interval, and changes of room per 1,000 steps."""
    split, changes = zip(*(run_of(scenario, seed, run) for run in range(runs)), strict=True)
    share, low, high = feasibee.wilson(sum(split), runs)
    return {"split": share, "low": low, "high": high, "changes": 1000 / STEPS * float(np.mean(changes))}


def main() -> None:
    """Print how often swarms split, as it is, and with what might help."""
    parser = argparse.ArgumentParser(description=__doc__, epilog=EXAMPLE)
    parser.add_argument("--door", type=float, default=1.0, help="width of the door, in units")
    parser.add_argument("--strategy", default="dmmd")
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--seed", type=int, default=5)
    given = parser.parse_args()
    worlds = {
        "as it is": two_rooms(given.door, given.strategy),
        "radio through walls": two_rooms(given.door, given.strategy, **{"radio.walls": 1.0}),
        "twice the door": two_rooms(2 * given.door, given.strategy),
    }
    print(
        json.dumps({name: measured(each, given.runs, given.seed) for name, each in worlds.items()}, indent=1)
    )


if __name__ == "__main__":
    main()

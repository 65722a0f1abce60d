"""The scenarios of the benchmark, and how long a step of theirs takes."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from functools import partial
from typing import Any

from measure import Sample, seconds

import feasibee

SPACE_PER_ROBOT = 20.0  # square units: the paper's 20 robots on 20 x 20
PAPER_ROBOTS = 20
PAPER_TASKS = 100
PAPER_STEPS = 1000

Tables = dict[str, dict[str, Any]]
"""The sections of a scenario."""

BEYOND: dict[str, Tables] = {
    "walls and collisions": {"arena": {"boundary": "walls"}, "robots": {"avoid_collisions": True}},
    "unique observation": {"sensing": {"observation": "unique"}},
    "lost messages": {"radio": {"loss": 0.3}},
    "three classes": {
        "robots": {
            "classes": [
                {"name": "porters", "count": 10, "skills": ["lift"]},
                {"name": "all-rounders", "count": 6, "skills": ["lift", "scan"]},
                {"name": "spares", "count": 4},
            ]
        },
        "tasks": {
            "classes": [
                {"name": "carry", "count": 10, "needs": {"lift": 2, "scan": 1}},
                {"name": "push", "count": 10, "needs": {"lift": 1}},
            ]
        },
    },
}
"""What differs from the paper's world, for 20 robots and 20 tasks."""

HALL: Tables = {
    "units": {"metres": 1.0, "seconds": 0.5},
    "arena": {"side": [60.0, 25.0], "boundary": "walls"},
    "robots": {"count": 35, "speed": 0.25, "diameter": 0.4, "avoid_collisions": True},
    "tasks": {"count": 28},
    "sensing": {"range": 3.0, "miss": 0.05},
    "radio": {"range": 6.0, "loss": 0.05},
    "faults": {"byzantine": 0.03},
    "run": {"steps": 1200},
}
"""A hall with walls, bodies, lost messages and a Byzantine robot, about which an engineer asks."""


def world(robots: int, tasks: int, changes: Tables | None = None) -> Tables:
    """Return the sections of a world with the paper's space per robot."""
    tables = {section: dict(fields) for section, fields in (changes or {}).items()}
    tables.setdefault("arena", {})["side"] = math.sqrt(SPACE_PER_ROBOT * robots)
    for section, count in (("robots", robots), ("tasks", tasks)):
        table = tables.setdefault(section, {})
        if "classes" in table:
            scale = count // sum(each["count"] for each in table["classes"])
            table["classes"] = [{**each, "count": each["count"] * scale} for each in table["classes"]]
        else:
            table["count"] = count
    return tables


def paper(changes: Tables | None = None) -> Tables:
    """Return the sections of the paper's swarm with 100 tasks."""
    return world(PAPER_ROBOTS, PAPER_TASKS, changes)


def scenario(tables: Tables, steps: int) -> feasibee.Scenario:
    """Return the scenario of some sections, with a number of steps."""
    return feasibee.Scenario(**tables, run={"steps": steps})


def robots_of(tables: Tables) -> int:
    """Return the number of robots of some sections."""
    return scenario(tables, 1).robots.count


def whole_runs(tables: Tables, steps: int, runs: int) -> Sample:
    """Return a sample of the CPU time of whole runs on one thread, in ns per robot-step.

    What a call takes for itself is left out: it is the time of one run of one step, 5 to 7 ms, most of it for
    labels of the results.
    """
    play = partial(feasibee.simulate, seed=1, threads=1)
    long, short = scenario(tables, steps), scenario(tables, 1)
    robot_steps = robots_of(tables) * (steps * runs - 1)

    def take() -> float:
        call = seconds(lambda: play(short, 1))
        return 1e9 * (seconds(lambda: play(long, runs)) - call) / robot_steps

    return Sample(warm(tables), take)


def steps_only(
    tables: Tables,
    steps: int,
    runs: int = 1,
    threads: int = 1,
    clock: Callable[[], float] = time.process_time,
) -> Sample:
    """Return a sample of the time of the steps after the first, in ns per robot-step.

    What the start of a swarm takes is left out: it is that of runs of a single step.
    """
    play = partial(feasibee.simulate, runs=runs, seed=1, threads=threads)
    long, short = scenario(tables, steps + 1), scenario(tables, 1)
    robot_steps = robots_of(tables) * steps * runs

    def take() -> float:
        start = seconds(lambda: play(short), clock)
        return 1e9 * (seconds(lambda: play(long), clock) - start) / robot_steps

    return Sample(warm(tables, threads), take)


def warm(tables: Tables, threads: int = 1) -> Callable[[], object]:
    """Return a function that loads the engine, and what a world needs of it."""
    return partial(feasibee.simulate, scenario(tables, 2), 1, seed=1, threads=threads)

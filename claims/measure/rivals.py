"""Measure rules of other authors in the worlds of robots that act: docs/ask-first.md, "Rivals".

The swarms of rules that the package has, too, are checked against its engine, run by run.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from claims.measure.rival_rules import AUCTION, CBAA, GRAPE, NEAREST, RANK, THRESHOLD
from claims.measure.rival_world import Options, empty, play
from feasibee import Scenario, Swarm, simulate
from feasibee.results.statistics import declare_times, wilson
from feasibee.studies.assignment import least, ways_between

RUNS, FEW = 200, 50
STEPS = 2000
UNITS = {"speed": 1.0, "reach": 1, "sight": 2, "radio": 2}
"""Lengths of the paper's world, in units."""
CONTENDERS: Mapping[str, dict[str, Any]] = {
    "greedy, at once": {"rule": NEAREST, "tells": False},
    "gossip, at once": {"rule": NEAREST},
    "gossip, start 40": {"rule": NEAREST, "start": 40},
    "tag, start 60": {"rule": NEAREST, "start": 60, "tags": True},
    "rank, start 100": {"rule": RANK, "start": 100},
    "CBAA, at once": {"rule": CBAA},
    "CBAA, start 40": {"rule": CBAA, "start": 40},
    "threshold, at once": {"rule": THRESHOLD},
    "GRAPE, at once": {"rule": GRAPE},
    "GRAPE, start 40": {"rule": GRAPE, "start": 40},
    "auction, rounds of 10, start 40": {"rule": AUCTION, "start": 40, "length": 10},
    "auction, rounds of 72, all known": {"rule": AUCTION, "length": 72, "knows": True},
}
RADIOS: Mapping[str, dict[str, Any]] = {
    "perfect": {},
    "5 % lost": {"loss": 0.05},
    "30 % lost in bursts": {"loss": 0.3, "burst": 10.0},
    "5 steps late": {"delay": 5},
    "one robot lies": {"lies": 1},
}
SIZES: Mapping[str, tuple[int, int]] = {
    "by_radio": (20, 18),
    "by_radio_twenty": (20, 20),
    "by_radio_fifty": (50, 50),
}
"""Robots and tasks with which all radios are measured."""
MANY = (10, 15, 20, 25, 40)
"""Numbers of tasks with which perfect radio is measured."""
OURS = ("greedy, at once", "gossip, at once", "gossip, start 40", "tag, start 60", "rank, start 100")
"""Contenders that the package has, and what sets them."""
SET: Mapping[str, dict[str, Any]] = {
    "greedy, at once": {"acting.start": 0, "acting.tell": False},
    "gossip, at once": {"acting.start": 0},
    "gossip, start 40": {"acting.start": 40},
    "tag, start 60": {"acting.start": 60, "acting.hold": "tag"},
    "rank, start 100": {"acting.start": 100, "acting.choose": "rank"},
}


class Place(NamedTuple):
    """The start of a run, in fixed point."""

    robots: Any
    tasks: Any
    honest: Any
    soonest: int
    moves: int


def main() -> None:
    """Print all swarms as rows, and how many runs of ours end as those of the engine."""
    cases = [(20, tasks, "perfect") for tasks in MANY]
    cases += [(*size, radio) for size in SIZES.values() for radio in RADIOS]
    rows = [measured(name, *case) for case in dict.fromkeys(cases) for name in CONTENDERS]
    print(json.dumps({"runs": RUNS, "few": FEW, **tables(rows), "same": same_as_engine()}, indent=1))


def tables(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the rows at 20 tasks, medians and 95 % by number of tasks and by radio, and all rows."""

    def across(cases: list[tuple[int, int, str]]) -> list[dict[str, Any]]:
        own = {(row["name"], row["robots"], row["tasks"], row["radio"]): _times(row) for row in rows}
        return [{"name": name, "times": [own[name, *case] for case in cases]} for name in CONTENDERS]

    def at(*case: object) -> list[dict[str, Any]]:
        return [row for row in rows if (row["robots"], row["tasks"], row["radio"]) == case]

    radios = {key: across([(*size, radio) for radio in RADIOS]) for key, size in SIZES.items()}
    return {
        "main": at(20, 20, "perfect"),
        "by_tasks": across([*((20, tasks, "perfect") for tasks in MANY), (50, 50, "perfect")]),
        **radios,
        "lying": at(20, 18, "one robot lies"),
        "bursts": at(20, 20, "30 % lost in bursts"),
        "large": at(50, 50, "perfect"),
        "rows": rows,
    }


def _times(row: Mapping[str, Any]) -> str:
    """Return median and 95 % of a row, and the share of runs in which all is done unless it is 1."""
    steps = "/".join("never" if row[key] is None else f"{row[key]:,}" for key in ("median", "p95"))
    return steps if row["done"] == 1 else f"{steps} (done {row['done']:.3f})"


def world(robots: int, tasks: int, lies: int = 0) -> Scenario:
    """Return the scenario of some robots and tasks, in the paper's density."""
    byzantine = {"faults.byzantine": lies / robots, "faults.byzantine_says": "infeasible"} if lies else {}
    sides = {20: 20.0, 50: 31.6}
    return Scenario().replace(
        {"robots.count": robots, "tasks.count": tasks, "arena.side": sides[robots], **byzantine}
    )


@cache
def places(robots: int, tasks: int, lies: int, runs: int) -> list[Place]:
    """Return the starts of runs, with the assignments that no swarm betters."""
    scenario, found = world(robots, tasks, lies), []
    unit = scenario.arena.size[0] / 2**32
    for run in range(runs):
        swarm = Swarm(scenario, 1, run)
        best = least(ways_between(scenario, swarm.positions, swarm.tasks)[swarm.counted])
        whole = [np.rint(each / unit).astype(np.int64) for each in (swarm.positions, swarm.tasks)]
        found.append(Place(*whole, swarm.counted, best.maximum_steps, best.moves))
    return found


def measured(name: str, robots: int, tasks: int, radio: str) -> dict[str, Any]:
    """Return what the swarms of a contender reach, as a row."""
    runs = FEW if "all known" in name or robots > 20 else RUNS
    air = dict(RADIOS[radio])
    lies = air.pop("lies", 0)
    starts = places(robots, tasks, lies, runs)
    changes = {**CONTENDERS[name], **air}
    if lies and name in OURS:
        changes["tolerates"] = lies
    steps, found = played(starts, world(robots, tasks).arena.size[0], changes)
    return {"name": name, "robots": robots, "tasks": tasks, "radio": radio, **summary(starts, steps, found)}


def played(starts: list[Place], side: float, changes: Mapping[str, Any]) -> tuple[Any, Any]:
    """Return the step at which all is done in each run, -1 if never, and the sums of `rival_world.play`."""
    given, unit = dict(changes), 2**32 / side
    knows = given.pop("knows", False)
    lengths = {key: type(length)(length * unit) for key, length in UNITS.items()}
    common = {
        **{"start": 0, "tags": False, "tells": True, "tolerates": 0, "mind": False, "length": 1},
        **lengths,
    }
    common |= {"delay": 0, "loss": 0.0, "burst": 0.0, "low": 1, "high": 0, "steps": STEPS, **given}
    steps, found = [], []
    for run, each in enumerate(starts):
        swarm, said = empty(each.robots, each.tasks, each.honest, common["delay"])
        if knows:
            swarm.state[:] = 0
        step, sums = play(swarm, said, each.tasks, Options(run=run, **common))
        steps.append(step)
        found.append(sums)
    return np.array(steps), np.array(found)


def summary(starts: list[Place], steps: Any, found: Any) -> dict[str, Any]:
    """Return shares, times and means of some runs."""
    robots, runs = len(starts[0].robots), len(starts)
    done, times = wilson(int((steps >= 0).sum()), runs), declare_times(steps)
    moved, vain, bits, going, double, taken = found.sum(axis=0)
    lasted = np.where(steps < 0, STEPS, steps)
    wanted = sum(min(len(each.tasks), int(each.honest.sum())) for each in starts)
    return {
        **{"runs": runs, "done": done.estimate, "done_low": done.low},
        **{"median": times.median, "p95": times.p95},
        **{"low": times.median_interval[0], "high": times.median_interval[1]},
        "over": float(np.median(lasted / [each.soonest for each in starts])),
        "distance": float(moved / robots / runs),
        "distance_over": float(moved / sum(each.moves for each in starts)),
        "bits": float(bits / robots / lasted.sum()),
        "vain": float(vain / runs),
        "double": float(double / max(1, going)),
        "untaken": float(1 - taken / wanted),
    }


def same_as_engine() -> float:
    """Return the share of runs of our contenders that end at the same step as those of the engine."""
    same = []
    rest = {"decision.strategy": "quiet-census", "robots.know_count": True, "run.stop_when_taken": True}
    for name, changes in SET.items():
        for air in ({}, {"radio.loss": 0.05}, {"radio.delay": 5}):
            scenario = world(20, 20).replace({**rest, **changes, **air, "run.steps": STEPS})
            ended = simulate(scenario, runs=FEW, seed=1).all_taken_step.values
            mine = {key.partition(".")[2]: value for key, value in air.items()}
            steps, _ = played(places(20, 20, 0, RUNS)[:FEW], 20.0, {**CONTENDERS[name], **mine})
            same += [*(steps == ended)]
    return float(np.mean(same))


if __name__ == "__main__":
    main()

"""Rooms of a place: whether swarms split into rooms, how often robots change rooms, and what would help."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.errors import ScenarioError
from feasibee.model.codes import NO_OPINION, exact
from feasibee.results.statistics import Interval, wilson
from feasibee.scenario.bitmaps import Cells, image_of
from feasibee.scenario.ground import Ground, connected, ground_of, grown
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.swarm import Swarm
from feasibee.studies.flooding import flooded, go_on

RUNS: Final = 100
STRIDE: Final = 10
"""Steps between two looks at where robots are."""
LEAST_AREA: Final = 0.01
"""Share of the passable cells that a room has at least."""
MAJORITY: Final = 2 / 3
LEAST_ROBOTS: Final = 2
"""Robots of a room with a majority."""
LEAST_SPLIT: Final = 0.02
"""Share of split swarms above which robots are said to decide on their room's ratio."""
WIDER: Final = 1.0
"""Units by which doors are widened."""


class Split(NamedTuple):
    """How robots of a place share out over its rooms."""

    rooms: int
    """Number of rooms."""
    split: Interval
    """Share of the runs in which two rooms have opposite majorities of two thirds at the last step."""
    passages: float
    """Mean number of times that a robot comes into another room, per 1,000 steps."""


def rooms_of(scenario: Scenario) -> NDArray[np.int32]:
    """Return the number of each cell's room, from 1 on: int32, shape (rows, columns); 0 is none.

    A room is a part of the passable cells that hangs together where a disc fits whose radius is half the
    range of sight. Rooms with less than 1 % of the passable cells are none.
    """
    ground = ground_of(scenario)
    assert ground is not None
    near = grown(~ground.passable, math.ceil(_reach(scenario, ground) ** 2) - 1)  # closed ones, or the edges
    cores = connected(ground.passable & ~near, 0)
    areas = np.bincount(cores.ravel())
    large = areas >= LEAST_AREA * ground.passable.sum()
    large[0] = False
    return np.where(large, np.cumsum(large), 0).astype(np.int32)[cores]


def _reach(scenario: Scenario, ground: Ground) -> float:
    """Return half the range of sight, in cells."""
    return float(exact(scenario.sensing.range) / ground.plan.cell / 2)


def split_of(
    scenario: Scenario, seed: int, runs: int = RUNS, check: Callable[[], None] = go_on
) -> Split | None:
    """Simulate swarms in a place, and find where their robots are; None without two rooms.

    Parameters
    ----------
    scenario : Scenario
        The swarm and its place.
    seed, runs : int
        Seed and number of the runs.
    check : callable
        As in `flooded`.
    """
    if not scenario.place.exists or scenario.dynamic:
        return None
    rooms = rooms_of(scenario)
    if rooms.max() < 2:
        return None
    found = [_run(Swarm(scenario, seed, run), rooms, check) for run in range(runs)]
    passages = 1000 * np.mean([each[1] for each in found]) / scenario.run.steps
    return Split(int(rooms.max()), wilson(sum(each[0] for each in found), runs), float(passages))


def _run(swarm: Swarm, rooms: NDArray[np.int32], check: Callable[[], None]) -> tuple[bool, float]:
    """Return whether a swarm ends split, and how often its robots came into another room on average."""
    plan = swarm.scenario.plan
    assert plan is not None
    last, passages = np.zeros(len(swarm.opinions), np.int32), 0
    steps = swarm.scenario.run.steps
    while True:
        check()
        columns, rows = (
            np.minimum(np.nan_to_num(swarm.positions) / float(plan.cell), np.array(rooms.shape)[::-1] - 1)
            .astype(int)
            .T
        )
        there = np.where(swarm.present, rooms[rows, columns], 0)
        passages += int(np.count_nonzero((there > 0) & (last > 0) & (there != last)))
        last = np.where(there > 0, there, last)
        if swarm.step >= steps:
            break
        swarm.advance(min(STRIDE, steps - swarm.step))
    return is_split(last[swarm.counted], swarm.opinions[swarm.counted]), passages / len(last)


def is_split(rooms: NDArray[np.int32], opinions: NDArray[np.int8]) -> bool:
    """Return whether two rooms have opposite majorities of two thirds, with the room of each robot."""
    majorities = set()
    for room in set(rooms[rooms > 0].tolist()):
        own = opinions[(rooms == room) & (opinions != NO_OPINION)]
        if own.size >= LEAST_ROBOTS:
            majorities |= {answer for answer in (0, 1) if np.mean(own == answer) >= MAJORITY}
    return len(majorities) == 2


def changes_of_place(scenario: Scenario) -> dict[str, dict[str, Any]]:
    """Return what may help in rooms: starts everywhere, radio through walls, wider doors."""
    if not scenario.place.exists:
        return {}
    found: dict[str, dict[str, Any]] = {}
    if scenario.robots.zone is not None:
        found["robots that start everywhere"] = {"robots.zone": None}
    if scenario.radio.walls < 1:
        found["radio through walls"] = {"radio.walls": 1.0}
    wider = widened(scenario)
    if wider is not None:
        found[f"doors wider by {WIDER:g}"] = {"place.map": wider, "place.walls": ()}
    return found


def widened(scenario: Scenario) -> dict[str, Any] | None:
    """Return a map without the walls around the doors between rooms; None without such doors."""
    ground = ground_of(scenario)
    assert ground is not None
    reach, rooms = _reach(scenario, ground), rooms_of(scenario)
    doors = _doors(ground.passable, rooms, reach)
    if not doors.any():
        return None
    cells = float(
        exact(scenario.robots.diameter / 2 + scenario.robots.speed / 8 + WIDER / 2) / ground.plan.cell
    )
    return {
        "cell": float(ground.plan.cell),
        "image": image_of(ground.plan.walls & ~_grown(doors, cells)),
    }


def _grown(cells: Cells, reach: float) -> Cells:
    """Return which cells are at most so many cells from some, without the edges."""
    pad = math.ceil(reach) + 2
    return grown(np.pad(cells, pad), math.ceil(reach**2))[pad:-pad, pad:-pad]


def _doors(passable: Cells, rooms: NDArray[np.int32], reach: float) -> Cells:
    """Return the passable cells between two rooms, in which no disc of a room's size fits."""
    bodies = [_grown(rooms == room, reach + 1) for room in range(1, rooms.max() + 1)]
    narrow = connected(passable & ~np.logical_or.reduce([np.zeros_like(passable), *bodies]), 0)
    touched = np.zeros(int(narrow.max()) + 1, np.int64)
    for body in bodies:
        touched[np.unique(narrow[_grown(body, 1.0)])] += 1
    touched[0] = 0
    return (touched > 1)[narrow]


def splits_of(
    scenario: Scenario, seed: int, runs: int = RUNS, check: Callable[[], None] = go_on
) -> dict[str, Split]:
    """Return how robots share out over rooms, as it is (under an empty name) and with each change.

    All have the same runs. Without two rooms, there is nothing to return. ``check`` is as in `flooded`.
    """
    scenario = scenario if scenario.dynamic else flooded(scenario, check)
    own = split_of(scenario, seed, runs, check)
    if own is None:
        return {}
    found: dict[str, Split] = {"": own}
    for name, changes in changes_of_place(scenario).items():
        with suppress(ScenarioError):
            changed = split_of(flooded(scenario.replace(changes), check), seed, runs, check)
            found |= {} if changed is None else {name: changed}
    return found


def rooms_in_words(splits: Mapping[str, Split]) -> list[str]:
    """Return in words how many swarms split into rooms, and what changes of the place do to it."""
    lines = []
    for name, (rooms, split, passages) in splits.items():
        shown = f"{100 * split.estimate:.0f} % ({100 * split.low:.0f} to {100 * split.high:.0f} %)"
        if name:
            lines.append(f"With {name}, {shown} are split, with {passages:.3g} changes of room.")
            continue
        why = " Robots decide on their room's ratio." if split.low > LEAST_SPLIT else ""
        lines.append(
            f"The place has {rooms} rooms, and a robot changes rooms {passages:.3g} times in 1,000 steps. "
            f"Of the swarms, {shown} end split, with opposite majorities of two thirds in two rooms.{why}"
        )
    return lines

"""How soon names flood a place: by it, robots there know how long to wait (model.md 6.20.14)."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.base.cache import cache_root
from feasibee.base.record import Record
from feasibee.results.statistics import declare_times
from feasibee.scenario.ground import ground_of
from feasibee.scenario.scenario import Scenario
from feasibee.strategies import GOSSIP, gossip
from feasibee.strategies.certified import NEVER

SEED: Final = 28
"""Seed of all runs, whatever that of a study: one place has one time of flooding."""
LONGEST: Final = 20_000
"""Steps of a run at most; a place whose names take longer has no time of flooding."""
FIRST: Final = 20
"""Runs that come first: if names take too long in one of them, there are no more."""
ALL: Final = 0.999_999_9
"""Share of the robots that all but one don't exceed, however many there are."""
LEFT_OUT: Final = {
    "robots": {"classes", "arrival_rate", "failure_rate", "most", "work", "charge", "away", "know_count"},
    "tasks": {"classes", "arrival_rate", "lifetime", "work"},
    "sensing": {"false_robots", "false_tasks", "misname", "position_error", "gate"},
    "radio": {"id_bits"},
    "decision": {"parameters", "declare", "quality_floor", "start", "strategy", "threshold"},
}
"""Fields that change no time of flooding, or that would make the world change or names wrong."""


class Flooding(NamedTuple):
    """The step by which all robots know all names of tasks, over many runs."""

    median: int | None
    """None if half of the runs take more than 20,000 steps; likewise the quantile."""
    p95: int | None
    slowest: int
    """That of the slowest run; `NEVER` if one takes more than 20,000 steps."""


def runs_of(scenario: Scenario) -> int:
    """Return the number of runs: 1,000 for up to 50 robots, fewer for more, 200 at least.

    Fewer than 0.003 of all runs take longer than the slowest of 1,000, and 0.015 than that of 200 (95 %). The
    times of many robots vary less.
    """
    return max(200, min(1000, 50_000 // scenario.robots.count))


def flooding(scenario: Scenario, progress: Callable[[float], None] | None = None) -> Flooding:
    """Simulate how soon names flood a scenario's arena, whatever its strategy.

    Robots keep all names that they see and hear, and broadcast all, in the phases of the scenario. There is
    one task more than robots, unless tasks are at given points. In a place, a robot knows all names of its
    piece. In a world that changes, robots and tasks are those of the start.

    Parameters
    ----------
    scenario : Scenario
        The swarm and its place.
    progress : callable, optional
        Called with the share of the runs that are done, from 0 to 1.
    """
    world = _world_of(scenario)
    runs = runs_of(world)
    steps = _steps(world, 0, min(FIRST, runs), None)
    if steps.min() >= 0:
        steps = np.concatenate([steps, _steps(world, len(steps), runs - len(steps), progress)])
    times = declare_times(steps)
    return Flooding(times.median, times.p95, NEVER if steps.min() < 0 else int(steps.max()))


def flooded(scenario: Scenario, progress: Callable[[float], None] | None = None) -> Scenario:
    """Return a scenario that knows in which time names flood its place, if its robots wait for that.

    The time is simulated once, and kept in the scenario, in memory and in the cache.
    """
    if scenario.flooding is not None or not scenario.waits_for_names:
        return scenario
    world = _world_of(scenario)
    key = f"{world.hash}-{runs_of(world)}"
    with _one_at_a_time:
        if key not in _known:
            folder = cache_root() / "flooding"
            found = _kept(folder, key)
            _known[key] = flooding(scenario, progress).slowest if found is None else found
            if found is None:
                _keep(folder, key, _known[key])
        scenario.__dict__["_flooding"] = _known[key]
    return scenario


def within(scenario: Scenario) -> int | None:
    """Return the step by which names flood a scenario's place; None if they take too long."""
    found = flooded(scenario).flooding
    return None if found == NEVER else found


def flooding_in_words(scenario: Scenario) -> list[str]:
    """Return a line on how soon names flood a scenario's place, if its robots wait for that."""
    if not scenario.waits_for_names:
        return []
    found, runs = within(scenario), runs_of(scenario)
    if found is not None:
        return [f"Names flood this place by step {found:,}, the latest of {runs:,} runs; robots wait by it."]
    never = "never act" if scenario.acts else "that wait for a quiet time never declare feasible"
    return [f"Names take more than {LONGEST:,} steps to flood this place: robots {never}."]


def _world_of(scenario: Scenario) -> Scenario:
    """Return the world in which names flood: the same for all scenarios that have equal times of flooding."""
    tables = scenario.to_dict()
    world: dict[str, Any] = {
        name: {key: value for key, value in tables.get(name, {}).items() if key not in LEFT_OUT.get(name, ())}
        for name in ("arena", "place", "robots", "tasks", "walk", "sensing", "radio", "decision", "faults")
    }
    robots, at_points = scenario.robots.count, scenario.tasks.placement == "points"
    world["robots"]["count"] = robots
    world["tasks"]["count"] = scenario.tasks.count if at_points else robots + 1
    world["decision"] |= {"strategy": gossip.__file__, "quality_floor": 0, "start": "coin", "threshold": ALL}
    world["run"] = {"steps": LONGEST, "stop_at_declarations": True}
    return Scenario.from_tables(world)


def _steps(
    world: Scenario, first: int, runs: int, progress: Callable[[float], None] | None
) -> NDArray[np.int64]:
    """Return the step by which all counted robots know all names that they can, for each run; -1 if never."""
    from feasibee.engine import runner
    from feasibee.simulation.lowering import lower

    lowered, record = lower(world, SEED), Record.empty(first, runs, 0, 0)
    setting = lowered.setting._replace(plan=_wanted(world).tobytes())
    lowered = lowered._replace(setting=setting, strategy=GOSSIP)  # the same, compiled with the engine
    runner.simulate(lowered, record, progress=progress)
    return record.declare_step.astype(np.int64)


def _wanted(world: Scenario) -> NDArray[np.uint8]:
    """Return how many names there are for each robot to know, as `gossip.declare` reads them."""
    ground = ground_of(world)
    if ground is None or ground.is_one:
        return np.zeros(0, np.uint8)
    pieces = np.bincount(ground.tasks.piece, minlength=int(ground.robots.piece.max()) + 1)
    wanted = pieces[ground.robots.piece]
    shifts = np.arange(gossip.WANTED_BYTES)[::-1] * 8
    return (wanted[:, None] >> shifts & 255).astype(np.uint8).ravel()


def _kept(folder: Path, key: str) -> int | None:
    """Return the time that is kept as the end of a file's name; None without such a file."""
    with suppress(OSError, ValueError):
        for file in folder.glob(f"{key}-*"):
            return int(file.name.rpartition("-")[2])
    return None


def _keep(folder: Path, key: str, steps: int) -> None:
    """Keep a time; a folder that can't be written to costs the next process the simulation."""
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{key}-{steps}").touch()  # without content, which could be damaged


_known: Final[dict[str, int]] = {}
_one_at_a_time: Final = threading.Lock()

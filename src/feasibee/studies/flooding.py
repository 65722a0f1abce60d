"""How soon names flood a place: by it, robots there know how long to wait (place.flooding)."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import local
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.errors import Problem, ScenarioError
from feasibee.results.statistics import declare_times
from feasibee.scenario.fields import Acting
from feasibee.scenario.ground import ground_of
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.ensemble import check_progress, processors
from feasibee.simulation.loading import load_engine
from feasibee.simulation.swarm import Swarm
from feasibee.studies import oracle

RUNS: Final = 1000
SEED: Final = 28
"""Seed of all runs, whatever that of a study: one place has one time of flooding."""
LONGEST: Final = 20_000
"""Steps of a run at most; a place whose names take longer has no time of flooding."""
STRIDE: Final = 100
NEVER: Final = -1
KNOWN: Final = 256
"""Number of worlds whose times of flooding are kept in memory."""
ROOM: Final = 2**28
"""Largest memory in bytes of what an oracle's robots know."""
STAYING: Final[dict[str, Any]] = {
    **{"events": [], "robots.arrival_rate": None, "robots.failure_rate": None, "robots.most": None},
    **{"tasks.arrival_rate": None, "tasks.lifetime": None, "robots.work": None, "robots.charge": None},
    "robots.away": "counted",
}
"""What makes a world stay as it is at the start."""
SEARCHING: Final[dict[str, Any]] = {
    **{f"acting.{name}": field.default for name, field in Acting.model_fields.items()},
    "run.stop_when_taken": False,
    "tasks.work": None,
}
"""What makes robots search for good, whoever acts."""


class Flooding(NamedTuple):
    """The step by which all robots know all names of tasks, over 1,000 runs."""

    median: int | None
    """None if half of the runs take more than 20,000 steps; likewise the quantiles."""
    p95: int | None
    slowest: int | None
    """That of the slowest run: what ``place.flooding`` is. Fewer than 0.003 of all take longer (95 %)."""


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

    Raises
    ------
    FeasibeeError
        If robots or tasks have classes, or the arena is too large.
    """
    check_progress(progress)
    return _flooding(_world_of(scenario), progress, go_on)


def go_on() -> None:
    """Let the simulation go on to its end, however long it takes."""


def _world_of(scenario: Scenario) -> Scenario:
    """Return the world in which names flood: the same for all scenarios that have equal times of flooding."""
    changes: dict[str, Any] = {"run.steps": LONGEST, "run.stop_at_decision": False, **STAYING}
    if scenario.tasks.placement != "points":
        changes["tasks.count"] = scenario.robots.count + 1
    if scenario.place.exists:
        changes["place.flooding"] = None
    world = with_oracle(scenario.replace({**changes, "run.stop_at_declarations": False}), 1, "flooding is")
    return world.replace({"decision.listen": scenario.decision.listen})


def _flooding(
    world: Scenario, progress: Callable[[float], None] | None, check: Callable[[], None]
) -> Flooding:
    load_engine(world)
    steps, wanted, own = np.empty(RUNS, np.int64), can_know(world), local()

    def found_in(run: int) -> int:
        if not hasattr(own, "swarm"):  # one for each thread: to make one takes longer than its run
            own.swarm = Repeated(world, SEED, run)
        own.swarm.begin(run)
        return _flooded_at(own.swarm, wanted, check)

    with ThreadPoolExecutor(processors()) as pool:
        for run, step in enumerate(pool.map(found_in, range(RUNS))):
            steps[run] = step
            if progress is not None:
                progress((run + 1) / RUNS)
    times = declare_times(steps)
    return Flooding(times.median, times.p95, None if NEVER in steps else int(steps.max()))


def with_oracle(scenario: Scenario, cells_per_range: int, what: str) -> Scenario:
    """Return the scenario with the oracle in place of its strategy.

    Raises
    ------
    FeasibeeError
        If robots or tasks have classes, or the oracle's robots would know too much.
    """
    for path in ("robots.classes", "tasks.classes"):
        classes = scenario.get(path)
        if classes:
            rule = f"{what} those of robots that can all do all tasks"
            names = [each.name for each in classes]
            raise ScenarioError([Problem(path, names, rule, f"use {path.split('.')[0]}.count instead")])
    world = scenario.replace(
        {
            "decision.strategy": str(Path(oracle.__file__)),
            "decision.parameters": {
                "cells_per_range": float(cells_per_range),
                "range": scenario.sensing.range,
            },
            "decision.declare": None,
            **SEARCHING,
            "decision.start": "coin",
            "decision.listen": "always",
            "decision.quality_floor": 0,
            "sensing.false_robots": 0.0,
            "sensing.false_tasks": 0.0,
            "sensing.misname": 0.0,
            "sensing.position_error": 0.0,
        }
    )
    setting = world.setting
    needed = 8 * setting.robots * oracle.words(setting)
    if needed > ROOM:
        size = f"{setting.robots} robots with {oracle.cells(setting)} cells take {needed / 2**20:.0f} MiB"
        fitting = scenario.sensing.range * math.sqrt(needed / ROOM) * 1.01
        remedy = f"use fewer robots, a smaller arena, or a range of {fitting:.3g}"
        problem = Problem("sensing.range", scenario.sensing.range, f"{size}, above {ROOM // 2**20}", remedy)
        raise ScenarioError([problem])
    return world


class Repeated(Swarm):
    """A swarm that plays one run after another."""

    def begin(self, run: int) -> None:
        """Go to step 0 of a run."""
        if self.step > 0 or run != self._which.first:
            self._which = Runs.single(self._which.seed, run)
            self._begin(self._inboxes)


def can_know(world: Scenario) -> NDArray[np.bool_]:
    """Return whether each robot can know each task: shape (robots, tasks)."""
    ground = ground_of(world)
    if ground is None:
        return np.ones((world.robots.count, world.tasks.count), np.bool_)
    return np.equal.outer(ground.robots.piece, ground.tasks.piece)


def _flooded_at(swarm: Repeated, wanted: NDArray[np.bool_], check: Callable[[], None]) -> int:
    """Return the first step by which all counted robots know all wanted tasks; -1 if never."""
    start, wanted = oracle.known_start(swarm.scenario.setting), wanted & swarm.counted[:, None]
    while swarm.step < LONGEST:
        check()
        swarm.advance(STRIDE)
        known = swarm.knowledge[:, start : start + wanted.shape[1]][wanted]
        if known.all():
            return int(known.max(initial=0))
    return NEVER


def acts_late(scenario: Scenario) -> bool:
    """Return whether robots act in a place from a step on that follows from its time of flooding."""
    return scenario.place.exists and scenario.acting.start in ("search", "safe")


def lacks_flooding(scenario: Scenario) -> bool:
    """Return whether a scenario has a place without a time of flooding, for which its robots may wait."""
    waits = scenario.manifest.needs_names or acts_late(scenario)
    return scenario.place.exists and scenario.place.flooding is None and bool(waits)


def flooded(scenario: Scenario, check: Callable[[], None] = go_on) -> Scenario:
    """Return a scenario with the time of flooding in its place, if its robots may wait for it.

    A time that it has already is kept. ``check`` is called often, and ends the simulation by an exception.
    """
    if not lacks_flooding(scenario):
        return scenario
    if scenario.robots.classes or scenario.tasks.classes:
        return scenario
    world = _world_of(scenario)
    found = _known.pop(world, None)
    if found is None:
        check()
        found = _flooding(world, None, check)
    if len(_known) == KNOWN:
        del _known[next(iter(_known))]
    _known[world] = found  # the latest used is the last
    return scenario.replace({"place.flooding": found.slowest})


_known: Final[dict[Scenario, Flooding]] = {}

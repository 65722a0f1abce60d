"""Physical limits of a swarm: how soon robots have seen, and can know, enough to be sure.

In each run an oracle's robots look, broadcast all that they saw and hear in every step
(``feasibee.studies.oracle``), on the trajectories that the scenario's swarm has with that seed. No robot of
any strategy knows more at any step: docs/limits.md has the proof.

Robots of some strategies declare (model.md 6.15). Those of others commit to an opinion (6.14). The frontier
shows what both reach by their own word, near ratio one, with the limits of their scenario behind.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from threading import local
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from feasibee.errors import ScenarioError
from feasibee.figures.limits import Panel, Word, draw_frontier, draw_limits
from feasibee.figures.style import save_both
from feasibee.files import write_table
from feasibee.model.codes import DECISIONS
from feasibee.results.measures import columns, least_quorum
from feasibee.results.statistics import DeclareTimes, declare_times, plain
from feasibee.scenario.runs import Runs, check_integer
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.ensemble import THREADS_LIMIT, check_progress, check_scenario, processors
from feasibee.simulation.loading import load_engine
from feasibee.simulation.snapshot import members
from feasibee.simulation.swarm import Swarm
from feasibee.strategies.contract import Setting
from feasibee.studies import oracle
from feasibee.studies.assignment import Least, done_between, least, ways_between
from feasibee.studies.comparison import Outcome, check_distinct, check_stays, origin
from feasibee.studies.flooding import NEVER, Repeated, can_know, with_oracle

LIMITS: Final[Mapping[str, str]] = {
    "pooled": "all sightings together name all tasks, or one more than there are robots",
    "flooding": "enough robots to decide can know those names",
    "area": "all robots together have seen the centre of each cell of the area",
    "complete_map": "enough robots to decide can know that all of these were seen",
}
"""What has happened by the step of each limit."""
TAKEN: Final[Mapping[str, str]] = {
    "least_sum": "all tasks taken, or as many as there are robots, if all know all and walk least in total",
    "least_maximum": "the same at the soonest",
    "mapped_sum": "as least sum, if robots search until the complete map",
    "mapped_maximum": "the same at the soonest",
}
"""Likewise if robots act (model.md 6.25), by the assignments of `feasibee.studies.assignment`."""
DONE: Final[Mapping[str, str]] = {
    "done_bound": "no swarm has done all tasks before",
    "done_schedule": "all tasks done, if all know all at the start and keep a schedule: a deadline they meet",
}
"""Likewise if tasks take time (model.md 6.26)."""
BOUNDS: Final[Mapping[str, str]] = {"infeasible": "flooding", "proved_feasible": "complete_map"}
"""Which limit bounds the step by which a swarm of any strategy declares, if none of its robots ever errs."""
STRIDE: Final = 80
"""Number of steps between two looks at what robots know; runs of the paper's world take about 70.

To call the engine costs as much time as 40 steps of 20 robots."""


@dataclass(frozen=True)
class Limits:
    """Physical limits of a scenario: the first step by which each was reached, per run."""

    scenario: Scenario
    """The swarm and its world."""
    seed: int
    """Seed of the runs."""
    steps: Mapping[str, NDArray[np.int64]]
    """First step of each of `LIMITS` and, if robots act, ``TAKEN``, ``DONE``, shape (runs,); -1 if never."""
    cell: tuple[float, float]
    """Width and height in units of a cell of the area, which is seen when its centre is in range."""
    distance: float | None = None
    """If robots act, mean distance in units that a robot walks until ``least_sum``."""

    @property
    def runs(self) -> int:
        """Number of runs."""
        return next(iter(self.steps.values())).size

    @property
    def times(self) -> dict[str, DeclareTimes]:
        """Median and 95 % quantile of the step of each limit, with 95 % intervals; None is never."""
        return {name: declare_times(steps) for name, steps in self.steps.items()}

    def to_dict(self) -> dict[str, Any]:
        """Return the limits as plain tables, for programs."""
        return {
            **plain(self.times),
            **({} if self.distance is None else {"distance": self.distance}),
            "bounds": dict(BOUNDS),
            "cell": list(self.cell),
            "runs": self.runs,
            "scenario": self.scenario.to_dict(),
            **origin(self.seed, self.scenario),
        }


def limits(
    scenario: Scenario | None = None,
    runs: int = 1000,
    seed: int = 0,
    *,
    cells_per_range: int = 4,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Limits:
    """Compute the physical limits of a scenario, for any strategy.

    Robots look, broadcast all that they know and hear in every step, as no robot of a strategy can.

    Parameters
    ----------
    scenario : Scenario, optional
        The swarm and its world; by default the paper's swarm with 20 tasks.
    runs, seed : int
        Number of runs, and their seed; the trajectories are those of `feasibee.simulate`.
    cells_per_range : int
        How finely the area is divided, from 1 to 64: with smaller cells, there is more to see.
    threads : int, optional
        Number of threads, by default one per processor. It changes no result.
    progress : callable, optional
        Called with the share of the runs that are done, from 0 to 1.

    Raises
    ------
    FeasibeeError
        If an argument is invalid, if robots or tasks have classes, or if the world is too large.

    Examples
    --------
    >>> from feasibee.studies.limits import limits
    >>> limits(runs=100, seed=1).times["flooding"].median
    42
    """
    scenario = check_scenario(scenario)
    (found,) = limits_at(
        {scenario.tasks.count: scenario}, runs, seed, cells_per_range, threads, progress
    ).values()
    return found


def limits_at(
    worlds: Mapping[int, Scenario],
    runs: int,
    seed: int,
    cells_per_range: int = 4,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> dict[int, Limits]:
    """Compute the limits of scenarios that differ in their numbers of tasks alone, as `limits`.

    Fewer tasks are the first ones of more (model.md 1.3), and robots move alike: one swarm has all limits.
    """
    which, most = Runs(runs, seed), worlds[max(worlds)]
    threads = processors() if threads is None else check_integer("threads", threads, 1, THREADS_LIMIT)
    check_progress(progress)
    world = oracle_world(most, cells_per_range)
    acts = most if most.acts else None
    steps = _steps_of(world, list(worlds), which, threads, progress, acts)
    setting = world.setting
    cell = setting.width / oracle.columns(setting), setting.height / oracle.rows(setting)
    found = {}
    for place, (number, each) in enumerate(worlds.items()):
        columns = dict(zip((*LIMITS, *_names(acts)), steps[:, place].T, strict=True))
        moves = columns.pop("moves", None)
        walked = None if moves is None else float(moves.mean() * each.robots.speed / each.robots.count)
        found[number] = Limits(each, which.seed, columns, cell, walked)
    return found


def _steps_of(
    world: Scenario,
    tasks: Sequence[int],
    runs: Runs,
    threads: int,
    progress: Callable[[float], None] | None,
    acts: Scenario | None,
) -> NDArray[np.int64]:
    """Return the first step of each limit in each run: shape (runs, len(tasks), limits); -1 if never.

    If robots act, as ``acts`` says, what `_names` names follows.
    """
    load_engine(world)
    steps = np.empty((runs.count, len(tasks), len(LIMITS) + len(_names(acts))), np.int64)
    own = local()

    def found_in(run: int) -> list[list[int]]:
        if not hasattr(own, "swarm"):  # one for each thread: to make one takes longer than its run
            own.swarm = Tireless(world, runs.seed, run)
        found = limits_of_run(own.swarm, run, tasks)
        if acts is None:
            return found
        more = _taken(own.swarm, run, found[0][-1], tasks, acts)
        return [each + rest for each, rest in zip(found, more, strict=True)]

    with ThreadPoolExecutor(threads) as pool:
        found = pool.map(found_in, range(runs.count))
        for run, each in enumerate(found):  # an exception here cancels the runs that are left
            steps[run] = each
            if progress is not None:
                progress((run + 1) / runs.count)
    return steps


def oracle_world(scenario: Scenario, cells_per_range: int) -> Scenario:
    """Return the scenario with the oracle in place of its strategy.

    Raises
    ------
    FeasibeeError
        If the world changes, robots or tasks have classes, or the oracle's robots would know too much.
    """
    check_stays(scenario, "limits")
    check_integer("cells_per_range", cells_per_range, 1, 64)
    return with_oracle(scenario, cells_per_range, "limits are")


class Tireless(Repeated):
    """A swarm whose robots explore, broadcast and hear in every step, as no robot of the model can.

    The engine lets a robot broadcast that is in the set of those that speak, whatever its phase.
    """

    def _begin(self, room: Any) -> None:
        super()._begin(room)
        layout, state, robots = self._layout, self._state, slice(self._params.robots.count)
        state.robots[layout.Robot.PHASE_LEFT] = np.iinfo(np.int32).max
        state.sets[layout.Set.SPEAKING] = state.sets[layout.Set.WORKING]
        state.robots[layout.Robot.LABEL, robots] |= members(state.sets[layout.Set.WORKING])[robots]

    def _play(self, until: int) -> None:
        if until > 0:  # step 0 is recorded with the first steps: a call takes as long as 40 steps
            super()._play(until)


def limits_of_run(swarm: Tireless, run: int, tasks: Sequence[int]) -> list[list[int]]:
    """Return the first step of each limit with only the first so many tasks of a run; -1 if never."""
    swarm.begin(run)
    honest, setting, last = swarm.counted, swarm.scenario.setting, swarm.scenario.run.steps
    flooding, complete_map = [NEVER], NEVER
    while NEVER in (*flooding, complete_map) and swarm.step < last:
        swarm.advance(min(STRIDE, last - swarm.step))
        known = swarm.knowledge
        complete_map = _quorum_step(swarm, honest, known[:, oracle.MAP_STEP])
        flooding = [
            _quorum_step(swarm, honest, naming_steps(known, setting, each)) if each else 0 for each in tasks
        ]
    seen = known[honest, oracle.FIRST_STEPS : oracle.known_start(setting)]
    area = _pooled(seen[:, setting.tasks :], oracle.cells(setting))
    pooled = [_pooled(seen[:, :each], min(each, setting.robots + 1)) for each in tasks]
    return [[*both, area, complete_map] for both in zip(pooled, flooding, strict=True)]


def _names(acts: Scenario | None) -> list[str]:
    """Return the limits of robots that act, and the moves until the first of them."""
    if acts is None:
        return []
    return [*TAKEN, "moves", *(DONE if acts.tasks.work else ())]


def _taken(swarm: Tireless, run: int, mapped: int, tasks: Sequence[int], acts: Scenario) -> list[list[int]]:
    """Return what `_names` names with only the first so many tasks of a run.

    ``mapped`` is the step of the complete map; -1 if never.
    """
    able = can_know(acts)

    def best(step: int) -> list[Least]:
        swarm.begin(run)
        swarm.advance(step)
        ways = ways_between(acts, swarm.positions, swarm.tasks, able)[swarm.counted]
        return [least(ways[:, :each]) for each in tasks]

    then, first = best(max(0, mapped)), best(0)
    done = _done(swarm, tasks, acts) if acts.tasks.work else [[] for _ in tasks]
    return [
        [*now[:2], *(mapped + steps if mapped >= 0 else NEVER for steps in later[:2]), now.moves, *more]
        for now, later, more in zip(first, then, done, strict=True)
    ]


def _done(swarm: Tireless, tasks: Sequence[int], acts: Scenario) -> list[list[int]]:
    """Return the steps of `DONE` for robots and tasks as they are now."""
    ways = ways_between(acts, swarm.positions, swarm.tasks, can_know(acts))[swarm.counted]
    apart = ways_between(acts, swarm.tasks, swarm.tasks) + acts.acting.reach / acts.robots.speed
    return [[*done_between(ways[:, :each], apart[:each, :each], acts.tasks.work or 0)] for each in tasks]


def naming_steps(known: NDArray[np.int32], setting: Setting, tasks: int) -> NDArray[np.int32]:
    """Return the step at which each robot knew all of the first tasks, or n + 1 of them; 0 if never."""
    start, needed = oracle.known_start(setting), min(tasks, setting.robots + 1)
    steps = known[:, start : start + tasks].astype(np.uint32) - np.uint32(1)  # never comes last
    return (np.partition(steps, needed - 1)[:, needed - 1] + np.uint32(1)).astype(np.int32)


def _pooled(steps: NDArray[np.int32], needed: int) -> int:
    """Return the first step by which the robots together had seen a number of things; -1 if never.

    ``steps`` has the step at which each robot first saw each thing; 0 if never.
    """
    if needed == 0:
        return 0
    seen = (steps > 0).any(axis=0)
    if seen.sum() < needed:
        return NEVER
    first = np.where(steps > 0, steps, np.iinfo(np.int32).max).min(axis=0)
    return int(np.partition(first, needed - 1)[needed - 1])


def _quorum_step(swarm: Swarm, honest: NDArray[np.bool_], steps: NDArray[np.int32]) -> int:
    """Return the first step by which more than the threshold's share of the counted robots knew; -1 if never.

    Robots may stop, and then count no longer (model.md 6.6). ``steps`` is 0 for a robot that doesn't know.
    """
    stop = swarm.scenario.faults.stop_step
    before = _nth(steps[honest], swarm.scenario)
    if 0 < before < stop or swarm.step < stop:
        return before
    after = _nth(steps[swarm.counted], swarm.scenario)
    return max(after, stop) if after > 0 else NEVER


def _nth(steps: NDArray[np.int32], scenario: Scenario) -> int:
    """Return the step by which more than the threshold's share of some robots knew; -1 if never."""
    needed = least_quorum(scenario, steps.size)
    known = np.sort(steps[steps > 0])
    return int(known[needed - 1]) if known.size >= needed else NEVER


RULE: Final = {"quorum": 0.9, "rounds": 3, "heard": 3}
"""The rule by which robots declare whose strategy has no word of its own (model.md 6.14)."""
OFFSETS: Final = (-1, 0, 1, 2)
"""Numbers of tasks, less the number of robots."""


def _using(strategy: str, knows_count: bool | None = None, **parameters: float) -> dict[str, Any]:
    """Return the changes that give a scenario a strategy, and say whether its robots know their number."""
    known = {} if knows_count is None else {"robots.know_count": knows_count}
    return {"decision.strategy": strategy, "decision.parameters": parameters, **known}


CONTENDERS: Final = (
    ("turns, alarm only", _using("turns", names=0.0)),
    ("turns, 1 name", _using("turns", names=1.0)),
    ("turns, 3 names", _using("turns", names=3.0)),
    ("turns, 6 names", _using("turns", names=6.0)),
    ("turns, all names", _using("turns", names=-1.0)),
    ("quiet census, n known", _using("quiet-census", knows_count=True)),
    ("quiet census, n unknown", _using("quiet-census", knows_count=False)),
    ("map", _using("map")),
    ("tally, by votes", _using("tally")),
    ("census, by votes", _using("census")),
)
"""What is compared by default: the names of rows of the figure, and what each changes in the scenario."""


def speakers(scenario: Scenario, strategies: Sequence[str] = ()) -> dict[str, Scenario]:
    """Return the scenario with each strategy, by name; robots declare by votes if their strategy doesn't.

    Robots know their number if the strategy needs it, or the scenario says so.

    Parameters
    ----------
    scenario : Scenario
        What all contenders have in common.
    strategies : sequence of str
        Names or files, each with its default parameters; by default `CONTENDERS`.
        Of these, the ones that the scenario rejects are left out.

    Raises
    ------
    FeasibeeError
        If a strategy is unknown, or named twice.
    """
    names = [Path(name).name for name in strategies]
    check_distinct(names)
    named = [(name, _using(given)) for name, given in zip(names, strategies, strict=True)]
    if named:
        return {name: _speaker(scenario, changes) for name, changes in named}
    found = {}
    for name, changes in CONTENDERS:
        with suppress(ScenarioError):  # such as map, behind walls
            found[name] = _speaker(scenario, changes)
    return found


def _speaker(scenario: Scenario, changes: Mapping[str, Any]) -> Scenario:
    own = {**changes, "decision.declare": None, "run.stop_at_decision": False}
    manifest = scenario.replace({**own, "robots.know_count": True}).manifest
    knows = manifest.needs_count or scenario.robots.know_count
    rule = None if manifest.declares else RULE
    return scenario.replace({"robots.know_count": knows, **own, "decision.declare": rule})


def tasks_near(scenario: Scenario, tasks: Sequence[int] = ()) -> list[int]:
    """Return the given numbers of tasks, or those near ratio one."""
    return list(tasks) or [max(0, scenario.robots.count + offset) for offset in OFFSETS]


def write_frontier(folder: Path, found: Sequence[Outcome], bounds: Mapping[int, Limits]) -> None:
    """Write the figures (PNG, PDF) and their data, ``limits.csv`` and ``frontier.csv``, into a folder.

    Parameters
    ----------
    folder : Path
        The folder.
    found : sequence of Outcome
        Outcomes of `speakers` at each number of tasks. Without any, each number of tasks has a figure of its
        limits alone.
    bounds : mapping of int to Limits
        The limits at each number of tasks.
    """
    rows = [
        {"tasks": number, "limit": name, "step_median": times.median, "step_p95": times.p95}
        for number, limit in bounds.items()
        for name, times in limit.times.items()
    ]
    write_table(folder / "limits.csv", rows)
    for number, limit in bounds.items() if not found else ():
        save_both(draw_limits(limit.steps, limit.scenario.run.steps), folder / f"limits-{number}")
    if found:
        most = next(iter(bounds.values())).scenario.run.steps
        panels = [
            _panel([each for each in found if each.tasks == number], bounds[number]) for number in bounds
        ]
        save_both(draw_frontier(panels, most), folder / "frontier")
        write_table(folder / "frontier.csv", list(map(_row, found)))


def _panel(group: Sequence[Outcome], limit: Limits) -> Panel:
    words = [
        Word(each.contender, each.found.bits, each.spoken.ok.estimate, *each.spoken.step_90[:2])
        for each in group
    ]
    steps = {name: times[:2] for name, times in limit.times.items()}
    return Panel(f"m = {group[0].tasks}: {DECISIONS[int(group[0].feasible)]}", words, steps)


def spoken(each: Outcome) -> dict[str, Any]:
    """Return what the robots of one of `speakers` declared, as plain tables, for programs."""
    said = each.spoken
    return {
        **{"contender": each.contender, "robots": each.robots, "tasks": each.tasks},
        **{"feasible": each.feasible, "runs": each.runs},
        **{"ok": said.ok._asdict(), "wrong": said.wrong._asdict()},
        "times": {"median": said.step_90.median, "p95": said.step_90.p95},
        "bits": each.found.bits,
    }


def _row(each: Outcome) -> dict[str, object]:
    """Return the columns of an outcome in ``frontier.csv``."""
    said = each.spoken
    return {
        **{"contender": each.contender, "robots": each.robots, "tasks": each.tasks},
        "truth": DECISIONS[int(each.feasible)],
        "runs": each.runs,
        **columns("ok", said.ok),
        **columns("wrong", said.wrong),
        **{"step_median": said.step_90.median, "step_p95": said.step_90.p95},
        "bits_per_robot_and_step": f"{each.found.bits:.6g}",
    }

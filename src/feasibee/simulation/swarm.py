"""Swarm: one run, simulated step by step, with the state of every robot."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from feasibee.base.codes import NO_OPINION
from feasibee.base.errors import FeasibeeError
from feasibee.base.record import Record
from feasibee.results.measures import held_decision
from feasibee.scenario.feasibility import Verdict, explain, explain_kinds
from feasibee.scenario.picture import Deeds
from feasibee.scenario.runs import Runs, check_integer
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.ensemble import STEPS_LIMIT, check_scenario, failure_of
from feasibee.simulation.flooding import flooded
from feasibee.simulation.snapshot import (
    RobotState,
    Saved,
    Snapshot,
    coarse,
    members,
    snapshot_of,
    state_of,
)

FIRST_STEPS = 1024
"""Initial length of the curves of counts."""


class Swarm:
    """One run, simulated step by step; the results are those of `simulate` to the bit.

    Parameters
    ----------
    scenario : Scenario, optional
        The swarm and its world; by default the paper's swarm with 20 tasks.
    seed, run : int
        Seed and number of the run.
    room : int, optional
        Largest memory of the swarm's state in bytes; by default unlimited.

    Raises
    ------
    FeasibeeError
        If an argument is invalid, or the swarm needs more memory than ``room``.

    Notes
    -----
    In a world that changes (model.md 6.17), arrays per robot have an entry for each of the
    ``scenario.most.robots`` numbers that robots may have. `present` says which numbers have a robot at this
    step. The others have position and heading NaN, opinion -1, zeros as knowledge, and False elsewhere. A
    robot that charges (model.md 6.23) isn't present, but keeps opinion and knowledge.

    Examples
    --------
    >>> import feasibee
    >>> swarm = feasibee.Swarm(seed=1)
    >>> swarm.advance(10)
    >>> swarm.step, swarm.positions.shape
    (10, (20, 2))
    """

    def __init__(
        self, scenario: Scenario | None = None, seed: int = 0, run: int = 0, *, room: int | None = None
    ) -> None:
        self._which = Runs.single(seed, run)
        self.scenario = flooded(check_scenario(scenario))
        self._room = None if room is None else check_integer("room", room, 0, 2**63)
        from feasibee.engine.given import Given
        from feasibee.engine.state import Room
        from feasibee.simulation import lowering

        lowered = lowering.lower(self.scenario, self._which.seed, fast=False)
        stops = dict.fromkeys(("stop_at_decision", "stop_at_declarations", "stop_when_taken"), False)
        endless = lowered.params.run._replace(**stops)
        self._params = lowered.params._replace(run=endless)
        self._given = Given(lowered._replace(params=self._params))
        self._unit = lowering.unit_of(self.scenario)
        self._side = max(self._params.arena.width, self._params.arena.height)
        self._in_motion, self._changes = self.scenario.in_motion, self.scenario.dynamic
        self._record = Record.empty(self._which.first, 1, FIRST_STEPS, FIRST_STEPS if self._changes else 0)
        self._counted = np.zeros(FIRST_STEPS if self._must_count else 0, np.int32)
        self._begin(Room.first(self._params))

    def _begin(self, room: Any) -> None:
        from feasibee.engine.state import State, size_of

        needed = size_of(self._given, room)
        if self._room is not None and needed > self._room:
            raise FeasibeeError(
                f"this swarm needs {needed / 2**20:.0f} MiB, above the limit of {self._room // 2**20} MiB; "
                "use fewer robots, or a shorter radio.range"
            )
        self._state = State(self._given, room)
        self._state.start(self._which.first)
        self._play(0)  # records step 0

    def advance(self, steps: int = 1) -> None:
        """Simulate a number of steps."""
        until = self.step + check_integer("steps", steps, 0, STEPS_LIMIT)
        self._make_room_for(until)
        while self.step < until:
            self._play(self.step + 1 if self._must_count else until)
            if self._state.struct.clock.full:
                self._begin(self._state.enlarged())  # repeat the run with more room

    def _play(self, until: int) -> None:
        from feasibee.engine.tables import Control, RunError

        unwatched = self._given.control(Control(np.zeros(1, np.int64), np.zeros(1, np.bool_)))
        outcome = self._given.outcome(self._record)
        self._given.engine.feasibee_advance(self._state.struct, 0, until, outcome, unwatched, 0)
        try:
            self._given.check(unwatched, 0, self._record, 0)
        except RunError as failure:
            raise failure_of(self.scenario, self._which, failure.error) from None
        if self._must_count:
            self._counted[self.step] = self._state.struct.clock.counted

    @property
    def _must_count(self) -> bool:
        """Whether only the state of each step says how many robots count: some that leave don't."""
        faults = self._params.faults
        return self._changes and faults.byzantine + faults.stopped > 0

    def _make_room_for(self, step: int) -> None:
        """Lengthen the curves for a step, at least to twice their length: a step costs constant time."""
        old = self._record
        if step < old.feasible_count.shape[1]:
            return
        self._record = old.lengthened(max(step + 1, 2 * old.feasible_count.shape[1]))
        self._counted = np.resize(self._counted, self._record.feasible_count.shape[1] * self._must_count)

    def save(self) -> Saved:
        """Return a copy of this step's state, for `restore`."""
        return Saved.of(self.step, self._state.room, self._changing())

    def restore(self, saved: Saved) -> None:
        """Return to a step of this run that `save` has copied."""
        if saved.room != self._state.room:
            self._begin(saved.room)
        part = self._state.struct.parts[0]  # its queues are in this block, which may not be the one saved
        queues = {name: getattr(part, name) for name in ("who", "other", "third", "free_tables")}
        saved.copy_to(self._changing())
        for name, queue in queues.items():
            setattr(part, name, queue)

    def _changing(self) -> list[NDArray[Any]]:
        """Return all that a step may change, but for the curves: they are written again."""
        record = self._record
        return [self._state.block, record.decision, record.decision_step, record.account]

    @property
    def step(self) -> int:
        """Number of steps simulated so far."""
        return int(self._state.struct.clock.step)

    @property
    def positions(self) -> NDArray[np.float64]:
        """Positions of the robots in units: float64, shape (robots, 2), from 0 to the side of the arena."""
        x, y = self._numbers("X", "Y")
        positions = self._in_units(x, y)
        if self._in_motion:
            positions[~self.present] = np.nan
        return positions

    @property
    def present(self) -> NDArray[np.bool_]:
        """Whether a robot of each number is in the arena at this step: bool, shape (robots,)."""
        return self._members(self._state.sets["THERE"]).astype(np.bool_)

    @property
    def _exists(self) -> NDArray[np.bool_]:
        """Whether a robot has each number at this step, even if it charges."""
        sets = self._state.sets
        return self._members(sets["THERE"] | sets["AWAY"]).astype(np.bool_)

    @property
    def tasks(self) -> NDArray[np.float64]:
        """Positions of the tasks at this step in units: float64, shape (tasks, 2)."""
        return self._in_units(*self._places_of_tasks())

    @property
    def task_numbers(self) -> NDArray[np.int64]:
        """Numbers of the tasks at this step, in ascending order: int64, shape (tasks,)."""
        return np.flatnonzero(members(self._state.array("tasks_there", self._state.struct.task_words)))

    @property
    def truth(self) -> bool:
        """Whether the tasks of this step are feasible for the robots of this step (model.md 6.17.3)."""
        return bool(self._state.struct.clock.truth)

    @property
    def verdict(self) -> Verdict:
        """The ground truth of this step with its proof, as `feasibee.explain` gives."""
        if not self._changes:
            return explain(self.scenario)
        tasks = self._classes[self._params.robots.count + self.task_numbers]
        return explain_kinds(self.scenario, self.robot_kinds[self.present].tolist(), tasks.tolist())

    @property
    def opinions(self) -> NDArray[np.int8]:
        """Opinions of the robots: int8, shape (robots,), 1 feasible, 0 infeasible, -1 none."""
        feasible = self._members(self._state.sets["FOR_FEASIBLE"])
        opinions = feasible - self._members(self._state.sets["NEUTRAL"])
        return np.where(self._exists, opinions, np.int8(NO_OPINION)) if self._in_motion else opinions

    @property
    def disseminating(self) -> NDArray[np.bool_]:
        """Whether each robot is disseminating: bool, shape (robots,); the others explore."""
        return self._members(self._state.sets["DISSEMINATING"]).astype(np.bool_)

    @property
    def feasible_count(self) -> int:
        """Number of counted robots with opinion 1."""
        return int(self._record.feasible_at_end[0])

    @property
    def infeasible_count(self) -> int:
        """Number of counted robots with opinion 0."""
        return int(self._record.infeasible_at_end[0])

    @property
    def feasible_counts(self) -> NDArray[np.int32]:
        """Number of counted robots with opinion 1 at each step so far: int32, shape (step + 1,)."""
        return self._record.feasible_count[0, : self.step + 1]

    @property
    def infeasible_counts(self) -> NDArray[np.int32]:
        """Number of counted robots with opinion 0 at each step so far: int32, shape (step + 1,)."""
        return self._record.infeasible_count[0, : self.step + 1]

    @property
    def counted_counts(self) -> NDArray[np.int32]:
        """Number of counted robots at each step so far: int32, shape (step + 1,)."""
        if self._must_count:
            return self._counted[: self.step + 1]
        if self._changes:
            return self.robot_counts
        stop, counts = self.scenario.faults.stop_step, np.empty(self.step + 1, np.int32)
        counts[:stop], counts[stop:] = self.scenario.counted(0), self.scenario.counted(stop)
        return counts

    @property
    def robot_counts(self) -> NDArray[np.int32]:
        """Number of robots at each step so far: int32, shape (step + 1,)."""
        return self._curve(self._record.robots_present, self.scenario.robots.count)

    @property
    def task_counts(self) -> NDArray[np.int32]:
        """Number of tasks at each step so far: int32, shape (step + 1,)."""
        return self._curve(self._record.tasks_present, self.scenario.tasks.count)

    @property
    def truths(self) -> NDArray[np.bool_]:
        """Whether the tasks were feasible at each step so far: bool, shape (step + 1,)."""
        return self._curve(self._record.truth, self.truth).astype(np.bool_)

    def _curve(self, trace: NDArray[Any], constant: int) -> NDArray[np.int32]:
        """Return a trace of the record up to this step; in a world that doesn't change, a constant."""
        length = self.step + 1
        return trace[0, :length] if self._changes else np.full(length, constant, np.int32)

    @property
    def first_decision(self) -> tuple[int, int]:
        """First decision of the swarm and its step, as in `simulate`; -1 and -1 while undecided."""
        return int(self._record.decision[0]), int(self._record.decision_step[0])

    @property
    def declared(self) -> NDArray[np.int8]:
        """What each robot has declared: int8, shape (robots,), 1 feasible, 0 infeasible, -1 nothing yet."""
        sets = self._state.sets
        feasible = self._members(sets["DECLARED"] & sets["FOR_FEASIBLE_DECLARED"])
        return feasible + self._members(sets["DECLARED"]) - np.int8(1)

    @property
    def declared_counts(self) -> tuple[int, int]:
        """Numbers of counted robots that have declared feasible, and infeasible."""
        return int(self._record.declared_feasible[0]), int(self._record.declared_infeasible[0])

    @property
    def knowledge(self) -> NDArray[np.int32]:
        """Words that each robot knows: int32, shape (robots, words); no words if the strategy has none."""
        known = self._state.known()
        return np.where(self._exists[:, None], known, np.int32(0)) if self._in_motion else known

    @property
    def targets(self) -> NDArray[np.int32]:
        """The task to which each robot goes: int32, shape (robots,), -1 for none (model.md 6.25)."""
        bound = self._members(self._state.sets["BOUND"])
        return np.where(bound, self._numbers("TARGET")[0], np.int32(-1))

    @property
    def standing(self) -> NDArray[np.bool_]:
        """Whether each robot stands at a task that it has taken: bool, shape (robots,)."""
        return self._members(self._state.sets["STANDING"]).astype(np.bool_)

    @property
    def holders(self) -> NDArray[np.int32]:
        """The robot that has taken or marked each task, -1 for none: int32, shape (tasks,), by number.

        Empty unless robots act.
        """
        return self._state.array("holders", self._params.tasks.count)

    @property
    def news(self) -> NDArray[np.int32]:
        """The version of each task that each robot knows: int32, shape (robots, tasks) (model.md 6.25.5).

        -1 stands for nothing. There are no tasks unless robots act.
        """
        news = self._state.array("news", self._state.struct.padded, self._params.tasks.count)
        return news[: self._params.robots.count] - np.int32(1)

    @property
    def declaration_step(self) -> int:
        """First step at which more than the threshold's share had declared one opinion; -1 before."""
        return int(self._record.declare_step[0])

    @property
    def all_taken_step(self) -> int:
        """First step at which robots stood at all tasks that they could; -1 before."""
        return int(self._record.all_taken_step[0])

    def robot(self, number: int) -> RobotState:
        """Return what one robot knows at this step.

        Parameters
        ----------
        number : int
            Number of the robot, from 0.

        Raises
        ------
        FeasibeeError
            If no robot has this number at this step.
        """
        number = check_integer("robot", number, 0, self._params.robots.count - 1)
        if not self.present[number]:
            rule = f"no robot has this number at step {self.step}"
            raise FeasibeeError(f"robot = {number}: {rule}; use a number for which present is true")
        x, y = map(float, self.positions[number])
        return state_of(self._params, self._state, number, (x, y))

    @property
    def bits_sent(self) -> int:
        """Total length in bits of all messages sent so far."""
        return int(self._record.bits_sent[0])

    @property
    def decision(self) -> int:
        """Decision of the counted robots at this step: 1 feasible, 0 infeasible, -1 undecided."""
        counts = (self.feasible_count, self.infeasible_count, int(self.counted.sum()))
        return held_decision(self.scenario, *counts)

    @property
    def counted(self) -> NDArray[np.bool_]:
        """Whether each robot counts in the decision, honest and still working: bool, shape (robots,)."""
        return self._members(self._state.sets["COUNTED"]).astype(np.bool_)

    @property
    def robot_kinds(self) -> NDArray[np.int32]:
        """Number of each robot's class, 0 without classes: int32, shape (robots,)."""
        return self._classes[: self._params.robots.count]

    @property
    def _classes(self) -> NDArray[np.int32]:
        """Classes of robots, then of tasks."""
        return self._state.array("class_of", self._params.robots.count + self._params.tasks.count)

    @property
    def headings(self) -> NDArray[np.float64]:
        """Directions of robots in radians: float64, shape (robots,); 0 if a robot never moves again."""
        angles: NDArray[np.float64] = np.arctan2(*self._numbers("STEP_Y", "STEP_X"))
        if self._in_motion:
            angles[~self.present] = np.nan
        return angles

    def snapshot(self) -> Snapshot:
        """Return the robots of this step in few bytes."""
        return snapshot_of(self._state, self._side, self._params.robots.count)

    @property
    def acting(self) -> Deeds:
        """Targets of robots, and taken tasks, of this step; only if robots act (model.md 6.25)."""
        return Deeds.of(self.targets, self.standing, self.holders, self.task_numbers)

    def task_places(self) -> tuple[NDArray[np.uint16], NDArray[np.uint16]]:
        """Return x and y of the tasks of this step, in the unit of ``Snapshot``."""
        x, y = self._places_of_tasks()
        return coarse(x, self._side), coarse(y, self._side)

    def _places_of_tasks(self) -> list[NDArray[np.int32]]:
        """Return x and y of the tasks of this step."""
        return [self._state.tasks[axis][self.task_numbers] for axis in ("POINT_X", "POINT_Y")]

    def _repr_html_(self) -> str:
        """Return the arena and the counts as HTML for notebooks."""
        from feasibee.simulation.frames import show_swarm  # loads Pillow

        return show_swarm(self, self._which.first)

    def _in_units(self, x: NDArray[np.int32], y: NDArray[np.int32]) -> NDArray[np.float64]:
        fixed = np.stack([x, y], axis=1).astype(np.uint32).astype(np.float64)
        places: NDArray[np.float64] = fixed * float(self._unit)
        return places

    def _members(self, words: NDArray[np.uint32]) -> NDArray[np.int8]:
        """Return whether each robot is a member of a set, as 1 or 0."""
        return members(words)[: self._params.robots.count]

    def _numbers(self, *rows: str) -> NDArray[np.int32]:
        """Return rows of the state's numbers: int32, shape (row, robot)."""
        return np.stack([self._state.robots[row][: self._params.robots.count] for row in rows])


def truth_at(scenario: Scenario, step: int, seed: int = 0, run: int = 0) -> Verdict:
    """Return the ground truth of one step of a run, with its proof.

    Parameters
    ----------
    scenario : Scenario
        The swarm and its world. If its world doesn't change, no run is simulated.
    step : int
        Step of the run, 0 to ``scenario.run.steps``.
    seed, run : int
        Seed and number of the run.

    Returns
    -------
    Verdict
        Whether the robots of the step can do the tasks of the step (model.md 6.17.3), as ``explain`` returns.

    Raises
    ------
    FeasibeeError
        If an argument is invalid.

    Examples
    --------
    >>> import feasibee
    >>> scenario = feasibee.Scenario(events=[{"step": 300, "tasks": 5}])
    >>> feasibee.truth_at(scenario, 299).feasible, feasibee.truth_at(scenario, 300).feasible
    (True, False)
    """
    scenario, which = check_scenario(scenario), Runs.single(seed, run)
    step = check_integer("step", step, 0, scenario.run.steps)
    if not scenario.dynamic:
        return explain(scenario)
    swarm = Swarm(scenario, which.seed, which.first)
    swarm.advance(step)
    return swarm.verdict

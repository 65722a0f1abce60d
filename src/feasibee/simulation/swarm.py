"""Swarm: one run, simulated step by step, with the state of every robot."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.errors import FeasibeeError
from feasibee.model.codes import DECISIONS, FEASIBLE, INFEASIBLE, UNDECIDED, exact
from feasibee.model.record import Record
from feasibee.scenario.feasibility import truth
from feasibee.scenario.runs import Runs, check_integer
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.ensemble import STEPS_LIMIT, check_scenario, failure_of
from feasibee.simulation.html import draw_arena, show_swarm
from feasibee.simulation.loading import load_engine

if TYPE_CHECKING:
    from feasibee.simulation.inspection import RobotState

FIRST_STEPS = 1024
"""Initial length of the curves of counts."""


class Snapshot(NamedTuple):
    """The robots of a step in few bytes, as a page draws them."""

    x: NDArray[np.uint16]
    """Position of each robot, in 65,536ths of the arena's longer side."""
    y: NDArray[np.uint16]
    """Position of each robot, in the same unit."""
    heading: NDArray[np.uint8]
    """Direction of each robot, in 256ths of a turn, counterclockwise from the x axis."""
    flags: NDArray[np.uint8]
    """Properties of each robot: a bit for each of `FLAGS`, the lowest first."""


class Saved(NamedTuple):
    """The state of a swarm at a step, to return to; see `Swarm.save`."""

    step: int
    """Number of steps simulated."""
    nbytes: int
    """Memory that it takes, in bytes."""
    room: Any
    """Room of the inboxes."""
    arrays: tuple[NDArray[Any], ...]
    """Copies of the arrays that change in a run."""


FLAGS = ("feasible", "neutral", "disseminating", "committed", "declared", "working", "byzantine", "stubborn")


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
        self.scenario = check_scenario(scenario)
        room = None if room is None else check_integer("room", room, 0, 2**63)
        load_engine(self.scenario)
        from feasibee.engine import allocation, layout, params, runner, team
        from feasibee.simulation import fixed_point, lowering

        self._room = room
        self._layout, self._allocation = layout, allocation
        lowered = lowering.lower(self.scenario, self._which.seed)
        self._tables = lowered.tables
        self._params = lowered.params._replace(run=lowered.params.run._replace(stop_at_decision=False))
        self._packed = params.packed(self._params)
        engine = runner.engine_functions(*lowered.form)
        self._start, self._advance, self._functions = engine
        self._part = team.parts_of(self._params)
        self._unit = fixed_point.unit_of(self.scenario)
        traces = FIRST_STEPS if self.scenario.dynamic else 0
        self._record = Record.empty(self._which.first, 1, FIRST_STEPS, traces)
        self._begin(allocation.first_room(self._params))

    def _begin(self, room: Any) -> None:
        self._inboxes = room
        memory = self.scenario.strategy.memory
        needed = self._allocation.size_of(self._params, self._tables, room)
        if self._room is not None and needed > self._room:
            raise FeasibeeError(
                f"this swarm needs {needed / 2**20:.0f} MiB, above the limit of {self._room // 2**20} MiB; "
                "use fewer robots, or a shorter radio.range"
            )
        self._state = self._allocation.empty_state(self._params, self._tables, room, memory)
        self._start(self._packed, self._state, self._which.first)
        self._play(0)  # records step 0

    def advance(self, steps: int = 1) -> None:
        """Simulate a number of steps."""
        from feasibee.engine import runner

        until = self.step + check_integer("steps", steps, 0, STEPS_LIMIT)
        self._make_room_for(until)
        while self.step < until:
            self._play(until)
            if self._state.clock[self._layout.Clock.FULL]:
                self._begin(runner.enlarged(self._inboxes, self._state))  # repeat the run with more room

    def _play(self, until: int) -> None:
        from feasibee.engine.runner import FAILURES, outcome_of

        unwatched = self._layout.Control(np.zeros(1, np.int64), np.zeros(1, np.bool_))
        try:
            self._advance(
                self._packed,
                self._state,
                outcome_of(self._record),
                0,
                until,
                unwatched,
                self._functions,
                *self._part,
            )
        except FAILURES as error:
            raise failure_of(self.scenario, self._which, error) from None

    def _make_room_for(self, step: int) -> None:
        """Lengthen the curves for a step, at least to twice their length: a step costs constant time."""
        old = self._record
        if step < old.feasible_count.shape[1]:
            return
        self._record = old.lengthened(max(step + 1, 2 * old.feasible_count.shape[1]))

    def save(self) -> Saved:
        """Return a copy of this step's state, for `restore`."""
        arrays = tuple(each.copy() for each in self._changing())
        return Saved(self.step, sum(each.nbytes for each in arrays), self._inboxes, arrays)

    def restore(self, saved: Saved) -> None:
        """Return to a step of this run that `save` has copied."""
        if saved.room != self._inboxes:
            self._begin(saved.room)
        for array, old in zip(self._changing(), saved.arrays, strict=True):
            np.copyto(array, old)

    def _changing(self) -> list[NDArray[Any]]:
        """Return the arrays that a step may change, without the curves: they are written again."""
        state, record = self._state, self._record
        names = {each.name for each in fields(state)} - {"tasks", "task_cells", "task_lists", "tables"}
        arrays = [getattr(state, each) for each in sorted(names - {"robot_cells"})]
        cells = state.robot_cells
        return [*arrays, cells.points, cells.start, record.decision, record.decision_step, record.account]

    @property
    def step(self) -> int:
        """Number of steps simulated so far."""
        return int(self._state.clock[self._layout.Clock.STEP])

    @property
    def positions(self) -> NDArray[np.float64]:
        """Positions of the robots in units: float64, shape (robots, 2), from 0 to the side of the arena."""
        x, y = self._numbers([self._layout.Robot.X, self._layout.Robot.Y])
        return self._in_units(x, y)

    @property
    def tasks(self) -> NDArray[np.float64]:
        """Positions of the tasks in units: float64, shape (tasks, 2)."""
        return self._in_units(
            self._state.tasks[self._layout.Point.X], self._state.tasks[self._layout.Point.Y]
        )

    @property
    def opinions(self) -> NDArray[np.int8]:
        """Opinions of the robots: int8, shape (robots,), 1 feasible, 0 infeasible, -1 none."""
        feasible = self._members(self._state.sets[self._layout.Set.FEASIBLE])
        return feasible - self._members(self._state.sets[self._layout.Set.NEUTRAL])

    @property
    def disseminating(self) -> NDArray[np.bool_]:
        """Whether each robot is disseminating: bool, shape (robots,); the others explore."""
        return self._members(self._state.sets[self._layout.Set.DISSEMINATING]).astype(np.bool_)

    @property
    def feasible_count(self) -> int:
        """Number of counted robots with opinion 1."""
        return int(self._state.clock[self._layout.Clock.FEASIBLE_COUNT])

    @property
    def infeasible_count(self) -> int:
        """Number of counted robots with opinion 0."""
        neutral = int(self._state.clock[self._layout.Clock.NEUTRAL_COUNT])
        return int(self.counted.sum()) - self.feasible_count - neutral

    @property
    def feasible_counts(self) -> NDArray[np.int32]:
        """Number of counted robots with opinion 1 at each step so far: int32, shape (step + 1,)."""
        return self._record.feasible_count[0, : self.step + 1]

    @property
    def infeasible_counts(self) -> NDArray[np.int32]:
        """Number of counted robots with opinion 0 at each step so far: int32, shape (step + 1,)."""
        return self._record.infeasible_count[0, : self.step + 1]

    @property
    def first_decision(self) -> tuple[int, int]:
        """First decision of the swarm and its step, as in `simulate`; -1 and -1 while undecided."""
        return int(self._record.decision[0]), int(self._record.decision_step[0])

    @property
    def committed(self) -> NDArray[np.bool_]:
        """Whether each robot has committed to its opinion: bool, shape (robots,)."""
        return self._members(self._state.sets[self._layout.Set.COMMITTED]).astype(np.bool_)

    @property
    def declared(self) -> NDArray[np.int8]:
        """What each robot has declared: int8, shape (robots,), 1 feasible, 0 infeasible, -1 nothing yet."""
        sets, layout = self._state.sets, self._layout
        feasible = self._members(sets[layout.Set.DECLARED] & sets[layout.Set.DECLARED_FEASIBLE])
        return feasible + self._members(sets[layout.Set.DECLARED]) - np.int8(1)

    @property
    def declared_counts(self) -> tuple[int, int]:
        """Numbers of counted robots that have declared feasible, and infeasible."""
        clock, layout = self._state.clock, self._layout
        return int(clock[layout.Clock.DECLARED_FEASIBLE]), int(clock[layout.Clock.DECLARED_INFEASIBLE])

    @property
    def knowledge(self) -> NDArray[np.int32]:
        """Words that each robot knows: int32, shape (robots, words); no words if the strategy has none."""
        known: NDArray[np.int32] = self._state.knowledge[self._layout.Copy.KNOWN]
        return known[: self.scenario.robots.count, : self._params.strategy.knowledge.words]

    @property
    def declaration_step(self) -> int:
        """First step at which more than the threshold's share had declared one opinion; -1 before."""
        return int(self._record.declare_step[0])

    def robot(self, number: int) -> RobotState:
        """Return what one robot knows at this step.

        Parameters
        ----------
        number : int
            Number of the robot, from 0.

        Raises
        ------
        FeasibeeError
            If there is no such robot.
        """
        i = self._place_of(check_integer("robot", number, 0, self.scenario.robots.count - 1))
        from feasibee.simulation import inspection

        kinds = max(1, len(self.scenario.robots.classes))
        x, y = self._in_units(*(self._state.robots[[self._layout.Robot.X, self._layout.Robot.Y], i : i + 1]))[
            0
        ]
        place, flags = (float(x), float(y)), _sets_of_flags(self._layout)
        return inspection.state_of(self._params, self._state, i, place, kinds, flags)

    def _place_of(self, number: int) -> int:
        """Return where the state has a robot."""
        if not self._params.in_space_order:
            return number
        labels = self._state.robots[self._layout.Robot.LABEL, : self.scenario.robots.count]
        return int(np.flatnonzero(labels >> 2 == number)[0])

    @property
    def bits_sent(self) -> int:
        """Total length in bits of all messages sent so far."""
        return int(self._state.clock[self._layout.Clock.BITS])

    @property
    def decision(self) -> int:
        """Decision of the counted robots at this step: 1 feasible, 0 infeasible, -1 undecided."""
        counted = int(self.counted.sum())
        needed = exact(self.scenario.decision.threshold) * counted
        if self.feasible_count > needed:
            return FEASIBLE
        if self.infeasible_count > needed:
            return INFEASIBLE
        return UNDECIDED

    @property
    def counted(self) -> NDArray[np.bool_]:
        """Whether each robot counts in the decision, honest and still working: bool, shape (robots,)."""
        return self._members(self._state.sets[self._layout.Set.COUNTED]).astype(np.bool_)

    @property
    def headings(self) -> NDArray[np.float64]:
        """Directions of robots in radians: float64, shape (robots,); 0 if a robot never moves again."""
        angles: NDArray[np.float64] = np.arctan2(
            *self._numbers([self._layout.Robot.STEP_Y, self._layout.Robot.STEP_X])
        )
        return angles

    def snapshot(self) -> Snapshot:
        """Return the robots of this step in few bytes."""
        layout = self._layout
        sets = _sets_of_flags(layout)
        members = np.unpackbits(self._state.sets[sets].view(np.uint8), axis=1, bitorder="little")
        x, y = map(self._coarse, self._numbers([layout.Robot.X, layout.Robot.Y]))
        steps = self._numbers([layout.Robot.STEP_X, layout.Robot.STEP_Y]).astype(np.float32)
        turns = np.arctan2(steps[1], steps[0]) * np.float32(128 / np.pi)
        return Snapshot(
            x,
            y,
            np.round(turns).astype(np.int16).astype(np.uint8),
            np.packbits(members[:, self._places], axis=0, bitorder="little")[0],
        )

    def task_places(self) -> tuple[NDArray[np.uint16], NDArray[np.uint16]]:
        """Return x and y of the tasks, in the unit of ``Snapshot``."""
        tasks = self._state.tasks
        return self._coarse(tasks[self._layout.Point.X]), self._coarse(tasks[self._layout.Point.Y])

    def _coarse(self, fixed: NDArray[np.int32]) -> NDArray[np.uint16]:
        """Convert fixed-point numbers to 65,536ths of the longer side."""
        coarse = fixed.view(np.uint32) >> np.uint32(15 if self._params.arena.walls else 16)
        places: NDArray[np.uint16] = np.minimum(coarse, 65535).astype(np.uint16)
        return places

    def _repr_html_(self) -> str:
        """Return the arena and the counts as HTML for notebooks."""
        world = self.scenario
        drawn = draw_arena(
            world.arena.size,
            self.positions,
            self.opinions,
            self.disseminating,
            self.declared,
            self.tasks,
            diameter=world.robots.diameter,
            walls=world.arena.boundary == "walls",
        )
        counts = {DECISIONS[FEASIBLE]: self.feasible_count, DECISIONS[INFEASIBLE]: self.infeasible_count}
        title = f"Run {self._which.first}, step {self.step}"
        outcome = f"{DECISIONS[self.decision]} (truth: {DECISIONS[int(truth(world))]})"
        if world.manifest.declares:
            outcome += "; declared: {} feasible, {} infeasible".format(*self.declared_counts)
        return show_swarm(title, drawn, counts, outcome, world._repr_html_())

    def _in_units(self, x: NDArray[np.int32], y: NDArray[np.int32]) -> NDArray[np.float64]:
        fixed = np.stack([x, y], axis=1).astype(np.uint32).astype(np.float64)
        places: NDArray[np.float64] = fixed * float(self._unit)
        return places

    def _members(self, words: NDArray[np.uint32]) -> NDArray[np.int8]:
        bits = (words[:, None] >> np.arange(32, dtype=np.uint32)) & np.uint32(1)
        members: NDArray[np.int8] = bits.reshape(-1)[self._places].astype(np.int8)
        return members

    def _numbers(self, rows: list[int]) -> NDArray[np.int32]:
        """Return rows of the state's numbers, in the order of the robots: int32, shape (row, robot)."""
        numbers: NDArray[np.int32] = self._state.robots[rows][:, self._places]
        return numbers

    @property
    def _places(self) -> Any:
        """Where the state has each robot."""
        count = self.scenario.robots.count
        if not self._params.in_space_order:
            return slice(count)
        return np.argsort(self._state.robots[self._layout.Robot.LABEL, :count])


def _sets_of_flags(layout: Any) -> list[int]:
    """Return the sets whose members have each of `FLAGS`."""
    return [layout.Set[name.upper()] for name in FLAGS]

"""Swarm: one run, step by step, to look at."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from feasibee.display import draw_arena, show_swarm
from feasibee.feasibility import truth
from feasibee.record import Record
from feasibee.scenario import Scenario
from feasibee.simulation import check_numbers, load_engine
from feasibee.vocabulary import DECISIONS, FEASIBLE, INFEASIBLE, UNDECIDED, exact


class Swarm:
    """The swarm of one run; the same computation as `simulate`, to the bit.

    Parameters
    ----------
    scenario : Scenario, optional
        By default the paper's swarm with 20 tasks.
    seed, run : int
        Which run.

    Raises
    ------
    FeasibeeError
        If there is no such run.

    Examples
    --------
    >>> import feasibee
    >>> swarm = feasibee.Swarm(seed=1)
    >>> swarm.advance(10)
    >>> swarm.step, swarm.positions.shape
    (10, (20, 2))
    """

    def __init__(self, scenario: Scenario | None = None, seed: int = 0, run: int = 0) -> None:
        _, seed, run = check_numbers(1, seed, run)
        self.scenario = Scenario() if scenario is None else scenario
        load_engine(self.scenario)
        from feasibee.engine import layout, runner, translation

        self._run = run
        self._layout = layout
        self._params = translation.params_of(self.scenario, seed)._replace(stop_at_decision=False)
        self._start, self._advance, *self._strategy = runner.engine_functions(self.scenario)
        self._kinds = translation.kinds_of(self.scenario, self._params)
        self._packed = layout.packed(self._params)
        self._unit = float(translation.unit_of(self.scenario))
        self._begin(runner.FIRST_SLOTS)

    def _begin(self, slots: int) -> None:
        self._slots = slots
        memory = self.scenario.strategy.memory
        self._state = self._layout.empty_state(self._params, self._kinds, slots, memory)
        self._start(self._packed, self._state, self._run)

    def advance(self, steps: int = 1) -> None:
        """Let some steps pass."""
        until = self.step + steps
        record = Record.empty(self._run, 1, 0)
        unwatched = np.zeros(1, np.int64), np.zeros(1, np.bool_)
        while self.step < until:
            self._advance(
                self._packed,
                self._state,
                until,
                record.decision,
                record.decision_step,
                record.feasible_count[0],
                record.infeasible_count[0],
                record.account[0],
                *unwatched,
                *self._strategy,
            )
            if self._state.clock[self._layout.FULL]:
                self._begin(2 * self._slots)  # an inbox needs more room: play the run again up to here

    @property
    def step(self) -> int:
        """Steps done."""
        return int(self._state.clock[self._layout.STEP])

    @property
    def positions(self) -> NDArray[np.float64]:
        """Where the robots are: float64, shape (robots, 2), in units, from 0 to the side."""
        count = self.scenario.robots.count
        return self._in_units(
            self._state.robots[self._layout.X, :count], self._state.robots[self._layout.Y, :count]
        )

    @property
    def tasks(self) -> NDArray[np.float64]:
        """Where the tasks are: float64, shape (tasks, 2), in units."""
        return self._in_units(self._state.tasks[self._layout.X], self._state.tasks[self._layout.Y])

    @property
    def opinions(self) -> NDArray[np.int8]:
        """What the robots think: int8, shape (robots,), 1 feasible, 0 infeasible, -1 nothing."""
        feasible = self._members(self._state.sets[self._layout.OPINIONS])
        return feasible - self._members(self._state.sets[self._layout.NEUTRAL])

    @property
    def disseminating(self) -> NDArray[np.bool_]:
        """Which robots broadcast their opinion: bool, shape (robots,); the others explore."""
        return self._members(self._state.sets[self._layout.DISSEMINATING]).astype(np.bool_)

    @property
    def feasible_count(self) -> int:
        """Number of counted robots with opinion 1."""
        return int(self._state.clock[self._layout.FEASIBLE_COUNT])

    @property
    def infeasible_count(self) -> int:
        """Number of counted robots with opinion 0."""
        neutral = int(self._state.clock[self._layout.NEUTRAL_COUNT])
        return int(self.counted.sum()) - self.feasible_count - neutral

    @property
    def committed(self) -> NDArray[np.bool_]:
        """Which robots have committed to their opinion: bool, shape (robots,)."""
        return self._members(self._state.sets[self._layout.COMMITTED]).astype(np.bool_)

    @property
    def bits_sent(self) -> int:
        """Length of all messages so far."""
        return int(self._state.clock[self._layout.BITS])

    @property
    def decision(self) -> int:
        """What the counted robots agree on at this step: 1 feasible, 0 infeasible, -1 nothing."""
        counted = int(self.counted.sum())
        needed = exact(self.scenario.decision.threshold) * counted
        if self.feasible_count > needed:
            return FEASIBLE
        if self.infeasible_count > needed:
            return INFEASIBLE
        return UNDECIDED

    @property
    def counted(self) -> NDArray[np.bool_]:
        """Which robots the decision is taken over: bool, shape (robots,); honest, and still working."""
        return self._members(self._state.sets[self._layout.COUNTED]).astype(np.bool_)

    def _repr_html_(self) -> str:
        """Return what a notebook shows: the arena and the counts."""
        world = self.scenario
        drawn = draw_arena(
            world.arena.size,
            self.positions,
            self.opinions,
            self.disseminating,
            self.tasks,
            diameter=world.robots.diameter,
            walls=world.arena.boundary == "walls",
        )
        counts = {DECISIONS[FEASIBLE]: self.feasible_count, DECISIONS[INFEASIBLE]: self.infeasible_count}
        title = f"Run {self._run}, step {self.step}"
        outcome = f"{DECISIONS[self.decision]} (truth: {DECISIONS[int(truth(world))]})"
        return show_swarm(title, drawn, counts, outcome, world._repr_html_())

    def _in_units(self, x: NDArray[np.int32], y: NDArray[np.int32]) -> NDArray[np.float64]:
        fixed = np.stack([x, y], axis=1).astype(np.uint32).astype(np.float64)
        places: NDArray[np.float64] = fixed * self._unit
        return places

    def _members(self, words: NDArray[np.uint32]) -> NDArray[np.int8]:
        bits = (words[:, None] >> np.arange(32, dtype=np.uint32)) & np.uint32(1)
        return bits.reshape(-1)[: self.scenario.robots.count].astype(np.int8)

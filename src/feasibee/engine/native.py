"""Runs of the engine in C: what it is given, who calls it, and what it says."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

from feasibee.engine.library import library, pointer
from feasibee.engine.params import packed
from feasibee.engine.state import Room, State, tables_of
from feasibee.engine.tables import Control, Lowered, Player, RunError
from feasibee.errors import FeasibeeError
from feasibee.model.codes import UNDECIDED
from feasibee.model.record import Record
from feasibee.strategies.contract import Setting, Strategy

NO_MEMORY = "the runs need more memory than there is; simulate fewer robots, or fewer runs at a time"


def rules_of(strategy: Strategy) -> Any:
    """Return a pointer to a strategy's ``struct rules``; a user's is translated and compiled first."""
    ffi, engine = library()
    if strategy.source:
        from feasibee.engine.own import load  # what translates and compiles takes a while to import

        return load(strategy, ffi, engine).rules
    return engine.feasibee_rules(strategy.name.encode())


def player_of(lowered: Lowered, team: int) -> Player:
    """Return what plays runs of a scenario, each by so many threads."""
    given = Given(lowered)
    if not lowered.fast:
        return AnyWorld(given, team).play
    return given.play if team == 1 else lambda record, control: given.play_together(record, control, team)


class Given:
    """What the engine is given of a scenario; the arrays live as long as this."""

    def __init__(self, lowered: Lowered) -> None:
        self.ffi, self.engine = library()
        self.strategy, self.params = lowered.strategy, lowered.params
        self._packed = packed(lowered.params).tobytes()
        setting, self._arrays = struct_of(self.ffi, lowered.setting)
        params = self.ffi.from_buffer("struct params *", self._packed)
        if lowered.fast and not self.engine.feasibee_has(params):
            raise ValueError("the engine's fast path doesn't have this world; report it, with the scenario")
        self.job = params, rules_of(lowered.strategy), setting, lowered.strategy.memory
        self.tables, self._tables = tables_of(self.ffi, lowered.tables), lowered.tables

    def play(self, record: Record, control: Control) -> None:
        """Play runs, one after another, by this thread."""
        shared = self.control(control)
        complete = self.engine.feasibee_play(*self.job, record.first_run, self.outcome(record), shared)
        self.check(shared, complete, record, int(complete))

    def play_together(self, record: Record, control: Control, team: int) -> None:
        """Play runs, one after another, each by several threads."""
        shared, outcome = self.control(control), self.outcome(record)
        crowd = self.engine.feasibee_crowd_new(*self.job, team)
        if not crowd:
            raise MemoryError(NO_MEMORY)
        try:
            with ThreadPoolExecutor(team) as pool:
                for row in range(record.runs):
                    run = crowd, record.first_run + row, row, outcome, shared
                    part = partial(self.engine.feasibee_crowd_run, *run)
                    self.check(shared, min(pool.map(part, range(team))), record, row)
                    if control.cancelled[0]:
                        return
        finally:
            self.engine.feasibee_crowd_free(crowd)

    def check(self, shared: Any, result: int, record: Record, complete: int) -> None:
        """Raise an error if the engine had no memory, or if the strategy failed after so many runs."""
        if result < 0:
            raise MemoryError(NO_MEMORY)
        found = shared.failure
        if found.what:
            from feasibee.engine.own import Failure, explained

            failure = Failure(found.what, found.line, found.first, found.second)
            raise RunError(record.first_run + complete, FeasibeeError(explained(self.strategy, failure)))

    def control(self, control: Control) -> Any:
        """Return what a simulating thread shares with the one that waits for it."""
        numbers = {
            "steps_done": pointer(control.steps_done, "int64_t"),
            "cancelled": pointer(control.cancelled, "bool"),
        }
        return self.ffi.new("struct control *", numbers)

    def outcome(self, record: Record) -> Any:
        """Return the arrays of a record, as the engine fills them in."""
        numbers = {
            "decision": pointer(record.decision, "int8_t"),
            "decision_step": pointer(record.decision_step, "int32_t"),
            "feasible_count": pointer(record.feasible_count, "int32_t"),
            "infeasible_count": pointer(record.infeasible_count, "int32_t"),
            "account": pointer(record.account, "int64_t"),
            "runs": record.runs,
            "curve_length": record.feasible_count.shape[1],
            "columns": record.account.shape[1],
            "truth": pointer(record.truth, "int8_t"),
            "held": pointer(record.held, "int8_t"),
            "robots_present": pointer(record.robots_present, "int32_t"),
            "tasks_present": pointer(record.tasks_present, "int32_t"),
            "trace_length": record.truth.shape[1],
        }
        return self.ffi.new("struct outcome *", numbers)


class AnyWorld:
    """Plays runs by the general path, each by so many threads."""

    def __init__(self, given: Given, team: int) -> None:
        self.given, self.team = given, team
        self.room = Room.first(given.params)  # has sufficed so far, for all chunks; it changes no result

    def play(self, record: Record, control: Control) -> None:
        """Play runs, one after another; where an inbox has no room, play that run again with more."""
        complete = 0
        while complete < record.runs and not control.cancelled[0]:
            state = State(self.given, self.room, self.team)
            rest = record.part(complete, record.runs)
            complete += self._play_some(state, rest, control)
            if state.struct.clock.full:
                self.room = state.enlarged()

    def _play_some(self, state: State, record: Record, control: Control) -> int:
        """Play runs until one isn't complete; return how many are."""
        given, row = self.given, 0
        shared, outcome = given.control(control), given.outcome(record)
        if self.team == 1:
            row = given.engine.feasibee_play_any(state.struct, record.first_run, outcome, shared)
            given.check(shared, row, record, row)
            return int(row)
        steps = given.params.run.steps
        with ThreadPoolExecutor(self.team) as pool:
            for row in range(record.runs):
                state.start(record.first_run + row)
                record.decision[row], record.decision_step[row] = UNDECIDED, -1
                part = partial(given.engine.feasibee_advance, state.struct, row, steps, outcome, shared)
                list(pool.map(part, range(self.team)))
                given.check(shared, 0, record, row)
                if state.struct.clock.full or control.cancelled[0]:
                    return row
        return record.runs


def struct_of(ffi: Any, setting: Setting) -> tuple[Any, list[Any]]:
    """Return a ``struct setting``, and the arrays that must live as long as it is used."""
    numbers = setting._asdict()
    plan, parameters = bytes(numbers.pop("plan")), list(numbers.pop("parameters"))
    arrays = [ffi.new("uint8_t[]", plan or b"\0"), ffi.new("double[]", parameters or 1)]
    lengths = {"plan_length": len(plan), "parameter_count": len(parameters)}
    pointers = dict(zip(("plan", "parameters"), arrays, strict=True))
    return ffi.new("struct setting *", numbers | lengths | pointers), arrays

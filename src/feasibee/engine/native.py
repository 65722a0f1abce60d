"""Runs of the engine in C: what it is given, who calls it, and what it says."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

from feasibee.engine.layout import Control, Lowered, Player, RunError
from feasibee.engine.library import library, pointer
from feasibee.engine.params import packed
from feasibee.errors import FeasibeeError
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
    return given.play if team == 1 else lambda record, control: given.play_together(record, control, team)


class Given:
    """What the engine is given of a scenario; the arrays live as long as this."""

    def __init__(self, lowered: Lowered) -> None:
        self.ffi, self.engine = library()
        self.strategy = lowered.strategy
        self._packed = packed(lowered.params).tobytes()
        setting, self._arrays = struct_of(self.ffi, lowered.setting)
        params = self.ffi.from_buffer("struct params *", self._packed)
        if not self.engine.feasibee_has(params):
            raise ValueError("the engine in C doesn't have this world; report it, with the scenario")
        self.job = params, rules_of(lowered.strategy), setting, lowered.strategy.memory

    def play(self, record: Record, control: Control) -> None:
        """Play runs, one after another, by this thread."""
        shared = self._control(control)
        complete = self.engine.feasibee_play(*self.job, record.first_run, self._outcome(record), shared)
        self._check(shared, complete, record, int(complete))

    def play_together(self, record: Record, control: Control, team: int) -> None:
        """Play runs, one after another, each by several threads."""
        shared, outcome = self._control(control), self._outcome(record)
        crowd = self.engine.feasibee_crowd_new(*self.job, team)
        if not crowd:
            raise MemoryError(NO_MEMORY)
        try:
            with ThreadPoolExecutor(team) as pool:
                for row in range(record.runs):
                    run = crowd, record.first_run + row, row, outcome, shared
                    part = partial(self.engine.feasibee_crowd_run, *run)
                    self._check(shared, min(pool.map(part, range(team))), record, row)
                    if control.cancelled[0]:
                        return
        finally:
            self.engine.feasibee_crowd_free(crowd)

    def _check(self, shared: Any, result: int, record: Record, complete: int) -> None:
        """Raise an error if the engine had no memory, or if the strategy failed after so many runs."""
        if result < 0:
            raise MemoryError(NO_MEMORY)
        found = shared.failure
        if found.what:
            from feasibee.engine.own import Failure, explained

            failure = Failure(found.what, found.line, found.first, found.second)
            raise RunError(record.first_run + complete, FeasibeeError(explained(self.strategy, failure)))

    def _control(self, control: Control) -> Any:
        numbers = {
            "steps_done": pointer(control.steps_done, "int64_t"),
            "cancelled": pointer(control.cancelled, "bool"),
        }
        return self.ffi.new("struct control *", numbers)

    def _outcome(self, record: Record) -> Any:
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
        }
        return self.ffi.new("struct outcome *", numbers)


def struct_of(ffi: Any, setting: Setting) -> tuple[Any, list[Any]]:
    """Return a ``struct setting``, and the arrays that must live as long as it is used."""
    numbers = setting._asdict()
    plan, parameters = bytes(numbers.pop("plan")), list(numbers.pop("parameters"))
    arrays = [ffi.new("uint8_t[]", plan or b"\0"), ffi.new("double[]", parameters or 1)]
    lengths = {"plan_length": len(plan), "parameter_count": len(parameters)}
    pointers = dict(zip(("plan", "parameters"), arrays, strict=True))
    return ffi.new("struct setting *", numbers | lengths | pointers), arrays

"""What the engine is given of a scenario, and what it says: structs of engine.h and state.h."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from feasibee.base.errors import FeasibeeError
from feasibee.base.record import Record
from feasibee.engine.library import REMEDY, library, pointer
from feasibee.engine.params import packed
from feasibee.engine.tables import Control, EndlessLoopError, Lowered, RunError, Tables
from feasibee.strategies.contract import Setting, Strategy

NO_MEMORY: Final = "the runs need more memory than there is; simulate fewer robots, or fewer runs at a time"
KINDS: Final = {
    "int32_t": np.int32,
    "uint32_t": np.uint32,
    "int64_t": np.int64,
    "uint8_t": np.uint8,
    "uint64_t": np.uint64,
    "double": np.float64,
}
"""Types of numpy by those of C."""


def rules_of(strategy: Strategy) -> Any:
    """Return a pointer to a strategy's ``struct rules``; a user's is translated and compiled first."""
    ffi, engine = library()
    if strategy.source:
        from feasibee.engine.own import load  # what translates and compiles takes a while to import

        return load(strategy, ffi, engine).rules
    rules = engine.feasibee_rules(strategy.name.encode())
    if not rules:
        raise FeasibeeError(f"strategy {strategy.name}: it isn't in the compiled engine; {REMEDY}")
    return rules


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

    def check(self, shared: Any, result: int, record: Record, complete: int) -> None:
        """Raise an error if the engine had no memory, or if the strategy failed after so many runs."""
        if result < 0:
            raise MemoryError(NO_MEMORY)
        found = shared.failure
        if found.what:
            from feasibee.engine.failing import Failing
            from feasibee.engine.own import Failure, explained

            kind = EndlessLoopError if found.what == Failing.ENDLESS else FeasibeeError
            failure = Failure(found.what, found.line, found.first, found.second)
            raise RunError(record.first_run + complete, kind(explained(self.strategy, failure)))

    def control(self, control: Control) -> Any:
        """Return what a simulating thread shares with the one that waits for it."""
        return self.ffi.new("struct control *", arrays_of(self.ffi, "struct control", control))

    def outcome(self, record: Record) -> Any:
        """Return the arrays of a record, as the engine fills them in."""
        lengths = {
            "runs": record.runs,
            "curve_length": record.feasible_count.shape[1],
            "columns": record.account.shape[1],
            "trace_length": record.truth.shape[1],
        }
        return self.ffi.new("struct outcome *", arrays_of(self.ffi, "struct outcome", record) | lengths)


def struct_of(ffi: Any, setting: Setting) -> tuple[Any, list[Any]]:
    """Return a ``struct setting``, and the arrays that must live as long as it is used."""
    numbers = setting._asdict()
    plan, parameters = bytes(numbers.pop("plan")), list(numbers.pop("parameters"))
    arrays = [ffi.new("uint8_t[]", plan or b"\0"), ffi.new("double[]", parameters or 1)]
    lengths = {"plan_length": len(plan), "parameter_count": len(parameters)}
    pointers = dict(zip(("plan", "parameters"), arrays, strict=True))
    return ffi.new("struct setting *", numbers | lengths | pointers), arrays


def tables_of(ffi: Any, tables: Tables) -> Any:
    """Return a ``struct tables``; the arrays must live as long as it is used."""
    sizes = {
        "skill_sets": tables.adds.shape[0],
        "classes": tables.adds.shape[1],
        "task_classes": tables.able.shape[1],
        "event_count": tables.events.shape[0],
    }
    ground = arrays_of(ffi, "struct ground", tables.ground)
    return arrays_of(ffi, "struct tables", tables) | sizes | {"ground": ground}


def arrays_of(ffi: Any, struct: str, given: Any) -> dict[str, Any]:
    """Return pointers to the arrays that have the names of the pointers of a struct."""
    fields = ffi.typeof(struct).fields
    kinds = {name: field.type.item.cname for name, field in fields if field.type.kind == "pointer"}
    return {name: pointer(getattr(given, name), kind) for name, kind in kinds.items()}

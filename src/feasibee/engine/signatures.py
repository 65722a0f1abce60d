"""The types of what Python passes to compiled functions, from the annotations in `layout` and `params`."""

from __future__ import annotations

from typing import Any, Final

from numba import boolean, float64, from_dtype, int32, int64, none, types

from feasibee.engine.layout import Control, Functions, Outcome, Part, Passing, State
from feasibee.engine.params import PARAMS as RECORD
from feasibee.engine.pointers import type_of
from feasibee.engine.structs import fields_of
from feasibee.strategies.contract import Inbox, Me, Mind, Setting, Thing

of_types: Any = types.BaseTuple.from_types


def tuple_type(cls: Any) -> Any:
    """Return the type of a NamedTuple of annotated arrays."""
    return of_types([type_of(kind) for kind in fields_of(cls).values()], cls)


PARAMS: Final = from_dtype(RECORD)
STATE: Final = type_of(State)
OUTCOME: Final = type_of(Outcome)
CONTROL: Final = type_of(Control)
PART: Final = type_of(Part)
FLOATS: Final = types.Array(float64, 1, "C")
MIND: Final = of_types([int64, float64, float64, int64, FLOATS, FLOATS], Mind)
INBOX: Final = of_types([int64, int64, int64, float64, float64, float64], Inbox)
UPDATE: Final = int64(PARAMS, tuple_type(Passing), int64, int64, int64)
STRATEGY: Final = Functions(
    quality=float64(int64, int64),
    dissemination=float64(float64, float64),
    decide=int64(MIND, INBOX),
    say=int64(MIND),
    value=float64(MIND),
    lasting=float64(MIND, float64),
    update=UPDATE,
    change=types.void(PARAMS, STATE, types.FunctionType(UPDATE), int64),
)
"""Signatures of the functions that a scenario chooses."""
FUNCTIONS: Final = of_types([types.FunctionType(each) for each in STRATEGY], Functions)
ROW: Final = types.Array(int32, 1, "C")
MESSAGE: Final = types.Array(int32, 1, "C", readonly=True)
SETTING: Final = of_types(
    [int64] * 8 + [FLOATS, boolean, boolean, float64, float64, boolean] + [float64] * 6, Setting
)
ME: Final = of_types([int64] * 4 + [FLOATS, SETTING, boolean, float64, float64], Me)
THING: Final = of_types([boolean, int64, int64, int64, float64, float64], Thing)
KNOWLEDGE: Final = {
    "start": none(ROW, ME),
    "observe": none(ROW, THING, ME),
    "encode": none(ROW, ROW, ME),
    "lie": none(ROW, int64, ME),
    "merge": none(ROW, MESSAGE, int64, ME),
    "count": none(MESSAGE, types.Array(int64, 1, "C"), ME),
    "bits": int64(MESSAGE, ME),
    "declare": int64(ROW, ME),
    "judge": int64(ROW, ME),
    "gap": int64(MESSAGE, ME),
}
"""Signatures of the functions of a strategy that passes on knowledge."""
START: Final = types.void(PARAMS, STATE, int64)
"""Put the swarm of a run at step 0."""
ADVANCE: Final = types.void(PARAMS, STATE, OUTCOME, int64, int64, CONTROL, FUNCTIONS, PART)
"""Simulate a thread's part of a run up to a step: the row of its outcome, and the step."""
PLAY: Final = int64(
    PARAMS,
    STATE,
    OUTCOME,
    int64,
    CONTROL,
    types.FunctionType(START),
    types.FunctionType(ADVANCE),
    FUNCTIONS,
    PART,
)
"""Simulate many runs from a first one on; return how many are complete."""
ABANDON: Final = types.void(PART)
"""End a run in which a thread has failed."""

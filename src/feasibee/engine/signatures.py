"""The compiled types of what kernels take: the state is a pointer, of which code reads what it uses."""

from __future__ import annotations

from functools import cache
from itertools import accumulate
from typing import Any, Final, get_type_hints

from llvmlite import ir
from numba import boolean, extending, float64, from_dtype, int32, int64, none, types, uint8, uint32
from numba.core import imputils
from numba.core.typing import templates
from numba.np.numpy_support import as_dtype

from feasibee.engine.layout import Control, Functions, Outcome, Part, State
from feasibee.engine.params import PARAMS as RECORD
from feasibee.engine.params import Axes, Struct, fields_of
from feasibee.strategies.contract import Inbox, Me, Mind, Setting, Thing

AttributeTemplate: Any = templates.AttributeTemplate
PrimitiveModel: Any = extending.models.PrimitiveModel
NativeValue: Any = extending.NativeValue
unboxes: Any = extending.unbox
loads_field: Any = imputils.lower_getattr_generic
LONG: Final = ir.IntType(64)
NOTHING: Final = ir.Constant(ir.IntType(8).as_pointer(), None)


class Pointer(types.Type):
    """The type of a pointer to the words of a struct, or to those of a tuple in it."""

    def __init__(self, cls: Any) -> None:
        super().__init__(f"Pointer({cls.__module__}.{cls.__qualname__})")
        self.fields = {name: type_of(kind) for name, kind in fields_of(cls).items()}
        *places, self.words = accumulate((words_of(each) for each in self.fields.values()), initial=0)
        self.places = dict(zip(self.fields, places, strict=True))


@cache
def type_of(kind: Any) -> Any:
    """Return the compiled type of a kind of field."""
    if isinstance(kind, Axes):
        return types.Array(from_dtype(kind.dtype), kind.count, "C")
    return int64 if kind is int else Pointer(kind)


def words_of(field: Any) -> int:
    """Return how many words of a struct a field takes."""
    if isinstance(field, types.Array):
        return 1 + field.ndim
    return field.words if isinstance(field, Pointer) else 1


def table_of(kind: Pointer) -> Any:
    """Return LLVM's type of the words that a pointer points to."""
    return ir.ArrayType(LONG, kind.words)


@extending.typeof_impl.register(Struct)
def _typeof(struct: Any, _context: Any) -> Any:
    cls: Any = type(struct)
    return type_of(cls)


@extending.register_model(Pointer)
class _Model(PrimitiveModel):  # type: ignore[misc]  # numba has no types
    def __init__(self, manager: Any, kind: Pointer) -> None:
        super().__init__(manager, kind, table_of(kind).as_pointer())


def _unbox(kind: Any, struct: Any, unboxing: Any) -> Any:
    number = unboxing.pyapi.object_getattr_string(struct, "address")
    address = unboxing.pyapi.long_as_longlong(number)
    unboxing.pyapi.decref(number)
    return NativeValue(unboxing.builder.inttoptr(address, table_of(kind).as_pointer()))


unboxes(Pointer)(_unbox)


@extending.infer_getattr
class _Fields(AttributeTemplate):  # type: ignore[misc]
    key = Pointer

    def generic_resolve(self, kind: Any, name: str) -> Any:
        """Return the type of a field, or None for another name."""
        return kind.fields.get(name)


def _load_field(context: Any, builder: Any, kind: Any, pointer: Any, name: str) -> Any:
    field, place = kind.fields[name], kind.places[name]
    if isinstance(field, Pointer):
        start = builder.gep(pointer, [LONG(0), LONG(place)], inbounds=True)
        return builder.bitcast(start, table_of(field).as_pointer())
    words = [word_at(builder, pointer, place + k) for k in range(words_of(field))]
    return array_of(context, builder, field, *words) if isinstance(field, types.Array) else words[0]


loads_field(Pointer)(_load_field)


def word_at(builder: Any, pointer: Any, place: int) -> Any:
    """Load a word that never changes: what compiled code stores elsewhere doesn't make LLVM load it again."""
    word = builder.load(builder.gep(pointer, [LONG(0), LONG(place)], inbounds=True))
    word.set_metadata("invariant.load", builder.module.add_metadata([]))
    return word


def array_of(context: Any, builder: Any, kind: types.Array, address: Any, *shape: Any) -> Any:
    """Return an array as numba has it, from its address and its length along each axis."""
    size = LONG(as_dtype(kind.dtype).itemsize)
    steps = [size]
    for length in reversed(shape[1:]):
        steps.insert(0, builder.mul(steps[0], length, flags=["nsw"]))
    count = shape[0]
    for length in shape[1:]:
        count = builder.mul(count, length, flags=["nsw"])
    data = builder.inttoptr(address, context.get_data_type(kind.dtype).as_pointer())
    array = ir.Constant(context.get_value_type(kind), ir.Undefined)
    for place, value in enumerate([NOTHING, NOTHING, count, size, data]):  # as in numba's `ArrayModel`
        array = builder.insert_value(array, value, place)
    for axis, (length, step) in enumerate(zip(shape, steps, strict=True)):
        array = builder.insert_value(array, length, (5, axis))
        array = builder.insert_value(array, step, (6, axis))
    return array


of_types: Any = types.BaseTuple.from_types


PARAMS: Final = from_dtype(RECORD)
STATE: Final = type_of(State)
OUTCOME: Final = type_of(Outcome)
CONTROL: Final = type_of(Control)
PART: Final = type_of(Part)
FLOATS: Final = types.Array(float64, 1, "C")
BYTES: Final = types.Array(uint8, 1, "C")
FIELDS: Final = {bool: boolean, int: int64, float: float64, bytes: BYTES, Any: FLOATS}


@cache
def tuple_of(cls: Any) -> Any:
    """Return the compiled type of a tuple that strategies are given, from its annotations."""
    kinds = get_type_hints(cls).values()
    return of_types([FIELDS[kind] if kind in FIELDS else tuple_of(kind) for kind in kinds], cls)


MIND, INBOX, ME, THING, SETTING = (tuple_of(each) for each in (Mind, Inbox, Me, Thing, Setting))
ROW: Final = types.Array(int32, 1, "C")
MESSAGE: Final = types.Array(int32, 1, "C", readonly=True)
STRATEGY: Final = Functions(
    quality=float64(int64, int64),
    dissemination=float64(float64, float64),
    decide=int64(MIND, INBOX),
    say=int64(MIND),
    value=float64(MIND),
    lasting=float64(MIND, float64),
    probability=float64(MIND, MESSAGE, SETTING),
    update=int64(PARAMS, STATE, int64, int64, int64),
    change=types.void(PARAMS, STATE, int64),
    act=types.void(PARAMS, STATE, int64, int64, int64, uint32),
)
"""Signatures of the functions that a scenario chooses."""
FUNCTIONS: Final = of_types([types.FunctionType(each) for each in STRATEGY], Functions)
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

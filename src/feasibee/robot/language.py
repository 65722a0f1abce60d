"""The language of strategies: types, records and functions that have a translation to C99.

Types flow from the contract: whole numbers, real ones, truth values, rows of words, and records like ``me``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final, NamedTuple, get_type_hints

from feasibee.strategies.contract import Inbox, Me, Mind, Setting, Thing

SMALL, INT, WORD, LONG, REAL = "int", "feasibee_int", "uint32_t", "int64_t", "feasibee_real"
BOOL, VOID = "bool", "void"
ROW, REALS, COUNTS = "struct feasibee_row", "struct feasibee_reals", "struct feasibee_counts"
PLAN = "struct feasibee_plan"
MESSAGE = "message"
"""A row of words that a user's function only reads."""
TEXT = "text"
TABLE: Final = "table"
"""The type of a constant tuple, which `Value.known` is."""
CONSTANTS: Final = "struct feasibee_constants"
"""The type of parameters that C keeps a strategy from writing."""
Type = str | tuple[str, ...]
"""A type of C, a record by its name in Python, or the types of a tuple."""
WHOLE: Final = (BOOL, SMALL, INT, WORD, LONG)
NUMBERS: Final = (*WHOLE, REAL)
"""Types of numbers: of two that meet, the later one is taken. A word of 32 bits has no sign: with another one
it becomes a type that holds both."""
ELEMENTS: Final = {ROW: INT, MESSAGE: INT, REALS: REAL, CONSTANTS: REAL, COUNTS: LONG, PLAN: INT}
"""Types of what a row holds."""
RECORDS: Final = {
    "me": "struct feasibee_robot *",
    "mind": "struct feasibee_robot *",
    "setting": "const struct feasibee_setting *",
    "thing": "const struct feasibee_thing *",
    "inbox": "const struct feasibee_votes *",
    "wire": "struct feasibee_layout *",
    "writer": "struct feasibee_writer *",
    "reader": "struct feasibee_reader *",
}
"""Types of records in C."""
ARGUMENTS: Final[Mapping[str, tuple[Type, ...]]] = {
    "quality": (LONG, LONG),
    "dissemination": (REAL, REAL),
    "decide": ("mind", "inbox"),
    "say": ("mind",),
    "value": ("mind",),
    "lasting": ("mind", REAL),
    "probability": ("mind", ROW, "setting"),
    "words": ("setting",),
    "message_words": ("setting",),
    "start": (ROW, "me"),
    "observe": (ROW, "thing", "me"),
    "encode": (ROW, ROW, "me"),
    "lie": (ROW, INT, "me"),
    "merge": (ROW, ROW, INT, "me"),
    "count": (ROW, COUNTS, "me"),
    "bits": (ROW, "me"),
    "declare": (ROW, "me"),
    "judge": (ROW, "me"),
    "layout": ("wire", ROW, INT, "setting"),
    "pack": ("writer", ROW, INT, "setting"),
    "unpack": (ROW, "reader", "setting"),
}
"""Types of the arguments of a strategy's functions."""
RESULTS: Final[Mapping[str, Type]] = {
    **dict.fromkeys(("quality", "dissemination", "value", "lasting", "probability"), REAL),
    **dict.fromkeys(("start", "observe", "encode", "lie", "merge", "count", "pack"), VOID),
}
"""Types of their results; the others are whole."""


class Value(NamedTuple):
    """An expression in C, its type, and its value if that is known now."""

    text: str
    type: Type
    known: Any = None


class Needs(NamedTuple):
    """What keeps a function from running with whole numbers only."""

    position: bool = False
    """It reads a position or keeps floats, as all that call it do, too."""
    floating: bool = False
    """It computes with the scenario's real numbers or logarithms: it can't, but those that call it can."""


class Signature(NamedTuple):
    """A function in C."""

    name: str
    arguments: tuple[Type, ...]
    result: Type
    needs: Needs


def _field(text: str, kind: Type, *needs: str) -> tuple[str, Type, tuple[str, ...]]:
    return text, kind, needs


def _of(record: type, kind: type) -> list[str]:
    """Return the fields of a record of the contract that are of a type."""
    return [name for name, each in get_type_hints(record).items() if each is kind]


_SETTING: Final = "{}->settings->setting"
FIELDS: Final[Mapping[str, Mapping[str, tuple[str, Type, tuple[str, ...]]]]] = {
    "setting": {
        **{name: _field(f"(int){{}}->{name}", SMALL) for name in _of(Setting, int)},
        **{
            name: _field(f"(feasibee_int)FEASIBEE_CLASSES_OF({{}}->{name})", INT)
            for name in ("robot_classes", "task_classes")
        },
        **{name: _field(f"{{}}->{name}", REAL, "floating") for name in _of(Setting, float)},
        **{name: _field(f"{{}}->{name}", BOOL) for name in _of(Setting, bool)},
        "walled": _field("{}->walled", BOOL, "floating"),
        "plan": _field("{}->plan", PLAN, "floating"),
        "columns": _field("(int){}->columns", SMALL, "floating"),
        "parameters": _field("feasibee_parameters_of({})", REALS),
    },
    "me": {
        "id": _field("(feasibee_int){}->me.id", INT),
        "kind": _field("(feasibee_int)FEASIBEE_CLASS_OF({}->me.kind)", INT),
        "hash": _field("{}->me.hash", WORD),
        "step": _field("{}->me.step", WORD),
        "explores": _field("!{}->disseminating", BOOL),
        "setting": _field(_SETTING, "setting"),
        "memory": _field("feasibee_memory_of({})", REALS, "position"),
        "x": _field("{}->x", REAL, "position"),
        "y": _field("{}->y", REAL, "position"),
    },
    "mind": {
        "opinion": _field("(feasibee_int){}->opinion", INT),
        "quality": _field("feasibee_own_quality({})", REAL),
        "feasible_quality": _field("feasibee_real_of({}->feasible_quality)", REAL),
        "own_vote": _field("(feasibee_int){}->settings->own_vote", INT),
        "random_ties": _field("(feasibee_int){}->settings->random_ties", INT),
        "memory": _field("feasibee_memory_of({})", REALS, "position"),
        "parameters": _field(f"feasibee_parameters_of({_SETTING})", REALS),
    },
    "thing": {
        "is_robot": _field("{}->is_robot", BOOL),
        "id": _field("(feasibee_int){}->id", INT),
        "kind": _field("(feasibee_int)FEASIBEE_CLASS_OF({}->kind)", INT),
        "hash": _field("{}->hash", WORD),
        "x": _field("{}->x", REAL, "position"),
        "y": _field("{}->y", REAL, "position"),
    },
    "inbox": {
        "feasible_votes": _field("(feasibee_int){}->feasible", INT),
        "infeasible_votes": _field("(feasibee_int){}->infeasible", INT),
        "heard_opinion": _field("(feasibee_int){}->heard", INT),
        "heard_value": _field("feasibee_heard_value({})", REAL),
        "mean_value": _field("feasibee_mean_value({})", REAL),
        "chance": _field("feasibee_chance({})", REAL),
    },
}
"""The fields of each record on a robot: in C, their type, and what it takes to have them."""


class Target(NamedTuple):
    """A program for which functions are translated: how it holds records, and how their fields are read."""

    records: Mapping[str, str]
    """Types of records in C."""
    fields: Mapping[str, Mapping[str, tuple[str, Type, tuple[str, ...]]]]
    """Their fields, as in `FIELDS`."""
    lengths: tuple[str, str, Type]
    """How the lengths of rows of words and of counts are read, and their type."""
    inlined: str = "static inline"
    """What a definition begins with."""

    def text_of(self, kind: Type) -> str:
        """Return a type as it is written in C."""
        return self.records.get(str(kind)) or text_of(kind)


def _numbers(record: type) -> dict[str, tuple[str, Type, tuple[str, ...]]]:
    """Return the fields of a record that are numbers, as the engine's struct has them."""
    kinds: dict[type, Type] = {int: INT, float: REAL, bool: BOOL}
    return {name: _field(f"{{}}->{name}", kinds[each]) for each in kinds for name in _of(record, each)}


ROBOT: Final = Target(RECORDS, FIELDS, ("(int){}.length", "FEASIBEE_LENGTH_OF({})", SMALL))
ENGINE: Final = Target(
    {
        "mind": "struct mind *",
        "inbox": "const struct inbox *",
        "setting": "const struct setting *",
        "me": "const struct me *",
        "thing": "const struct thing *",
        ROW: "struct known",
        MESSAGE: "struct known",
    },
    {
        "setting": {
            **_numbers(Setting),
            "plan": _field("feasibee_plan_of({})", PLAN),
            "parameters": _field("feasibee_parameters_of({})", REALS),
        },
        "mind": {
            **_numbers(Mind),
            "memory": _field("feasibee_memory_of({})", REALS),
            "parameters": _field("feasibee_parameters_of({})", REALS),
        },
        "inbox": _numbers(Inbox),
        "me": {
            **_numbers(Me),
            "setting": _field("{}->setting", "setting"),
            "memory": _field("feasibee_memory_of({})", REALS),
        },
        "thing": _numbers(Thing),
    },
    ("{}.length", "{}.length", INT),
    "ALWAYS",
)
"""The engine's structs, those of ``engine/c/engine.h``."""
METHODS: Final[Mapping[tuple[str, str], tuple[Type, tuple[Type, ...]]]] = {
    ("wire", "number"): (INT, (INT, INT)),
    ("wire", "flag"): (BOOL, (BOOL,)),
    ("wire", "rice"): (INT, (INT, INT, INT)),
    ("wire", "task"): (INT, (LONG, INT, INT)),
    ("wire", "check"): (VOID, (BOOL, TEXT)),
    ("writer", "number"): (VOID, (INT, INT)),
    ("writer", "flag"): (VOID, (BOOL,)),
    ("writer", "unary"): (VOID, (INT,)),
    ("writer", "rice"): (VOID, (INT, INT)),
    ("writer", "word"): (VOID, (INT,)),
    ("reader", "number"): (INT, (INT,)),
    ("reader", "below"): (INT, (INT, INT)),
    ("reader", "flag"): (BOOL, ()),
    ("reader", "unary"): (INT, (INT,)),
    ("reader", "rice"): (INT, (INT, INT)),
    ("reader", "word"): (INT, ()),
    ("reader", "task"): (INT, (LONG, INT)),
    ("reader", "check"): (VOID, (BOOL, TEXT)),
}
"""What records can do: the type of the result, and those of the arguments."""
BITS_OF: Final = {("wire", "number"): 1, ("reader", "number"): 0, ("reader", "below"): 1}
"""Which argument is the number of bits: of 32 bits, the result takes more than a word."""
MATH: Final = {
    **dict.fromkeys(("sqrt", "log", "log2", "log10", "log1p", "exp", "expm1", "sin", "cos", "tan"), 1),
    **dict.fromkeys(("atan", "asin", "acos", "tanh", "trunc"), 1),
    **dict.fromkeys(("pow", "atan2", "hypot", "fmod", "copysign"), 2),
}
"""Functions of ``math`` that C99 has under the same name, and their numbers of arguments."""
REMEDIES: Final = {
    **dict.fromkeys(("sum", "any", "all", "sorted", "enumerate", "zip", "reversed", "map"), "write a loop"),
    **dict.fromkeys(("list", "tuple", "set", "dict"), "keep numbers in the row of words"),
    "round": "write math.floor(number + 0.5)",
    "print": "leave it out",
    "divmod": "write // and %",
}
"""What to write instead of functions that strategies don't have."""
KEYWORDS: Final = frozenset(MATH) | frozenset(
    """
    auto break case char const continue default do double else enum extern float for goto if inline int
    long register restrict return short signed sizeof static struct switch typedef union unsigned void
    volatile while bool true false main NULL INFINITY unix linux
    bitand bitor catch class compl delete explicit export friend mutable namespace new operator private
    protected public template this throw try typename using virtual xor
    """.split()  # noqa: SIM905  # as a list it would take forty lines
)
"""Names that a variable can't have in C or C++."""


def promoted(kind: Type) -> Type:
    """Return the type in which C computes with numbers of this one."""
    return INT if kind in (BOOL, SMALL) else kind


def text_of(kind: Type) -> str:
    """Return a type in C."""
    if isinstance(kind, tuple):
        return f"struct feasibee_{'_'.join(SHORT[each] for each in kind)}"
    return RECORDS.get(kind, kind)


def maker_of(kinds: tuple[str, ...]) -> str:
    """Return the function in C that makes a tuple."""
    return f"feasibee_{'_'.join(SHORT[each] for each in kinds)}_of"


SHORT: Final = {INT: "int", WORD: "word", LONG: "long", REAL: "real", BOOL: "bool"}


def joined(one: Type, other: Type) -> Type | None:
    """Return the type of what is one or the other; None where they have no common one."""
    if one == other:
        return one
    if isinstance(one, tuple) and isinstance(other, tuple) and len(one) == len(other):
        parts = [joined(*pair) for pair in zip(one, other, strict=True)]
        return None if None in parts else tuple(map(str, parts))
    if one in NUMBERS and other in NUMBERS:
        kind = NUMBERS[max(NUMBERS.index(str(one)), NUMBERS.index(str(other)))]
        return LONG if kind == WORD else kind
    return None


def _whole(value: int) -> Value | None:
    """Return a whole number in C, of the smallest type that has it."""
    sign = "-" if value < 0 else ""
    size = abs(value)
    if size < 2**31:
        return Value(f"(-{size})" if sign else str(size), INT, value)
    if 0 <= value < 2**32:
        return Value(f"UINT32_C({value})", WORD, value)
    return Value(f"({sign}INT64_C({size}))", LONG, value) if size < 2**63 else None


def constant(value: Any) -> Value | None:
    """Return a number of Python in C, None if it isn't one."""
    if isinstance(value, bool):
        return Value("true" if value else "false", BOOL, value)
    if isinstance(value, int):
        return _whole(value)
    if isinstance(value, float) and math.isinf(value):
        return Value("FEASIBEE_INFINITY" if value > 0 else "(-FEASIBEE_INFINITY)", REAL, value)
    if isinstance(value, float) and not math.isnan(value):
        return Value(f"FEASIBEE_REAL({value!r})", REAL, value)
    return None

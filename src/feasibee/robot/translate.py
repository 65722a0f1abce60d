"""Translate the functions of a strategy from Python to C99, by their syntax trees.

Types flow from the contract: whole numbers, real ones, truth values, rows of words, and records such as ``me``.
A function is translated once for each combination of types that it is called with, those of other modules
included. What the language of strategies doesn't have is an error: file, line, what was met, what to write.
"""

from __future__ import annotations

import ast
import inspect
import math
import operator
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import FunctionType, ModuleType
from typing import Any, Final, NamedTuple, NoReturn

from feasibee.errors import FeasibeeError

INT, WORD, LONG, REAL = "feasibee_int", "uint32_t", "int64_t", "feasibee_real"
BOOL, VOID = "bool", "void"
ROW, REALS, COUNTS = "struct feasibee_row", "struct feasibee_reals", "struct feasibee_counts"
TEXT = "text"
Type = str | tuple[str, ...]
"""A type of C, a record by its name in Python, or the types of a tuple."""
WHOLE: Final = (BOOL, INT, WORD, LONG)
NUMBERS: Final = (*WHOLE, REAL)
"""Types of numbers: of two that meet, the later one is taken, and instead of a word of 32 bits without a sign
one that holds both."""
ELEMENTS: Final = {ROW: INT, REALS: REAL, COUNTS: LONG}
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
    "gap": (ROW, "me"),
    "layout": ("wire", ROW, INT, "setting"),
    "pack": ("writer", ROW, INT, "setting"),
    "unpack": (ROW, "reader", "setting"),
}
"""Types of the arguments of a strategy's functions."""
RESULTS: Final[Mapping[str, Type]] = {
    **dict.fromkeys(("quality", "dissemination", "value", "lasting"), REAL),
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


_WHOLE: Final = (
    "robots count tasks robot_ids task_ids id_bits".split()  # noqa: SIM905
)
_CLASSES: Final = ("robot_classes", "task_classes")
_REALS: Final = "width height sight radio speed exploration dissemination mean_run".split()  # noqa: SIM905
_SETTING: Final = "{}->settings->setting"
FIELDS: Final[Mapping[str, Mapping[str, tuple[str, Type, tuple[str, ...]]]]] = {
    "setting": {
        **{name: _field(f"(feasibee_int){{}}->{name}", INT) for name in _WHOLE},
        **{name: _field(f"(feasibee_int)FEASIBEE_CLASSES_OF({{}}->{name})", INT) for name in _CLASSES},
        **{name: _field(f"{{}}->{name}", REAL, "floating") for name in _REALS},
        **{name: _field(f"{{}}->{name}", BOOL) for name in ("knows_count", "colluding")},
        "walled": _field("{}->walled", BOOL, "floating"),
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
"""The fields of each record: in C, their type, and what it takes to have them."""
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
KEYWORDS: Final = frozenset(
    "auto break case char const continue default do double else enum extern float for goto if inline int long "
    "register restrict return short signed sizeof static struct switch typedef union unsigned void volatile "
    "while bool true false floor ceil main INFINITY NULL unix linux".split()  # noqa: SIM905
    + list(MATH)
)
"""Names that a variable can't have in C."""


def text_of(kind: Type) -> str:
    """Return a type in C."""
    if isinstance(kind, tuple):
        return f"struct feasibee_{'_'.join(_SHORT[each] for each in kind)}"
    return RECORDS.get(kind, kind)


_SHORT: Final = {INT: "int", WORD: "word", LONG: "long", REAL: "real", BOOL: "bool"}


def _joined(one: Type, other: Type) -> Type | None:
    """Return the type of what is one or the other, None if there is none."""
    if one == other:
        return one
    if isinstance(one, tuple) and isinstance(other, tuple) and len(one) == len(other):
        parts = [_joined(*pair) for pair in zip(one, other, strict=True)]
        return None if None in parts else tuple(map(str, parts))
    if one in NUMBERS and other in NUMBERS:
        kind = NUMBERS[max(NUMBERS.index(str(one)), NUMBERS.index(str(other)))]
        return LONG if kind == WORD else kind
    return None


def constant(value: Any) -> Value | None:
    """Return a number of Python in C, None if it isn't one."""
    if isinstance(value, bool):
        return Value("true" if value else "false", BOOL, value)
    if isinstance(value, int) and abs(value) <= 2**63 - 1:
        if -(2**31) < value < 2**31:
            return Value(str(value) if value >= 0 else f"({value})", INT, value)
        if 0 <= value < 2**32:
            return Value(f"UINT32_C({value})", WORD, value)
        return Value(f"INT64_C({value})" if value >= 0 else f"(-INT64_C({-value}))", LONG, value)
    if isinstance(value, float) and math.isinf(value):
        return Value("FEASIBEE_INFINITY" if value > 0 else "(-FEASIBEE_INFINITY)", REAL, value)
    if isinstance(value, float) and not math.isnan(value):
        return Value(f"FEASIBEE_REAL({value!r})", REAL, value)
    return None


@dataclass
class Translation:
    """Functions in C, each once for each combination of types."""

    sources: Mapping[str, str] = field(default_factory=dict)
    """Texts of modules that aren't files, by the name of the module."""
    functions: list[str] = field(default_factory=list)
    """Definitions, each after those that it calls."""
    tuples: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Types of tuples, by their names in C."""
    _done: dict[tuple[str, int, tuple[Type | None, ...]], Signature] = field(default_factory=dict)
    _under_way: list[tuple[str, int, tuple[Type | None, ...]]] = field(default_factory=list)
    _trees: dict[str, ast.Module] = field(default_factory=dict)

    def entry(self, name: str, function: FunctionType, source: str = "") -> Signature:
        """Translate a function of the contract; its module's text is needed if that isn't a file."""
        if source:
            self.sources[function.__module__] = source
        return self.function(function, ARGUMENTS[name], RESULTS.get(name, INT))

    def function(
        self, function: FunctionType, arguments: tuple[Type, ...], result: Type | None = None
    ) -> Signature:
        """Translate a function for arguments of these types; return it as it is in C.

        Raises
        ------
        FeasibeeError
            If it has what the language of strategies doesn't have.
        """
        key = (function.__module__, function.__code__.co_firstlineno, (*arguments, result))
        if key in self._done:
            return self._done[key]
        body = _Body(self, function, self._definition(function))
        if key in self._under_way:
            body.fail(body.tree, f"{function.__name__} calls itself", "write a loop")
        self._under_way.append(key)
        try:
            signature = body.translate(self._name(function), arguments, result)
        finally:
            self._under_way.pop()
        self._done[key] = signature
        self.functions.append(body.text(signature))
        return signature

    def structs(self) -> list[str]:
        """Return the definitions of the tuples."""
        return [
            f"struct {name} {{\n"
            + "".join(f"    {kind} m{place};\n" for place, kind in enumerate(kinds))
            + "};\n"
            for name, kinds in self.tuples.items()
        ]

    def _name(self, function: FunctionType) -> str:
        module = function.__module__.rpartition(".")[2]
        base = f"feasibee_{module}_{function.__name__}"
        taken = {signature.name for signature in self._done.values()}
        return next(
            each for each in (base, *(f"{base}_{n}" for n in range(2, 100))) if each not in taken
        )

    def _definition(self, function: FunctionType) -> ast.FunctionDef:
        """Return the syntax tree of a function."""
        name = function.__module__
        if name not in self._trees:
            text = self.sources.get(name) or inspect.getsource(sys.modules[name])
            self._trees[name] = ast.parse(text)
        for node in ast.walk(self._trees[name]):
            if isinstance(node, ast.FunctionDef) and node.lineno == function.__code__.co_firstlineno:
                return node
        raise FeasibeeError(f"{function.__name__}: isn't a plain function; write def {function.__name__}(...)")


class _Body:
    """The body of one function, in C."""

    def __init__(self, translation: Translation, function: FunctionType, tree: ast.FunctionDef) -> None:
        self.translation, self.function, self.tree = translation, function, tree
        self.names: Mapping[str, Any] = function.__globals__
        self.types: dict[str, Type] = {}
        self.loops: set[str] = set()
        self.result: Type | None = None
        self.position = self.floating = False
        self.lines: list[str] = []
        self.temporary = 0

    def fail(self, node: ast.AST, met: str, remedy: str) -> NoReturn:
        """Raise an error that says where, what was met, and what to write instead."""
        file = self.function.__code__.co_filename.replace("\\", "/").rpartition("/")[2]
        raise FeasibeeError(f"{file}, line {getattr(node, 'lineno', 1)}: {met}; {remedy}")

    def translate(self, name: str, arguments: tuple[Type, ...], result: Type | None) -> Signature:
        """Translate until no type changes: a variable may be whole at first, and real later on."""
        parameters = [each.arg for each in self.tree.args.args]
        self.types, self.result, self.wanted = dict(zip(parameters, arguments, strict=True)), result, result
        self.own_loops = self._variables_of_loops()
        while True:
            before, self.lines, self.temporary = (dict(self.types), self.result), [], 0
            self.block(self.tree.body, 1)
            if before == (self.types, self.result):
                break
        return Signature(name, arguments, self.result or VOID, Needs(self.position, self.floating))

    def text(self, signature: Signature) -> str:
        """Return the definition."""
        parameters = [each.arg for each in self.tree.args.args]
        written = [
            f"{text_of(kind)} {_c_name(each)}".replace("* ", "*")
            for each, kind in zip(parameters, (self.types[each] for each in parameters), strict=True)
        ]
        said = (ast.get_docstring(self.tree) or "").split("\n")[0].replace("*/", "* /")
        lines = [f"/* {said} */"] if said else []
        result = text_of(signature.result)
        lines += [f"static inline {result} {signature.name}({', '.join(written) or 'void'})", "{"]
        if signature.needs.floating and not signature.needs.position:
            lines += ["#ifndef FEASIBEE_DOUBLE", *(f"    (void){_c_name(each)};" for each in parameters)]
            lines += ["    FEASIBEE_STOP();"]
            lines += [f"    return {_zero(signature.result)};"] if signature.result != VOID else []
            lines += ["#else"]
        lines += [
            f"    {text_of(kind)} {_c_name(each)} = {_zero(kind, begins=True)};"
            for each, kind in self.types.items()
            if each not in parameters and each not in self.loops
        ]
        lines += [f"    (void){_c_name(each)};" for each in parameters if self._may_be_unread(each)]
        lines += self.lines
        if signature.needs.floating and not signature.needs.position:
            lines += ["#endif"]
        lines += ["}", ""]
        return "\n".join(["#ifdef FEASIBEE_DOUBLE", *lines, "#endif", ""] if signature.needs.position else lines)

    def _may_be_unread(self, name: str) -> bool:
        """Whether C may not read an argument: it isn't read here, or only for what is a constant there."""
        read = any(isinstance(node, ast.Name) and node.id == name for node in ast.walk(self.tree))
        return not read or self.types[name] in ("me", "setting")

    def _variables_of_loops(self) -> set[str]:
        """Return the variables that only loops set, and that only their bodies read."""
        inside: dict[str, int] = {}
        for loop in ast.walk(self.tree):
            if isinstance(loop, ast.For) and isinstance(loop.target, ast.Name):
                used = [each for each in ast.walk(loop) if isinstance(each, ast.Name) and each.id == loop.target.id]
                if sum(isinstance(each.ctx, ast.Store) for each in used) == 1:
                    inside[loop.target.id] = inside.get(loop.target.id, 0) + len(used)
        everywhere = [node.id for node in ast.walk(self.tree) if isinstance(node, ast.Name)]
        return {name for name, times in inside.items() if everywhere.count(name) == times}

    # --- Statements ---

    def block(self, statements: Sequence[ast.stmt], depth: int) -> None:
        """Translate statements."""
        for statement in statements:
            write = getattr(self, f"_{type(statement).__name__.lower()}", None)
            if write is None:
                what = type(statement).__name__.lower()
                self.fail(statement, f"a statement of the kind {what!r}", "write assignments, if, for and while")
            write(statement, depth)

    def put(self, depth: int, line: str) -> None:
        """Add a line."""
        self.lines.append("    " * depth + line)

    def _pass(self, statement: ast.Pass, depth: int) -> None:
        self.put(depth, ";")

    def _break(self, statement: ast.Break, depth: int) -> None:
        self.put(depth, "break;")

    def _continue(self, statement: ast.Continue, depth: int) -> None:
        self.put(depth, "continue;")

    def _expr(self, statement: ast.Expr, depth: int) -> None:
        if not isinstance(statement.value, ast.Constant):
            self.put(depth, f"{self.value(statement.value).text};")

    def _return(self, statement: ast.Return, depth: int) -> None:
        if statement.value is None:
            self.put(depth, "return;")
            return
        value = self.value(statement.value)
        if self.wanted is None or value.type not in NUMBERS:
            self.result = self._join(statement, value.type, self.result or value.type)
        self.put(depth, f"return {self._cast(value, self.result).text};")

    def _if(self, statement: ast.If, depth: int) -> None:
        self.put(depth, f"if ({self.truth(statement.test)}) {{")
        self.block(statement.body, depth + 1)
        if statement.orelse:
            self.put(depth, "} else {")
            self.block(statement.orelse, depth + 1)
        self.put(depth, "}")

    def _while(self, statement: ast.While, depth: int) -> None:
        self._no_else(statement)
        self.put(depth, f"while ({self.truth(statement.test)}) {{")
        self.block(statement.body, depth + 1)
        self.put(depth, "}")

    def _no_else(self, statement: ast.For | ast.While) -> None:
        if statement.orelse:
            self.fail(statement, "a loop with else", "write if after it")

    def _for(self, statement: ast.For, depth: int) -> None:
        self._no_else(statement)
        over = statement.iter
        if isinstance(over, ast.Call) and isinstance(over.func, ast.Name) and over.func.id == "range":
            self._count_up(statement, over.args, depth)
            return
        items = self._items(over)
        if items is None:
            remedy = "write for k in range(number), and take what is at k"
            self.fail(statement, f"a loop over {ast.unparse(over)}", remedy)
        for item in items:  # each pass of the loop for itself
            self.assign(statement.target, item, depth)
            self.block(statement.body, depth)
        if any(isinstance(each, ast.Break | ast.Continue) for each in ast.walk(statement)):
            self.fail(statement, "a loop over numbers written out, with break or continue", "use range")

    def _items(self, over: ast.expr) -> list[ast.expr | Value] | None:
        """Return the items of a tuple that is written out, or of a constant one."""
        if isinstance(over, ast.Tuple):
            return list(over.elts)
        known = self.names.get(over.id) if isinstance(over, ast.Name) and over.id not in self.types else None
        if isinstance(known, tuple):
            return [ast.parse(repr(each), mode="eval").body for each in known]
        return None

    def _count_up(self, statement: ast.For, limits: list[ast.expr], depth: int) -> None:
        if not isinstance(statement.target, ast.Name):
            self.fail(statement, f"{ast.unparse(statement.target)} in a range", "use one name")
        values = [self.value(each) for each in limits]
        first = constant(0) if len(values) == 1 else values[0]
        step = values[2] if len(values) > 2 else constant(1)
        assert first is not None and step is not None
        last = values[0] if len(values) == 1 else values[1]
        kind = self._join(statement, self._join(statement, first.type, last.type), INT)
        name, own = statement.target.id, statement.target.id in self.own_loops
        if own:
            self.loops.add(name)
        self.types[name] = self._join(statement, self.types.get(name, kind), kind)
        counter = _c_name(name) if own else self.new()
        # Without a number written out, steps go up, as they do in all strategies so far.
        sign = ">" if step.known is not None and step.known < 0 else "<"
        steps = {1: "++", -1: "--"}.get(step.known, f" += {step.text}")
        head = f"{text_of(kind)} {counter} = {first.text}, {counter}_end = {last.text}"
        self.put(depth, f"for ({head}; {counter} {sign} {counter}_end; {counter}{steps}) {{")
        if not own:
            self.put(depth + 1, f"{_c_name(name)} = {counter};")
        elif not any(isinstance(n, ast.Name) and n.id == name for each in statement.body for n in ast.walk(each)):
            self.put(depth + 1, f"(void){counter};")
        self.block(statement.body, depth + 1)
        self.put(depth, "}")

    def _annassign(self, statement: ast.AnnAssign, depth: int) -> None:
        if statement.value is not None:
            self.assign(statement.target, statement.value, depth)

    def _augassign(self, statement: ast.AugAssign, depth: int) -> None:
        old = ast.copy_location(_loaded(statement.target), statement)
        new = ast.BinOp(left=old, op=statement.op, right=statement.value)
        self.assign(statement.target, ast.copy_location(new, statement), depth)

    def _assign(self, statement: ast.Assign, depth: int) -> None:
        if len(statement.targets) == 1:
            self.assign(statement.targets[0], statement.value, depth)
            return
        held = self.hold(self.value(statement.value), depth)
        for target in statement.targets:
            self.assign(target, held, depth)

    def assign(self, target: ast.expr, given: ast.expr | Value, depth: int) -> None:
        """Assign an expression to a name, a place in a row, or several of them."""
        if isinstance(target, ast.Tuple | ast.List):
            self._assign_several(target, given, depth)
            return
        value = given if isinstance(given, Value) else self.value(given)
        if isinstance(target, ast.Name) and target.id == "_":
            return
        if isinstance(target, ast.Name):
            kind = self._join(target, self.types.get(target.id, value.type), value.type)
            if kind == VOID:
                self.fail(target, f"{target.id} is given nothing", "call a function that returns a number")
            self.types[target.id] = kind
            self.put(depth, f"{_c_name(target.id)} = {self._cast(value, kind).text};")
        elif isinstance(target, ast.Subscript) and not isinstance(target.slice, ast.Slice):
            self.put(depth, f"{self._place(target)} = {self._stored(target, value)};")
        else:
            self.fail(target, f"an assignment to {ast.unparse(target)}", "assign to a name, or to row[place]")

    def _stored(self, target: ast.Subscript, value: Value) -> str:
        row = self.value(target.value).type
        if value.type not in NUMBERS or (value.type == REAL and row != REALS):
            self.fail(target, f"{ast.unparse(target)} is given a value of another type", "write int(...)")
        return f"(int32_t)({value.text})" if row == ROW else f"({ELEMENTS[str(row)]})({value.text})"

    def _assign_several(self, target: ast.Tuple | ast.List, given: ast.expr | Value, depth: int) -> None:
        if isinstance(given, ast.Tuple) and len(given.elts) == len(target.elts):
            values: list[Value] = [self.value(each) for each in given.elts]
            written = {node.id for node in ast.walk(target) if isinstance(node, ast.Name)}
            read = {node.id for node in ast.walk(given) if isinstance(node, ast.Name)}
            if written & read:
                values = [self.hold(value, depth) for value in values]
        else:
            whole = self.hold(given if isinstance(given, Value) else self.value(given), depth)
            if not isinstance(whole.type, tuple) or len(whole.type) != len(target.elts):
                self.fail(target, f"{len(target.elts)} names for another number of values", "give each one")
            values = [Value(f"{whole.text}.m{k}", kind) for k, kind in enumerate(whole.type)]
        for each, value in zip(target.elts, values, strict=True):
            self.assign(each, value, depth)

    def hold(self, value: Value, depth: int) -> Value:
        """Keep a value in a variable of its own."""
        if value.known is not None:
            return value
        name = self.new()
        self.put(depth, f"{text_of(value.type)} {name} = {value.text};")
        return Value(name, value.type)

    def new(self) -> str:
        """Return a new name."""
        self.temporary += 1
        return f"t{self.temporary}_"

    # --- Expressions ---

    def value(self, node: ast.expr) -> Value:
        """Translate an expression."""
        read = getattr(self, f"_v_{type(node).__name__.lower()}", None)
        if read is None:
            self.fail(node, ast.unparse(node), "write it with numbers, rows and calls of functions")
        found: Value = read(node)
        return found

    def truth(self, node: ast.expr) -> str:
        """Translate a condition."""
        value = self.value(node)
        if value.type not in NUMBERS:
            self.fail(node, f"{ast.unparse(node)} as a condition", "compare it with a number")
        return _bare(value.text) if value.type == BOOL else f"{value.text} != 0"

    def _join(self, node: ast.AST, one: Type, other: Type) -> Type:
        kind = _joined(one, other)
        if kind is None:
            self.fail(node, f"{ast.unparse(node)} is now one type, now another", "use two names")
        if isinstance(kind, tuple):
            self.translation.tuples[text_of(kind).removeprefix("struct ")] = kind
        return kind

    def _cast(self, value: Value, kind: Type) -> Value:
        """Return a tuple of another type as one of this type; C converts numbers by itself."""
        if value.type == kind or not isinstance(kind, tuple):
            return value
        if value.text.startswith("(struct"):
            return Value(f"({text_of(kind)}){value.text[value.text.index('{') :]}", kind)
        name = value.text
        return Value(f"({text_of(kind)}){{{', '.join(f'{name}.m{k}' for k in range(len(kind)))}}}", kind)

    def _v_constant(self, node: ast.Constant) -> Value:
        if isinstance(node.value, str):
            return Value("", TEXT)
        found = constant(node.value)
        if found is None:
            self.fail(node, repr(node.value), "write a number")
        return found

    def _v_name(self, node: ast.Name) -> Value:
        if node.id in self.types:
            return Value(_c_name(node.id), self.types[node.id])
        found = constant(self.names.get(node.id))
        if found is None:
            self.fail(node, f"the name {node.id}", "use arguments, own variables, and constants of the file")
        return found

    def _v_attribute(self, node: ast.Attribute) -> Value:
        if isinstance(node.value, ast.Name) and node.value.id not in self.types:
            module = self.names.get(node.value.id)
            found = constant(getattr(module, node.attr, None)) if isinstance(module, ModuleType) else None
            if found is None:
                self.fail(node, ast.unparse(node), "use a constant of the file, or of math")
            return found
        record = self.value(node.value)
        fields = FIELDS.get(str(record.type), {})
        if node.attr not in fields:
            self.fail(node, ast.unparse(node), f"use one of {', '.join(fields) or 'the arguments'}")
        text, kind, needs = fields[node.attr]
        self.position |= "position" in needs
        self.floating |= "floating" in needs
        return Value(text.format(record.text), kind)

    def _place(self, node: ast.Subscript) -> str:
        """Return a place in a row."""
        row, place = self.value(node.value), self.value(node.slice)
        if row.type not in ELEMENTS or place.type not in WHOLE:
            self.fail(node, ast.unparse(node), "take one number out of a row, by a whole number")
        name = {ROW: "feasibee_at", REALS: "feasibee_real_at", COUNTS: "feasibee_count_at"}[str(row.type)]
        return f"*{name}({row.text}, {_bare(place.text)})"

    def _v_subscript(self, node: ast.Subscript) -> Value:
        if isinstance(node.slice, ast.Slice):
            self.fail(node, ast.unparse(node), "write a loop over the places")
        whole = self.value(node.value)
        if isinstance(whole.type, tuple):
            place = self.value(node.slice).known
            if not isinstance(place, int) or not 0 <= place < len(whole.type):
                self.fail(node, ast.unparse(node), f"write a number from 0 to {len(whole.type) - 1}")
            return Value(f"{whole.text}.m{place}", whole.type[place])
        return Value(f"(feasibee_int){self._place(node)}" if whole.type == ROW else f"({self._place(node)})",
                     ELEMENTS.get(str(whole.type), INT))

    def _v_tuple(self, node: ast.Tuple) -> Value:
        values = [self.value(each) for each in node.elts]
        kinds = tuple(str(each.type) for each in values)
        if not set(kinds) <= set(NUMBERS):
            self.fail(node, ast.unparse(node), "return numbers")
        self.translation.tuples[text_of(kinds).removeprefix("struct ")] = kinds
        return Value(f"({text_of(kinds)}){{{', '.join(each.text for each in values)}}}", kinds)

    def _v_unaryop(self, node: ast.UnaryOp) -> Value:
        if isinstance(node.op, ast.Not):
            return Value(f"!({self.truth(node.operand)})", BOOL)
        value = self.number(node.operand)
        if value.known is not None:
            known = _UNARY[type(node.op)][1](value.known)
            return constant(known) or value
        if isinstance(node.op, ast.Invert) and value.type == REAL:
            self.fail(node, ast.unparse(node), "use a whole number")
        kind = {BOOL: INT, WORD: LONG}.get(str(value.type), value.type)
        return Value(f"({_UNARY[type(node.op)][0]}{_of(value, str(kind))})", kind)

    def _v_boolop(self, node: ast.BoolOp) -> Value:
        sign = " && " if isinstance(node.op, ast.And) else " || "
        return Value(f"({sign.join(f'({self.truth(each)})' for each in node.values)})", BOOL)

    def _v_ifexp(self, node: ast.IfExp) -> Value:
        condition = self.value(node.test)
        one, other = self.value(node.body), self.value(node.orelse)
        if condition.known is not None:
            return one if condition.known else other
        kind = self._join(node, one.type, other.type)
        one, other = self._cast(one, kind), self._cast(other, kind)
        cast = f"({text_of(kind)})" if kind in NUMBERS else ""
        return Value(f"({self.truth(node.test)} ? {cast}{one.text} : {cast}{other.text})", kind)

    def number(self, node: ast.expr) -> Value:
        """Translate an expression that must be a number."""
        value = self.value(node)
        if value.type not in NUMBERS:
            self.fail(node, f"{ast.unparse(node)} as a number", "compute with numbers, one by one")
        return value

    def _v_compare(self, node: ast.Compare) -> Value:
        parts, left = [], node.left
        for sign, right in zip(node.ops, node.comparators, strict=True):
            parts.append(self._compared(node, left, sign, right))
            left = right
        return Value(parts[0] if len(parts) == 1 else f"({' && '.join(parts)})", BOOL)

    def _compared(self, node: ast.Compare, left: ast.expr, sign: ast.cmpop, right: ast.expr) -> str:
        if isinstance(sign, ast.In | ast.NotIn) and isinstance(right, ast.Tuple):
            each = [f"{self.number(left).text} == {self.number(item).text}" for item in right.elts]
            return f"{'!' if isinstance(sign, ast.NotIn) else ''}({' || '.join(each)})"
        if type(sign) not in _COMPARISONS:
            self.fail(node, ast.unparse(node), "compare numbers with ==, !=, <, <=, > or >=")
        half = self._half(left, sign, right)
        if half:
            return half
        one, other = _comparable(self.number(left), self.number(right))
        return f"({one} {_COMPARISONS[type(sign)]} {other})"

    def _half(self, left: ast.expr, sign: ast.cmpop, right: ast.expr) -> str:
        """Return the comparison of a quality with 1/2 in whole numbers, which needs no float."""
        is_quality = isinstance(left, ast.Attribute) and left.attr == "feasible_quality"
        if not is_quality or self.value(right).known != 0.5:
            return ""
        mind = self.value(left.value)  # type: ignore[attr-defined]
        if mind.type != "mind":
            return ""
        ratio = f"{mind.text}->feasible_quality"
        return f"({ratio}.part {_COMPARISONS[type(sign)]} {ratio}.whole - {ratio}.part)"

    def _v_binop(self, node: ast.BinOp) -> Value:
        one, other = self.number(node.left), self.number(node.right)
        if one.known is not None and other.known is not None:
            found = constant(_folded(node.op, one.known, other.known))
            if found is not None:
                return found
        wrapped = self._wrapped(node, one, other)
        if wrapped is not None:
            return wrapped
        kind = self._join(node, self._join(node, one.type, other.type), INT)
        write = _OPERATORS.get(type(node.op))
        text, kind = ("", kind) if write is None else write(one, other, str(kind))
        if not text:
            self.fail(node, ast.unparse(node), "use whole numbers, or math.floor and math.fmod")
        self.floating |= text.startswith("FEASIBEE_POW")
        return Value(text, kind)

    def _wrapped(self, node: ast.BinOp, one: Value, other: Value) -> Value | None:
        """Return a number modulo 2**32, for which words of 32 bits are enough."""
        last = 2**32 - (0 if isinstance(node.op, ast.Mod) else 1)
        if not isinstance(node.op, ast.BitAnd | ast.Mod) or other.known != last or one.type == REAL:
            return None
        inner = node.left
        if isinstance(inner, ast.BinOp) and type(inner.op) in _MODULAR:
            left, right = self.number(inner.left), self.number(inner.right)
            text = f"(uint32_t)({left.text}) {_MODULAR[type(inner.op)]} (uint32_t)({right.text})"
            return Value(f"({text})", WORD)
        return Value(f"(uint32_t)({one.text})", WORD)

    # --- Calls ---

    def _v_call(self, node: ast.Call) -> Value:
        if node.keywords or any(isinstance(each, ast.Starred) for each in node.args):
            self.fail(node, ast.unparse(node), "give the arguments in their order, one by one")
        if isinstance(node.func, ast.Attribute):
            return self._method(node, node.func)
        if not isinstance(node.func, ast.Name):
            self.fail(node, ast.unparse(node), "call a function by its name")
        builtin = getattr(self, f"_call_{node.func.id}", None)
        known = self.names.get(node.func.id)
        if builtin is not None and known is None:
            found: Value = builtin(node)
            return found
        return self._own(node, known, node.func.id)

    def _own(self, node: ast.Call, function: Any, name: str) -> Value:
        """Call a function of this file or of another strategy."""
        function = inspect.unwrap(function) if callable(function) else function
        if not isinstance(function, FunctionType):
            remedy = REMEDIES.get(name, "call functions of the file, of math, min, max, abs, int, float or len")
            self.fail(node, f"{name}(...)", remedy)
        values = [self.value(each) for each in node.args]
        arguments = tuple(INT if each.type == BOOL else each.type for each in values)
        if len(arguments) != function.__code__.co_argcount or TEXT in arguments or VOID in arguments:
            self.fail(node, ast.unparse(node), f"give the arguments of {name}, all of them")
        signature = self.translation.function(function, arguments)
        self.position |= signature.needs.position
        return Value(f"{signature.name}({', '.join(_bare(each.text) for each in values)})", signature.result)

    def _method(self, node: ast.Call, method: ast.Attribute) -> Value:
        if isinstance(method.value, ast.Name) and method.value.id not in self.types:
            module = self.names.get(method.value.id)
            if module is math:
                return self._of_math(node, method.attr)
            if isinstance(module, ModuleType):
                return self._own(node, getattr(module, method.attr, None), ast.unparse(method))
        record = self.value(method.value)
        if record.type in WHOLE and method.attr in ("bit_length", "bit_count"):
            if record.known is not None:
                return constant(getattr(record.known, method.attr)()) or record
            kind = _SHORT[INT if record.type == BOOL else str(record.type)]
            size = _bare(record.text) if kind == "word" else f"feasibee_size_{kind}({_bare(record.text)})"
            return Value(f"feasibee_{method.attr}_{kind}({size})", INT)
        if (record.type, method.attr) not in METHODS:
            known = ", ".join(name for kind, name in METHODS if kind == record.type)
            self.fail(node, ast.unparse(node), f"use {known or 'functions of numbers'}")
        return self._of_record(node, record, method.attr)

    def _of_record(self, node: ast.Call, record: Value, name: str) -> Value:
        values = [self.value(each) for each in node.args]
        result, wanted = METHODS[str(record.type), name]
        if (record.type, name) == ("wire", "number") and len(values) == 3:
            name, wanted = "below", (INT, INT, INT)
        if len(values) != len(wanted):
            self.fail(node, ast.unparse(node), f"give {len(wanted)} arguments")
        place = BITS_OF.get((str(record.type), name if name != "below" or record.type == "reader" else "number"))
        if place is not None and values[place].known == 32:
            result = WORD
        told = [
            _bare(each.text) if kind == BOOL else f"(uint32_t)({_bare(each.text)})"
            for each, kind in zip(values, wanted, strict=True)
            if kind != TEXT
        ]
        call = f"feasibee_{record.type}_{name}({', '.join([record.text, *told])})"
        return Value(f"(feasibee_int){call}" if result == INT else call, result)

    def _of_math(self, node: ast.Call, name: str) -> Value:
        values = [self.number(each) for each in node.args]
        told = ", ".join(f"(feasibee_real)({_bare(each.text)})" for each in values)
        if name in ("floor", "ceil") and len(values) == 1:
            if values[0].type != REAL:
                return values[0]
            return Value(f"feasibee_{name}({told})", INT)
        if name in ("isinf", "isnan", "isfinite") and len(values) == 1:
            return Value(f"({name}({told}) != 0)", BOOL)
        if MATH.get(name) != len(values):
            self.fail(node, f"math.{name}", f"use one of {', '.join(MATH)}, floor, ceil, or write it out")
        self.floating = True
        return Value(f"FEASIBEE_{name.upper()}({told})", REAL)

    def _call_len(self, node: ast.Call) -> Value:
        (row,) = [self.value(each) for each in node.args]
        if row.type not in ELEMENTS:
            self.fail(node, ast.unparse(node), "take the length of a row")
        return Value(f"(feasibee_int){row.text}.length", INT)

    def _call_int(self, node: ast.Call) -> Value:
        (value,) = [self.number(each) for each in node.args]
        if value.type in WHOLE[1:]:
            return value
        return Value(f"(feasibee_int)({value.text})", INT)

    def _call_float(self, node: ast.Call) -> Value:
        (value,) = [self.number(each) for each in node.args]
        if value.known is not None:
            return constant(float(value.known)) or value
        return Value(f"(feasibee_real)({value.text})", REAL)

    def _call_bool(self, node: ast.Call) -> Value:
        (argument,) = node.args
        return Value(f"({self.truth(argument)})", BOOL)

    def _call_abs(self, node: ast.Call) -> Value:
        (value,) = [self.number(each) for each in node.args]
        if value.type == WORD:
            return value
        kind = INT if value.type == BOOL else value.type
        return Value(f"feasibee_abs_{_SHORT[str(kind)]}({value.text})", kind)

    def _call_min(self, node: ast.Call) -> Value:
        return self._extreme(node, "min")

    def _call_max(self, node: ast.Call) -> Value:
        return self._extreme(node, "max")

    def _extreme(self, node: ast.Call, name: str) -> Value:
        values = [self.number(each) for each in node.args]
        if len(values) < 2:
            self.fail(node, ast.unparse(node), "give two numbers or more")
        kind: Type = WORD if all(_is_word(each) for each in values) else INT
        for each in values:
            kind = kind if kind == WORD else self._join(node, kind, each.type)
        text = values[0].text
        for each in values[1:]:
            text = f"feasibee_{name}_{_SHORT[str(kind)]}({_bare(text)}, {_bare(each.text)})"
        return Value(text, kind)


_UNARY: Final[Mapping[type, tuple[str, Callable[[Any], Any]]]] = {
    ast.USub: ("-", lambda value: -value),
    ast.UAdd: ("+", lambda value: +value),
    ast.Invert: ("~", lambda value: ~value),
}
_FOLDED: Final[Mapping[type, Callable[[Any, Any], Any]]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
    ast.LShift: operator.lshift,
    ast.RShift: operator.rshift,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.BitXor: operator.xor,
}
_COMPARISONS: Final[Mapping[type, str]] = {
    ast.Eq: "==", ast.NotEq: "!=", ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=",
}  # fmt: skip


def _c_name(name: str) -> str:
    """Return a variable's name in C."""
    if not name.isascii():
        raise FeasibeeError(f"{name}: has letters that C doesn't know; use a to z")
    return "unused_" if name == "_" else f"{name}_" if name in KEYWORDS or name.endswith("_end") else name


def _bare(text: str) -> str:
    """Return an expression without parentheses around all of it."""
    depth = 0
    for place, letter in enumerate(text):
        depth += (letter == "(") - (letter == ")")
        if depth == 0 and place < len(text) - 1:
            return text
    return text[1:-1] if text.startswith("(") else text


def _is_word(value: Value) -> bool:
    """Whether a number is at least 0 and has at most 32 bits, as its type or its value says."""
    return value.type == WORD or (value.type == INT and value.known is not None and value.known >= 0)


def _comparable(one: Value, other: Value) -> tuple[str, str]:
    """Return two numbers in C such that their comparison is Python's: with and without a sign don't mix."""
    if WORD not in (one.type, other.type) or REAL in (one.type, other.type):
        return one.text, other.text
    kind = WORD if _is_word(one) and _is_word(other) else LONG
    return _of(one, kind), _of(other, kind)


def _wide(value: Value) -> str:
    """Return a number that C doesn't compute with in fewer bits."""
    return f"(feasibee_int){value.text}" if value.type == BOOL else value.text


def _zero(kind: Type, begins: bool = False) -> str:
    """Return nothing of a type, for a definition or as a value."""
    if kind in NUMBERS:
        return "0"
    return "{0}" if begins else f"({text_of(kind)}){{0}}"


def _loaded(target: ast.expr) -> ast.expr:
    return ast.parse(ast.unparse(target), mode="eval").body


def _folded(sign: ast.operator, one: Any, other: Any) -> Any:
    """Return what Python computes of two numbers, None if nothing or too much."""
    if isinstance(sign, ast.LShift | ast.Pow) and abs(other) > 64:
        return None
    try:
        return _FOLDED[type(sign)](one, other)
    except (ArithmeticError, TypeError):
        return None


def _plain(sign: str) -> Callable[[Value, Value, str], tuple[str, Type]]:
    def write(one: Value, other: Value, kind: str) -> tuple[str, Type]:
        return f"({_of(one, kind)} {sign} {_of(other, kind)})", kind

    return write


def _of(value: Value, kind: str) -> str:
    """Return an operand as wide as the result."""
    return value.text if value.type == kind else f"({kind}){value.text}"


def _bitwise(sign: str) -> Callable[[Value, Value, str], tuple[str, Type]]:
    def write(one: Value, other: Value, kind: str) -> tuple[str, Type]:
        if kind == REAL:
            return "", kind
        masks = [each for each in (one, other) if each.known is not None and each.known >= 0]
        if kind == LONG and _is_word(one) and _is_word(other):
            text = f"({_of(one, WORD)} {sign} {_of(other, WORD)})"
            small = sign == "&" and any(each.type == INT for each in masks)
            return (f"(feasibee_int){text}", INT) if small else (text, WORD)
        text = f"({_of(one, kind)} {sign} {_of(other, kind)})"
        small = sign == "&" and kind == LONG and any(each.type == INT for each in masks)
        return (f"(feasibee_int){text}", INT) if small else (text, kind)

    return write


def _left(one: Value, other: Value, kind: str) -> tuple[str, Type]:
    if kind == REAL:
        return "", kind
    wide = INT if one.type in (BOOL, INT) else LONG
    unsigned = "uint64_t" if wide == LONG else "feasibee_unsigned"
    return f"({wide})(({unsigned}){_of(one, wide)} << {_wide(other)})", wide


def _right(one: Value, other: Value, kind: str) -> tuple[str, Type]:
    if kind == REAL:
        return "", kind
    return f"({_wide(one)} >> {_wide(other)})", INT if one.type == BOOL else str(one.type)


def _is_power(value: Value) -> bool:
    return isinstance(value.known, int) and value.known > 0 and value.known & (value.known - 1) == 0


def _floor_divided(one: Value, other: Value, kind: str) -> tuple[str, Type]:
    if kind == REAL:
        return "", kind
    if _is_power(other):
        return _right(one, Value(str(other.known.bit_length() - 1), INT), kind)
    return f"feasibee_divided_{_SHORT[kind]}({_bare(one.text)}, {_bare(other.text)})", kind


def _modulo(one: Value, other: Value, kind: str) -> tuple[str, Type]:
    if kind == REAL:
        return "", kind
    if _is_power(other):
        mask = constant(other.known - 1)
        assert mask is not None
        return _bitwise("&")(one, mask, str(_joined(one.type, mask.type)))
    text = f"feasibee_modulo_{_SHORT[kind]}({_bare(one.text)}, {_bare(other.text)})"
    return (f"(feasibee_int){text}", INT) if other.type == INT and kind == LONG else (text, kind)


def _divided(one: Value, other: Value, kind: str) -> tuple[str, Type]:
    return f"({_of(one, REAL)} / {_of(other, REAL)})", REAL


def _power(one: Value, other: Value, kind: str) -> tuple[str, Type]:
    if kind == REAL:
        return f"FEASIBEE_POW({_of(one, REAL)}, {_of(other, REAL)})", REAL
    if one.known == 2:
        return _left(Value("1", LONG, 1), other, LONG)
    return f"feasibee_power_{_SHORT[kind]}({_bare(one.text)}, {_bare(other.text)})", kind


_MODULAR: Final[Mapping[type, str]] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*"}
_OPERATORS: Final[Mapping[type, Callable[[Value, Value, str], tuple[str, Type]]]] = {
    ast.Add: _plain("+"),
    ast.Sub: _plain("-"),
    ast.Mult: _plain("*"),
    ast.Div: _divided,
    ast.FloorDiv: _floor_divided,
    ast.Mod: _modulo,
    ast.Pow: _power,
    ast.LShift: _left,
    ast.RShift: _right,
    ast.BitAnd: _bitwise("&"),
    ast.BitOr: _bitwise("|"),
    ast.BitXor: _bitwise("^"),
}

"""Expressions of a strategy in C99: what they compute is what Python computes."""

from __future__ import annotations

import ast
import inspect
import math
import re
from collections.abc import Callable, Mapping, Sequence
from types import FunctionType, ModuleType
from typing import Any, Final, NoReturn, Protocol

from feasibee.base.errors import FeasibeeError
from feasibee.robot.definitions import Definition, folded, is_of_math
from feasibee.robot.language import (
    BITS_OF,
    BOOL,
    COUNTS,
    ELEMENTS,
    INT,
    KEYWORDS,
    LONG,
    MATH,
    METHODS,
    NUMBERS,
    PLAN,
    REAL,
    REALS,
    REMEDIES,
    ROW,
    SHORT,
    SMALL,
    TABLE,
    TEXT,
    VOID,
    WHOLE,
    WORD,
    Signature,
    Target,
    Type,
    Value,
    constant,
    joined,
    maker_of,
    promoted,
    text_of,
)

FLAT: Final = "make a tuple of numbers only, and one for each row"


class Functions(Protocol):
    """The functions that are translated, what for, and the tuples that they return."""

    target: Target
    tuples: dict[str, tuple[str, ...]]

    def definition(self, function: FunctionType | Definition) -> Definition:
        """Return a function with its syntax tree."""
        ...

    def function(self, function: FunctionType | Definition, arguments: tuple[Type, ...]) -> Signature:
        """Translate a function for arguments of these types; return it as it is in C."""
        ...


class Expressions:
    """The expressions of one function."""

    def __init__(self, translation: Functions, function: Definition) -> None:
        self.translation, self.function = translation, function
        self.names: Mapping[str, Any] = function.names
        self.types: dict[str, Type] = {}
        self.position = self.floating = False

    def fail(self, node: ast.AST, met: str, remedy: str) -> NoReturn:
        """Raise an error that says where, what was met, and what to write instead."""
        raise FeasibeeError(f"{self.function.file}, line {getattr(node, 'lineno', 1)}: {met}; {remedy}")

    def constant(self, value: Any) -> Value | None:
        """Return a number of Python in C, None if it isn't one."""
        return constant(value)

    def known(self, value: Any) -> Value | None:
        """Return a number or a tuple of the file in C, None if it is neither."""
        return Value("", TABLE, value) if isinstance(value, tuple) else self.constant(value)

    def in_order(
        self, values: Sequence[Value], write: Callable[[list[Value]], Value], *, first: bool = False
    ) -> Value:
        """Write an expression of values, computed before it where order matters, or with ``first``."""
        return write(list(values))

    def called(self, name: str, values: Sequence[Value], kind: Type, *before: str) -> Value:
        """Call a function in C, with arguments before the values."""

        def write(held: list[Value]) -> Value:
            return Value(f"{name}({', '.join([*before, *(bare(each.text) for each in held)])})", kind)

        return self.in_order(values, write)

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
        return bare(value.text) if value.type == BOOL else f"{value.text} != 0"

    def _join(self, node: ast.AST, one: Type, other: Type) -> Type:
        kind = joined(one, other)
        if kind is None:
            self.fail(node, f"{ast.unparse(node)} is now one type, now another", "use two names")
        if isinstance(kind, tuple):
            self.translation.tuples[text_of(kind)] = kind
        return kind

    def _cast(self, value: Value, kind: Type) -> Value:
        """Return a tuple of another type as one of this type; C converts numbers by itself."""
        if value.type == kind or not isinstance(kind, tuple):
            return value
        made = f"{maker_of(tuple(map(str, value.type)))}("
        if value.text.startswith(made):
            return Value(f"{maker_of(kind)}({value.text.removeprefix(made)}", kind)
        parts = ", ".join(f"{value.text}.m{k}" for k in range(len(kind)))
        return Value(f"{maker_of(kind)}({parts})", kind)

    def _v_constant(self, node: ast.Constant) -> Value:
        if isinstance(node.value, str):
            return Value("", TEXT)
        return self.constant(node.value) or self.fail(node, repr(node.value), "write a number")

    def _v_name(self, node: ast.Name) -> Value:
        if node.id in self.types:
            return self.variable(node)
        found = self.known(self.names.get(node.id))
        if found is None:
            self.fail(node, f"the name {node.id}", "use arguments, own variables, and constants of the file")
        return found

    def variable(self, node: ast.Name) -> Value:
        """Read a variable."""
        return Value(c_name(node.id), self.types[node.id])

    def _v_attribute(self, node: ast.Attribute) -> Value:
        if isinstance(node.value, ast.Name) and node.value.id not in self.types:
            module = self.names.get(node.value.id)
            found = (
                self.constant(getattr(module, node.attr, None)) if isinstance(module, ModuleType) else None
            )
            if found is None:
                self.fail(node, ast.unparse(node), "use a constant of the file, or of math")
            return found
        record = self.value(node.value)
        fields = self.translation.target.fields.get(str(record.type), {})
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
        return f"*{_AT[str(row.type)]}({row.text}, {bare(place.text)})"

    def _v_subscript(self, node: ast.Subscript) -> Value:
        if isinstance(node.slice, ast.Slice):
            self.fail(node, ast.unparse(node), "write a loop over the places")
        whole = self.value(node.value)
        if whole.type == TABLE:
            return self._of_table(node, whole.known)
        return self._of_tuple(node, whole) if isinstance(whole.type, tuple) else self.of_row(node, whole)

    def of_row(self, node: ast.Subscript, row: Value) -> Value:
        """Write in C how a number of a row is read."""
        cast = "(feasibee_int)" if row.type in (ROW, PLAN) else ""
        place = self._place(node)
        return Value(f"{cast}{place}" if cast else f"({place})", ELEMENTS[str(row.type)])

    def _of_tuple(self, node: ast.Subscript, whole: Value) -> Value:
        place, count = self.value(node.slice).known, len(whole.type)
        if not isinstance(place, int) or not -count <= place < count:
            self.fail(node, ast.unparse(node), f"write a number from 0 to {count - 1}")
        return Value(f"{whole.text}.m{place % count}", whole.type[place])

    def _of_table(self, node: ast.Subscript, table: tuple[Any, ...]) -> Value:
        """Return what is at a place of a constant tuple."""
        place = self.value(node.slice)
        if place.type not in WHOLE:
            self.fail(node, ast.unparse(node), "give its place as a whole number")
        if place.known is not None and -len(table) <= place.known < len(table):
            found = self.known(table[place.known])
            if found is not None:
                return found
        numbers = self._numbers(node, [self.known(each) for each in table])
        if place.known is not None or not numbers:
            self.fail(node, ast.unparse(node), f"write a place from 0 to {len(table) - 1}")
        return self.of_numbers(node, numbers, place)

    def of_numbers(self, node: ast.Subscript, numbers: Sequence[Value], place: Value) -> Value:
        """Fail: robots read no constant tuple at a place that only a run knows."""
        self.fail(node, ast.unparse(node), f"write a place from 0 to {len(numbers) - 1}")

    def items(self, over: ast.expr) -> list[ast.expr | Value] | None:
        """Return the items of a tuple that is written out, or of a constant one."""
        if isinstance(over, ast.Tuple | ast.List):
            return list(over.elts)
        table = self.value(over) if isinstance(over, ast.Name | ast.Subscript) else None
        if table is None or table.type != TABLE:
            return None
        return [self.known(each) or self.fail(over, ast.unparse(over), FLAT) for each in table.known]

    def _numbers(self, node: ast.AST, items: Sequence[ast.expr | Value | None]) -> list[Value]:
        """Return items as numbers."""
        found = [self.number(each) if isinstance(each, ast.expr) else each for each in items]
        numbers = [each for each in found if each is not None and each.type in NUMBERS]
        if len(numbers) < len(found):
            self.fail(node, ast.unparse(node), FLAT)
        return numbers

    def _v_tuple(self, node: ast.Tuple) -> Value:
        values = [self.number(each) for each in node.elts]
        kinds = tuple(str(promoted(each.type)) for each in values)
        self.translation.tuples[text_of(kinds)] = kinds
        return self.called(maker_of(kinds), values, kinds)

    def _v_unaryop(self, node: ast.UnaryOp) -> Value:
        if isinstance(node.op, ast.Not):
            return Value(f"!({self.truth(node.operand)})", BOOL)
        value = self.number(node.operand)
        if value.known is not None:
            found = self.constant(folded(node.op, value.known))
            if found is not None:
                return found
        if isinstance(node.op, ast.Invert) and value.type == REAL:
            self.fail(node, ast.unparse(node), "use a whole number")
        return self.signed(node, value)

    def signed(self, node: ast.UnaryOp, value: Value) -> Value:
        """Write a sign before a number."""
        kind = LONG if value.type == WORD else promoted(value.type)
        return Value(f"({_UNARY[type(node.op)]}{_of(value, str(kind))})", kind)

    def _v_boolop(self, node: ast.BoolOp) -> Value:
        sign = " && " if isinstance(node.op, ast.And) else " || "
        return Value(f"({sign.join(f'({self.truth(each)})' for each in node.values)})", BOOL)

    def _v_ifexp(self, node: ast.IfExp) -> Value:
        condition = self.value(node.test)
        one, other = self.value(node.body), self.value(node.orelse)
        if condition.known is not None:
            return one if condition.known else other
        return self.chosen(node, one, other)

    def chosen(self, node: ast.IfExp, one: Value, other: Value) -> Value:
        """Write a choice between two values."""
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
        if isinstance(node.ops[0], ast.In | ast.NotIn) and len(node.ops) == 1:
            return self._contained(node)
        return self._chained(self.number(node.left), node.ops, node.comparators, node)

    def _chained(
        self, left: Value, signs: Sequence[ast.cmpop], rights: Sequence[ast.expr], node: ast.Compare
    ) -> Value:
        """Compare numbers in a row: each is computed once, and those after the first that fails are not."""
        if type(signs[0]) not in _COMPARISONS:
            self.fail(node, ast.unparse(node), "compare numbers with ==, !=, <, <=, > or >=")
        right, more = self.number(rights[0]), len(signs) > 1

        def write(held: list[Value]) -> Value:
            text = self.compared(held[0], held[1], _COMPARISONS[type(signs[0])])
            if more:
                text = f"({text} && {self._chained(held[1], signs[1:], rights[1:], node).text})"
            return Value(text, BOOL)

        return self.in_order([left, right], write, first=more and calls(right))

    def _contained(self, node: ast.Compare) -> Value:
        items = self.items(node.comparators[0])
        if items is None:
            self.fail(node, ast.unparse(node), "write the numbers in parentheses after in")
        values = [self.number(node.left), *self._numbers(node, items)]

        def write(held: list[Value]) -> Value:
            found = " || ".join(self.compared(held[0], each, "==") for each in held[1:]) or "false"
            return Value(f"{'!' if isinstance(node.ops[0], ast.NotIn) else ''}({found})", BOOL)

        return self.in_order(values, write, first=True)

    def compared(self, one: Value, other: Value, sign: str) -> str:
        """Write a comparison; that of a quality with 1/2 in whole numbers, which needs no float."""
        if one.text.startswith("feasibee_real_of(") and other.known == 0.5:
            ratio = one.text.removeprefix("feasibee_real_of(").removesuffix(")")
            return f"({ratio}.part {sign} {ratio}.whole - {ratio}.part)"
        left, right = _comparable(one, other)
        return f"({left} {sign} {right})"

    def wide(self, node: ast.expr) -> Value:
        """Translate what is divided or counted: 64 bits for a product, or a real number that is cut off."""
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "int":
            value = self.value(node)
            return Value("(int64_t)" + value.text.removeprefix("(feasibee_int)"), LONG)
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub):
            one, other = self.wide(node.left), self.wide(node.right)
            if LONG in (one.type, other.type) and REAL not in (one.type, other.type):
                return Value(f"({_of(one, LONG)} {_MODULAR[type(node.op)]} {_of(other, LONG)})", LONG)
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult):
            one, other = self.number(node.left), self.number(node.right)
            if {one.type, other.type} <= {SMALL, INT} and None in (one.known, other.known):
                return Value(f"({_of(one, LONG)} * {_of(other, LONG)})", LONG)
        return self.value(node)

    def _v_binop(self, node: ast.BinOp) -> Value:
        one, other = self.number(node.left), self.number(node.right)
        narrow = isinstance(node.op, ast.FloorDiv) and {one.type, other.type} <= {BOOL, SMALL, INT}
        if isinstance(node.op, ast.Div | ast.FloorDiv) and not _is_power(other):
            one = self.wide(node.left)
        if one.known is not None and other.known is not None:
            found = self.constant(folded(node.op, one.known, other.known))
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
        if kind == LONG and narrow:
            return Value(f"(feasibee_int){text}", INT)
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
        own = self.names.get(node.func.id) if isinstance(node.func, ast.Name) else None
        named = node.keywords and not isinstance(own, FunctionType | Definition)
        if named or any(isinstance(each, ast.Starred) for each in node.args):
            self.fail(node, ast.unparse(node), "give the arguments in their order, one by one")
        if isinstance(node.func, ast.Attribute):
            return self._method(node, node.func)
        if not isinstance(node.func, ast.Name):
            self.fail(node, ast.unparse(node), "call a function by its name")
        builtin = getattr(self, f"_call_{node.func.id}", None)
        if builtin is not None and own is None:
            found: Value = builtin(node)
            return found
        return self._own(node, own, node.func.id)

    def _own(self, node: ast.Call, function: Any, name: str) -> Value:
        """Call a function of this file, of the contract or of another strategy."""
        if is_of_math(function):
            return self._of_math(node, function.__name__)
        function = inspect.unwrap(function) if callable(function) else function
        if not isinstance(function, FunctionType | Definition):
            remedy = REMEDIES.get(
                name, "call functions of the file, of math, min, max, abs, int, float or len"
            )
            self.fail(node, f"{name}(...)", remedy)
        values = self._arguments(node, self.translation.definition(function), name)
        signature = self.translation.function(function, tuple(promoted(each.type) for each in values))
        self.position |= signature.needs.position
        return self.called(signature.name, values, signature.result)

    def _arguments(self, node: ast.Call, definition: Definition, name: str) -> list[Value]:
        """Return the arguments of a call in their order, with those by name and the defaults."""
        values = [self.value(each) for each in node.args]
        given = {str(each.arg): self.value(each.value) for each in node.keywords}
        usual = dict(zip(definition.arguments[::-1], definition.defaults[::-1], strict=False))
        for each in definition.arguments[len(values) :]:
            value = given.pop(each, None) or self.known(usual.get(each))
            if value is None:
                self.fail(node, ast.unparse(node), f"give the arguments of {name}, all of them")
            values.append(value)
        kinds = {str(each.type) for each in values}
        if given or len(values) != definition.count or not kinds.isdisjoint((TEXT, VOID, TABLE)):
            self.fail(node, ast.unparse(node), f"give the arguments of {name}, all of them, as numbers")
        return values

    def _method(self, node: ast.Call, method: ast.Attribute) -> Value:
        if isinstance(method.value, ast.Name) and method.value.id not in self.types:
            module = self.names.get(method.value.id)
            if module is math:
                return self._of_math(node, method.attr)
            if isinstance(module, ModuleType):
                return self._own(node, getattr(module, method.attr, None), ast.unparse(method))
        if method.attr in ("bit_length", "bit_count"):
            value = self.number(method.value)
            if value.type == REAL or node.args:
                self.fail(node, ast.unparse(node), "use a whole number")
            return self.bits(value, method.attr)
        record = self.value(method.value)
        if (record.type, method.attr) not in METHODS:
            known = ", ".join(name for kind, name in METHODS if kind == record.type)
            self.fail(node, ast.unparse(node), f"use {known or 'functions of numbers'}")
        return self._of_record(node, record, method.attr)

    def bits(self, value: Value, name: str) -> Value:
        """Count the bits of a whole number."""
        if value.known is not None:
            return self.constant(getattr(value.known, name)()) or value
        kind = SHORT[str(promoted(value.type))]
        size = bare(value.text) if kind == "word" else f"feasibee_size_{kind}({bare(value.text)})"
        return Value(f"feasibee_{name}_{kind}({size})", INT)

    def _of_record(self, node: ast.Call, record: Value, name: str) -> Value:
        values = [self.value(each) for each in node.args]
        result, wanted = METHODS[str(record.type), name]
        if (record.type, name) == ("wire", "number") and len(values) == 3:
            name, wanted = "below", (INT, INT, INT)
        if len(values) != len(wanted):
            self.fail(node, ast.unparse(node), f"give {len(wanted)} arguments")
        place = BITS_OF.get(
            (str(record.type), name if name != "below" or record.type == "reader" else "number")
        )
        if place is not None and values[place].known == 32:
            result = WORD
        told = [
            bare(each.text) if kind == BOOL else f"(uint32_t)({bare(each.text)})"
            for each, kind in zip(values, wanted, strict=True)
            if kind != TEXT
        ]
        call = f"feasibee_{record.type}_{name}({', '.join([record.text, *told])})"
        return Value(f"(feasibee_int){call}" if result == INT else call, result)

    def _of_math(self, node: ast.Call, name: str) -> Value:
        values = [self.number(each) for each in node.args]
        told = ", ".join(f"(feasibee_real)({bare(each.text)})" for each in values)
        if name in ("floor", "ceil") and len(values) == 1:
            if values[0].type != REAL:
                return values[0]
            return Value(f"feasibee_{name}({told})", INT)
        if name in ("isinf", "isnan", "isfinite") and len(values) == 1:
            return Value(f"({name}({told}) != 0)", BOOL)
        if MATH.get(name) != len(values):
            self.fail(node, f"math.{name}", f"use one of {', '.join(MATH)}, floor, ceil, or write it out")
        self.floating = True
        function = f"FEASIBEE_{name.upper()}" if name in ("log", "pow", "sqrt") else name
        return Value(f"{function}({told})", REAL)

    def _argument(self, node: ast.Call) -> ast.expr:
        if len(node.args) != 1:
            self.fail(node, ast.unparse(node), "give one number")
        return node.args[0]

    def one(self, node: ast.Call) -> Value:
        """Return the only argument of a call, a number."""
        return self.number(self._argument(node))

    def _call_len(self, node: ast.Call) -> Value:
        row = self.value(self._argument(node))
        if row.type == TABLE:
            return self.constant(len(row.known)) or row
        if row.type not in ELEMENTS:
            self.fail(node, ast.unparse(node), "take the length of a row")
        of_words, of_counts, kind = self.translation.target.lengths
        return Value((of_counts if row.type == COUNTS else of_words).format(row.text), kind)

    def _call_int(self, node: ast.Call) -> Value:
        value = self.one(node)
        if value.type in WHOLE[1:]:
            return value
        return Value(f"(feasibee_int)({value.text})", INT)

    def _call_float(self, node: ast.Call) -> Value:
        value = self.one(node)
        if value.known is not None:
            return self.constant(float(value.known)) or value
        return self.real(value)

    def real(self, value: Value) -> Value:
        """Return a number as a real one."""
        return Value(f"(feasibee_real)({value.text})", REAL)

    def _call_bool(self, node: ast.Call) -> Value:
        return Value(f"({self.truth(self._argument(node))})", BOOL)

    def _call_abs(self, node: ast.Call) -> Value:
        value = self.one(node)
        if value.type == WORD:
            return value
        kind = promoted(value.type)
        return Value(f"feasibee_abs_{SHORT[str(kind)]}({value.text})", kind)

    def _call_min(self, node: ast.Call) -> Value:
        return self._extreme(node, "min")

    def _call_max(self, node: ast.Call) -> Value:
        return self._extreme(node, "max")

    def _extreme(self, node: ast.Call, name: str) -> Value:
        items = self.items(node.args[0]) if len(node.args) == 1 else node.args
        if not items:
            self.fail(node, ast.unparse(node), "give two numbers or more")
        values = self._numbers(node, items)
        kind = self.widest(node, values)

        def write(held: list[Value]) -> Value:
            text = held[0].text
            for each in held[1:]:
                text = f"feasibee_{name}_{SHORT[str(kind)]}({bare(text)}, {bare(each.text)})"
            return Value(text, kind)

        return self.in_order(values, write)

    def widest(self, node: ast.AST, values: Sequence[Value]) -> Type:
        """Return the type that holds each of several numbers."""
        if all(_is_word(each) for each in values):
            return WORD
        kind: Type = INT
        for each in values:
            kind = self._join(node, kind, each.type)
        return kind


_UNARY: Final[Mapping[type, str]] = {ast.USub: "-", ast.UAdd: "+", ast.Invert: "~"}
_AT: Final = {
    ROW: "feasibee_at",
    REALS: "feasibee_real_at",
    COUNTS: "feasibee_count_at",
    PLAN: "feasibee_cell_at",
}
_COMPARISONS: Final[Mapping[type, str]] = {
    ast.Eq: "==", ast.NotEq: "!=", ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=",
}  # fmt: skip


def c_name(name: str) -> str:
    """Return a name in C, in letters that all compilers know."""
    name = "".join(each if each.isascii() else f"u{ord(each):x}_" for each in name)
    return "unused_" if name == "_" else f"{name}_" if name in KEYWORDS or name.endswith("_end") else name


def bare(text: str) -> str:
    """Return an expression without parentheses around all of it; statements keep theirs."""
    depth = 0
    for place, letter in enumerate(text):
        depth += (letter == "(") - (letter == ")")
        if depth == 0 and place < len(text) - 1:
            return text
    return text[1:-1] if text.startswith("(") and not text.startswith("({") else text


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
    return f"(feasibee_int){value.text}" if value.type in (BOOL, SMALL) else value.text


def calls(value: Value) -> bool:
    """Whether computing a value may fail or change something: whether its text calls a function."""
    return (
        re.search(r"(?<!memory_of)(?<!constants_of)(?<!plan_of)[(](?<=[A-Za-z0-9_][(])", value.text)
        is not None
    )


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
    wide = INT if promoted(one.type) == INT else LONG
    unsigned = "uint64_t" if wide == LONG else "feasibee_unsigned"
    return f"({wide})(({unsigned}){_of(one, wide)} << {_wide(other)})", wide


def _right(one: Value, other: Value, kind: str) -> tuple[str, Type]:
    if kind == REAL:
        return "", kind
    return f"({_wide(one)} >> {_wide(other)})", promoted(one.type)


def _is_power(value: Value) -> bool:
    return isinstance(value.known, int) and value.known > 0 and value.known & (value.known - 1) == 0


def _floor_divided(one: Value, other: Value, kind: str) -> tuple[str, Type]:
    if kind == REAL:
        return "", kind
    if _is_power(other):
        return _right(one, Value(str(other.known.bit_length() - 1), INT), kind)
    return f"feasibee_divided_{SHORT[kind]}({bare(one.text)}, {bare(other.text)})", kind


def _modulo(one: Value, other: Value, kind: str) -> tuple[str, Type]:
    if kind == REAL:
        return "", kind
    if _is_power(other):
        mask = constant(other.known - 1)
        assert mask is not None
        return _bitwise("&")(one, mask, str(joined(one.type, mask.type)))
    text = f"feasibee_modulo_{SHORT[kind]}({bare(one.text)}, {bare(other.text)})"
    return (f"(feasibee_int){text}", INT) if other.type == INT and kind == LONG else (text, kind)


def _divided(one: Value, other: Value, kind: str) -> tuple[str, Type]:
    return f"({_of(one, REAL)} / {_of(other, REAL)})", REAL


def _power(one: Value, other: Value, kind: str) -> tuple[str, Type]:
    if kind == REAL:
        return f"FEASIBEE_POW({_of(one, REAL)}, {_of(other, REAL)})", REAL
    if one.known == 2:
        return _left(Value("1", LONG, 1), other, LONG)
    return f"feasibee_power_{SHORT[kind]}({bare(one.text)}, {bare(other.text)})", kind


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

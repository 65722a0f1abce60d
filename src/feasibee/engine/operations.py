"""Expressions of a user's functions in C with Python's checks, computed from left to right as in Python."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from feasibee.engine.failing import OF_MATH
from feasibee.engine.flow import unsure
from feasibee.robot.definitions import Definition, folded
from feasibee.robot.expressions import bare, c_name, calls
from feasibee.robot.language import (
    BOOL,
    CONSTANTS,
    COUNTS,
    INT,
    MESSAGE,
    PLAN,
    REAL,
    REALS,
    ROW,
    Type,
    Value,
    promoted,
    text_of,
)
from feasibee.robot.translate import FunctionBody, Translation
from feasibee.strategies.overflow import MOST

MATH_REMEDIES: Final = {
    **dict.fromkeys(
        ("gamma", "lgamma", "factorial", "comb", "perm"), "write a loop of products or logarithms"
    ),
    "gcd": "give two whole numbers",
}


class Operations(FunctionBody):
    """The expressions of one function."""

    def __init__(self, translation: Translation, function: Definition) -> None:
        super().__init__(translation, function)
        self.unsure = unsure(function.tree)
        self.places: dict[str, Value] = {}  # of numbers in a row that change, by names that no text has

    # --- Values ---

    def constant(self, value: Any) -> Value | None:
        """Return a number of Python in C, None if it isn't one."""
        if isinstance(value, bool):
            return Value("true" if value else "false", BOOL, value)
        if value == -MOST:
            return Value(f"({1 - MOST} - 1)", INT, value)  # C has no number for its size
        if isinstance(value, int) and -MOST < value < MOST:
            return Value(f"({value})" if value < 0 else str(value), INT, value)
        if isinstance(value, float):
            if math.isnan(value):
                return Value('__builtin_nan("")', REAL)
            size = "FEASIBEE_INFINITY" if math.isinf(value) else repr(abs(value))
            return Value(f"(-{size})" if math.copysign(1.0, value) < 0 else size, REAL, value)
        return None

    def in_order(
        self, values: Sequence[Value], write: Callable[[list[Value]], Value], *, first: bool = False
    ) -> Value:
        """Write an expression of values, computed before it from left to right if several call functions."""
        if not first and sum(calls(each) for each in values) < 2:
            return write(list(values))
        lines, held = [], []
        for each in values:
            if not calls(each):
                held.append(each)
                continue
            name = self.new()
            lines.append(f"{self.translation.target.text_of(each.type)} {name} = {each.text};")
            held.append(Value(name, each.type))
        made = write(held)
        return Value(f"({{ {' '.join([*lines, bare(made.text)])}; }})" if lines else made.text, made.type)

    def _v_name(self, node: ast.Name) -> Value:
        return self.places.get(node.id) or super()._v_name(node)

    def variable(self, node: ast.Name) -> Value:
        """Read a variable, which must have a value."""
        found = super().variable(node)
        if node.id not in self.unsure:
            return found
        return Value(
            f"({{ feasibee_assigned({node.lineno}, {flag_of(node.id)}); {found.text}; }})", found.type
        )

    def signed(self, node: ast.UnaryOp, value: Value) -> Value:
        """Write a sign before a number, whose type may have no room for the result."""
        if isinstance(node.op, ast.UAdd):
            return Value(value.text, promoted(value.type))
        if value.type == REAL:
            return Value(f"(-{value.text})", REAL)
        if isinstance(node.op, ast.Invert):
            return Value(f"(~(int64_t){value.text})", INT)
        return self._applied(node, "feasibee_negative", [value], INT)

    def truth(self, node: ast.expr) -> str:
        """Translate a condition."""
        if isinstance(node, ast.BoolOp):
            sign = " && " if isinstance(node.op, ast.And) else " || "
            return sign.join(f"({self.truth(each)})" for each in node.values)
        return super().truth(node)

    def _v_boolop(self, node: ast.BoolOp) -> Value:
        """Return the value that decides, which need not be a bool."""
        values = [self.number(each) for each in node.values]
        if all(each.type == BOOL for each in values):
            sign = " && " if isinstance(node.op, ast.And) else " || "
            return Value(f"({sign.join(f'({bare(each.text)})' for each in values)})", BOOL)
        found = values.pop()
        while values:
            found = self._either(node, values.pop(), found)
        return found

    def _either(self, node: ast.BoolOp, value: Value, rest: Value) -> Value:
        """Return the first of two numbers if it decides, else the second."""
        kind = self._join(node, value.type, rest.type)

        def write(held: list[Value]) -> Value:
            one, other = (rest, held[0]) if isinstance(node.op, ast.And) else (held[0], rest)
            cast = text_of(kind)
            return Value(f"({held[0].text} != 0 ? ({cast}){one.text} : ({cast}){other.text})", kind)

        return self.in_order([value], write, first=True)

    def _v_ifexp(self, node: ast.IfExp) -> Value:
        one, other = (self.plain(each, self.value(each)) for each in (node.body, node.orelse))
        return self.chosen(node, one, other)

    def compared(self, one: Value, other: Value, sign: str) -> str:
        """Write a comparison, exact also where one number is whole and large."""
        if (one.type == REAL) == (other.type == REAL) or _is_small(one) or _is_small(other):
            return f"({one.text} {sign} {other.text})"
        if one.type == REAL:
            one, other, sign = other, one, _SWAPPED[sign]
        return _ORDERS[sign].format(f"feasibee_order({bare(one.text)}, {bare(other.text)})")

    # --- Operations ---

    def _v_binop(self, node: ast.BinOp) -> Value:
        one, other = self.number(node.left), self.number(node.right)
        return self.operation(node, node.op, one, other)

    def operation(self, node: ast.expr, sign: ast.operator, one: Value, other: Value) -> Value:
        """Translate an operation on two numbers."""
        if one.known is not None and other.known is not None:
            found = self.constant(folded(sign, one.known, other.known))
            if found is not None:
                return found
        real = REAL in (one.type, other.type)
        name, kind = _OPERATIONS.get((type(sign), real), ("", INT))
        if not name:
            self.fail(node, ast.unparse(node), "use whole numbers, or math.floor")
        if isinstance(sign, ast.Pow) and not real and isinstance(other.known, int) and other.known < 0:
            name, kind = "feasibee_power_real", REAL
        if isinstance(sign, ast.Div) and real and other.known:
            name = "/"

        if name[0].isalpha():
            return self._applied(node, name, [one, other], kind)

        def write(held: list[Value]) -> Value:
            left, right = (
                f"(double){each.text}" if real and each.type != REAL else each.text for each in held
            )
            return Value(f"({left} {name} {right})", kind)

        return self.in_order([one, other], write)

    def _applied(self, node: ast.AST, name: str, values: Sequence[Value], kind: Type) -> Value:
        """Call a function in C that may fail at a line of the strategy."""
        return self.called(name, values, kind, str(getattr(node, "lineno", 1)))

    # --- Rows and tuples ---

    def of_row(self, node: ast.Subscript, row: Value) -> Value:
        """Write in C how a number of a row is read, which fails at a place that the row lacks."""
        place, read = self.index(node), _READ.get(str(row.type))
        if read is None:
            self.fail(node, ast.unparse(node), "take one number out of a row or of a constant tuple")

        def write(held: list[Value]) -> Value:
            text = f"{read}({node.lineno}, {held[0].text}, {bare(held[1].text)})"
            return Value(f"({text})", REAL if row.type in (REALS, CONSTANTS) else INT)

        return self.in_order([row, place], write)

    def of_numbers(self, node: ast.Subscript, numbers: Sequence[Value], place: Value) -> Value:
        """Write in C how a constant tuple is read at a place that only a run knows."""
        kind, items = array_of(numbers)
        read = "feasibee_real_of" if kind == REAL else "feasibee_whole_of"
        return self.called(read, [place], kind, str(node.lineno), items, str(len(numbers)))

    def index(self, node: ast.Subscript) -> Value:
        """Translate a place in a row."""
        place = self.value(node.slice)
        if place.type not in (BOOL, INT):
            self.fail(node, ast.unparse(node), "give its place as a whole number")
        return place

    # --- Calls ---

    def bits(self, value: Value, name: str) -> Value:
        """Count the bits of a whole number."""
        return self.called(f"feasibee_{name}", [value], INT)

    def _of_math(self, node: ast.Call, name: str) -> Value:
        values = [self.number(each) for each in node.args]
        if name in ("floor", "ceil", "trunc") and len(values) == 1:
            return self._cut(node, "int_of" if name == "trunc" else name, values[0])
        if name in ("isinf", "isnan", "isfinite") and len(values) == 1:
            return Value(f"({name}((double){values[0].text}) != 0)", BOOL)
        if name == "gcd" and len(values) == 2 and REAL not in (values[0].type, values[1].type):
            return self._applied(node, "feasibee_gcd", values, INT)
        if name == "log" and len(values) == 2:
            parts = [self._applied(node, "feasibee_log", [each], REAL) for each in values]
            return self.operation(node, ast.Div(), *parts)
        if OF_MATH.get(name) != len(values):
            known = f"use one of {', '.join([*OF_MATH, 'floor', 'ceil'])}, or write it out"
            self.fail(node, f"math.{name}", MATH_REMEDIES.get(name, known))
        return self._applied(node, f"feasibee_{name}", values, REAL)

    def _cut(self, node: ast.Call, how: str, value: Value) -> Value:
        """Return a real number as a whole one."""
        if value.type != REAL:
            return Value(value.text, INT, None if value.known is None else int(value.known))
        return self._applied(node, f"feasibee_{how}", [value], INT)

    def _call_int(self, node: ast.Call) -> Value:
        return self._cut(node, "int_of", self.one(node))

    def _call_round(self, node: ast.Call) -> Value:
        return self._cut(node, "round", self.one(node))

    def real(self, value: Value) -> Value:
        """Return a number as a real one."""
        return value if value.type == REAL else Value(f"((double){value.text})", REAL)

    def _call_abs(self, node: ast.Call) -> Value:
        value = self.one(node)
        if value.type == REAL:
            return self.called("feasibee_abs_real", [value], REAL)
        return self._applied(node, "feasibee_abs_int", [value], INT)

    def _call_pow(self, node: ast.Call) -> Value:
        if len(node.args) != 2:
            self.fail(node, ast.unparse(node), "write base ** exponent")
        one, other = (self.number(each) for each in node.args)
        return self.operation(node, ast.Pow(), one, other)

    def widest(self, node: ast.AST, values: Sequence[Value]) -> Type:
        """Return the type that holds each of several numbers."""
        return REAL if any(each.type == REAL for each in values) else INT


_READ: Final = {
    REALS: "*feasibee_place_in_reals",
    CONSTANTS: "feasibee_parameter",
    PLAN: "feasibee_cell",
    ROW: "feasibee_word",
    MESSAGE: "feasibee_word",
    COUNTS: "*feasibee_place_in_counts",
}
"""What takes a number out of a row, by its type."""
_SWAPPED: Final = {"==": "==", "!=": "!=", "<": ">", "<=": ">=", ">": "<", ">=": "<="}
_ORDERS: Final = {
    "==": "({} == 0)", "!=": "({} != 0)", "<": "({} == -1)", "<=": "({} <= 0)", ">": "({} == 1)",
    ">=": "(({} & ~1) == 0)",
}  # fmt: skip
"""What compares, given the result of ``feasibee_order``."""
_OPERATIONS: Final[Mapping[tuple[type, bool], tuple[str, Type]]] = {
    (ast.Add, False): ("feasibee_plus", INT),
    (ast.Sub, False): ("feasibee_minus", INT),
    (ast.Mult, False): ("feasibee_times", INT),
    (ast.Div, False): ("feasibee_ratio", REAL),
    (ast.FloorDiv, False): ("feasibee_divided", INT),
    (ast.Mod, False): ("feasibee_modulo", INT),
    (ast.Pow, False): ("feasibee_power", INT),
    (ast.LShift, False): ("feasibee_left", INT),
    (ast.RShift, False): ("feasibee_right", INT),
    (ast.BitAnd, False): ("&", INT),
    (ast.BitOr, False): ("|", INT),
    (ast.BitXor, False): ("^", INT),
    (ast.Add, True): ("+", REAL),
    (ast.Sub, True): ("-", REAL),
    (ast.Mult, True): ("*", REAL),
    (ast.Div, True): ("feasibee_over", REAL),
    (ast.FloorDiv, True): ("feasibee_divided_real", REAL),
    (ast.Mod, True): ("feasibee_modulo_real", REAL),
    (ast.Pow, True): ("feasibee_power_real", REAL),
}
"""By an operator and whether a number is real: what computes it in C, and the type of the result."""


def flag_of(name: str) -> str:
    """Return what says whether a variable has a value."""
    return f"has_{c_name(name)}_"


def array_of(values: Sequence[Value]) -> tuple[Type, str]:
    """Return the type of an array of numbers, and the array in C."""
    kind = REAL if any(each.type == REAL for each in values) else INT
    return kind, f"(const {text_of(kind)}[]){{{', '.join(bare(each.text) for each in values)}}}"


def _is_small(value: Value) -> bool:
    """Whether a whole number is known to be the same as a real one."""
    return value.type == BOOL or (
        value.type != REAL and value.known is not None and abs(value.known) <= 2**53
    )

"""Expressions of a user's functions in C with Python's checks, computed from left to right as in Python."""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Callable, Mapping, Sequence
from types import FunctionType, ModuleType
from typing import Any, Final

from feasibee.engine.failing import OF_MATH
from feasibee.engine.flow import unsure
from feasibee.robot.definitions import Constants, Definition, is_of_math
from feasibee.robot.expressions import bare, c_name, folded
from feasibee.robot.language import (
    BOOL,
    COUNTS,
    INT,
    MESSAGE,
    NUMBERS,
    PLAN,
    REAL,
    REALS,
    ROW,
    TEXT,
    VOID,
    Type,
    Value,
    maker_of,
    text_of,
)
from feasibee.robot.translate import Body, Translation
from feasibee.strategies.overflow import MOST

TABLE: Final = "table"
"""The type of a constant tuple, which `Value.known` is."""
CONSTANTS: Final = "struct feasibee_constants"
"""The type of the parameters, which a strategy can't write."""
FLAT: Final = "make a tuple of numbers only, and one for each row"
MATH_REMEDIES: Final = {
    **dict.fromkeys(
        ("gamma", "lgamma", "factorial", "comb", "perm"), "write a loop of products or logarithms"
    ),
    "gcd": "give two whole numbers",
}


class Operations(Body):
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

    def known(self, node: ast.AST, value: Any) -> Value | None:
        """Return a number or a tuple of the file in C, None if it is neither."""
        return Value("", TABLE, value) if isinstance(value, tuple) else self.constant(value)

    def in_order(self, values: Sequence[Value], write: Callable[[list[Value]], Value]) -> Value:
        """Write an expression of values that are computed from left to right."""
        if sum(calls(each) for each in values) < 2:
            return write(list(values))
        return self.held(values, write)

    def held(self, values: Sequence[Value], write: Callable[[list[Value]], Value]) -> Value:
        """Write an expression of values that are computed before it, from left to right."""
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

    def _v_constant(self, node: ast.Constant) -> Value:
        if isinstance(node.value, str):
            return Value("", TEXT)
        return self.constant(node.value) or self.fail(node, repr(node.value), "write a number")

    def _v_name(self, node: ast.Name) -> Value:
        if node.id in self.places:
            return self.places[node.id]
        if node.id in self.types:
            text = c_name(node.id)
            if node.id in self.unsure:
                text = f"({{ feasibee_assigned({node.lineno}, {flag_of(node.id)}); {text}; }})"
            return Value(text, self.types[node.id])
        found = self.known(node, self.names.get(node.id))
        if found is None:
            self.fail(node, f"the name {node.id}", "use arguments, own variables, and constants of the file")
        return found

    def _v_tuple(self, node: ast.Tuple) -> Value:
        values = [self.number(each) for each in node.elts]
        kinds = tuple(str(_promoted(each.type)) for each in values)
        self.translation.tuples[text_of(kinds)] = kinds

        def write(held: list[Value]) -> Value:
            return Value(f"{maker_of(kinds)}({', '.join(bare(each.text) for each in held)})", kinds)

        return self.in_order(values, write)

    def _v_unaryop(self, node: ast.UnaryOp) -> Value:
        if isinstance(node.op, ast.Not):
            return Value(f"!({self.truth(node.operand)})", BOOL)
        value = self.number(node.operand)
        if value.known is not None:
            try:
                found = self.constant(Constants(self.names).of(node))
            except (ArithmeticError, TypeError, LookupError):
                found = None
            if found is not None:
                return found
        if isinstance(node.op, ast.UAdd):
            return Value(value.text, _promoted(value.type))
        if value.type == REAL:
            if isinstance(node.op, ast.Invert):
                self.fail(node, ast.unparse(node), "use a whole number")
            return Value(f"(-{value.text})", REAL)
        if isinstance(node.op, ast.Invert):
            return Value(f"(~(int64_t){value.text})", INT)
        return Value(f"feasibee_negative({node.lineno}, {bare(value.text)})", INT)

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

        return self.held([value], write)

    def _v_ifexp(self, node: ast.IfExp) -> Value:
        one, other = (self._plain(each, self.value(each)) for each in (node.body, node.orelse))
        kind = self._join(node, one.type, other.type)
        one, other = self._cast(one, kind), self._cast(other, kind)
        cast = f"({text_of(kind)})" if kind in NUMBERS else ""
        return Value(f"({self.truth(node.test)} ? {cast}{one.text} : {cast}{other.text})", kind)

    def _plain(self, node: ast.AST, value: Value) -> Value:
        """Return a value that C can hold in a variable."""
        if value.type in (TABLE, TEXT):
            self.fail(node, ast.unparse(node), "write it where a number of it is taken")
        return value

    def _v_attribute(self, node: ast.Attribute) -> Value:
        found = super()._v_attribute(node)
        if node.attr == "parameters" and found.type == REALS:
            return Value(found.text.replace("parameters_of", "constants_of"), CONSTANTS)
        return found

    # --- Comparisons ---

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
            text = _compared(held[0], held[1], _COMPARISONS[type(signs[0])])
            if more:
                text = f"({text} && {self._chained(held[1], signs[1:], rights[1:], node).text})"
            return Value(text, BOOL)

        pair = [left, right]
        return self.held(pair, write) if more and calls(right) else self.in_order(pair, write)

    def _contained(self, node: ast.Compare) -> Value:
        items = self._items(node.comparators[0])
        if items is None:
            self.fail(node, ast.unparse(node), "write the numbers in parentheses after in")
        values = [self.number(node.left), *self._numbers(node, items)]

        def write(held: list[Value]) -> Value:
            found = " || ".join(_compared(held[0], each, "==") for each in held[1:]) or "false"
            return Value(f"{'!' if isinstance(node.ops[0], ast.NotIn) else ''}({found})", BOOL)

        return self.held(values, write)

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

        def write(held: list[Value]) -> Value:
            if not name[0].isalpha():
                left, right = (
                    f"(double){each.text}" if real and each.type != REAL else each.text for each in held
                )
                return Value(f"({left} {name} {right})", kind)
            return Value(f"{name}({node.lineno}, {', '.join(bare(each.text) for each in held)})", kind)

        return self.in_order([one, other], write)

    # --- Rows and tuples ---

    def _v_subscript(self, node: ast.Subscript) -> Value:
        if isinstance(node.slice, ast.Slice):
            self.fail(node, ast.unparse(node), "write a loop over the places")
        whole = self.value(node.value)
        if whole.type == TABLE:
            return self._of_table(node, whole.known)
        if isinstance(whole.type, tuple):
            return self._of_tuple(node, whole)
        return self._at(node, whole, self._index(node))

    def _at(self, node: ast.Subscript, row: Value, place: Value) -> Value:
        read = _READ.get(str(row.type))
        if read is None:
            self.fail(node, ast.unparse(node), "take one number out of a row or of a constant tuple")

        def write(held: list[Value]) -> Value:
            text = f"{read}({node.lineno}, {held[0].text}, {bare(held[1].text)})"
            return Value(f"({text})", REAL if row.type in (REALS, CONSTANTS) else INT)

        return self.in_order([row, place], write)

    def _index(self, node: ast.Subscript) -> Value:
        place = self.value(node.slice)
        if place.type not in (BOOL, INT):
            self.fail(node, ast.unparse(node), "give its place as a whole number")
        return place

    def _of_tuple(self, node: ast.Subscript, whole: Value) -> Value:
        place, count = self.value(node.slice).known, len(whole.type)
        if not isinstance(place, int) or not -count <= place < count:
            self.fail(node, ast.unparse(node), f"write a number from 0 to {count - 1}")
        return Value(f"{whole.text}.m{place % count}", whole.type[place])

    def _of_table(self, node: ast.Subscript, table: tuple[Any, ...]) -> Value:
        """Return the number at a place of a constant tuple, in C."""
        place = self._index(node)
        if place.known is not None and -len(table) <= place.known < len(table):
            found = self.known(node, table[place.known])
            if found is not None:
                return found
        numbers = self._numbers(node, [self.known(node, each) for each in table])
        if place.known is not None or not numbers:
            self.fail(node, ast.unparse(node), f"write a place from 0 to {len(table) - 1}")
        kind, items = array_of(numbers)
        read = "feasibee_real_of" if kind == REAL else "feasibee_whole_of"
        return Value(f"{read}({node.lineno}, {items}, {len(table)}, {bare(place.text)})", kind)

    def _items(self, over: ast.expr) -> list[ast.expr | Value] | None:
        """Return the items of a tuple that is written out, or of a constant one."""
        if isinstance(over, ast.Tuple | ast.List):
            return list(over.elts)
        table = self.value(over) if isinstance(over, ast.Name | ast.Subscript) else None
        if table is None or table.type != TABLE:
            return None
        return [self.known(over, each) or self.fail(over, ast.unparse(over), FLAT) for each in table.known]

    def _numbers(self, node: ast.AST, items: Sequence[ast.expr | Value | None]) -> list[Value]:
        """Return items as numbers."""
        found = [self.number(each) if isinstance(each, ast.expr) else each for each in items]
        numbers = [each for each in found if each is not None and each.type in NUMBERS]
        if len(numbers) < len(found):
            self.fail(node, ast.unparse(node), FLAT)
        return numbers

    # --- Calls ---

    def _own(self, node: ast.Call, function: Any, name: str) -> Value:
        """Call a function of this file or of the contract, with its defaults, and arguments by name."""
        if is_of_math(function):
            return self._of_math(node, function.__name__)
        if not isinstance(function, FunctionType | Definition):
            return super()._own(node, function, name)
        definition = self.translation.definition(function)
        values = [self.value(each) for each in node.args]
        given = {each.arg: self.value(each.value) for each in node.keywords}
        rest = definition.arguments[len(values) :]
        usual = dict(zip(definition.arguments[::-1], definition.defaults[::-1], strict=False))
        for each in rest:
            value = given.pop(each, None) or self.known(node, usual.get(each))
            if value is None:
                self.fail(node, ast.unparse(node), f"give the arguments of {name}, all of them")
            values.append(value)
        kinds = tuple(_promoted(each.type) for each in values)
        if given or len(kinds) != definition.count or not {TEXT, VOID, TABLE}.isdisjoint(map(str, kinds)):
            self.fail(node, ast.unparse(node), f"give the arguments of {name}, all of them, as numbers")
        signature = self.translation.function(function, kinds)

        def write(held: list[Value]) -> Value:
            return Value(f"{signature.name}({', '.join(bare(each.text) for each in held)})", signature.result)

        return self.in_order(values, write)

    def _v_call(self, node: ast.Call) -> Value:
        own = self.names.get(node.func.id) if isinstance(node.func, ast.Name) else None
        if node.keywords and isinstance(own, FunctionType | Definition):
            if any(isinstance(each, ast.Starred) for each in node.args):
                self.fail(node, ast.unparse(node), "give the arguments one by one")
            return self._own(node, own, own.name if isinstance(own, Definition) else own.__name__)
        return super()._v_call(node)

    def _method(self, node: ast.Call, method: ast.Attribute) -> Value:
        if method.attr in ("bit_length", "bit_count") and not self._is_module(method.value):
            value = self.number(method.value)
            if value.type == REAL or node.args:
                self.fail(node, ast.unparse(node), "use a whole number")
            return Value(f"feasibee_{method.attr}({bare(value.text)})", INT)
        return super()._method(node, method)

    def _is_module(self, node: ast.expr) -> bool:
        return isinstance(node, ast.Name) and isinstance(self.names.get(node.id), ModuleType)

    def _of_math(self, node: ast.Call, name: str) -> Value:
        values = [self.number(each) for each in node.args]
        line = node.lineno
        if name in ("floor", "ceil", "trunc") and len(values) == 1:
            return self._cut(node, "int_of" if name == "trunc" else name, values[0])
        if name in ("isinf", "isnan", "isfinite") and len(values) == 1:
            return Value(f"({name}((double){values[0].text}) != 0)", BOOL)
        if name == "gcd" and len(values) == 2 and REAL not in (values[0].type, values[1].type):
            return self._applied("feasibee_gcd", line, values, INT)
        if name == "log" and len(values) == 2:
            parts = [Value(f"feasibee_log({line}, {bare(each.text)})", REAL) for each in values]
            return self.operation(node, ast.Div(), *parts)
        if OF_MATH.get(name) != len(values):
            known = f"use one of {', '.join([*OF_MATH, 'floor', 'ceil'])}, or write it out"
            self.fail(node, f"math.{name}", MATH_REMEDIES.get(name, known))
        return self._applied(f"feasibee_{name}", line, values, REAL)

    def _applied(self, name: str, line: int, values: list[Value], kind: Type) -> Value:
        def write(held: list[Value]) -> Value:
            return Value(f"{name}({', '.join([str(line), *(bare(each.text) for each in held)])})", kind)

        return self.in_order(values, write)

    def _cut(self, node: ast.Call, how: str, value: Value) -> Value:
        """Return a real number as a whole one."""
        if value.type != REAL:
            return Value(value.text, INT, None if value.known is None else int(value.known))
        return Value(f"feasibee_{how}({node.lineno}, {bare(value.text)})", INT)

    def _one(self, node: ast.Call) -> Value:
        if len(node.args) != 1:
            self.fail(node, ast.unparse(node), "give one number")
        return self.number(node.args[0])

    def _call_len(self, node: ast.Call) -> Value:
        (row,) = [self.value(each) for each in node.args]
        if row.type == TABLE:
            return self.constant(len(row.known)) or row
        if row.type not in _READ:
            self.fail(node, ast.unparse(node), "take the length of a row")
        return Value(f"{row.text}.length", INT)

    def _call_int(self, node: ast.Call) -> Value:
        return self._cut(node, "int_of", self._one(node))

    def _call_round(self, node: ast.Call) -> Value:
        return self._cut(node, "round", self._one(node))

    def _call_float(self, node: ast.Call) -> Value:
        value = self._one(node)
        if value.known is not None:
            return self.constant(float(value.known)) or value
        return value if value.type == REAL else Value(f"((double){value.text})", REAL)

    def _call_abs(self, node: ast.Call) -> Value:
        value = self._one(node)
        if value.type == REAL:
            return Value(f"feasibee_abs_real({bare(value.text)})", REAL)
        return Value(f"feasibee_abs_int({node.lineno}, {bare(value.text)})", INT)

    def _call_pow(self, node: ast.Call) -> Value:
        if len(node.args) != 2:
            self.fail(node, ast.unparse(node), "write base ** exponent")
        one, other = (self.number(each) for each in node.args)
        return self.operation(node, ast.Pow(), one, other)

    def _extreme(self, node: ast.Call, name: str) -> Value:
        items = self._items(node.args[0]) if len(node.args) == 1 else node.args
        if not items:
            self.fail(node, ast.unparse(node), "give two numbers or more")
        values = self._numbers(node, items)
        kind: Type = INT
        for each in values:
            kind = self._join(node, kind, each.type)

        def write(held: list[Value]) -> Value:
            text = held[0].text
            for each in held[1:]:
                text = f"feasibee_{name}_{'real' if kind == REAL else 'int'}({bare(text)}, {bare(each.text)})"
            return Value(text, kind)

        return self.in_order(values, write)


_COMPARISONS: Final[Mapping[type, str]] = {
    ast.Eq: "==", ast.NotEq: "!=", ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=",
}  # fmt: skip
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


def _promoted(kind: Type) -> Type:
    return INT if kind == BOOL else kind


def flag_of(name: str) -> str:
    """Return what says whether a variable has a value."""
    return f"has_{c_name(name)}_"


def calls(value: Value) -> bool:
    """Whether computing a value may fail or change something: whether its text calls a function."""
    return (
        re.search(r"(?<!memory_of)(?<!constants_of)(?<!plan_of)[(](?<=[A-Za-z0-9_][(])", value.text)
        is not None
    )


def array_of(values: Sequence[Value]) -> tuple[Type, str]:
    """Return the type of an array of numbers, and the array in C."""
    kind = REAL if any(each.type == REAL for each in values) else INT
    return kind, f"(const {text_of(kind)}[]){{{', '.join(bare(each.text) for each in values)}}}"


def _compared(one: Value, other: Value, sign: str) -> str:
    """Return a comparison of two numbers, exact also where one is whole and large."""
    if (one.type == REAL) == (other.type == REAL) or _is_small(one) or _is_small(other):
        return f"({one.text} {sign} {other.text})"
    if one.type == REAL:
        one, other, sign = other, one, _SWAPPED[sign]
    return _ORDERS[sign].format(f"feasibee_order({bare(one.text)}, {bare(other.text)})")


def _is_small(value: Value) -> bool:
    """Whether a whole number is known to be the same as a real one."""
    return value.type == BOOL or (
        value.type != REAL and value.known is not None and abs(value.known) <= 2**53
    )

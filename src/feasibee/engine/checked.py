"""Translate a user's functions to C with Python's checks: each failure has its line and its values.

Types are fewer than on a robot: bool, whole numbers of 64 bits, and reals of 64 bits. Operands that may fail
or change something are computed from left to right, as in Python, where C would leave the order open.
"""

from __future__ import annotations

import ast
from dataclasses import dataclass
from typing import Final

from feasibee.engine.failing import Failing
from feasibee.engine.flow import ends
from feasibee.engine.operations import Operations, array_of, flag_of
from feasibee.robot.expressions import bare, calls
from feasibee.robot.language import (
    BOOL,
    CONSTANTS,
    COUNTS,
    ENGINE,
    INT,
    MESSAGE,
    REAL,
    REALS,
    ROW,
    VOID,
    Signature,
    Target,
    Value,
    text_of,
)
from feasibee.robot.translate import FunctionBody, Translation

_READ_ONLY: Final = {"parameters": ("feasibee_constants_of({})", CONSTANTS, ())}
OWN: Final = ENGINE._replace(
    inlined="static inline",
    fields={
        name: {**fields, **_READ_ONLY} if "parameters" in fields else fields
        for name, fields in ENGINE.fields.items()
    },
)
"""The engine's structs. Parameters are constants; not all is inlined, since a user waits for the compiler."""


@dataclass
class CheckedTranslation(Translation):
    """A user's functions in C, with Python's checks."""

    target: Target = OWN

    @property
    def body(self) -> type[FunctionBody]:
        """Return what translates the body of one function."""
        return CheckedBody


class CheckedBody(Operations):
    """The body of one function, in C with Python's checks."""

    def _assert(self, statement: ast.Assert, depth: int) -> None:
        self.put(depth, f"if (!({self.truth(statement.test)}))")
        self.put(depth + 1, f"feasibee_failed({statement.lineno}, {Failing.ASSERTION:d}, 0, 0);")

    def _return(self, statement: ast.Return, depth: int) -> None:
        value = statement.value
        if value is None or _is_none(value):
            self.put(depth, self._nothing(statement.lineno))
            return
        if isinstance(value, ast.IfExp) and (_is_none(value.body) or _is_none(value.orelse)):
            one, other = (ast.copy_location(ast.Return(each), value) for each in (value.body, value.orelse))
            self.block([ast.copy_location(ast.If(value.test, [one], [other]), statement)], depth)
            return
        self.plain(value, self.value(value))
        super()._return(statement, depth)

    def _nothing(self, line: int) -> str:
        """Return what a function does that ends without a value."""
        if self.result is None:
            return "return;"
        return f"feasibee_failed({line}, {Failing.NO_RESULT:d}, 0, 0);"

    def text(self, signature: Signature) -> str:
        """Return the definition."""
        if ends(self.tree) and signature.result != VOID:
            self.put(1, self._nothing(self.tree.lineno))
        flags = [f"    bool {flag_of(each)} = false;" for each in sorted(self.unsure & self.types.keys())]
        self.lines[:0] = flags
        return super().text(signature)

    def assign(self, target: ast.expr, given: ast.expr | Value, depth: int) -> None:
        """Assign an expression to a name, a place in a row, or several of them."""
        if isinstance(target, ast.Subscript) and not isinstance(target.slice, ast.Slice):
            self._store(target, given, depth)
            return
        if not isinstance(given, Value) and not isinstance(target, ast.Tuple | ast.List):
            given = self.plain(given, self.value(given))
        super().assign(target, given, depth)
        if isinstance(target, ast.Name) and target.id in self.unsure:
            self.put(depth, f"{flag_of(target.id)} = true;")

    def _store(self, target: ast.Subscript, given: ast.expr | Value, depth: int) -> None:
        """Write a number into a row: Python computes it first, and then its place."""
        row = self.value(target.value)
        if row.type == MESSAGE:
            self.fail(target, f"an assignment to {ast.unparse(target)}", "only read it; write to known")
        if row.type not in _WRITTEN:
            self.fail(target, f"an assignment to {ast.unparse(target)}", "write to mind.memory only")
        write, kind = _WRITTEN[str(row.type)]
        value = given if isinstance(given, Value) else self.number(given)
        if value.type == REAL and row.type != REALS:
            self.fail(target, f"{ast.unparse(target)} is given a real number", "write int(...)")
        value, place = (
            self.hold(each, depth) if calls(each) else each for each in (value, self.index(target))
        )
        taken = f"{target.lineno}, {row.text}, {bare(place.text)}"
        self.put(depth, f"*{write}({taken}) = ({kind}){value.text};")

    def _augassign(self, statement: ast.AugAssign, depth: int) -> None:
        """Change a variable or a number in a row: its place is computed once."""
        target = statement.target
        if isinstance(target, ast.Subscript) and any(
            isinstance(each, ast.Call) for each in ast.walk(target.slice)
        ):
            place = self.hold(self.index(target), depth)
            self.places[place.text] = place
            name = ast.copy_location(ast.Name(place.text, ast.Load()), statement)
            target = ast.copy_location(ast.Subscript(target.value, name, target.ctx), statement)
            statement = ast.copy_location(ast.AugAssign(target, statement.op, statement.value), statement)
        super()._augassign(statement, depth)

    def _for(self, statement: ast.For, depth: int) -> None:
        """Loop over numbers as over an array of them, and over all else as on a robot."""
        items = self.items(statement.iter)
        if items is None or not isinstance(statement.target, ast.Name):
            super()._for(statement, depth)
            return
        self._no_else(statement)
        values = [self.hold(each, depth) for each in self._numbers(statement.iter, items)]
        if not values:
            return
        kind, array = array_of(values)
        counter, held = self.new(), self.new()
        self.put(depth, f"const {text_of(kind)} *{held} = {array};")
        self.put(depth, f"for (int {counter} = 0; {counter} < {len(values)}; {counter}++) {{")
        self.assign(statement.target, Value(f"{held}[{counter}]", kind), depth + 1)
        self.block(statement.body, depth + 1)
        self.put(depth, "}")

    def begins_pass(self, loop: ast.For | ast.While, depth: int) -> list[str]:
        """Count the passes of a loop, which must not be endless."""
        passed = self.new()
        self.put(depth, f"int64_t {passed} = 0;")
        return ["    " * (depth + 1) + f"feasibee_pass({loop.lineno}, &{passed});"]

    def _count_up(self, statement: ast.For, limits: list[ast.expr], depth: int) -> None:
        first, last, step = (each.text for each in self._limits(statement, limits, depth))
        counter, left, begins = self.new(), self.new(), self.begins_pass(statement, depth)
        passes = f"feasibee_passes({statement.lineno}, {first}, {last}, {step})"
        self.put(depth, f"int64_t {counter} = {first};")
        self.put(depth, f"for (uint64_t {left} = {passes}; {left} > 0; {left}--) {{")
        self.lines += begins
        self.assign(statement.target, Value(counter, INT), depth + 1)
        self.put(depth + 1, f"{counter} = feasibee_next({counter}, {step});")
        self.block(statement.body, depth + 1)
        self.put(depth, "}")

    def limit(self, node: ast.expr, depth: int) -> Value:
        """Compute a limit of a range, or its step, before the loop."""
        value = self.value(node)
        if value.type not in (BOOL, INT):
            self.fail(node, f"{ast.unparse(node)} in a range", "give whole numbers, such as int(...)")
        return self.hold(value, depth)

    def _variables_of_loops(self) -> set[str]:
        """Return none: all variables are those of the function."""
        return set()


_WRITTEN: Final = {
    REALS: ("feasibee_place_in_reals", "double"),
    ROW: ("feasibee_place_in_row", "int32_t"),
    COUNTS: ("feasibee_place_in_counts", "int64_t"),
}
"""What finds the place of a number in a row, by the row's type, and the number's type: a word wraps."""


def _is_none(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value is None

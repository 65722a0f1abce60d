"""A user's strategy in Python: whole numbers that leave 64 bits are errors, and loops that don't end, too.

The text's operations become calls of `CheckedOperation`, which Python computes, and its loops count their
passes. The engine has its own checks, in ``checked.h``.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Mapping
from typing import Any, Final

LEAVES: Final = "leaves 64 bits"
"""What an error says of a number."""
MOST: Final = 2**63
"""Whole numbers are at least -MOST, and less than MOST."""


PASSES: Final = 2**24
"""Most passes of one loop: some seconds of Python."""


def passed(passes: int) -> int:
    """Count a pass of a loop."""
    if passes == PASSES:
        raise RuntimeError(f"a loop has passed {PASSES:,} times; end it sooner")
    return passes + 1


class CheckedOperation:
    """An operation on numbers that raises an OverflowError if its result is whole and leaves 64 bits."""

    def __init__(self, operation: Callable[..., Any], form: str) -> None:
        self.operation = operation
        self.form = form

    def __call__(self, *numbers: Any) -> Any:
        """Compute the result."""
        if not self._is_endless(numbers):
            result = self.operation(*numbers)
            if not isinstance(result, int) or -MOST <= result < MOST:
                return result
        raise OverflowError(f"{self.form.format(*numbers)} {LEAVES}")

    def _is_endless(self, numbers: tuple[Any, ...]) -> bool:
        """Return whether a power or a shift of whole numbers is too large to compute it."""
        if self.operation not in (operator.pow, operator.lshift) or not all(map(_is_int, numbers)):
            return False
        base, places = numbers
        digits = base.bit_length() - 1 if self.operation is operator.pow else 1
        return bool(base != 0 and digits * places >= 64)


def _is_int(number: Any) -> bool:
    return isinstance(number, int)


_PREFIX: Final = "__feasibee_"
_PLACE: Final = f"{_PREFIX}place"
_PASSED, _PASSES = f"{_PREFIX}passed", f"{_PREFIX}passes"
OPERATIONS: Final[Mapping[type[ast.AST] | str, CheckedOperation]] = {
    ast.Add: CheckedOperation(operator.add, "{} + {}"),
    ast.Sub: CheckedOperation(operator.sub, "{} - {}"),
    ast.Mult: CheckedOperation(operator.mul, "{} * {}"),
    ast.FloorDiv: CheckedOperation(operator.floordiv, "{} // {}"),
    ast.Pow: CheckedOperation(operator.pow, "{} ** {}"),
    ast.LShift: CheckedOperation(operator.lshift, "{} << {}"),
    ast.USub: CheckedOperation(operator.neg, "-({})"),
    "abs": CheckedOperation(abs, "abs({})"),
    "int": CheckedOperation(int, "int({})"),
}
"""By an operator or a function of Python, what computes it."""
NAMES: Final = {
    f"{_PREFIX}{kind if isinstance(kind, str) else kind.__name__.lower()}": each
    for kind, each in OPERATIONS.items()
} | {_PASSED: passed}
"""What the text of a checked strategy needs in its module."""
_NAME_OF: Final = {each: name for name, each in NAMES.items() if isinstance(each, CheckedOperation)}


def checked(tree: ast.Module) -> ast.Module:
    """Return a syntax tree whose operations on numbers are checked; lines stay."""
    replaced: ast.Module = _Checking().visit(tree)
    return ast.fix_missing_locations(replaced)


class _Checking(ast.NodeTransformer):
    """Replace operations by calls, and compute those of constants at once, as Python's compiler does."""

    loops = 0

    def visit_While(self, node: ast.While) -> Any:
        """Count the passes of a loop."""
        return self._counted(node)

    def visit_For(self, node: ast.For) -> Any:
        """Count the passes of a loop."""
        return self._counted(node)

    def _counted(self, node: ast.While | ast.For) -> list[ast.stmt]:
        self.generic_visit(node)
        self.loops += 1
        name = f"{_PASSES}{self.loops}"
        begin, count = ast.parse(f"{name} = 0\n{name} = {_PASSED}({name})").body
        for each in (*ast.walk(begin), *ast.walk(count)):
            ast.copy_location(each, node)
        node.body.insert(0, count)
        return [begin, node]

    def visit_BinOp(self, node: ast.BinOp) -> Any:
        """Replace an operation on two numbers."""
        self.generic_visit(node)
        return self._called(node, type(node.op), node.left, node.right)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> Any:
        """Replace a minus sign."""
        self.generic_visit(node)
        return self._called(node, type(node.op), node.operand)

    def visit_Call(self, node: ast.Call) -> Any:
        """Replace a call of a function of Python."""
        self.generic_visit(node)
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        one = len(node.args) == 1 and not node.keywords and not isinstance(node.args[0], ast.Starred)
        return self._called(node, name, node.args[0]) if one else node

    def visit_AugAssign(self, node: ast.AugAssign) -> Any:
        """Replace a change of a variable, or of a number in a row, by an assignment.

        Where a function says the place of the number, it is called once.
        """
        target, before = node.target, []
        if isinstance(target, ast.Subscript) and any(
            isinstance(each, ast.Call) for each in ast.walk(target.slice)
        ):
            before = [
                self.visit(ast.copy_location(ast.Assign([ast.Name(_PLACE, ast.Store())], target.slice), node))
            ]
            target.slice = ast.copy_location(ast.Name(_PLACE, ast.Load()), target.slice)
        old = ast.parse(ast.unparse(node.target), mode="eval").body
        for each in ast.walk(old):
            ast.copy_location(each, node.target)
        new = ast.copy_location(ast.BinOp(old, node.op, node.value), node)
        return [*before, self.visit(ast.copy_location(ast.Assign([node.target], new), node))]

    def _called(self, node: ast.expr, kind: Any, *numbers: ast.expr) -> ast.expr:
        operation = OPERATIONS.get(kind)
        if operation is None:
            return node
        if not isinstance(node, ast.Call) and all(map(_is_number, numbers)):
            try:
                constant = ast.Constant(operation(*(each.value for each in numbers)))  # type: ignore[attr-defined]
                return ast.copy_location(constant, node)
            except (ArithmeticError, ValueError, TypeError):
                pass  # it is an error when it runs
        function = ast.Name(_NAME_OF[operation], ast.Load())
        return ast.copy_location(ast.Call(function, list(numbers), []), node)


def _is_number(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, int | float)

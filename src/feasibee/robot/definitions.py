"""Functions as their files have them, and a user's file read without running it.

The names of a file that runs are those of its module. Otherwise they are read from the text: imports of
`ALLOWED` modules, functions, and constants, which are computed here.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from types import BuiltinFunctionType, FunctionType
from typing import Any, Final

from feasibee.base.errors import FeasibeeError
from feasibee.strategies import contract
from feasibee.strategies.overflow import OPERATIONS

ALLOWED: Final = {"math": math, "feasibee.strategies.contract": contract}
"""Modules whose names a text may use; types are left out."""


@dataclass(frozen=True, eq=False)
class Definition:
    """A function in a file."""

    name: str
    module: str
    """Name of its module, or the path of its text."""
    file: str
    """What errors call the file."""
    tree: ast.FunctionDef
    names: Mapping[str, Any]
    """What the names of the file mean: numbers, tuples, modules and functions."""
    defaults: tuple[Any, ...] = ()
    """Of its last arguments."""

    @property
    def key(self) -> tuple[str, int]:
        """Return what no other function has."""
        return self.module, self.tree.lineno

    @property
    def arguments(self) -> list[str]:
        """Return the names of its arguments."""
        return [each.arg for each in (*self.tree.args.posonlyargs, *self.tree.args.args)]

    @property
    def count(self) -> int:
        """Return the number of its arguments."""
        return len(self.arguments)


class Text(Mapping[str, Any]):
    """The names of a user's file, which never runs.

    A constant is computed when it is first asked for.

    Parameters
    ----------
    file : str
        What errors call the file.
    source : str
        Its text, which ``feasibee.scenario.plugins`` has checked.

    Examples
    --------
    >>> Text("mine.py", "import math\\nHALF = math.pi / 2")["HALF"]
    1.5707963267948966
    """

    def __init__(self, file: str, source: str) -> None:
        self.file = file
        self._nodes: dict[str, Callable[[], Any]] = {}
        self._known: dict[str, Any] = {}
        for node in ast.parse(source).body:
            self._bind(node)

    def __getitem__(self, name: str) -> Any:
        if name not in self._known:
            self._known[name] = self._nodes[name]()
        return self._known[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._nodes)

    def __len__(self) -> int:
        return len(self._nodes)

    def _bind(self, node: ast.stmt) -> None:
        if isinstance(node, ast.FunctionDef):
            self._nodes[node.name] = lambda: self._function(node)
        elif isinstance(node, ast.Import):
            for each in node.names:
                self._nodes[each.asname or each.name] = partial(ALLOWED.get, each.name)
        elif isinstance(node, ast.ImportFrom):
            module = ALLOWED.get(node.module or "")
            for each in node.names:
                self._nodes[each.asname or each.name] = partial(getattr, module, each.name, None)
        elif isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            value = node.value
            for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                self._bind_constant(target, lambda: self._computed(value))

    def _bind_constant(self, target: ast.expr, value: Callable[[], Any]) -> None:
        """Bind a name, or each of several to its part."""
        if isinstance(target, ast.Name):
            self._nodes[target.id] = value
        elif isinstance(target, ast.Tuple | ast.List):
            for place, each in enumerate(target.elts):
                self._bind_constant(each, partial(_part, value, place))

    def _function(self, node: ast.FunctionDef) -> Definition:
        defaults = tuple(self._computed(each) for each in node.args.defaults)
        return Definition(node.name, self.file, self.file, node, self, defaults)

    def _computed(self, node: ast.expr) -> Any:
        try:
            return Constants(self).of(node)
        except (ArithmeticError, ValueError, TypeError, LookupError, RecursionError) as error:
            what = f"{type(error).__name__}: {error}"
            remedy = "write the value of the constant out, as a number or a tuple of numbers"
            raise FeasibeeError(f"{self.file}, line {node.lineno}: {what}; {remedy}") from None


def _part(value: Callable[[], Any], place: int) -> Any:
    return value()[place]


class Constants:
    """What expressions of numbers, tuples and functions of ``math`` are, computed as Python does.

    Parameters
    ----------
    names : mapping of str to object
        What the names in them mean.
    """

    def __init__(self, names: Mapping[str, Any]) -> None:
        self.names = names

    def of(self, node: ast.expr) -> Any:
        """Return the value of an expression; raise a TypeError if it is none of those."""
        compute = getattr(self, f"_{type(node).__name__.lower()}", None)
        if compute is None:
            raise TypeError(f"{ast.unparse(node)} isn't made of numbers")
        return compute(node)

    def _constant(self, node: ast.Constant) -> Any:
        return node.value

    def _tuple(self, node: ast.Tuple) -> Any:
        return tuple(map(self.of, node.elts))

    _list = _tuple

    def _name(self, node: ast.Name) -> Any:
        return self.names[node.id]

    def _attribute(self, node: ast.Attribute) -> Any:
        module = self.of(node.value)
        if module is not math:
            raise TypeError(f"{ast.unparse(node)} isn't a number of math")
        return getattr(module, node.attr)

    def _subscript(self, node: ast.Subscript) -> Any:
        return self.of(node.value)[self.of(node.slice)]

    def _unaryop(self, node: ast.UnaryOp) -> Any:
        return UNARY[type(node.op)](self.of(node.operand))

    def _binop(self, node: ast.BinOp) -> Any:
        return BINARY[type(node.op)](self.of(node.left), self.of(node.right))

    def _call(self, node: ast.Call) -> Any:
        function = BUILT_IN.get(node.func.id) if isinstance(node.func, ast.Name) else None
        function = function or self.of(node.func)
        if node.keywords or not (function in BUILT_IN.values() or is_of_math(function)):
            raise TypeError(f"{ast.unparse(node)} calls what isn't of math")
        return function(*map(self.of, node.args))


def definition_of(function: FunctionType, tree: ast.Module) -> Definition:
    """Return a function of a module that has run, whose text has this syntax tree."""
    name = function.__name__
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and node.lineno == function.__code__.co_firstlineno:
            file = function.__code__.co_filename.replace("\\", "/").rpartition("/")[2]
            defaults = function.__defaults__ or ()
            return Definition(name, function.__module__, file, node, function.__globals__, defaults)
    raise FeasibeeError(f"{name}: isn't a plain function; write def {name}(...)")


def is_of_math(function: object) -> bool:
    """Whether an object is a function of ``math``."""
    return isinstance(function, BuiltinFunctionType) and function.__module__ == "math"


def folded(sign: ast.operator | ast.unaryop, *numbers: Any) -> Any:
    """Return what Python computes of one or two numbers, None if nothing or too much."""
    try:
        return (UNARY if len(numbers) == 1 else BINARY)[type(sign)](*numbers)
    except (ArithmeticError, LookupError, TypeError, ValueError):
        return None


_OPERATORS: Final[Mapping[type[ast.AST], Callable[..., Any]]] = {
    ast.Div: operator.truediv,
    ast.Mod: operator.mod,
    ast.RShift: operator.rshift,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.BitXor: operator.xor,
}
BINARY: Final[Mapping[Any, Callable[..., Any]]] = {**OPERATIONS, **_OPERATORS}
"""What Python computes of two numbers; an OverflowError is a whole number beyond 64 bits."""
UNARY: Final[Mapping[Any, Callable[..., Any]]] = {
    **OPERATIONS,
    ast.UAdd: operator.pos,
    ast.Invert: operator.invert,
    ast.Not: operator.not_,
}
BUILT_IN: Final[Mapping[str, Callable[..., Any]]] = {
    each.__name__: each for each in (abs, bool, float, int, len, max, min, pow, round, sum)
}

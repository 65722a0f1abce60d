"""Variables that a function of Python may read before they have a value."""

from __future__ import annotations

import ast
from collections.abc import Sequence

Names = frozenset[str]


def unsure(tree: ast.FunctionDef) -> set[str]:
    """Return the variables of a function that may have no value where they are read.

    In doubt a variable is among them: what a loop sets may not be set after it.

    Examples
    --------
    >>> import ast
    >>> tree = ast.parse("def f(a):\\n if a:\\n  b = 1\\n return b")
    >>> unsure(tree.body[0])
    {'b'}
    """
    flow = _Flow(tree)
    arguments = {each.arg for each in (*tree.args.posonlyargs, *tree.args.args)}
    flow.block(tree.body, frozenset(arguments))
    return flow.found


def ends(tree: ast.FunctionDef) -> bool:
    """Return whether a function may end without ``return``."""
    return _Flow(tree).block(tree.body, frozenset()) is not None


class _Flow:
    """Which names have values, statement by statement."""

    def __init__(self, tree: ast.FunctionDef) -> None:
        self.found: set[str] = set()
        self.own = _stored(tree)

    def block(self, statements: Sequence[ast.stmt], have: Names) -> Names | None:
        """Return the names that have values after statements; None if nothing follows them."""
        for statement in statements:
            after = self.after(statement, have)
            if after is None:
                return None
            have = after
        return have

    def after(self, statement: ast.stmt, have: Names) -> Names | None:
        """Return the names that have values after a statement."""
        if isinstance(statement, ast.If):
            self.read(statement.test, have)
            both = self.block(statement.body, have), self.block(statement.orelse, have)
            known = [each for each in both if each is not None]
            return frozenset.intersection(*known) if known else None
        if isinstance(statement, ast.While | ast.For):
            self.read(statement.test if isinstance(statement, ast.While) else statement.iter, have)
            inside = have if isinstance(statement, ast.While) else have | _stored(statement.target)
            self.block(statement.body, inside)
            return None if _is_endless(statement) else have
        self.read(statement, have)
        if isinstance(statement, ast.AugAssign) and isinstance(statement.target, ast.Name):
            self.met(statement.target.id, have)
        return (
            None
            if isinstance(statement, ast.Return | ast.Break | ast.Continue)
            else have | _stored(statement)
        )

    def read(self, node: ast.AST, have: Names) -> None:
        """Find the names that are read without a value."""
        for each in ast.walk(node):
            if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Load):
                self.met(each.id, have)

    def met(self, name: str, have: Names) -> None:
        """Read a name."""
        if name in self.own and name not in have:
            self.found.add(name)


def _is_endless(loop: ast.While | ast.For) -> bool:
    """Return whether only ``return`` leaves a loop."""
    if not (isinstance(loop, ast.While) and isinstance(loop.test, ast.Constant) and loop.test.value):
        return False
    return not any(isinstance(each, ast.Break) for each in ast.walk(loop))


def _stored(node: ast.AST) -> Names:
    """Return the names that a node gives values; an annotation alone gives none."""
    if isinstance(node, ast.AnnAssign) and node.value is None:
        return frozenset()
    return frozenset(
        each.id for each in ast.walk(node) if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)
    )

"""Users' strategies, from files and other packages: found and parsed as text, without running them.

What a file declares (its constants, and which functions it has) is taken from its syntax tree, so that a
scenario that names it can be checked, printed and compared. It runs when something simulates it:
see ``feasibee.scenario.trial``.
"""

from __future__ import annotations

import ast
import math
import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from hashlib import sha256
from importlib.machinery import ModuleSpec, PathFinder
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from pathlib import Path
from types import FunctionType
from typing import Any, Final, TypeGuard

from feasibee.base.codes import is_whole
from feasibee.base.errors import FeasibeeError, one_line
from feasibee.base.files import UnreadableError, read_text
from feasibee.strategies import STRATEGIES, module_of
from feasibee.strategies.contract import (
    ARGUMENTS,
    CONSTANTS,
    KNOWLEDGE,
    KNOWLEDGE_OPTIONS,
    REQUIRED,
    Manifest,
    Strategy,
)
from feasibee.strategies.overflow import LEAVES, MOST

GROUP: Final = "feasibee.strategies"
"""Entry point group by which other packages register strategies."""
ALLOWED: Final = ("math", "typing", "__future__", "feasibee.strategies.contract")
TOGETHER: Final = (("message_words", "encode"), ("pack", "unpack"), ("unpack", "pack"))
"""Functions, and others that a file with them must have, too."""
DEEPEST: Final = 150
"""Largest depth of a file's syntax tree: Python's compiler recurses with it."""
TOP_LEVEL: Final = (ast.Import, ast.ImportFrom, ast.FunctionDef, ast.Assign, ast.AnnAssign)
"""Statements that a file may have at its top level, in addition to texts such as its docstring."""
MISSING: Final[Mapping[type[ast.AST], tuple[str, str]]] = {
    ast.Global: ("global", "keep numbers in mind.memory or me.memory"),
    ast.Nonlocal: ("nonlocal", "keep numbers in mind.memory or me.memory"),
    ast.Raise: ("raise", "return a value in each case"),
    ast.Try: ("try", "test with if what could fail"),
    ast.TryStar: ("try", "test with if what could fail"),
    ast.With: ("with", "write assignments, if, for and while"),
    ast.ClassDef: ("class", "write functions, each with def"),
    ast.Lambda: ("lambda", "write def"),
    ast.Yield: ("yield", "write into the row, or return one number"),
    ast.YieldFrom: ("yield", "write into the row, or return one number"),
    ast.Await: ("await", "write assignments, if, for and while"),
    ast.AsyncFunctionDef: ("async", "write def"),
    ast.AsyncFor: ("async", "write for"),
    ast.AsyncWith: ("async", "write assignments, if, for and while"),
    ast.Delete: ("del", "leave it out"),
}
"""What a strategy can't have, in Python's word, and what to write instead."""
UNCALLED: Final = frozenset(
    """
    breakpoint compile delattr eval exec exit getattr globals help input locals open print quit setattr vars
    __import__
    """.split()  # noqa: SIM905  # as a list it would take seventeen lines
)
"""Functions of Python that reach beyond the numbers of a strategy."""
RHO: Final = "\N{GREEK SMALL LETTER RHO}\N{SUBSCRIPT ONE}"
"""The quality of *feasible*, which docstrings write in ASCII."""
FLAG: Final = ("True or False", lambda value: isinstance(value, bool))
NEED: Final = ("True, False or the name of a parameter", lambda value: isinstance(value, bool | str))
RULES: Final[Mapping[str, tuple[str, Callable[[Any], bool]]]] = {
    "PARAMETERS": ("a dict of names and numbers", lambda value: _is_parameters(value)),  # noqa: PLW0108
    "MEMORY": ("a whole number from 0 to 64", lambda value: is_whole(value, 64)),
    "VALUE_BITS": ("a whole number from 0 to 16", lambda value: is_whole(value, 16)),
    **dict.fromkeys(("FORGETS", "STARTS_NEUTRAL", "MODULATES", "BY_NAME", "NEEDS_COUNT"), FLAG),
    **dict.fromkeys(("NEEDS_NAMES", "SENDS_POSITIONS", "ALL_ROUND", "READS_PLAN", "ONE_CLASS"), FLAG),
    "NEEDS_IDS": NEED,
    "POSITIVE": ("a tuple of names of parameters", lambda value: isinstance(value, tuple)),
}


def manifest_of(name: str, source: str | None = None, trusted: bool = True) -> Manifest:
    """Return the declarations of a strategy; a user's file is not run.

    Its name is that of a built-in one, the path of a ``.py`` file, or what a package registers. ``source`` is
    taken for the file's text, as when results kept it. Unless it is ``trusted``, it isn't run later on. Raise
    a FeasibeeError that says what is missing or wrong, and where.
    """
    if name in STRATEGIES:
        return STRATEGIES[name]
    manifest = _parsed(name, _text(name) if source is None else source)
    return manifest if trusted else replace(manifest, trusted=False)


def load(name: str) -> Strategy:
    """Load a strategy by its name, the path of its file, or the name under which a package registers it.

    Raises
    ------
    FeasibeeError
        If there is none, or it isn't one: what is missing or wrong, and where.
    """
    return strategy_of(manifest_of(name))


def strategy_of(manifest: Manifest) -> Strategy:
    """Return the strategy of a manifest: the one place where the text of a user's file is run.

    Raise a FeasibeeError if the text came with somebody's results and isn't that of a present file of the
    user's own, or if a function fails or returns nonsense in a trial.
    """
    if isinstance(manifest, Strategy):
        return manifest
    if not (manifest.trusted or is_own(manifest)):
        raise FeasibeeError(
            f"{manifest.name}: its text came with these results (SHA-256 {digest_of(manifest)[:16]}...) and "
            "isn't that of a file of yours at this path; read it, then allow it to run with --trust "
            "(in Python: trust=True)"
        )
    return _tried(replace(manifest, trusted=True))


@lru_cache(256)
def _tried(manifest: Manifest) -> Strategy:
    from feasibee.scenario.trial import tried

    return tried(manifest)


def rule_of(manifest: Manifest) -> str:
    """Return the first line of a strategy's file, without its name."""
    if manifest.source:
        text = ast.get_docstring(ast.parse(manifest.source)) or ""
    else:
        text = module_of(manifest.name).__doc__ or ""
    line = one_line(text.partition("\n")[0])
    name, _, rule = line.partition(": ")
    return line if "," in name or not rule else rule


def docstring_of(manifest: Manifest, name: str) -> str:
    """Return the docstring of a strategy's function in one line, without markup; the function isn't run."""
    text = getattr(manifest, name, getattr(Strategy, name, None)).__doc__ or ""
    if manifest.source and name in manifest.functions:
        node = dict(bindings(ast.parse(manifest.source)))[name]
        text = (isinstance(node, ast.FunctionDef) and ast.get_docstring(node)) or ""
    return " ".join(text.replace("*", "").replace("rho_1", RHO).split()).removeprefix("Return ")


def digest_of(manifest: Manifest) -> str:
    """Return the SHA-256 of a strategy's text."""
    return sha256(manifest.source.encode()).hexdigest()


def is_own(manifest: Manifest) -> bool:
    """Whether a strategy is built in, of an installed package, or a present file of the user's own."""
    if not manifest.source:
        return True
    try:
        text = _text(manifest.name)
        owner = Path(manifest.name).stat().st_uid if manifest.name.endswith(".py") else None
    except (FeasibeeError, OSError):
        return False
    return text == manifest.source and (owner is None or not hasattr(os, "getuid") or owner == os.getuid())


@lru_cache(256)
def reads_flooding(manifest: Manifest) -> bool:
    """Return whether a strategy's functions, or those that they call, read ``flooding`` of a `Setting`."""
    if manifest.source:
        nodes = ast.walk(ast.parse(manifest.source))
        return any(isinstance(each, ast.Attribute) and each.attr == "flooding" for each in nodes)
    functions = [getattr(manifest, name) for name in manifest.functions]
    for function in functions:
        names = function.__code__.co_names
        if "flooding" in names:
            return True
        called = (function.__globals__.get(name) for name in names)
        functions += [each for each in called if isinstance(each, FunctionType) and each not in functions]
    return False


def registered() -> list[str]:
    """Return the names of the strategies of other packages."""
    return sorted(point.name for point in entry_points(group=GROUP))


def _text(name: str) -> str:
    """Return the text of a strategy that isn't built in."""
    if name.endswith(".py"):
        return _read(name)
    found = [point for point in entry_points(group=GROUP) if point.name == name]
    if not found:
        raise FeasibeeError("names no strategy")
    return _text_of_module(found[0])


def _text_of_module(point: EntryPoint) -> str:
    """Return the text of a registered module, found without importing it or the packages that hold it."""
    if point.attr:
        raise FeasibeeError(f"{point.value} isn't a module, which it must be; register {point.module}")
    top, *parts = point.module.split(".")
    spec: ModuleSpec | None = find_spec(top)
    way = top
    for part in parts:
        way = f"{way}.{part}"
        places = spec.submodule_search_locations if spec is not None else None
        spec = None if places is None else PathFinder.find_spec(way, list(places))
    if spec is None or not (spec.origin or "").endswith(".py"):
        raise FeasibeeError(f"{point.value} isn't a module in a .py file; register one")
    return _read(str(spec.origin))


def _read(path: str) -> str:
    try:
        return read_text(path, "a file of Python")
    except UnreadableError as error:
        raise FeasibeeError(f"can't be read: {error.why}; name a file of Python") from None


class _WrongError(Exception):
    """What is wrong with a file's text: the statement or expression, if it is one, and the rule."""


@lru_cache(256)
def _parsed(name: str, source: str) -> Manifest:
    """Return the declarations in a file's text."""
    file = Path(name).name
    try:
        return _declared(name, source, ast.parse(source, file))
    except _WrongError as error:
        node, rule = error.args
        line = f", line {_line(node)}" if node else ""
        raise FeasibeeError(f"{file}{line}: {rule}") from None
    except (SyntaxError, ValueError) as error:
        line = f", line {error.lineno}" if isinstance(error, SyntaxError) and error.lineno else ""
        raise FeasibeeError(f"{file}{line}: {type(error).__name__}: {error.args[0]}") from None
    except (RecursionError, MemoryError):
        raise FeasibeeError(f"{file}: nests too deep for Python; {_SHALLOWER}") from None


def _declared(name: str, source: str, tree: ast.Module) -> Manifest:
    """Return the declarations of a file, after checks of its language, functions and constants."""
    _check_depth(tree)
    _check_imports(tree)
    bound = dict(bindings(tree))
    _check_language(tree, bound)
    functions = frozenset(ARGUMENTS).intersection(bound)
    for function in filter(functions.__contains__, ARGUMENTS):
        _check_function(function, bound[function])
    _check_completeness(functions)
    constants = {
        field: _constant(constant, bound[constant])
        for constant, field in CONSTANTS.items()
        if constant in bound
    }
    _check_constants(constants, functions)
    return Manifest(name=name, source=source, functions=functions, **constants)


def _check_constants(constants: Mapping[str, Any], functions: frozenset[str]) -> None:
    """Raise an error if a constant names no parameter of the file, or says the same as a function."""
    parameters, need = constants.get("parameters", {}), constants.get("needs_ids")
    known = ", ".join(parameters) or "none"
    if isinstance(need, str) and need not in parameters:
        raise _WrongError(None, f"NEEDS_IDS = {need!r} must be {NEED[0]}; it has {known}")
    if not set(constants.get("positive", ())) <= set(parameters):
        raise _WrongError(None, f"POSITIVE must have names of parameters; it has {known}")
    for name in ("dissemination", "lasting"):
        if constants.get("modulates") and name in functions:
            rule = f"has both MODULATES = True and {name}, which say for how long robots broadcast"
            raise _WrongError(None, f"{rule}; remove MODULATES or def {name}")


_SHALLOWER: Final = "write long expressions in several statements"


def _check_depth(tree: ast.Module) -> None:
    """Raise an error if statements or expressions nest deeper than `DEEPEST`."""
    nodes: list[ast.AST] = [tree]
    for _ in range(DEEPEST):
        nodes = [child for node in nodes for child in ast.iter_child_nodes(node)]
    for node in nodes:
        if hasattr(node, "lineno"):
            raise _WrongError(node, f"nests more than {DEEPEST} levels deep; {_SHALLOWER}")


def _check_language(tree: ast.Module, bound: Mapping[str, ast.AST]) -> None:
    """Raise an error for a statement or a call that no strategy can have, by syntax only."""
    for node in tree.body:
        text = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if not (text or isinstance(node, (*TOP_LEVEL, *MISSING))) or _targets_more_than_names(node):
            shown = one_line(ast.unparse(node).partition("\n")[0], 60)
            rule = "at the top level; write only imports, constants and functions there"
            raise _WrongError(node, f"{shown} {rule}")
    for each in ast.walk(tree):
        what, remedy = MISSING.get(type(each), ("", ""))
        if isinstance(each, ast.Import | ast.ImportFrom) and each not in tree.body:
            what, remedy = "import in a function", "import at the top level"
        if isinstance(each, ast.Name) and each.id in UNCALLED and each.id not in bound:
            what, remedy = each.id, "leave it out"
        if isinstance(each, ast.Constant) and isinstance(each.value, int) and each.value >= MOST:
            raise _WrongError(each, f"a number {LEAVES}; write one below 2**63")
        if what:
            raise _WrongError(each, f"has {what}, which no strategy has; {remedy}")


def _targets_more_than_names(node: ast.stmt) -> bool:
    """Return whether a statement assigns to a part of something, which could change a constant."""
    targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
    parts = (each for target in targets if target is not None for each in ast.walk(target))
    return any(isinstance(each, ast.Subscript | ast.Attribute) for each in parts)


def _check_imports(tree: ast.Module) -> None:
    """Raise an error for an import of anything but `ALLOWED`, which could make runs differ.

    This isn't a sandbox: it keeps strategies reproducible, and a file that is run can do what its user can.
    """
    for node in ast.walk(tree):
        modules = [each.name for each in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom):
            modules = [f"{'.' * node.level}{node.module or ''}"]
        for module in modules:
            if module not in ALLOWED:
                rule = f"imports {module}; a strategy may import math only, and has inbox.chance"
                raise _WrongError(node, rule)


def bindings(tree: ast.Module) -> list[tuple[str, ast.AST]]:
    """Return the names bound at the file's top level, each with its statement; the last one counts."""
    found: list[tuple[str, ast.AST]] = []
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            found.append((node.name, node))
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            found += [(each.id, node) for target in targets for each in ast.walk(target) if _is_bound(each)]
        elif isinstance(node, ast.Import | ast.ImportFrom):
            found += [(each.asname or each.name, node) for each in node.names]
    return found


def _is_bound(node: ast.AST) -> TypeGuard[ast.Name]:
    return isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)


def _check_completeness(functions: frozenset[str]) -> None:
    """Raise an error if a function is missing that all or others need, or if two exclude each other."""
    if "layout" in functions and not functions.isdisjoint(("pack", "unpack")):
        rule = "has both layout and pack or unpack, which are made of it"
        raise _WrongError(None, f"{rule}; remove def pack and def unpack, or def layout")
    needs = [("has no", name) for name in REQUIRED]
    knowing = next((name for name in (*KNOWLEDGE, *KNOWLEDGE_OPTIONS) if name in functions), None)
    if knowing:
        begin = f"has {knowing}, by which robots pass on knowledge, but no"
        needs += [(begin, name) for name in KNOWLEDGE]
    needs += [(f"has {name}, but no", other) for name, other in TOGETHER if name in functions]
    for begin, name in needs:
        if name not in functions:
            raise _WrongError(None, f"{begin} function {name}; {_wanted(name)}")
    if functions >= {"judge", "declare"}:
        rule = "has both judge, for opinions that may change in any step, and declare, for good ones"
        raise _WrongError(None, f"{rule}; remove def judge or def declare")


def _wanted(name: str) -> str:
    return f"write def {name}({', '.join(ARGUMENTS[name])})"


def _check_function(name: str, node: ast.AST) -> None:
    """Raise an error if the file defines a function as something else, or with other arguments."""
    if not isinstance(node, ast.FunctionDef) or node.decorator_list:
        raise _WrongError(node, f"{name} isn't a plain function; {_wanted(name)}")
    given, count = node.args, len(ARGUMENTS[name])
    extra = given.vararg or given.kwarg or given.kwonlyargs
    if len(given.posonlyargs) + len(given.args) != count or extra:
        raise _WrongError(node, f"{name} must take {count}; {_wanted(name)}")


def _constant(name: str, node: ast.AST) -> Any:
    """Return a constant's value, which must be written out in the file."""
    rule, holds = RULES[name]
    value = getattr(node, "value", None)
    try:
        given = ast.literal_eval(value)  # type: ignore[arg-type]  # None and functions fail as they should
        if holds(given):
            return given
    except (ValueError, TypeError, SyntaxError, MemoryError, RecursionError):
        pass
    shown = ast.unparse(value) if isinstance(value, ast.AST) else "..."
    raise _WrongError(node, f"{name} = {shown[:100]} must be {rule}, written out")


def _line(node: ast.AST) -> int:
    return int(getattr(node, "lineno", 1))


def _is_parameters(value: Any) -> bool:
    return isinstance(value, dict) and all(
        isinstance(key, str)
        and key.isprintable()
        and isinstance(number, int | float)
        and not isinstance(number, bool)
        and abs(number) < math.inf
        for key, number in value.items()
    )

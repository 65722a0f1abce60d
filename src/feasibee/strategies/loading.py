"""Strategies from files and other packages: found, read and tried once, so that errors come early."""

from __future__ import annotations

import ast
import hashlib
import importlib.util
import inspect
import math
import sys
import traceback
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType
from typing import Any

from feasibee.errors import FeasibeeError
from feasibee.strategies.contract import Inbox, Mind, Strategy

GROUP = "feasibee.strategies"
ARGUMENTS = {
    "quality": ("robots_seen", "tasks_seen"),
    "dissemination": ("quality", "gain"),
    "decide": ("mind", "inbox"),
    "say": ("mind",),
    "value": ("mind",),
}
ALLOWED = ("math", "typing", "__future__", "feasibee.strategies.contract")
REQUIRED = ("quality", "dissemination", "decide")
CONSTANTS = {
    "PARAMETERS": "parameters",
    "MEMORY": "memory",
    "VALUE_BITS": "value_bits",
    "FORGETS": "forgets",
    "STARTS_NEUTRAL": "starts_neutral",
    "Knowledge": "knowledge",
}


def of_module(name: str, module: ModuleType, source: str = "") -> Strategy:
    """Return the strategy that a module defines."""
    functions = {each: getattr(module, each) for each in ARGUMENTS if hasattr(module, each)}
    constants = {field: getattr(module, each) for each, field in CONSTANTS.items() if hasattr(module, each)}
    return Strategy(name, **functions, **constants, source=source)


def load(name: str) -> Strategy:
    """Load a strategy by the path of its file, or by the name under which a package registers it.

    Raises
    ------
    FeasibeeError
        If there is none, or it isn't one: what is missing or wrong, and where.
    """
    if name.endswith(".py"):
        path = Path(name)
        if not path.is_file():
            raise FeasibeeError("is no file; name a file of Python")
        return _of_file(name, path.resolve(), path.stat().st_mtime_ns)
    return of_package(name)


@cache
def _of_file(name: str, path: Path, changed: int) -> Strategy:
    """Load a strategy from a file as it was when last changed."""
    return _checked(name, _read(path))


@cache
def of_package(name: str) -> Strategy:
    """Load a strategy that another package registers."""
    found = [point for point in entry_points(group=GROUP) if point.name == name]
    if not found:
        raise FeasibeeError("names no strategy")
    return _checked(name, _imported(found[0]))


def _checked(name: str, module: ModuleType) -> Strategy:
    path = Path(module.__file__ or "")
    source = path.read_text(encoding="utf-8")
    _check_imports(source, path)
    _check(module, path)
    return of_module(name, module, source)


def _check_imports(source: str, path: Path) -> None:
    """Refuse what would make runs differ, or not compile: a strategy needs no library."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import | ast.ImportFrom):
            modules = (
                [node.module] if isinstance(node, ast.ImportFrom) else [each.name for each in node.names]
            )
            for module in modules:
                if module not in ALLOWED:
                    rule = f"imports {module}; a strategy may import math only, and has inbox.chance"
                    raise FeasibeeError(f"{path.name}, line {node.lineno}: {rule}")


def registered() -> list[str]:
    """Return the names of the strategies of other packages."""
    return sorted(point.name for point in entry_points(group=GROUP))


def _imported(point: EntryPoint) -> ModuleType:
    try:
        module = point.load()
    except Exception as error:
        raise FeasibeeError(f"{point.value} can't be imported: {_said(error)}") from None
    if not isinstance(module, ModuleType):
        raise FeasibeeError(f"{point.value} isn't a module, which it must be")
    return module


def _read(path: Path) -> ModuleType:
    digest = hashlib.sha256(str(path).encode()).hexdigest()[:8]
    spec = importlib.util.spec_from_file_location(f"feasibee_strategy_{path.stem}_{digest}", path)
    if spec is None or spec.loader is None:
        raise FeasibeeError("is no file; name a file of Python")
    module = importlib.util.module_from_spec(spec)
    sys.modules[module.__name__] = module  # compiled code on disk names its module
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise FeasibeeError(f"{_where(error, path)}: {_said(error)}") from None
    return module


def _check(module: ModuleType, path: Path) -> None:
    """Refuse a module that isn't a strategy, by its names, its arguments and one call of each function."""
    if hasattr(module, "Knowledge"):
        raise FeasibeeError(f"{path.name}: defines Knowledge; only built-in strategies pass on knowledge")
    for name, arguments in ARGUMENTS.items():
        function = getattr(module, name, None)
        wanted = f"def {name}({', '.join(arguments)})"
        if function is None:
            if name in REQUIRED:
                raise FeasibeeError(f"{path.name}: has no function {name}; write {wanted}")
            continue
        if not inspect.isfunction(function):
            raise FeasibeeError(f"{path.name}: {name} isn't a function; write {wanted}")
        if len(inspect.signature(function).parameters) != len(arguments):
            line = function.__code__.co_firstlineno
            raise FeasibeeError(
                f"{path.name}, line {line}: {name} must take {len(arguments)}; write {wanted}"
            )
    _check_constants(module, path)
    _try(module, path)


def _check_constants(module: ModuleType, path: Path) -> None:
    rules = {
        "PARAMETERS": ("a dict of names and numbers", _is_parameters),
        "MEMORY": ("a whole number from 0 to 64", lambda value: _is_whole(value, 64)),
        "VALUE_BITS": ("a whole number from 0 to 16", lambda value: _is_whole(value, 16)),
        "FORGETS": ("True or False", lambda value: isinstance(value, bool)),
        "STARTS_NEUTRAL": ("True or False", lambda value: isinstance(value, bool)),
    }
    for name, (rule, holds) in rules.items():
        if hasattr(module, name) and not holds(getattr(module, name)):
            raise FeasibeeError(f"{path.name}: {name} = {getattr(module, name)!r} must be {rule}")


def _is_whole(value: Any, most: int) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= most


def _is_parameters(value: Any) -> bool:
    return isinstance(value, dict) and all(
        isinstance(key, str) and isinstance(number, int | float) and math.isfinite(number)
        for key, number in value.items()
    )


def _try(module: ModuleType, path: Path) -> None:
    """Call each function once as the simulation would."""
    parameters = [float(number) for number in getattr(module, "PARAMETERS", {}).values()]
    mind = Mind(1, 0.6, 0.6, 1, [0.0] * getattr(module, "MEMORY", 0), parameters)
    inbox = Inbox(2, 1, 1, 0.5, 0.5, 0.25)
    calls: dict[str, tuple[Any, ...]] = {
        "quality": (3, 2),
        "dissemination": (0.6, 10.0),
        "decide": (mind, inbox),
        "say": (mind,),
        "value": (mind,),
    }
    for name, arguments in calls.items():
        if not hasattr(module, name):
            continue
        try:
            result = getattr(module, name)(*arguments)
        except Exception as error:
            raise FeasibeeError(f"{_where(error, path)}: {name} fails: {_said(error)}") from None
        if name in ("decide", "say"):
            if result not in (1, 0, -1):
                raise FeasibeeError(f"{path.name}: {name} returns {result!r}; must be 1, 0, or -1 for none")
        elif not isinstance(result, int | float) or not math.isfinite(result):
            raise FeasibeeError(f"{path.name}: {name} returns {result!r}; must be a number")


def _where(error: Exception, path: Path) -> str:
    """Return the last line of a file that an error passed through."""
    if isinstance(error, SyntaxError) and error.lineno:
        return f"{path.name}, line {error.lineno}"
    lines = [
        frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)
    ]
    return f"{path.name}, line {lines[-1]}" if lines else path.name


def _said(error: Exception) -> str:
    return f"{type(error).__name__}: {error}".splitlines()[0]

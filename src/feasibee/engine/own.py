"""A user's strategy in the engine: translated to C, compiled once on a machine, loaded, and why it failed.

The text never runs as Python here. The library has the functions of ``struct rules``, which check what Python
checks. A check that fails ends the run, and `explained` says where and why.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cache
from hashlib import sha256
from pathlib import Path
from platform import machine
from typing import Any, Final, NamedTuple

from feasibee.base.cache import cache_root, own_folder, read_library, scratch_folder, write_library
from feasibee.base.errors import FeasibeeError, how_to_install
from feasibee.engine.build import build, compile_library, digest, params_header
from feasibee.engine.compilers import zig
from feasibee.engine.failing import DOMAIN, OF_MATH, PASSES, RANGE, RESULT, Failing
from feasibee.engine.generate import RETURNING, built_in_strategies, own_strategy
from feasibee.engine.platforms import LIBRARIES, WEBASSEMBLY
from feasibee.robot.compiler import run_compiler
from feasibee.strategies.contract import MUST, Manifest

HEADERS: Final = Path(__file__).parent / "c"
INCLUDED: Final = (
    *("engine.h", "translated.h", "checked.h", "update.h", "given.h", "sets.h", "decisions.h", "state.h"),
    "vec.h",
)
"""The headers that a library is made of."""
FLAGS: Final = (
    *("-std=gnu11", "-O2", "-ffp-contract=off", "-fno-math-errno", "-fno-sanitize=all"),
    *("-fPIC", "-shared", "-w"),
)
"""No contraction: each operation rounds as in Python."""
FOLDER: Final = "strategies"
"""Where a cache has the libraries."""
SUFFIX: Final = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")


# --- The library ---


class OwnRules(NamedTuple):
    """The rules of a user's strategy."""

    rules: Any
    """A pointer to its ``struct rules``."""
    library: Any
    """What must live as long as they are used."""


@cache
def load(strategy: Manifest, ffi: Any, engine: Any) -> OwnRules:
    """Load a user's strategy; compile it unless it is cached.

    Parameters
    ----------
    strategy : Manifest
        The strategy, whose text isn't run.
    ffi : cffi.FFI
        With the declarations of ``engine.h``.
    engine : object
        The engine's library, whose ``feasibee_fail`` ends a run.

    Raises
    ------
    FeasibeeError
        If the file has what the language of strategies doesn't have, or there is no compiler.
    """
    library = ffi.dlopen(str(compiled(strategy)))
    library.feasibee_bind(ffi.addressof(engine, "feasibee_fail"))
    return OwnRules(library.feasibee_rules(b""), library)


def compiled(strategy: Manifest) -> Path:
    """Return the library of a user's strategy, from the cache if it is there."""
    text = own_strategy(_file(strategy), strategy.source)
    folder = own_folder(own_folder(cache_root()) / FOLDER)
    key = _key(text)
    return read_library(folder, key) or _made(text, folder, key)


def _file(strategy: Manifest) -> str:
    """Return what errors call a strategy's file."""
    return Path(strategy.name).name


def _key(text: str) -> str:
    """Return what names a library: all that decides what it computes.

    That is not the compiler, since each rounds alike. So where the library is copied to, none is needed.
    """
    headers = ((HEADERS / each).read_text(encoding="utf-8") for each in INCLUDED)
    parts = (text, params_header(), *headers, *FLAGS, sys.platform, machine())
    return sha256("\0".join(parts).encode()).hexdigest()[:32]


def _made(text: str, folder: Path, key: str) -> Path:
    """Compile a library into the cache; return it."""
    with scratch_folder(folder) as own:
        source, made = Path(own, "own.c"), Path(own, f"own{SUFFIX}")
        source.write_text(text, encoding="utf-8")
        source.with_name("params.h").write_text(params_header(), encoding="utf-8")
        run_compiler(*FLAGS, f"-I{own}", f"-I{HEADERS}", str(source), "-o", str(made), "-lm")
        return write_library(folder, key, made)


def module(strategy: Manifest) -> bytes:
    """Return the engine in WebAssembly, for pages, with a user's strategy if it is one; compile it if needed.

    Raise a FeasibeeError if it has to be compiled, and ziglang isn't installed.
    """
    whole = LIBRARIES / f"feasibee{WEBASSEMBLY.suffix}"
    if whole.exists() and not strategy.source:
        return whole.read_bytes()
    by = zig()
    if by is None:
        raise FeasibeeError(f"ziglang: not installed; {how_to_install('c')}")
    if not strategy.source:
        return build(WEBASSEMBLY)[0].read_bytes()
    text = own_strategy(_file(strategy), strategy.source, pages=True)
    folder, key = own_folder(own_folder(cache_root()) / FOLDER), _key(text + digest())
    found = read_library(folder, key)
    if found is None:
        with scratch_folder(folder) as own:
            out = Path(own, whole.name)
            out.with_name("own.c").write_text(text, encoding="utf-8")
            out.with_name("strategies.c").write_text(built_in_strategies(), encoding="utf-8")
            compile_library(out, WEBASSEMBLY, next(iter(WEBASSEMBLY.levels)), by)
            found = write_library(folder, key, out)
    return found.read_bytes()


# --- Why it failed ---


class Failure(NamedTuple):
    """A ``struct failure``: see `feasibee.engine.failing.Failing`."""

    what: int
    line: int
    first: float
    second: float


def explained(strategy: Manifest, failure: Failure) -> str:
    """Return why a user's strategy failed: file, line, values, rule and remedy.

    Examples
    --------
    >>> explained(Manifest(name="mine.py", source="X = 1\\n"), Failure(Failing.PLACE, 1, 5.0, 2.0))
    'mine.py, line 1: fails: IndexError: place 5 in a row of 2; take one from 0 on that is below its length'
    """
    kind, what, remedy = _template(failure.what)
    show: Callable[[float], object] = _shown if failure.what >= RESULT else float if "!r" in what else int
    values = [show(each) for each in (failure.first, failure.second)]
    fails = f"fails: {kind}: " if kind else ""
    return f"{_file(strategy)}, line {failure.line}: {fails}{what.format(*values)}; {remedy}"


def kind_of(failure: Failure) -> str:
    """Return the name of the error that Python raises there; empty if it raises none."""
    return _template(failure.what)[0]


def failures() -> dict[int, str]:
    """Return why a user's strategy may fail, by `Failure.what`: ``{0}`` and ``{1}`` stand for the values."""
    maths = (at + k for at in (DOMAIN, RANGE) for k in range(len(OF_MATH)))
    every = (*map(int, Failing), *maths, *(RESULT + k for k in range(len(RETURNING))))
    templates = {each: _template(each) for each in every}
    passes = f"{PASSES:,}"
    return {
        each: f"{what}; {remedy}".replace("!r", "").replace("{0:,}", passes)
        for each, (_, what, remedy) in templates.items()
    }


def _template(what: int) -> tuple[str, str, str]:
    """Return Python's error, if it raises one, what fails with places for the values, and a remedy."""
    if what >= RESULT:
        name = RETURNING[what - RESULT]
        return "", "count writes {0} into counts" if name == "count" else f"{name} returns {{0}}", MUST[name]
    if what < DOMAIN:
        return list(Failing)[what - 1].words
    large = what >= RANGE
    name = list(OF_MATH)[what - (RANGE if large else DOMAIN)]
    called = f"math.{name}({', '.join(('{0!r}', '{1!r}')[: OF_MATH[name]])})"
    if large:
        return "OverflowError", f"{called} is too large", "limit the number before"
    return "ValueError", f"{called}: math domain error", "test the number before"


def _shown(number: float) -> str:
    """Return a result as Python shows it, a whole number without a decimal point."""
    return str(int(number)) if number == number // 1 and abs(number) < 2**53 else repr(number)

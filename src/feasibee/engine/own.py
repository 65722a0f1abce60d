"""A user's strategy in the engine: translated to C, compiled once on a machine, loaded, and why it failed.

The text never runs as Python here. The library has the functions of ``struct rules``, which check what Python
checks. A check that fails ends the run, and `explained` says where and why.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from functools import cache
from hashlib import sha256
from pathlib import Path
from platform import machine
from typing import Any, Final, NamedTuple

from feasibee.engine.build import build, compile_library, digest
from feasibee.engine.compilers import zig
from feasibee.engine.failing import DOMAIN, OF_MATH, PASSES, RANGE, RESULT, Failing
from feasibee.engine.generate import RETURNING, built_in_strategies, own_strategy
from feasibee.engine.platforms import LIBRARIES, WEBASSEMBLY
from feasibee.errors import FeasibeeError, how_to_install
from feasibee.files.cache import cache_root, own_folder, read_library, scratch_folder, write_library
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
    parts = (text, *headers, *FLAGS, sys.platform, machine())
    return sha256("\0".join(parts).encode()).hexdigest()[:32]


def _made(text: str, folder: Path, key: str) -> Path:
    """Compile a library into the cache; return it."""
    with scratch_folder(folder) as own:
        source, made = Path(own, "own.c"), Path(own, f"own{SUFFIX}")
        source.write_text(text, encoding="utf-8")
        run_compiler(*FLAGS, f"-I{HEADERS}", str(source), "-o", str(made), "-lm")
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


_LARGE: Final = "compute with real numbers, such as float(...)"
_BY_ZERO: Final = "test that it isn't 0 before"
_WORDS: Final[Mapping[Failing, tuple[str, str, str]]] = {
    Failing.PLACE: ("IndexError", "place {0} in a row of {1}", "take one from 0 on that is below its length"),
    Failing.WHOLE_DIVISION: ("ZeroDivisionError", "{0} // 0", _BY_ZERO),
    Failing.WHOLE_MODULO: ("ZeroDivisionError", "{0} % 0", _BY_ZERO),
    Failing.RATIO: ("ZeroDivisionError", "{0} / 0", _BY_ZERO),
    Failing.DIVISION: ("ZeroDivisionError", "{0!r} / 0", _BY_ZERO),
    Failing.REAL_DIVISION: ("ZeroDivisionError", "{0!r} // 0", _BY_ZERO),
    Failing.REAL_MODULO: ("ZeroDivisionError", "{0!r} % 0", _BY_ZERO),
    Failing.LEFT_SHIFT: ("ValueError", "{0} << {1}", "shift by 0 places or more"),
    Failing.RIGHT_SHIFT: ("ValueError", "{0} >> {1}", "shift by 0 places or more"),
    Failing.SUM: ("OverflowError", "{0} + {1} leaves 64 bits", _LARGE),
    Failing.DIFFERENCE: ("OverflowError", "{0} - {1} leaves 64 bits", _LARGE),
    Failing.PRODUCT: ("OverflowError", "{0} * {1} leaves 64 bits", _LARGE),
    Failing.QUOTIENT: ("OverflowError", "{0} // {1} leaves 64 bits", _LARGE),
    Failing.POWER: ("OverflowError", "{0} ** {1} leaves 64 bits", _LARGE),
    Failing.SHIFT: ("OverflowError", "{0} << {1} leaves 64 bits", _LARGE),
    Failing.NEGATION: ("OverflowError", "-({0}) leaves 64 bits", _LARGE),
    Failing.SIZE: ("OverflowError", "abs({0}) leaves 64 bits", _LARGE),
    Failing.WHOLE: (
        "OverflowError",
        "int({0!r}) leaves 64 bits",
        "limit the number before, with min and max",
    ),
    Failing.FLOOR: ("OverflowError", "math.floor({0!r}) leaves 64 bits", "limit the number before"),
    Failing.CEIL: ("OverflowError", "math.ceil({0!r}) leaves 64 bits", "limit the number before"),
    Failing.ROUND: ("OverflowError", "round({0!r}) leaves 64 bits", "limit the number before"),
    Failing.WHOLE_OF_NAN: (
        "ValueError",
        "a float that is no number has no whole one",
        "test with math.isnan",
    ),
    Failing.WHOLE_OF_INFINITY: ("OverflowError", "{0!r} has no whole number", "test with math.isinf before"),
    Failing.ZERO_POWER: ("ZeroDivisionError", "{0!r} ** {1!r}", _BY_ZERO),
    Failing.ROOT: ("ValueError", "{0!r} ** {1!r} is complex", "take the power of a number of 0 or more"),
    Failing.REAL_POWER: ("OverflowError", "{0!r} ** {1!r} is too large", "limit the exponent before"),
    Failing.NEGATIVE_EXPONENT: (
        "ValueError",
        "{0} ** {1} is no whole number",
        "write float(base) ** exponent",
    ),
    Failing.STEP: ("ValueError", "range from {0} to {1} by 0", "step by another number"),
    Failing.NO_VALUE: ("UnboundLocalError", "a variable has no value yet", "give it one at the beginning"),
    Failing.NO_RESULT: ("TypeError", "a function returns nothing", "return a number in each case"),
    Failing.ASSERTION: ("AssertionError", "what is asserted doesn't hold", "remove it, or what is wrong"),
}
"""By failure: Python's error, what failed with which numbers, and a remedy."""


def explained(strategy: Manifest, failure: Failure) -> str:
    """Return why a user's strategy failed: file, line, values, rule and remedy.

    Examples
    --------
    >>> explained(Manifest(name="mine.py", source="X = 1\\n"), Failure(Failing.PLACE, 1, 5.0, 2.0))
    'mine.py, line 1: fails: IndexError: place 5 in a row of 2; take one from 0 on that is below its length'
    """
    where = f"{_file(strategy)}, line {failure.line}"
    if failure.what >= RESULT:
        name = RETURNING[failure.what - RESULT]
        does = "count writes {} into counts" if name == "count" else f"{name} returns {{}}"
        return f"{where}: {does.format(_shown(failure.first))}; {MUST[name]}"
    if failure.what == Failing.ENDLESS:
        return f"{where}: a loop has passed {PASSES:,} times; end it sooner"
    kind, what, remedy = _reason(failure)
    return f"{where}: fails: {kind}: {what}; {remedy}"


def kind_of(failure: Failure) -> str:
    """Return the name of the error that Python raises there; empty if it raises none."""
    return "" if failure.what >= RESULT or failure.what == Failing.ENDLESS else _reason(failure)[0]


def _reason(failure: Failure) -> tuple[str, str, str]:
    """Return Python's error, what failed, and a remedy."""
    if failure.what >= DOMAIN:
        large = failure.what >= RANGE
        name = list(OF_MATH)[failure.what - (RANGE if large else DOMAIN)]
        values = (failure.first, failure.second)[: OF_MATH[name]]
        called = f"math.{name}({', '.join(map(repr, values))})"
        if large:
            return "OverflowError", f"{called} is too large", "limit the number before"
        return "ValueError", f"{called}: math domain error", "test the number before"
    kind, what, remedy = _WORDS[Failing(failure.what)]
    shown = [each if "!r" in what else int(each) for each in (failure.first, failure.second)]
    return kind, what.format(*shown), remedy


def _shown(number: float) -> str:
    """Return a result as Python shows it, a whole number without a decimal point."""
    return str(int(number)) if number == number // 1 and abs(number) < 2**53 else repr(number)

"""Load the compiled engine: the library of the highest level that this processor has, and those of users."""

from __future__ import annotations

import os
from functools import cache
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from feasibee.base.errors import FeasibeeError
from feasibee.base.files import named
from feasibee.engine.platforms import BINDING, LIBRARIES, file_of, native

LEVEL: Final = "FEASIBEE_LEVEL"
"""Environment variable: the level to load instead of the highest one, for trials."""
REMEDY: Final = "install feasibee again, or in a checkout run: python -m feasibee.engine.build"


@cache
def library() -> tuple[Any, Any]:
    """Return cffi's description of engine.h and the library, loaded once per process.

    Raise a FeasibeeError if the engine isn't compiled, can't be loaded, or the processor lacks the level that
    ``FEASIBEE_LEVEL`` names.
    """
    found = levels()
    wanted = os.environ.get(LEVEL) or found[-1]
    if wanted not in found:
        raise FeasibeeError(
            f"{LEVEL} = {wanted}: must be a level that this processor has: {', '.join(found)}; unset it"
        )
    return ffi(), load(library_of(wanted))


@cache
def levels() -> list[str]:
    """Return the levels that are compiled and that this processor has, the lowest first."""
    names = list(native().levels)
    highest = load(library_of(names[0])).feasibee_level()
    if highest < 0:
        raise FeasibeeError(f"processor: the engine needs one of level {names[0]}; use a newer machine")
    return [name for name in names[: highest + 1] if library_of(name).exists()]


def library_of(level: str) -> Path:
    """Return the path of the library of a level."""
    return LIBRARIES / file_of(level, native())


@cache
def ffi() -> Any:
    """Return cffi's description of engine.h, written when the engine was compiled."""
    path = LIBRARIES / BINDING
    if not path.exists():
        raise _missing(path)
    loader = SourceFileLoader("feasibee_binding", str(path))
    module = module_from_spec(spec_from_loader(loader.name, loader))  # type: ignore[arg-type]  # it has one
    loader.exec_module(module)
    return module.ffi


@cache  # cffi unloads a library that nothing refers to, even while a function of it is called
def load(path: Path) -> Any:
    """Return a library with functions of engine.h: one of the engine's, or one made of a user's strategy."""
    if not path.exists():
        raise _missing(path)
    try:
        return ffi().dlopen(str(path))
    except OSError as error:
        raise FeasibeeError(f"{named(path)}: can't be loaded: {error}; {REMEDY}") from None


def _missing(path: Path) -> FeasibeeError:
    return FeasibeeError(f"{named(path)}: the engine is not compiled; {REMEDY}")


def pointer(array: NDArray[Any] | np.void | None, kind: str) -> Any:
    """Return a pointer to the numbers of an array, or of a record, as C takes it; NULL for None.

    Parameters
    ----------
    array : array, record or None
        A contiguous array. It must live as long as C may use it.
    kind : str
        What it points to, such as ``int32_t`` or ``struct params``.

    Raises
    ------
    TypeError
        If a number of the array has another size than one in C.
    """
    if array is None:
        return ffi().NULL
    if array.dtype.itemsize != ffi().sizeof(kind):
        raise TypeError(f"an array of {array.dtype} has no numbers of type {kind}")
    return ffi().cast(f"{kind} *", ffi().from_buffer(array))

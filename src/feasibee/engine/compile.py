"""The one compile decorator. Nothing else in the package says ``njit``."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from threading import Lock
from typing import Any

import llvmlite
import numba
import numpy

from feasibee.files import cache_root

CONFIG: Any = numba.config
ONE_AT_A_TIME = Lock()
"""numba's settings are those of all threads."""
# No kernel allocates, so the runtime that counts references to arrays is off: passing the state to a
# function would otherwise touch every array's count atomically, which doubled the cost of a step.
OPTIONS: dict[str, Any] = {"nogil": True, "_nrt": False, "error_model": "numpy"}
CAREFUL: dict[str, Any] = {**OPTIONS, "error_model": "python", "boundscheck": True}


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that kernels call; inlined, since passing the state costs more than most do."""
    compiled: Callable[..., Any] = numba.njit(forceinline=True, **OPTIONS)(function)
    return compiled


def passage(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile as part of the one function that calls it: a long one, which would else be compiled twice."""
    compiled: Callable[..., Any] = numba.njit(inline="always", **OPTIONS)(function)
    return compiled


def subroutine(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that kernels call where a call costs little beside it; one copy compiles sooner.

    numba makes a copy for each constant that is passed, hence ``int64(KNOWN)`` in place of ``KNOWN`` there.
    """
    compiled: Callable[..., Any] = numba.njit(**OPTIONS)(function)
    return compiled


def careful(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a user's function, which raises what Python would; `entry` keeps what calls it."""
    compiled: Callable[..., Any] = numba.njit(**CAREFUL)(function)
    return compiled


def entry(signature: Any, text: str = "") -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Compile a function that Python calls, for one signature, and keep the code on disk.

    Code that comes of a user's ``text`` is kept in a folder named after it, since numba tells functions
    apart by their own lines only.
    """
    options, folder = OPTIONS, cache_folder()
    if text:
        options, folder = CAREFUL, folder / "own" / hashlib.sha256(text.encode()).hexdigest()[:16]

    def decorate(function: Callable[..., Any]) -> Callable[..., Any]:
        # The cache folder is fixed while numba decorates; the user's own setting is put back at once.
        with ONE_AT_A_TIME:
            users_folder = CONFIG.CACHE_DIR
            CONFIG.CACHE_DIR = str(folder)
            try:
                compiled: Callable[..., Any] = numba.njit(signature, cache=True, **options)(function)
            finally:
                CONFIG.CACHE_DIR = users_folder
        return compiled

    return decorate


@cache
def cache_folder() -> Path:
    """Return the folder of the compiled code, named after all that it was compiled from.

    numba notices a change in a kernel's own file, not in the files of the kernels that it calls. Strategies
    call none.
    ``FEASIBEE_CACHE`` moves the folder.
    """
    package = Path(__file__).parent.parent
    digest = hashlib.sha256()
    shared = ("vocabulary.py", "record.py", "strategies/contract.py")
    for source in (*sorted(package.glob("engine/*.py")), *(package / name for name in shared)):
        digest.update(source.name.encode())
        digest.update(source.read_bytes())
    for version in (sys.version, numba.__version__, llvmlite.__version__, numpy.__version__):
        digest.update(version.encode())
    return cache_root() / digest.hexdigest()[:16]


def is_compiled(name: str) -> bool:
    """Tell whether the compiled code of an entry, from these very sources, is on disk already."""
    return any(cache_folder().glob(f"**/*.{name}-*.nbc"))

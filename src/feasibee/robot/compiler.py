"""The C compiler of this machine, or that of the extra ``c``."""

from __future__ import annotations

import shutil
import subprocess
import sys
from importlib.util import find_spec
from typing import Final

from feasibee.base.errors import FeasibeeError, how_to_install

SYSTEM: Final = ("cc", "gcc", "clang")
"""What compilers of a system are called."""
ZIG: Final = (sys.executable, "-m", "ziglang", "cc")
"""The compiler of the extra ``c``."""


def compiler() -> list[str]:
    """Return the command of a C compiler.

    Raise a FeasibeeError if there is none.
    """
    found = next((each for each in SYSTEM if shutil.which(each)), None)
    if found:
        return [found]
    if find_spec("ziglang"):
        return list(ZIG)
    raise FeasibeeError(f"C: there is no compiler here; install gcc or clang, or {how_to_install('c')}")


def run_compiler(*arguments: str) -> None:
    """Run the compiler; raise a FeasibeeError with its first error if it fails or is missing."""
    command = [*compiler(), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        lines = done.stderr.strip().splitlines() or [f"status {done.returncode}"]
        said = next((each for each in lines if "error" in each), lines[0])
        raise FeasibeeError(f"C: {command[0]} fails: {said}")

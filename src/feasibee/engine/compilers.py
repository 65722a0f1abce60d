"""The C compilers that the engine can be compiled by: ziglang, which pip fetches, and that of the system."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Final, NamedTuple

from feasibee.base.errors import FeasibeeError
from feasibee.engine.platforms import WEBASSEMBLY, X86_64, Platform
from feasibee.robot.compiler import SYSTEM, ZIG

ZIGLANG: Final = "ziglang==0.17.1"
"""The compiler that pip fetches."""


class Compiler(NamedTuple):
    """A C compiler."""

    command: tuple[str, ...]
    name: str
    """With its version: another one may make other code."""
    crosses: bool = False
    """Whether it is zig, which compiles for all platforms."""

    def known(self, target: Platform) -> list[str]:
        """Return the levels that it can compile for: a compiler of a system may be old."""
        levels = list(target.levels)
        asked = () if self.crosses else levels[1:]
        old = {
            each for each in asked if not _output(*self.command, f"-march={each}", "-xc", "-E", os.devnull)
        }
        return [each for each in levels if each not in old]

    def options(self, target: Platform, level: str) -> list[str]:
        """Return the options that say what to compile for."""
        if self.crosses:
            where = ["-target", target.target] if target.target else []
            return [*where, f"-mcpu={target.levels[level]}"]
        return [f"-march={level}"] if level in X86_64 else []

    def linking(self, target: Platform, *, maths: bool = False) -> list[str]:
        """Return the options that make a library of object files, some of which may call ``maths``."""
        if target is WEBASSEMBLY:
            alone = ["-target", "wasm32-freestanding", "-nostdlib"]  # memory.c has what it needs
            return [
                *(["-mexec-model=reactor"] if maths else alone),
                "-Wl,--no-entry",
                "-Wl,--export-dynamic",
                "-s",
            ]
        if not self.crosses:
            return ["-shared", "-lm"]
        # Zig would compile parts of the C library and of its own, which takes 12 s, and the engine uses none.
        without = ["-nostdlib", "-lc", "-lm"] if target.suffix != ".dll" else []
        return ["-shared", "-s", *without, *(["-Wl,-z,defs"] if target.suffix == ".so" else [])]


COMPILER: Final = "FEASIBEE_COMPILER"
"""Environment variable: ``zig`` or ``cc`` to use no other."""


def zig_has_wheels() -> bool:
    """Return whether pip finds ziglang for this machine, and should: its wheels are for these."""
    machines = {
        "Linux": {"x86_64", "aarch64", "i686", "ppc64le", "riscv64", "s390x"},
        "Windows": {"amd64", "arm64"},
        "Darwin": {"x86_64", "arm64"} if platform.mac_ver()[0] >= "13" else set(),
    }
    offered = platform.machine().lower() in machines.get(platform.system(), set())
    return offered and os.environ.get(COMPILER) != "cc"


def zig() -> Compiler | None:
    """Return the installed ziglang unless another is wanted, without a trial."""
    found = None if os.environ.get(COMPILER) == "cc" else find_spec("ziglang")
    if found is None or not found.origin:
        return None
    installed = next(Path(found.origin).parent.parent.glob("ziglang-*.dist-info"), Path("ziglang-?"))
    return Compiler(ZIG, installed.stem.replace("-", " "), True)


def system_compiler() -> Compiler | None:
    """Return the compiler of the system, if it has one that runs."""
    for name in SYSTEM:
        path = shutil.which(name)
        said = _output(path, "--version") if path else ""
        if path and said:
            return Compiler((path,), said.splitlines()[0].strip())
    return None


def _output(*command: str) -> str:
    """Return what a program prints, nothing if it doesn't run or fails."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError:
        return ""
    return "" if done.returncode else done.stdout


@cache
def compiler() -> Compiler:
    """Return the compiler to use: ziglang, else that of the system.

    Raise a FeasibeeError if neither runs.
    """
    wanted = os.environ.get(COMPILER, "")
    if wanted not in ("", "zig", "cc"):
        raise FeasibeeError(f"{COMPILER} = {wanted!r}: must be zig or cc; unset it to use either")
    found = zig()
    if found and _output(*found.command[:-1], "version"):
        return found
    other = system_compiler() if wanted != "zig" else None
    if other:
        if wanted != "cc":
            why = "does not run on this machine" if found else "is not installed"
            print(f"feasibee: ziglang {why}; the engine is compiled by {other.command[0]}, {other.name}")
        return other
    zigs = "does not run" if found else "is not installed"
    raise FeasibeeError(
        f"C compiler: ziglang {zigs}, and no cc, gcc or clang in PATH runs; "
        f"run: {sys.executable} -m pip install {ZIGLANG}, or install gcc or clang"
    )

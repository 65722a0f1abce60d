"""What the engine is compiled for: platforms, and the levels of their processors.

A *level* is a set of instructions that a processor may have. The same sources are compiled once for each
level, and `feasibee.engine.library` loads the highest one that the processor has.
"""

from __future__ import annotations

import platform
import re
import sysconfig
from pathlib import Path
from typing import Final, NamedTuple

LIBRARIES: Final = Path(__file__).parent / "lib"
"""Where the libraries are, in a checkout and where the package is installed."""
BINDING: Final = "engine.cffi"
"""What engine.h declares, as cffi reads it in 6 ms; parsing the header takes it 120 ms."""


class Platform(NamedTuple):
    """What a wheel is for."""

    tag: str
    """As in the name of a wheel; not of a standard if only this machine has it."""
    target: str
    """Of ``zig cc``; empty: this machine."""
    suffix: str
    levels: dict[str, str]
    """Names of processors, as ``zig cc`` has them, by level, the lowest first."""


X86_64: Final = {
    "x86-64-v2": "x86_64_v2",
    "x86-64-v3": "x86_64_v3",  # AVX2
    "icelake-server": "icelake_server",  # AVX-512, with counts of bits in vectors
}
"""macOS switches AVX-512 on when a program first uses it: no program can ask for it before."""
MAC_X86_64: Final = {level: X86_64[level] for level in ("x86-64-v2", "x86-64-v3")}
ARM64: Final = {"arm64": "baseline"}
PLATFORMS: Final = {
    "linux-x86-64": Platform("manylinux_2_17_x86_64", "x86_64-linux-gnu.2.17", ".so", X86_64),
    "linux-arm64": Platform("manylinux_2_17_aarch64", "aarch64-linux-gnu.2.17", ".so", ARM64),
    "macos-x86-64": Platform("macosx_11_0_x86_64", "x86_64-macos.11.0", ".dylib", MAC_X86_64),
    "macos-arm64": Platform("macosx_11_0_arm64", "aarch64-macos.11.0", ".dylib", ARM64),
    "windows-x86-64": Platform("win_amd64", "x86_64-windows-gnu", ".dll", X86_64),
}
"""Those of which `make wheels` makes wheels on any machine."""
WEBASSEMBLY: Final = Platform(
    "wasm32",
    "wasm32-wasi",
    ".wasm",
    {"simd128": "generic+simd128+bulk_memory+sign_ext+nontrapping_fptoint"},
)
"""What pages load: browsers have these instructions since 2023."""


def native() -> Platform:
    """Return the platform of this Python."""
    system = {"Darwin": "macos"}.get(platform.system(), platform.system().lower())
    machine = {"x86_64": "x86-64", "amd64": "x86-64", "arm64": "arm64", "aarch64": "arm64"}
    processor = machine.get(platform.machine().lower(), platform.machine().lower())
    musl = "musl" in str(sysconfig.get_config_var("SOABI"))
    known = PLATFORMS.get(f"{system}-{processor}")
    if known and not musl:
        return known
    suffix = {"macos": ".dylib", "windows": ".dll"}.get(system, ".so")
    levels = {"x86-64": X86_64, "arm64": ARM64}.get(processor, {"baseline": "baseline"})
    return Platform(own_tag(), "", suffix, levels)


def own_tag() -> str:
    """Return the tag of wheels for systems such as this one."""
    return re.sub(r"\W", "_", sysconfig.get_platform())


def file_of(level: str, target: Platform) -> str:
    """Return the name of the library of a level."""
    return f"feasibee-{level}{target.suffix}" if target is not WEBASSEMBLY else "feasibee.wasm"

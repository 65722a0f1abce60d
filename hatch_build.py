"""Compile the engine when pip builds the package: `feasibee.engine.build` does it."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

sys.path.insert(0, str(Path(__file__).parent / "src"))

from feasibee.base.errors import FeasibeeError
from feasibee.engine.build import build, tag_of
from feasibee.engine.compilers import ZIGLANG, zig, zig_has_wheels
from feasibee.engine.platforms import LIBRARIES, PLATFORMS, WEBASSEMBLY, native

PLATFORM = "FEASIBEE_PLATFORM"
"""Environment variable: the platform of the wheel, one of `PLATFORMS`; by default this machine's."""


class Engine(BuildHookInterface[Any]):
    """Put the engine's libraries into a wheel, or into the source folder if it is editable."""

    def dependencies(self) -> list[str]:
        """Return the compiler where the registry has it. Elsewhere, the system's has to do."""
        return [ZIGLANG] if zig_has_wheels() else []

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile, and say which files belong to the wheel and which machines it is for."""
        name = os.environ.get(PLATFORM)
        if name and name not in PLATFORMS:
            raise FeasibeeError(f"{PLATFORM} = {name}: must be one of {', '.join(PLATFORMS)}")
        if name:
            target, folder = PLATFORMS[name], Path(self.root, "build", name)
        else:
            target, folder = native(), LIBRARIES
        files = build(target, folder)
        if zig():
            files = [*files, *build(WEBASSEMBLY, folder)]  # which pages load
        if version == "editable":
            return
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{tag_of(target, folder)}"
        build_data["force_include"] |= {str(each): f"feasibee/engine/lib/{each.name}" for each in files}

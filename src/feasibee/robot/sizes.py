"""Flash and RAM of a robot's controller in C, compiled for a processor whose compiler is installed.

A program that calls all functions of the header is linked. Its sizes less those of a program that does
nothing are what the controller takes. RAM is without the stack and the radio's memory.
"""

from __future__ import annotations

import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Final, NamedTuple

from feasibee.base.errors import FeasibeeError, one_line
from feasibee.robot import firmware
from feasibee.robot.wire import name_of
from feasibee.strategies.contract import Setting, Strategy

SOURCE: Final = Path(__file__).parent / "c" / "least.c"
INBOX: Final = 32
"""Number of senders whose latest message the robots keep; 1 with knowledge, which counts no votes."""
SHARED: Final = (
    *("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror"),
    *("-Os", "-ffunction-sections", "-fdata-sections", "-Wl,--gc-sections"),
)
"""Flags for all processors."""


class Processor(NamedTuple):
    """How to compile for a processor, and the packages that have the compiler."""

    compiler: tuple[str, ...]
    packages: str
    link: tuple[str, ...] = ("-lm",)
    size: str = "size"

    @property
    def found(self) -> bool:
        """Whether its compiler is installed; cc compiles for the machine that it is on."""
        is_here = sys.platform == "linux" and platform.machine() == "x86_64"
        return shutil.which(self.compiler[0]) is not None and (is_here or self.compiler[0] != "cc")

    def bytes_of(self, program: Path) -> tuple[int, int]:
        """Return the bytes of a program in flash and in RAM."""
        text, data, bss = map(int, output(self.size, str(program)).splitlines()[1].split()[:3])
        return text + data, data + bss


PROCESSORS: Final = {
    "x86-64": Processor(("cc", "-m64"), "gcc"),
    "ATmega328P": Processor(
        ("avr-gcc", "-mmcu=atmega328p", "-mcall-prologues"), "gcc-avr and avr-libc", size="avr-size"
    ),
}
"""Processors, by name; benchmarks/sizes.py has more."""


def size_of(
    processor: Processor, strategy: Strategy, setting: Setting | None = None, *, frames: bool = True
) -> tuple[int, int]:
    """Return the bytes in flash and in RAM of the controller of a robot.

    ``setting`` has its parameters, and the numbers on which its knowledge depends. ``frames`` says whether
    messages are encoded as bytes and decoded. A `FeasibeeError` says if a program is too large.
    """
    (flash, ram), (no_flash, no_ram) = _linked(processor, strategy, setting, frames), _linked(processor)
    return flash - no_flash, ram - no_ram


@cache
def _linked(
    processor: Processor,
    strategy: Strategy | None = None,
    setting: Setting | None = None,
    frames: bool = False,
) -> tuple[int, int]:
    """Return the bytes in flash and in RAM of a program; without a strategy, it does nothing."""
    with tempfile.TemporaryDirectory() as folder:
        flags = ["-DNOTHING"] if strategy is None else _flags_of(strategy, setting, frames, folder)
        program = Path(folder, "program")
        output(*processor.compiler, *SHARED, *flags, str(SOURCE), "-o", str(program), *processor.link)
        return processor.bytes_of(program)


def _flags_of(strategy: Strategy, setting: Setting | None, frames: bool, folder: str) -> Iterator[str]:
    """Write the headers of a program with a strategy to a folder; yield the compiler's flags."""
    inbox = 1 if strategy.knowledge else INBOX
    Path(folder, "feasibee.h").write_text(firmware.header(strategy, inbox), encoding="utf-8")
    yield from (f"-I{folder}", f"-DSTRATEGY={firmware.constant(strategy)}")
    if frames:
        yield from ("-DFRAMES", f'-DNAME="{name_of(strategy)}"')
    if setting is not None and (strategy.knowledge or strategy.parameters):
        Path(folder, "swarm.h").write_text(setting_in_c(setting), encoding="utf-8")
        yield "-DSETTING"
    if setting is not None and strategy.knowledge:
        known, sent = strategy.row_lengths(setting)
        yield from ("-DKNOWLEDGE", f"-DFEASIBEE_WORDS={known}", f"-DFEASIBEE_MESSAGE_WORDS={sent}")
    if firmware.needs_double(strategy):
        yield from ("-DFEASIBEE_DOUBLE", "-DFEASIBEE_INT32")


def setting_in_c(setting: Setting) -> str:
    """Return a definition of ``setting`` in C."""
    fields = setting._asdict()
    cells, given = fields.pop("plan"), []
    parameters = ", ".join(f"FEASIBEE_REAL({value!r})" for value in fields.pop("parameters")) or "0"

    def rows(*, for_double: bool) -> list[str]:
        return [
            f"    .{name} = {str(value).lower()},"
            for name, value in fields.items()
            if (isinstance(value, float) or name in ("walled", "columns")) == for_double
        ]

    lines = ["static struct feasibee_setting setting = {", *rows(for_double=False)]
    lines += [f"    .parameters = {{{parameters}}},", "#ifdef FEASIBEE_DOUBLE", *rows(for_double=True)]
    if cells:
        given = [f"static const uint8_t plan[] = {{{', '.join(map(str, cells))}}};"]
        lines.append(f"    .plan = {{plan, {len(cells)}}},")
    return "\n".join([*given, *lines, "#endif", "};", ""])


def output(*command: str) -> str:
    """Return what a command printed; raise its program, its status and its first error if it fails."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        lines = done.stderr.strip().splitlines()
        said = next((each for each in lines if "error" in each or "region" in each), "".join(lines[-1:]))
        raise FeasibeeError(f"{command[0]}: ended with status {done.returncode}: {one_line(said)}")
    return done.stdout

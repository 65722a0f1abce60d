"""Flash and RAM of a robot's controller in C, compiled for the processors whose compilers are installed.

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
from importlib.util import find_spec
from pathlib import Path
from typing import Final, NamedTuple

from feasibee.errors import FeasibeeError, one_line
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
    size: str = ""

    @property
    def found(self) -> bool:
        """Whether its compiler is installed."""
        if "ziglang" in self.compiler:
            return find_spec("ziglang") is not None
        return shutil.which(self.compiler[0]) is not None

    def bytes_of(self, program: Path) -> tuple[int, int]:
        """Return the bytes of a program in flash and in RAM; of a WebAssembly module, its length and 0."""
        if not self.size:
            return program.stat().st_size, 0
        text, data, bss = map(int, output(self.size, str(program)).splitlines()[1].split()[:3])
        return text + data, data + bss


PROCESSORS: Final = {
    "ATmega328P": Processor(
        ("avr-gcc", "-mmcu=atmega328p", "-mcall-prologues"), "gcc-avr and avr-libc", size="avr-size"
    ),
    **{
        name: Processor(
            ("arm-none-eabi-gcc", "-mthumb", f"-mcpu={name.lower()}"),
            "gcc-arm-none-eabi and libnewlib-arm-none-eabi",
            ("--specs=nano.specs", "--specs=nosys.specs", "-lm"),
            "arm-none-eabi-size",
        )
        for name in ("Cortex-M0", "Cortex-M4")
    },
    "x86-64": Processor(("cc", "-m64"), "gcc", size="size"),
    "wasm32": Processor(
        (sys.executable, "-m", "ziglang", "cc", "-target", "wasm32-wasi"),
        "ziglang (PyPI)",
        ("-s", "-mexec-model=reactor", "-Wl,--no-entry", "-Wl,--export=run", "-lm"),
    ),
}
"""The processors, by name."""


def available() -> list[str]:
    """Return the processors for which there is a compiler here."""
    native = sys.platform == "linux" and platform.machine() == "x86_64"
    return [name for name, each in PROCESSORS.items() if each.found and (native or name != "x86-64")]


def size_of(
    processor: Processor, strategy: Strategy, setting: Setting | None = None, *, frames: bool = True
) -> tuple[int, int]:
    """Return the bytes in flash and in RAM of the controller of a robot.

    Parameters
    ----------
    processor : Processor
        One of `PROCESSORS` that is `available`.
    strategy : Strategy
        What the robot runs.
    setting : Setting, optional
        The numbers on which its knowledge depends, if it passes on any.
    frames : bool
        Whether messages are encoded as bytes and decoded.

    Raises
    ------
    FeasibeeError
        If the compiler fails, such as for a program that is too large.
    """
    (flash, ram), (no_flash, no_ram) = _linked(processor, strategy, setting, frames), _linked(processor, None)
    return flash - no_flash, ram - no_ram


@cache
def _linked(
    processor: Processor, strategy: Strategy | None, setting: Setting | None = None, frames: bool = False
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
    if strategy.knowledge and setting is not None:
        Path(folder, "swarm.h").write_text(setting_in_c(setting), encoding="utf-8")
        known, sent = strategy.row_lengths(setting)
        yield from ("-DKNOWLEDGE", f"-DFEASIBEE_WORDS={known}", f"-DFEASIBEE_MESSAGE_WORDS={sent}")
    if firmware.needs_double(strategy):
        yield from ("-DFEASIBEE_DOUBLE", "-DFEASIBEE_INT32")


def setting_in_c(setting: Setting) -> str:
    """Return a definition of ``setting`` in C."""
    whole = "robots count tasks robot_ids task_ids id_bits knows_count robot_classes task_classes".split()  # noqa: SIM905
    reals = "width height sight radio speed exploration dissemination mean_run".split()  # noqa: SIM905
    numbers = ", ".join(f"FEASIBEE_REAL({value!r})" for value in setting.parameters) or "0"
    return "\n".join(
        [
            "static struct feasibee_setting setting = {",
            *(f"    .{name} = {int(getattr(setting, name))}," for name in whole),
            f"    .parameters = {{{numbers}}},",
            "#ifdef FEASIBEE_DOUBLE",
            *(f"    .{name} = {getattr(setting, name)!r}," for name in reals),
            "#endif",
            "};",
            "",
        ]
    )


def output(*command: str) -> str:
    """Return what a command printed.

    Raises
    ------
    FeasibeeError
        If it fails: its program, its status, and its first error.
    """
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        lines = done.stderr.strip().splitlines()
        said = next((each for each in lines if "error" in each or "region" in each), "".join(lines[-1:]))
        raise FeasibeeError(f"{command[0]}: ended with status {done.returncode}: {one_line(said)}")
    return done.stdout

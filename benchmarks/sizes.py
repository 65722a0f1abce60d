"""Print flash and RAM of the C controller for each strategy and processor: make sizes.

A program that calls all functions of the header is linked for each strategy and processor. Its sizes less
those of a program that does nothing are what the controller takes. RAM is without the stack.
"""

from __future__ import annotations

import json
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from feasibee import firmware
from feasibee.strategies import STRATEGIES

SOURCE = Path(__file__).parent / "sizes.c"
INBOX = 32
"""Number of senders whose latest message the robots keep."""
SHARED = (
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


PROCESSORS = {
    "ATmega328P": Processor(("avr-gcc", "-mmcu=atmega328p"), "gcc-avr and avr-libc", size="avr-size"),
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
"""The processors of the table, by name."""


def available() -> list[str]:
    """Return the processors for which there is a compiler here."""
    native = sys.platform == "linux" and platform.machine() == "x86_64"
    return [name for name, each in PROCESSORS.items() if each.found and (native or name != "x86-64")]


@cache
def linked(name: str, strategy: str | None) -> tuple[int, int]:
    """Return the bytes in flash and in RAM of a program for a processor; None: it does nothing."""
    processor = PROCESSORS[name]
    with tempfile.TemporaryDirectory() as folder:
        flag = "-DNOTHING"
        if strategy is not None:
            Path(folder, "feasibee.h").write_text(firmware.header(strategy, INBOX), encoding="utf-8")
            flag = f"-DSTRATEGY=feasibee_{strategy.replace('-', '_')}"
        program = Path(folder, "program")
        command = [*processor.compiler, *SHARED, f"-I{folder}", flag, str(SOURCE), "-o", str(program)]
        output(*command, *processor.link)
        return processor.bytes_of(program)


def sizes(strategy: str, name: str) -> tuple[int, int]:
    """Return the bytes in flash and in RAM that the controller takes with a strategy on a processor."""
    (flash, ram), (least_flash, least_ram) = linked(name, strategy), linked(name, None)
    return flash - least_flash, ram - least_ram


def opinion_strategies() -> list[str]:
    """Return the strategies in C that pass on opinions only."""
    return [name for name in firmware.strategies_in_c() if not STRATEGIES[name].knowledge]


def row(strategy: str, names: Iterable[str]) -> dict[str, str | int]:
    """Return the row of a strategy: flash and RAM for each of some processors."""
    found: dict[str, str | int] = {"strategy": strategy}
    for name in names:
        flash, ram = sizes(strategy, name)
        found[f"{name} flash"] = flash
        if PROCESSORS[name].size:
            found[f"{name} RAM"] = ram
    return found


def output(*command: str) -> str:
    """Return what a command printed; if it fails, end with its errors."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(command)}\nended with status {done.returncode}:\n{done.stderr}")
    return done.stdout


def main() -> None:
    """Print the table, or JSON for claims/pages/targets.toml."""
    names = available()
    for name, processor in PROCESSORS.items():
        if name not in names:
            print(f"no {name}: its compiler is in {processor.packages}", file=sys.stderr)
    rows = [row(strategy, names) for strategy in opinion_strategies()]
    if "--json" in sys.argv[1:]:
        print(json.dumps(rows))
        return
    print(f"bytes, with {INBOX} senders, without the stack")
    for line in ([*rows[0]], *([*map(str, each.values())] for each in rows)):
        print("| " + " | ".join(line) + " |")


if __name__ == "__main__":
    main()

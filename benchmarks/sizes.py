"""Print flash and RAM of the C controller for each strategy and processor: make sizes.

A program that calls all functions of the header is linked for each strategy and processor. Its sizes less
those of a program that does nothing are what the controller takes. RAM is without the stack. There are three
tables: strategies that pass on opinions; what messages as bytes add to two of them; and strategies that
pass on knowledge, as bytes, for one swarm.
"""

from __future__ import annotations

import json
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from feasibee.robot import firmware
from feasibee.scenario.setting import setting_from
from feasibee.strategies import STRATEGIES
from feasibee.strategies.contract import Setting

SOURCE = Path(__file__).parent / "sizes.c"
INBOX = 32
"""Number of senders whose latest message the robots keep; 1 with knowledge, which counts no votes."""
SWARM = (20, 40)
"""Numbers of robots and tasks that strategies with knowledge can name."""
QUIET = 300.0
"""Quiet time in steps: without floating point it is given."""
FRAMED = ("dmmd", "dc")
"""Strategies for which the bytes that frames add are listed: one without a value, and one with."""
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
"""The processors of the table, by name."""


def available() -> list[str]:
    """Return the processors for which there is a compiler here."""
    native = sys.platform == "linux" and platform.machine() == "x86_64"
    return [name for name, each in PROCESSORS.items() if each.found and (native or name != "x86-64")]


def setting_of(strategy: str) -> Setting:
    """Return the setting of a strategy with knowledge in the swarm of the table."""
    built_in = STRATEGIES[strategy]
    parameters = built_in.parameters | ({"quiet": QUIET} if "quiet" in built_in.parameters else {})
    return setting_from(SWARM, (0, 0), False, None, parameters.values(), knows_count=built_in.needs_count)


def macros_of(strategy: str, setting: Setting) -> dict[str, int]:
    """Return the macros that a strategy with knowledge needs."""
    known, sent = STRATEGIES[strategy].row_lengths(setting)
    return {"FEASIBEE_WORDS": known, "FEASIBEE_MESSAGE_WORDS": sent}


def setting_in_c(setting: Setting) -> str:
    """Return a definition of ``setting`` in C."""
    names = (
        "robots",
        "count",
        "tasks",
        "robot_ids",
        "task_ids",
        "id_bits",
        "knows_count",
        "robot_classes",
        "task_classes",
    )
    reals = ("width", "height", "sight", "radio", "speed", "exploration", "dissemination", "mean_run")
    numbers = ", ".join(f"FEASIBEE_REAL({value!r})" for value in setting.parameters) or "0"
    return "\n".join(
        [
            "static struct feasibee_setting setting = {",
            *(f"    .{name} = {int(getattr(setting, name))}," for name in names),
            f"    .parameters = {{{numbers}}},",
            "#ifdef FEASIBEE_DOUBLE",
            *(f"    .{name} = {getattr(setting, name)!r}," for name in reals),
            "#endif",
            "};",
            "",
        ]
    )


def flags_of(strategy: str, frames: bool, folder: str) -> Iterator[str]:
    """Write the headers of a program with a strategy to a folder; yield the compiler's flags."""
    built_in = STRATEGIES[strategy]
    inbox = 1 if built_in.knowledge else INBOX
    Path(folder, "feasibee.h").write_text(firmware.header(strategy, inbox), encoding="utf-8")
    yield from (f"-I{folder}", f"-DSTRATEGY=feasibee_{strategy.replace('-', '_')}")
    if frames:
        yield from ("-DFRAMES", f'-DNAME="{strategy}"')
    if built_in.knowledge:
        setting = setting_of(strategy)
        Path(folder, "swarm.h").write_text(setting_in_c(setting), encoding="utf-8")
        yield "-DKNOWLEDGE"
        yield from (f"-D{name}={value}" for name, value in macros_of(strategy, setting).items())
    if firmware.needs_double(built_in):
        yield from ("-DFEASIBEE_DOUBLE", "-DFEASIBEE_INT32")


@cache
def linked(name: str, strategy: str | None, frames: bool = False) -> tuple[int, int]:
    """Return the bytes in flash and in RAM of a program for a processor; None: it does nothing."""
    processor = PROCESSORS[name]
    with tempfile.TemporaryDirectory() as folder:
        flags = ["-DNOTHING"] if strategy is None else flags_of(strategy, frames, folder)
        program = Path(folder, "program")
        output(*processor.compiler, *SHARED, *flags, str(SOURCE), "-o", str(program), *processor.link)
        return processor.bytes_of(program)


def sizes(strategy: str, name: str) -> tuple[int, int]:
    """Return the bytes in flash and in RAM of a controller; strategies with knowledge include frames."""
    return less(linked(name, strategy, STRATEGIES[strategy].knowledge), linked(name, None))


def added_by_frames(strategy: str, name: str) -> tuple[int, int]:
    """Return the bytes that messages as bytes add: encoding, decoding and checksum."""
    return less(linked(name, strategy, frames=True), linked(name, strategy))


def less(whole: tuple[int, int], part: tuple[int, int]) -> tuple[int, int]:
    """Return the difference of two sizes."""
    return whole[0] - part[0], whole[1] - part[1]


def names_in_c(*, knowledge: bool) -> list[str]:
    """Return the strategies in C that pass on knowledge, or opinions only."""
    return [name for name in STRATEGIES if STRATEGIES[name].knowledge == knowledge]


TABLES = {
    "opinions": (names_in_c(knowledge=False), sizes),
    "frames": (FRAMED, added_by_frames),
    "knowledge": (names_in_c(knowledge=True), sizes),
}
"""The tables: the strategies of each, and what measures one on a processor."""


def row(table: str, strategy: str, names: Iterable[str]) -> dict[str, str | int]:
    """Return the row of a strategy in a table: flash and RAM for each of some processors."""
    found: dict[str, str | int] = {"table": table, "strategy": strategy}
    for name in names:
        flash, ram = TABLES[table][1](strategy, name)
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
    """Print the tables, or JSON for claims/pages/targets.toml."""
    names = available()
    for name, processor in PROCESSORS.items():
        if name not in names:
            print(f"no {name}: its compiler is in {processor.packages}", file=sys.stderr)
    rows = [
        row(table, strategy, names) for table, (strategies, _) in TABLES.items() for strategy in strategies
    ]
    if "--json" in sys.argv[1:]:
        print(json.dumps(rows))
        return
    print("bytes, without the stack and the radio's memory")
    print(f"opinions: {INBOX} senders; knowledge: {SWARM[0]} robots, {SWARM[1]} tasks, with frames")
    for line in ([*rows[0]], *([*map(str, each.values())] for each in rows)):
        print("| " + " | ".join(line) + " |")


if __name__ == "__main__":
    main()

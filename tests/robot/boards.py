"""Programs on the C header that run on simulated boards, and the same steps in Python."""

from __future__ import annotations

import re
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple
from zlib import crc32

from benchmarks.sizes import PROCESSORS
from feasibee.robot import Controller, Declare, Message, Settings, Wire, firmware
from feasibee.robot.sizes import SHARED
from feasibee.strategies import STRATEGIES
from tests.robot.driving import Draws, constant, needs, run

SOURCES = Path(__file__).parent / "c"

CASES = [
    {},
    {"gain": 1_386_401, "exploration": 300_000, "listens_for": 0, "own_vote": False},
    {"gain": 200_001, "listens_for": 4, "dissemination_floor": 3, "quality_floor": 2},
    {"gain": 655_361, "inbox_size": 5, "declare": (3, 2, 2, 3)},
    {"every_message": True, "own_vote": False, "random_ties": True},
    {"stubborn": True, "exploration": 1},
]
"""Settings to try, durations in 1/65536 steps. An odd gain keeps means off whole steps, so off rounding.

A rule to declare is rounds, messages heard, quorum, of how many.
"""


class Board(NamedTuple):
    """A simulated board: its processor and simulator, how to link for it, how to read what it prints."""

    processor: str
    simulator: tuple[str, ...]
    package: str
    link: tuple[str, ...] = ()
    line: str = r"^(\w+)$"


CORTEX = (
    "-nographic",
    "-monitor",
    "none",
    "-serial",
    "none",
    "-semihosting-config",
    "enable=on,target=native",
)
LINK = ("-nostartfiles", "-T", str(SOURCES / "cortex.ld"), "--specs=nano.specs", "-lm")
BOARDS = {
    "ATmega328P": Board(
        "ATmega328P",
        ("simavr", "-m", "atmega328p", "-f", "16000000"),
        "simavr",
        ("-lm",),
        r"^(?:\x1b\[0m)?\x1b\[32m(\w+)\.$",
    ),
    "Cortex-M0": Board(
        "Cortex-M0", ("qemu-system-arm", "-M", "microbit", *CORTEX, "-kernel"), "qemu-system-arm", LINK
    ),
    "Cortex-M4": Board(
        "Cortex-M4",
        ("qemu-system-arm", "-M", "mps2-an386", *CORTEX, "-kernel"),
        "qemu-system-arm",
        (*LINK, "-Wl,--defsym=RAM_SIZE=256K"),
    ),
}


class Program(NamedTuple):
    """A program for a board, and its numbers of bytes in flash and RAM without the stack."""

    board: Board
    path: Path
    flash: int
    ram: int


def cases_of(strategy):
    """Return the settings that a strategy can have."""
    return [case for case in CASES if not (case.get("every_message") and STRATEGIES[strategy].value_bits)]


def in_c(cases, strategy):
    """Return the function that writes settings in C, and the strategy's parameters, if it has any."""
    lines = [
        f"    if (each == {number})\n        settings->{name} = {written(name, value)};"
        for number, case in enumerate(cases)
        for name, value in case.items()
    ]
    begin = "static void settings_of(int each, struct feasibee_settings *settings)\n{"
    lines = [f"#define CASES {len(cases)}", begin, *lines, "    (void)each, (void)settings;"]
    if STRATEGIES[strategy].parameters:
        parameters = f"{{.parameters = {constant(strategy)}_parameters}}"
        lines += [f"    static struct feasibee_setting setting = {parameters};"]
        lines += ["    settings->setting = &setting;"]
    return "\n".join([*lines, "}", ""])


def written(name, value):
    """Return the value of a setting in C."""
    if name == "declare":
        return f"(struct feasibee_declare){{{', '.join(map(str, value))}}}"
    if name in ("gain", "exploration"):
        return f"(feasibee_steps)({value} * (FEASIBEE_STEP / 65536.0))"
    return int(value)


def build(board, strategy, folder, steps, *flags):
    """Compile the program of ``steps.c`` for a board and a strategy."""
    (folder / "cases.h").write_text(in_c(cases_of(strategy), strategy))
    header = firmware.header(strategy=strategy, inbox=32)
    flags = (f"-DSTRATEGY={constant(strategy)}", f"-DSTEPS={steps}", *flags)
    return compiled(board, folder, header, SOURCES / "steps.c", *flags)


def compiled(board, folder, header, source, *flags):
    """Compile a program for a board."""
    board = BOARDS[board]
    processor = PROCESSORS[board.processor]
    needs(processor.compiler[0], processor.packages)
    (folder / "feasibee.h").write_text(header)
    path = folder / "program.elf"
    include = [f"-I{folder}", f"-I{SOURCES}"]
    run([*processor.compiler, *SHARED, *include, *flags, source, "-o", path, *board.link])
    return Program(board, path, *processor.bytes_of(path))


def outputs(program):
    """Run a program on its board; return the lines of states, and the bytes of stack that it used."""
    needs(program.board.simulator[0], program.board.package)
    printed = run([*program.board.simulator, str(program.path)])
    *lines, stack = re.findall(program.board.line, printed, re.MULTILINE)
    return lines, int(stack, 16)


def robot_of(strategy, number, case, draws):
    """Return the controller that a case of ``steps.c`` has."""
    case = dict(case)
    rounds, heard, quorum, of = case.pop("declare", (0, 0, 1, 1))
    stubborn = case.pop("stubborn", False)
    steps = {name: case.pop(name) / 65536 for name in ("gain", "exploration") if name in case}
    return Controller(
        STRATEGIES[strategy],
        opinion=number & 1,
        draw_duration=lambda mean: int(mean) + 1 + (draws.word() & 7),
        draw_choice=draws.choice,
        settings=Settings(
            declare=Declare(Fraction(quorum, of), rounds, heard) if rounds else None,
            inbox_size=case.pop("inbox_size", 32),
            **steps,
            **case,
        ),
        stubborn=stubborn,
    )


def expected(strategy, steps, frames=False):
    """Return the lines that ``steps.c`` prints, by the controller in Python."""
    return [
        line
        for number, case in enumerate(cases_of(strategy))
        for line in states(strategy, number, case, steps, frames)
    ]


def states(strategy, number, case, steps, frames=False):
    """Yield the state of a robot after each step, as ``steps.c`` prints it."""
    wire = Wire(STRATEGIES[strategy], 6, declares="declare" in case)
    draws = Draws(17 + number)
    robot = robot_of(strategy, number, case, draws)
    for _ in range(steps):
        word = draws.word()
        robot.observe(word & 3, word >> 2 & 3)
        for _ in range(word >> 4 & 3):
            heard = draws.word()
            if robot.listens:
                value = heard >> 16 if STRATEGIES[strategy].value_bits else 0
                robot.hear((heard & 255) % 40, Message(heard >> 8 & 1, value))
        said = robot.message()
        robot.end_step()
        flags = (robot.opinion + 1) | (robot.declared != -1) << 2 | robot.disseminating << 3
        told, value = (15, 0) if said is None else (said.opinion | said.declared << 1, said.value)
        sent = b"" if said is None else wire.encode(0, said)
        yield f"{flags:x}{robot.phase_left & 255:02x}{told:x}{value:04x}" + frames * f"{crc32(sent):08x}"

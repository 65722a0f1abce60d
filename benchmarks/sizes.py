"""Print flash and RAM of the C controller for each strategy and processor: make sizes.

There are three tables: strategies that pass on opinions; what messages as bytes add to two of them; and
strategies that pass on knowledge, as bytes, for one swarm. feasibee.robot.sizes says how they are measured.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable
from importlib.util import find_spec

from feasibee.robot import sizes as measured
from feasibee.robot.sizes import INBOX, Processor, size_of
from feasibee.scenario.setting import setting_from
from feasibee.strategies import STRATEGIES
from feasibee.strategies.contract import Setting

SWARM = (20, 40)
"""Numbers of robots and tasks that strategies with knowledge can name."""
QUIET = 300.0
"""Quiet time in steps: without floating point it is given."""


class WebAssembly(Processor):
    """WebAssembly, whose size is the length of its module."""

    @property
    def found(self):
        """Whether its compiler is installed."""
        return find_spec("ziglang") is not None

    def bytes_of(self, program):
        """Return the length of a module, and 0."""
        return program.stat().st_size, 0


ROOMY = measured.PROCESSORS["ATmega328P"]._replace(link=("-lm", "-Wl,--defsym=__DATA_REGION_LENGTH__=0xf000"))
PROCESSORS = {
    "ATmega328P": ROOMY,
    **{
        name: Processor(
            ("arm-none-eabi-gcc", "-mthumb", f"-mcpu={name.lower()}"),
            "gcc-arm-none-eabi and libnewlib-arm-none-eabi",
            ("--specs=nano.specs", "--specs=nosys.specs", "-lm"),
            "arm-none-eabi-size",
        )
        for name in ("Cortex-M0", "Cortex-M4")
    },
    "x86-64": measured.PROCESSORS["x86-64"],
    "wasm32": WebAssembly(
        (sys.executable, "-m", "ziglang", "cc", "-target", "wasm32-wasi"),
        "ziglang (PyPI)",
        ("-s", "-mexec-model=reactor", "-Wl,--no-entry", "-Wl,--export=run", "-lm"),
        "",
    ),
}
"""The processors of the tables. One has more RAM than it has, so that the table says how much is missing."""
FRAMED = ("dmmd", "dc")
"""Strategies for which the bytes that frames add are listed: one without a value, and one with."""


def setting_of(strategy: str) -> Setting | None:
    """Return the setting of a strategy with knowledge or parameters in the swarm of the table, else None."""
    built_in = STRATEGIES[strategy]
    if not (built_in.knowledge or built_in.parameters):
        return None
    parameters = built_in.parameters | ({"quiet": QUIET} if "quiet" in built_in.parameters else {})
    return setting_from(SWARM, (0, 0), False, None, parameters.values(), knows_count=built_in.needs_count)


def sizes(strategy: str, name: str) -> tuple[int, int]:
    """Return the bytes in flash and in RAM of a controller; strategies with knowledge include frames."""
    built_in = STRATEGIES[strategy]
    return size_of(PROCESSORS[name], built_in, setting_of(strategy), frames=built_in.knowledge)


def added_by_frames(strategy: str, name: str) -> tuple[int, int]:
    """Return the bytes that messages as bytes add: encoding, decoding and checksum."""
    framed, bare = (size_of(PROCESSORS[name], STRATEGIES[strategy], frames=each) for each in (True, False))
    return framed[0] - bare[0], framed[1] - bare[1]


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


def main() -> None:
    """Print the tables, or JSON for claims/pages/targets.toml."""
    names = [name for name, each in PROCESSORS.items() if each.found]
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

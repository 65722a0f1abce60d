"""The process that starts a field's robots: it loads what they need once, and forks once for each robot.

Forking 50 robots takes a fraction of the time of starting 50 interpreters. The commands come on standard
input, one a line: ``kill 3``, ``stop 3`` or ``cont 3``. When standard input ends, all robots are killed, so
that none outlives its field.
"""

from __future__ import annotations

import json
import os
import select
import signal
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from feasibee.errors import FeasibeeError, one_line
from feasibee.field.robot import KEY_VARIABLE, take_part
from feasibee.strategies.contract import Strategy

SIGNALS: Final = {"kill": "SIGKILL", "stop": "SIGSTOP", "cont": "SIGCONT"}
LOOK = 0.1
"""Seconds between looks at which robots have ended."""


def main() -> None:
    """Start the robots of an order, and wait until they have ended."""
    order = json.loads(sys.stdin.buffer.readline())
    strategy = None
    if order["strategy_file"] is not None:
        from feasibee.scenario.plugins import load

        strategy = load(order["strategy_file"])
    robots: dict[int, int] = {}
    for number in order["numbers"]:
        process = os.fork()
        if process == 0:
            os._exit(_robot(order, number, strategy))
        robots[number] = process
    _watch(robots)


def _robot(order: Mapping[str, Any], number: int, strategy: Strategy | None) -> int:
    """Run one robot; return its exit status."""
    os.close(sys.stdin.fileno())
    key = os.environ.get(KEY_VARIABLE, "").encode()
    log = Path(order["logs"]) / f"robot-{number}.jsonl" if order["logs"] else None
    try:
        status, why = take_part(
            order["connect"],
            number,
            transport=order["transport"],
            key=key,
            log=log,
            strategy=strategy,
            patience=order["patience"],
        )
    except FeasibeeError as error:
        status, why = 2, str(error)
    except Exception as error:  # a bug, or the user's strategy: one robot's failure, said at once
        status, why = 1, f"failed: {type(error).__name__}: {one_line(str(error))}"
    if why:
        os.write(2, f"feasibee: robot {number}: {why}\n".encode())
    return status


def _watch(robots: dict[int, int]) -> None:
    """Follow commands until all robots have ended; kill the rest when the field ends."""
    source = sys.stdin.fileno()
    unread = b""
    while robots:
        if select.select([source], [], [], LOOK)[0]:
            read = os.read(source, 4096)
            if not read:
                break
            *lines, unread = (unread + read).split(b"\n")
            for line in lines:
                what, which = line.decode().split()
                if int(which) in robots:
                    os.kill(robots[int(which)], getattr(signal, SIGNALS[what]))
            if lines:
                sys.stdout.write("done\n")
                sys.stdout.flush()
        for number, process in [*robots.items()]:
            if os.waitpid(process, os.WNOHANG)[0]:
                del robots[number]
    for process in robots.values():
        os.kill(process, signal.SIGKILL)
        os.waitpid(process, 0)


if __name__ == "__main__":
    main()

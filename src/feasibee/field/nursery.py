"""The process that starts a field's robots: it loads what they need once, and forks once for each robot.

Forking 50 robots takes a fraction of the time of starting 50 interpreters. The commands come on standard
input, one a line: ``start 3``, ``kill 3``, ``stop 3``, ``cont 3``, or ``end 0`` if no robot will be started
any more. When standard input ends, all robots are killed, so that none outlives its field.
"""

from __future__ import annotations

import json
import os
import select
import signal
import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any, Final

from feasibee.errors import FeasibeeError, one_line
from feasibee.field.robot import KEY_VARIABLE, take_part
from feasibee.strategies.contract import Strategy

SIGNALS: Final = {"kill": "SIGKILL", "stop": "SIGSTOP", "cont": "SIGCONT"}
LOOK = 0.1
"""Seconds between looks at which robots have ended."""


def main() -> None:
    """Start the robots of an order and those that come later, and wait until they have ended."""
    order = json.loads(sys.stdin.buffer.readline())
    if os.environ.get(KEY_VARIABLE):
        import_module("feasibee.field.noise")  # once for all robots
    strategy = None
    if order["strategy_file"] is not None:
        from feasibee.scenario.plugins import load

        strategy = load(order["strategy_file"])

    def start(number: int) -> int:
        process = os.fork()
        if process == 0:
            os._exit(_robot(order, number, strategy))
        return process

    _watch({number: start(number) for number in order["numbers"]}, start)


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


def _watch(robots: dict[int, int], start: Callable[[int], int]) -> None:
    """Follow commands until the last robot has ended; kill the rest when the field ends."""
    source = sys.stdin.fileno()
    unread = b""
    is_last = False
    while robots or not is_last:
        if select.select([source], [], [], LOOK)[0]:
            read = os.read(source, 4096)
            if not read:
                break
            *lines, unread = (unread + read).split(b"\n")
            for line in lines:
                what, which = line.decode().split()
                is_last |= what == "end"
                if what == "start":
                    robots[int(which)] = start(int(which))
                elif what in SIGNALS and int(which) in robots:
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

"""The process that starts a field's robots: it loads what they need once, and forks once for each robot.

Forking 50 robots takes a fraction of the time of starting 50 interpreters. The commands come on standard
input, one a line: ``start 3``, ``kill 3 5``, ``stop 3``, ``cont 3``, or ``end`` if no robot will be started
any more. The answer to each is a line, ``done``; any other line says why the field can't go on. When standard
input ends, all robots are killed, and when this process ends, they end by themselves.
"""

from __future__ import annotations

import os
import select
import signal
import socket
import sys
from collections.abc import Mapping
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any, Final

from feasibee.errors import FeasibeeError, one_line
from feasibee.field.parent import follow_parent, read_order
from feasibee.field.robot import KEY_VARIABLE, take_part
from feasibee.strategies.contract import Strategy

SIGNALS: Final = {"kill": "SIGKILL", "stop": "SIGSTOP", "cont": "SIGCONT"}
LOOK = 0.1
"""Seconds between looks at which robots have ended."""


def main() -> None:
    """Start the robots of an order and those that come later, and wait until they have ended."""
    order = read_order()
    try:
        if os.environ.get(KEY_VARIABLE):
            import_module("feasibee.field.noise")  # once for all robots
        strategy = None
        if order["strategy_file"] is not None:
            from feasibee.scenario.plugins import load

            strategy = load(order["strategy_file"])
        Nursery(order, strategy).watch()
    except (FeasibeeError, OSError) as error:  # OSError: no more processes
        _answer(one_line(str(error)))
        sys.exit(2)


class Nursery:
    """The processes of a field's robots.

    Parameters
    ----------
    order : mapping
        Which robots to start, and how.
    strategy : Strategy, optional
        The robots' strategy, if it is a file of the user.
    """

    def __init__(self, order: Mapping[str, Any], strategy: Strategy | None) -> None:
        self._order, self._strategy = order, strategy
        self._ours, self._theirs = socket.socketpair()
        self._robots: dict[int, int] = {}
        self._is_last = False

    def watch(self) -> None:
        """Follow commands until the last robot has ended; kill the rest when the field ends.

        Raises
        ------
        FeasibeeError
            If a robot can't go on because of its machine, such as a full disk.
        """
        try:
            for number in self._order["numbers"]:
                self._start(number)
            self._follow()
        finally:
            for process in self._robots.values():
                os.kill(process, signal.SIGKILL)
                os.waitpid(process, 0)

    def _follow(self) -> None:
        source = sys.stdin.fileno()
        unread = b""
        while self._robots or not self._is_last:
            ready = select.select([source, self._ours], [], [], LOOK)[0]
            if self._ours in ready:
                raise FeasibeeError(self._ours.recv(4096).decode().partition("\n")[0])
            if source in ready:
                read = os.read(source, 4096)
                if not read:
                    return
                *lines, unread = (unread + read).split(b"\n")
                for line in lines:
                    self._obey(*line.decode().split())
            for number, process in [*self._robots.items()]:
                if os.waitpid(process, os.WNOHANG)[0]:
                    del self._robots[number]

    def _obey(self, what: str, *numbers: str) -> None:
        self._is_last |= what == "end"
        for number in map(int, numbers):
            if what == "start":
                self._start(number)
            elif number in self._robots:
                os.kill(self._robots[number], getattr(signal, SIGNALS[what]))
        _answer("done")

    def _start(self, number: int) -> None:
        process = os.fork()
        if process == 0:
            status = 1
            try:
                status = self._robot(number)
            finally:
                os._exit(status)
        self._robots[number] = process

    def _robot(self, number: int) -> int:
        """Run one robot; return its exit status."""
        self._ours.close()
        follow_parent(self._theirs.fileno())
        os.close(sys.stdin.fileno())
        order = self._order
        try:
            status, why = take_part(
                order["connect"],
                number,
                key=os.environ.get(KEY_VARIABLE, "").encode(),
                log=Path(order["logs"]) / f"robot-{number}.jsonl" if order["logs"] else None,
                strategy=self._strategy,
                patience=order["patience"],
            )
        except FeasibeeError as error:  # of the machine: it would be that of other robots, too
            self._theirs.sendall(f"robot {number}: {error}\n".encode())
            return 2
        except Exception as error:  # a bug, or the user's strategy: one robot's failure, said at once
            status, why = 1, f"failed: {type(error).__name__}: {one_line(str(error))}"
        if why:
            os.write(2, f"feasibee: robot {number}: {why}\n".encode())
        return status


def _answer(line: str) -> None:
    """Write a line for the field; if the field has ended, nobody reads it."""
    with suppress(BrokenPipeError):
        sys.stdout.write(f"{line}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()

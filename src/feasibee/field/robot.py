"""The process of a robot: it joins a world, and steps in lockstep or by its own clock.

A robot needs the standard library only. Its settings come from the world. It ends when its world does.
"""

from __future__ import annotations

import json
import os
import random
import sys
import time
from collections.abc import Callable, Mapping
from contextlib import closing, nullcontext
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NoReturn, TextIO

from feasibee.base.errors import FeasibeeError, one_line
from feasibee.field.connections import (
    BYE,
    END,
    HEARD,
    HELLO,
    REFUSED,
    SAID,
    SIGHT,
    STEP,
    TICK,
    connection_to,
    packed,
)
from feasibee.field.logs import LineLog
from feasibee.field.node import HEARD_LIMIT, Node
from feasibee.strategies.contract import Strategy

GONE = 3
"""Exit status of a robot whose world has ended before the field has."""


def own_output() -> TextIO:
    """Return where the parent reads; from then on, what a strategy prints goes to standard error."""
    parent = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)
    sys.stdout = sys.stderr
    return parent


class Robot:
    """A robot of a field, by the orders of its world.

    Without a strategy of the user, it has the built-in one that the world names.
    """

    def __init__(
        self,
        orders: Mapping[str, Any],
        log: LineLog | None = None,
        strategy: Strategy | None = None,
        brain: Path | None = None,
    ) -> None:
        self.node = Node(orders, log.write if log else None, strategy=strategy, brain=brain)
        self._has_begun = False

    @property
    def held(self) -> dict[str, Any]:
        """What it reports: what its mind holds, and where it goes, if it acts."""
        return {"was": list(self.node.status), "goes": self.node.goes}

    @property
    def ready(self) -> dict[str, Any]:
        """What it reports before the first step."""
        return {"t": 0, "said": None, "ends": False, **self.held}

    def obey(self, kind: str, body: Mapping[str, Any]) -> dict[str, Any]:
        """Begin or end a step, as the world orders in lockstep; return what it reports."""
        if self._has_begun:  # a robot that was silent hasn't heard anything
            self.node.finish(body.get("heard", ()))
        self._has_begun = kind == STEP
        answer = {"t": body["t"], "said": None, "ends": kind == END, **self.held}
        if self._has_begun:
            answer["said"] = self.node.speak(body["t"], tuple(body["place"]), body.get("insight"))
            self.node.sense(body)
        return answer


class _EndedError(Exception):
    """The robot's part has ended, with an exit status and the reason why it could not join, if any."""


class _Part:
    """What a robot does in a world, by its connection."""

    def __init__(self, world: Connection) -> None:
        self._world = world

    def play(self, number: int, *about: Any) -> NoReturn:
        """Join a world, and step until the field ends: then raise an `_EndedError` with the exit status."""
        self._send(HELLO, {"robot": number})
        kind, orders = self._receive()
        if kind == REFUSED:
            raise _EndedError(2, orders["why"])
        robot = Robot(orders, *about)
        self._send(SAID, robot.ready)
        if orders["clock"]:
            self._free(robot, orders["settings"], orders["clock"])
        while True:
            kind, body = self._receive()
            if kind in (STEP, END):
                self._send(SAID, robot.obey(kind, body))

    def _free(self, robot: Robot, settings: Mapping[str, Any], clock: Mapping[str, float]) -> NoReturn:
        """Step by the robot's own clock, with what it saw and heard last."""
        self._seen: dict[str, Any] = {}
        self._heard: list[Any] = []
        self._place, self._insight = tuple(settings["place"]), None
        while not self._seen:  # the start
            self._take(*self._receive())
        noise, node = random.Random(), robot.node
        period = clock["period"] * (1.0 + clock["drift"])
        due = time.monotonic() + period * noise.random()
        first = step = settings["step"]
        while True:
            now = time.monotonic()
            if self._world.poll(max(0.0, due - now)):
                self._take(*self._receive())
            if now < due:
                continue
            if step > first:
                node.sense(self._seen)
                node.finish(self._heard)
                self._seen, self._heard = {"see": []}, []
            step += 1
            held = robot.held
            said = node.speak(step, self._place, self._insight)
            self._insight = None
            self._send(TICK, {"t": step, "said": said, **held})
            due += period * (1.0 + clock["jitter"] * (2.0 * noise.random() - 1.0))
            if time.monotonic() > due + period:  # it was stopped, or the machine is busy
                due = time.monotonic()

    def _take(self, kind: str, body: dict[str, Any]) -> None:
        """Keep what is seen or heard for the end of this step."""
        if kind == SIGHT:
            self._seen, self._place = body, tuple(body["place"])
            self._insight = body.get("insight") or self._insight
        elif kind == HEARD and len(self._heard) < HEARD_LIMIT:
            self._heard.append(body["heard"])

    def _send(self, kind: str, body: dict[str, Any]) -> None:
        try:
            self._world.send_bytes(packed(kind, body))
        except OSError:  # the world may have said the end before
            self._receive()

    def _receive(self) -> tuple[str, dict[str, Any]]:
        """Return kind and content of the next message; end when the world does."""
        try:
            kind, body = json.loads(self._world.recv_bytes())
        except (EOFError, OSError):
            raise _EndedError(GONE, "") from None
        if kind == BYE:
            raise _EndedError(0, "")
        return kind, body


def take_part(
    order: Mapping[str, Any], log: LineLog | None = None, strategy: Strategy | None = None
) -> tuple[int, str]:
    """Run the robot of an order until its world ends; return its status, and why it could not join.

    The order has the ``number``, the world's address (``connect``), and its program in C or "" (``brain``).
    """
    brain = Path(order["brain"]) if order["brain"] else None
    try:
        with connection_to(order["connect"]) as world:
            _Part(world).play(order["number"], log, strategy, brain)
    except _EndedError as ended:
        return ended.args


TakePart = Callable[[Mapping[str, Any], LineLog | None, Strategy | None], tuple[int, str]]
"""Runs a robot as `take_part` does, with its arguments."""


def main(take_part: TakePart = take_part) -> None:
    """Run the robot of the order in the first argument.

    A line on standard output says why the field can't go on, such as a full disk.
    """
    parent, order = own_output(), json.loads(sys.argv[1])
    number, strategy, status = order["number"], None, 2
    try:
        if order["strategy_file"] is not None:
            from feasibee.scenario.plugins import load

            strategy = load(order["strategy_file"])
        log = Path(order["logs"]) / f"robot-{number}.jsonl" if order["logs"] else None
        with closing(LineLog(log)) if log else nullcontext() as lines:
            status, why = take_part(order, lines, strategy)
    except FeasibeeError as error:  # of the machine: it would be that of other robots, too
        why = ""
        parent.write(f"robot {number}: {one_line(str(error))}\n")
    except Exception as error:  # a bug, or the user's strategy: one robot's failure, said at once
        status, why = 1, f"failed: {type(error).__name__}: {one_line(str(error))}"
    if why:
        os.write(2, f"feasibee: robot {number}: {why}\n".encode())
    sys.exit(status)


if __name__ == "__main__":
    main()

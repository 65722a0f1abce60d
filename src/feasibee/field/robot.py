"""The process of one robot: it joins a world, and steps in lockstep or by its own clock.

It needs the standard library only. Its settings come from the world.
"""

from __future__ import annotations

import random
import secrets
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from feasibee.field.checks import BYE, END, HEARD, HELLO, REFUSED, SAID, SIGHT, STEP, TICK, WELCOME
from feasibee.field.connections import Client
from feasibee.field.frames import Frame
from feasibee.field.linelog import LineLog
from feasibee.field.links import Link, split_address
from feasibee.field.node import HEARD_LIMIT, Node
from feasibee.strategies.contract import Strategy

RETRY = 0.2
"""Seconds after which a robot that has no answer asks again."""
IDLE = 1.0
"""Seconds after which a robot without orders lets the world know that it is there."""
KEPT = 2
"""Number of answers that a robot keeps: a world that starts again asks for the latest one."""
KEY_VARIABLE = "FEASIBEE_FIELD_KEY"
"""Environment variable of the shared key."""
GONE = 3
"""Exit status of a robot whose world is silent."""


class Robot:
    """A robot of a field.

    Parameters
    ----------
    link : Link
        To the world.
    key : bytes
        The shared key; empty for none.
    number : int
        The robot's number.
    log : LineLog, optional
        Its log.
    strategy : Strategy, optional
        A strategy of the user; by default the built-in one that the world names.
    patience : float
        Seconds of silence after which the world is gone.
    """

    def __init__(
        self,
        link: Link,
        key: bytes,
        number: int,
        log: LineLog | None = None,
        strategy: Strategy | None = None,
        patience: float = 20.0,
    ) -> None:
        self._hello = HELLO, {"robot": number, "nonce": secrets.randbits(63)}
        self._client = Client(link, key, lambda: self._hello)
        self._log, self._strategy, self._patience = log, strategy, patience
        self._heard_at = time.monotonic()
        self.why = ""

    def run(self) -> int:
        """Join and take part until the end; return the exit status."""
        orders = self._join()
        if orders is None:
            return 2 if self.why else GONE
        if not orders:
            return 0
        self._node = Node(orders, self._log.write if self._log else None, strategy=self._strategy)
        self._place = tuple(orders["settings"]["place"])
        self._first = orders["settings"]["step"]
        self._insight: Any = None
        self._ready = {"t": 0, "said": None, "was": list(self._node.status), "ends": False}
        self._client.send(SAID, self._ready)
        return self._free(orders["clock"]) if orders["clock"] else self._lockstep()

    def _join(self) -> dict[str, Any] | None:
        """Ask the world for the robot's settings until it answers; return nothing if it has ended."""
        asked = 0.0
        while not self._is_alone():
            if time.monotonic() - asked > RETRY:
                self._client.send(*self._hello)
                asked = time.monotonic()
            frame = self._receive(RETRY)
            if frame is not None and frame.kind == BYE:
                return {}
            if frame is not None and frame.kind == REFUSED:
                self.why = frame.body["why"]
                return None
            if frame is not None and frame.kind == WELCOME:
                return frame.body
        return None

    def _lockstep(self) -> int:
        """Answer each order of the world; one that comes again gets the same answer."""
        self._answers = {(0, False): self._ready}
        self._has_begun = False
        sent = time.monotonic()
        while not self._is_alone():
            frame = self._receive(RETRY)
            if frame is not None and frame.kind == BYE:
                return 0
            if frame is not None and frame.kind in (STEP, END):
                self._obey(frame)
                sent = time.monotonic()
            elif time.monotonic() - sent > IDLE:
                self._client.send(SAID, self._answers[max(self._answers)])
                sent = time.monotonic()
        return GONE

    def _obey(self, frame: Frame) -> None:
        """Begin a step or end one, unless this has been done."""
        body, ends = frame.body, frame.kind == END
        order = body["t"], ends
        if order > max(self._answers):
            if self._has_begun:  # a robot that was silent hasn't heard anything
                self._node.finish(body.get("heard", ()))
            self._has_begun = not ends
            answer = {"t": body["t"], "was": list(self._node.status), "said": None, "ends": ends}
            if not ends:
                answer["said"] = self._node.speak(body["t"], tuple(body["place"]), body.get("insight"))
                self._node.sense(body["see"])
            self._answers[order] = answer
            while len(self._answers) > KEPT:
                del self._answers[min(self._answers)]
        if order in self._answers:
            self._client.send(SAID, self._answers[order])

    def _free(self, clock: Mapping[str, float]) -> int:
        """Step by the robot's own clock, with what it saw and heard last."""
        self._see: list[Any] = []
        self._heard: list[Any] = []
        if not self._wait_for_start():
            return GONE
        noise = random.Random()
        period = clock["period"] * (1.0 + clock["drift"])
        due = time.monotonic() + period * noise.random()
        step = self._first
        while not self._is_alone():
            now = time.monotonic()
            if now < due:
                frame = self._receive(due - now)
                if frame is not None and frame.kind == BYE:
                    return 0
                if frame is not None:
                    self._take(frame)
                continue
            if step > self._first:
                self._node.sense(self._see)
                self._node.finish(self._heard)
                self._see, self._heard = [], []
            step += 1
            was = list(self._node.status)
            said = self._node.speak(step, self._place, self._insight)
            self._insight = None
            self._client.send(TICK, {"t": step, "said": said, "was": was})
            due += period * (1.0 + clock["jitter"] * (2.0 * noise.random() - 1.0))
            if time.monotonic() > due + period:  # it was stopped, or the machine is busy
                due = time.monotonic()
        return GONE

    def _wait_for_start(self) -> bool:
        while not self._is_alone():
            frame = self._receive(RETRY)
            if frame is not None and frame.kind == SIGHT:
                self._take(frame)
                return True
            self._client.send(SAID, self._ready)
        return False

    def _take(self, frame: Frame) -> None:
        """Keep what is seen or heard for the end of this step."""
        body = frame.body
        if frame.kind == SIGHT:
            self._see, self._place = body["see"], tuple(body["place"])
            self._insight = body.get("insight") or self._insight
        elif frame.kind == HEARD:
            if len(self._heard) < HEARD_LIMIT:
                self._heard.append(body["heard"])
            else:
                self._node.dropped["too many messages"] += 1

    def _receive(self, timeout: float) -> Frame | None:
        """Return the world's next packet, or None if none comes in so many seconds."""
        frame = self._client.receive(timeout)
        if frame is not None:
            self._heard_at = time.monotonic()
        return frame

    def _is_alone(self) -> bool:
        """Whether the world has been silent for too long."""
        return time.monotonic() - self._heard_at > self._patience


def take_part(
    connect: str,
    number: int,
    *,
    key: bytes = b"",
    log: Path | None = None,
    strategy: Strategy | None = None,
    patience: float = 20.0,
) -> tuple[int, str]:
    """Run a robot until its world ends; return the exit status, and why it could not join, if it couldn't."""
    link = Link(*split_address(connect), listens=False)
    lines = None
    try:
        lines = LineLog(log) if log is not None else None
        robot = Robot(link, key, number, lines, strategy, patience)
        return robot.run(), robot.why
    finally:
        link.close()
        if lines is not None:
            lines.close()

"""The processes of robots: each joins a world, and steps in lockstep or by its own clock.

A robot needs the standard library only. Its settings come from the world.

Run as a program, this module is the nursery, which starts a field's robots: it loads what they need once, and
forks once for each robot. Forking 50 robots takes a fraction of the time of starting 50 interpreters.

Commands come on standard input, one a line: ``start 3``, ``kill 3 5``, ``pause 3``, ``resume 3``, or ``end``
if no robot will be started any more. Each is answered by a line, ``done``; any other line says why the field
can't go on. When standard input ends, all robots are killed. When the nursery ends, they end by themselves.
"""

from __future__ import annotations

import json
import os
import random
import secrets
import select
import signal
import socket
import sys
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack, closing, suppress
from importlib import import_module
from pathlib import Path
from threading import Thread
from typing import Any, Final, NoReturn, TextIO

from feasibee.errors import FeasibeeError, one_line
from feasibee.field.checks import BYE, END, HEARD, HELLO, REFUSED, SAID, SIGHT, STEP, TICK, WELCOME
from feasibee.field.connections import Client, Frame, Link, split_address
from feasibee.field.logs import LineLog
from feasibee.field.node import HEARD_LIMIT, Node
from feasibee.field.plan import KILL, PAUSE, RESUME
from feasibee.strategies.contract import Strategy


def read_order() -> tuple[dict[str, Any], TextIO]:
    """Return the order on standard input, and where the parent reads; without one, end as the parent did.

    From then on, what a user's strategy prints goes to standard error, and isn't taken for an answer.
    """
    parent = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)
    sys.stdout = sys.stderr
    line = sys.stdin.buffer.readline()
    if not line.endswith(b"\n"):
        os._exit(1)
    order: dict[str, Any] = json.loads(line)
    return order, parent


def follow_parent(
    source: int,
    heed: Callable[[bytes], object] = lambda _: None,
    at_end: Callable[[], object] = lambda: None,
) -> Thread:
    """Start and return a thread that ends this process, after ``at_end``, when the pipe of its parent ends.

    Only the parent may have the pipe's end for writing. ``heed`` takes what it writes.
    """

    def follow() -> None:
        while read := os.read(source, 4096):  # not a file object: the exit would wait for its lock
            heed(read)
        at_end()
        os._exit(1)

    thread = Thread(target=follow, daemon=True)
    thread.start()
    return thread


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


class _EndedError(Exception):
    """The robot's part has ended, with an exit status and the reason why it could not join, if any."""


class Robot:
    """A robot of a field, whose world is gone after so many seconds of silence (patience).

    Without a strategy of the user, it has the built-in one that the world names.
    """

    def __init__(
        self,
        link: Link,
        key: bytes,
        number: int,
        log: LineLog | None = None,
        strategy: Strategy | None = None,
        patience: float = 20.0,
        brain: Path | None = None,
    ) -> None:
        self._hello = HELLO, {"robot": number, "nonce": secrets.randbits(63)}
        self._client = Client(link, key, lambda: self._hello)
        self._log, self._strategy, self._patience, self._brain = log, strategy, patience, brain
        self._heard_at = time.monotonic()

    def run(self) -> tuple[int, str]:
        """Let the robot take part until the field ends; return its exit status, and why it could not join."""
        try:
            self._take_part(self._join())
        except _EndedError as ended:
            return ended.args

    def _take_part(self, orders: dict[str, Any]) -> NoReturn:
        write = self._log.write if self._log else None
        self._node = Node(orders, write, strategy=self._strategy, brain=self._brain)
        self._place = tuple(orders["settings"]["place"])
        self._first = orders["settings"]["step"]
        self._insight: Any = None
        self._ready = {"t": 0, "said": None, "ends": False, **self._held}
        self._client.send(SAID, self._ready)
        if orders["clock"]:
            self._free(orders["clock"])
        self._lockstep()

    @property
    def _held(self) -> dict[str, Any]:
        """What it reports: what its mind holds, and where it goes, if it acts."""
        return {"was": list(self._node.status), "goes": self._node.goes}

    def _join(self) -> dict[str, Any]:
        """Ask the world for the robot's settings until it answers."""
        asked = 0.0
        while True:
            if time.monotonic() - asked > RETRY:
                self._client.send(*self._hello)
                asked = time.monotonic()
            frame = self._receive(RETRY)
            if frame is not None and frame.kind == REFUSED:
                raise _EndedError(2, frame.body["why"])
            if frame is not None and frame.kind == WELCOME:
                return frame.body

    def _lockstep(self) -> NoReturn:
        """Answer each order of the world; one that comes again gets the same answer."""
        self._answers = {(0, False): self._ready}
        self._has_begun = False
        sent = time.monotonic()
        while True:
            frame = self._receive(RETRY)
            if frame is not None and frame.kind in (STEP, END):
                self._obey(frame)
                sent = time.monotonic()
            elif time.monotonic() - sent > IDLE:
                self._client.send(SAID, self._answers[max(self._answers)])
                sent = time.monotonic()

    def _obey(self, frame: Frame) -> None:
        """Begin a step or end one, unless this has been done."""
        body, ends = frame.body, frame.kind == END
        order = body["t"], ends
        if order > max(self._answers):
            if self._has_begun:  # a robot that was silent hasn't heard anything
                self._node.finish(body.get("heard", ()))
            self._has_begun = not ends
            answer = {"t": body["t"], "said": None, "ends": ends, **self._held}
            if not ends:
                answer["said"] = self._node.speak(body["t"], tuple(body["place"]), body.get("insight"))
                self._node.sense(body)
            self._answers[order] = answer
            while len(self._answers) > KEPT:
                del self._answers[min(self._answers)]
        if order in self._answers:
            self._client.send(SAID, self._answers[order])

    def _free(self, clock: Mapping[str, float]) -> NoReturn:
        """Step by the robot's own clock, with what it saw and heard last."""
        self._seen: dict[str, Any] = {}
        self._heard: list[Any] = []
        while (frame := self._receive(RETRY)) is None or frame.kind != SIGHT:  # the start
            self._client.send(SAID, self._ready)
        self._take(frame)
        noise = random.Random()
        period = clock["period"] * (1.0 + clock["drift"])
        due = time.monotonic() + period * noise.random()
        step = self._first
        while True:
            now = time.monotonic()
            frame = self._receive(max(0.0, due - now))
            if frame is not None:
                self._take(frame)
            if now < due:
                continue
            if step > self._first:
                self._node.sense(self._seen)
                self._node.finish(self._heard)
                self._seen, self._heard = {"see": []}, []
            step += 1
            held = self._held
            said = self._node.speak(step, self._place, self._insight)
            self._insight = None
            self._client.send(TICK, {"t": step, "said": said, **held})
            due += period * (1.0 + clock["jitter"] * (2.0 * noise.random() - 1.0))
            if time.monotonic() > due + period:  # it was stopped, or the machine is busy
                due = time.monotonic()

    def _take(self, frame: Frame) -> None:
        """Keep what is seen or heard for the end of this step."""
        body = frame.body
        if frame.kind == SIGHT:
            self._seen, self._place = body, tuple(body["place"])
            self._insight = body.get("insight") or self._insight
        elif frame.kind == HEARD:
            if len(self._heard) < HEARD_LIMIT:
                self._heard.append(body["heard"])
            else:
                self._node.dropped["too many messages"] += 1

    def _receive(self, timeout: float) -> Frame | None:
        """Return the next packet, or None if none comes in so many seconds; end when the world does."""
        if time.monotonic() - self._heard_at > self._patience:
            raise _EndedError(GONE, "")
        frame = self._client.receive(timeout)
        if frame is not None:
            self._heard_at = time.monotonic()
            if frame.kind == BYE:
                raise _EndedError(0, "")
        return frame


def take_part(
    connect: str,
    number: int,
    *,
    key: bytes = b"",
    log: Path | None = None,
    strategy: Strategy | None = None,
    patience: float = 20.0,
    brain: Path | None = None,
) -> tuple[int, str]:
    """Run a robot until its world ends; return what `Robot.run` does."""
    with ExitStack() as opened:
        link = opened.enter_context(closing(Link(*split_address(connect), listens=False)))
        lines = opened.enter_context(closing(LineLog(log))) if log is not None else None
        return Robot(link, key, number, lines, strategy, patience, brain).run()


TakePart = Callable[..., tuple[int, str]]
"""Runs a robot as `take_part` does, with its arguments."""
SIGNALS: Final = {KILL: "SIGKILL", PAUSE: "SIGSTOP", RESUME: "SIGCONT"}
"""Faults of robots' processes, and how they are caused."""
LOOK = 0.1
"""Seconds between looks at which robots have ended."""


def main(take_part: TakePart = take_part) -> None:
    """Start the robots of an order and those that come later, and wait until they have ended."""
    order, parent = read_order()
    try:
        if os.environ.get(KEY_VARIABLE):
            import_module("feasibee.field.noise")  # once for all robots
        strategy = None
        if order["strategy_file"] is not None:
            from feasibee.scenario.plugins import load

            strategy = load(order["strategy_file"])
        Nursery(order, strategy, parent, take_part).watch()
    except (FeasibeeError, OSError) as error:  # OSError: no more processes
        with suppress(BrokenPipeError):
            parent.write(f"{one_line(str(error))}\n")
        sys.exit(2)


class Nursery:
    """The processes of a field's robots, started by an order; the field reads answers from ``parent``.

    In each of them, ``take_part`` runs its robot.
    """

    def __init__(
        self, order: Mapping[str, Any], strategy: Strategy | None, parent: TextIO, take_part: TakePart
    ) -> None:
        self._order, self._strategy, self._parent, self._take_part = order, strategy, parent, take_part
        self._ours, self._theirs = socket.socketpair()
        self._robots: dict[int, int] = {}
        self._is_last = False

    def watch(self) -> None:
        """Follow commands until the last robot has ended; kill the rest when the field ends.

        Raise a FeasibeeError if a robot can't go on because of its machine, such as a full disk.
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
                gone, status = os.waitpid(process, os.WNOHANG)
                if gone:
                    del self._robots[number]
                    if os.WIFSIGNALED(status) and os.WTERMSIG(status) != signal.SIGKILL:  # not by a fault
                        name = signal.Signals(os.WTERMSIG(status)).name
                        os.write(2, f"feasibee: robot {number}: ended by {name}\n".encode())

    def _obey(self, what: str, *numbers: str) -> None:
        self._is_last |= what == "end"
        for number in map(int, numbers):
            if what == "start":
                self._start(number)
            elif number in self._robots:
                os.kill(self._robots[number], getattr(signal, SIGNALS[what]))
        with suppress(BrokenPipeError):  # the field has ended
            self._parent.write("done\n")

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
        self._parent.close()  # the pipe ends with the nursery, though a stopped robot lives on
        order = self._order
        try:
            status, why = self._take_part(
                order["connect"],
                number,
                key=os.environ.get(KEY_VARIABLE, "").encode(),
                log=Path(order["logs"]) / f"robot-{number}.jsonl" if order["logs"] else None,
                strategy=self._strategy,
                patience=order["patience"],
                brain=Path(order["brain"]) if order["brain"] else None,
            )
        except FeasibeeError as error:  # of the machine: it would be that of other robots, too
            self._theirs.sendall(f"robot {number}: {error}\n".encode())
            return 2
        except Exception as error:  # a bug, or the user's strategy: one robot's failure, said at once
            status, why = 1, f"failed: {type(error).__name__}: {one_line(str(error))}"
        if why:
            os.write(2, f"feasibee: robot {number}: {why}\n".encode())
        return status


if __name__ == "__main__":
    main()

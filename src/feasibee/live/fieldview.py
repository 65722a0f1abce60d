"""A field as a viewer sees it: a thread receives its steps, and keeps them for the pages."""

from __future__ import annotations

import secrets
import time
from bisect import bisect_right
from collections.abc import Mapping
from threading import Condition, Thread
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.errors import FeasibeeError, one_line
from feasibee.field.addresses import split_address
from feasibee.field.checks import MARKS, REFUSED, SCENE, STATE, VIEW
from feasibee.field.frames import Frame, Frames
from feasibee.field.links import Link, open_link
from feasibee.simulation.snapshot import FLAGS, Snapshot

JOINING: Final = 5.0
"""Seconds that a field has to answer."""
SILENCE: Final = 5.0
"""Seconds without a packet after which a field is silent."""
ASKING: Final = 1.0
"""Seconds between two packets of a viewer."""
RETRY: Final = 0.2
"""Seconds between two packets of a viewer that has nothing yet."""
ROOM: Final = 64 * 2**20
"""Most bytes of the steps that are kept; the oldest ones go first."""
FIXED: Final = 2000
"""Bytes of a step in addition to those per robot, about."""
CURVE_LIMIT: Final = 200_000
"""Most steps of the curves of counts."""


class View(NamedTuple):
    """One step of a field."""

    step: int
    shown: Snapshot
    counts: tuple[int, int, int]
    """Robots that hold feasible, that hold infeasible, and that count."""
    declared: tuple[int, int]
    decision: tuple[int, int, int]
    """The opinion at this step, the first decision and its step."""
    lost: tuple[int, ...]
    """Numbers of the robots whose processes are silent."""
    is_cut: bool
    """Whether the radio is cut between the two halves of the robots."""
    tasks: NDArray[np.uint16]
    """Positions of the tasks in a world that changes, shape (tasks, 2); none in another one."""
    truth: bool
    """Whether the tasks of this step are feasible."""


class FieldView:
    """The steps of a field that have been received.

    Parameters
    ----------
    address : str
        Address of the field's world, HOST:PORT.
    transport : str
        ``"udp"`` or ``"zenoh"``.
    key : bytes
        The shared key; empty for none.
    """

    def __init__(self, address: str, transport: str = "udp", key: bytes = b"") -> None:
        host, port = split_address(address)
        self.address = address
        self._number = secrets.randbelow(2**16)
        name = f"viewer-{secrets.token_hex(8)}"
        self._link: Link = open_link(transport, host, port, listens=False, name=name)
        self._frames, self._nonce = Frames(0, key), secrets.randbits(63)
        self.scene: dict[str, Any] = {}
        self.views: list[View] = []
        self.first = 0
        self._curves: list[tuple[int, ...]] = []
        self.has_ended = False
        self._why = ""
        self._heard_at = time.monotonic()
        self._asked_at = 0.0
        self._closed = False
        self._changed = Condition()

    def join(self) -> None:
        """Wait until the field answers; then receive in a thread.

        Raises
        ------
        FeasibeeError
            If no field answers, or it takes no viewer.
        """
        until = time.monotonic() + JOINING
        while not self.scene:
            self.receive()
            if self._why or time.monotonic() > until:
                self._link.close()
                raise FeasibeeError(f"{self.address}: {self._why or self._no_answer()}")
        Thread(target=self._receive_all, daemon=True).start()

    def _no_answer(self) -> str:
        port = self.address.rpartition(":")[2]
        return (
            f"no field answers; start feasibee field --port {port}, or check the address and that "
            "--key-file gives its key"
        )

    def close(self) -> None:
        """Receive no more."""
        self._closed = True

    @property
    def is_silent(self) -> bool:
        """Whether the field says nothing any more, though it hasn't ended."""
        return not self.has_ended and time.monotonic() - self._heard_at > SILENCE

    @property
    def latest(self) -> int:
        """The newest step that was received; -1 before the first one."""
        return self.views[-1].step if self.views else -1

    def at(self, step: int) -> View:
        """Return a step that was received, or the last one before it that is kept."""
        place = bisect_right(self.views, step, key=lambda each: each.step)
        return self.views[max(0, place - 1)]

    def counts(self, first: int, until: int) -> NDArray[np.int32]:
        """Return counts and truth of steps from one to before another: int32, shape (steps, 4)."""
        found = self._curves[max(0, first - self.first) : max(0, until - self.first)]
        return np.array(found, np.int32).reshape(-1, 4)

    def wait_for(self, step: int, seconds: float) -> bool:
        """Wait until a step or a later one has come; return whether it has."""
        with self._changed:
            return self._changed.wait_for(lambda: self.latest >= step, seconds)

    def _receive_all(self) -> None:
        while not self._closed and not self.has_ended:
            self.receive()
        self._link.close()

    def receive(self) -> None:
        """Ask the field for more if it is time, and take its next packet, if one comes soon."""
        now = time.monotonic()
        if now - self._asked_at > (ASKING if self.views else RETRY):
            self._ask(now)
        received = self._link.receive(RETRY)
        frame = self._frames.read(received[0]) if received else None
        if frame is not None:
            self._take(frame)

    def _ask(self, now: float) -> None:
        if self.is_silent and self.scene:  # perhaps another viewer has the same number
            self._number = secrets.randbelow(2**16)
        body = {"nonce": self._nonce, "has": bool(self.scene)}
        self._link.send(self._frames.write(VIEW, self._number, body))
        self._asked_at = now

    def _take(self, frame: Frame) -> None:
        body = frame.body
        if frame.kind == STATE and self.scene and self._fits(body):
            self._keep(body)
        elif body.get("nonce") != self._nonce:
            return
        elif frame.kind == VIEW and "session" in body:
            self._frames.session = body["session"]
            self._asked_at = 0.0
        elif frame.kind == SCENE and body["faults"]:
            self.scene = self.scene or body
        elif frame.kind == REFUSED:
            self._why = one_line(str(body.get("why")))[:300]
            return
        self._heard_at = time.monotonic()

    def _fits(self, body: Mapping[str, Any]) -> bool:
        """Return whether a step is of robots that this field may have."""
        numbers = {*body["numbers"], *body["lost"]}
        return max(numbers, default=0) < len(self.scene["faults"])

    def _keep(self, body: Mapping[str, Any]) -> None:
        """Keep a step; while all steps take too much memory, drop the oldest ones."""
        view = view_of(body, len(self.scene["faults"]))
        known = *view.counts, int(view.truth)
        with self._changed:
            if not self.views:
                self.first = view.step
            missing = view.step - self.latest if self.views else 1
            if missing > 0 and view.step - self.first < CURVE_LIMIT:
                before = self._curves[-1:] or [known]
                self._curves += [*before * (missing - 1), known]  # packets that were lost
            if missing > 0:
                self.views.append(view)
            elif view.step == self.latest:  # a robot may have fallen silent meanwhile
                self.views[-1] = view
            most = max(2, ROOM // (FIXED + 7 * len(self.scene["faults"])))
            del self.views[: max(0, len(self.views) - most)]
            self.has_ended = body["end"]
            self._changed.notify_all()


def view_of(body: Mapping[str, Any], robots: int) -> View:
    """Return a step as pages draw it, with a row for each of so many numbers that robots may have.

    A silent robot has no opinion and doesn't work.
    """
    there = body["numbers"]

    def rows(values: Any, dtype: type[np.generic]) -> NDArray[Any]:
        found = np.zeros(robots, dtype)
        found[there] = values
        return found

    lost = np.zeros(robots, np.bool_)
    lost[body["lost"]] = True
    opinions, marks = rows(body["opinions"], np.int8), rows(body["marks"], np.uint16)
    having = {name: (marks >> bit & 1).astype(np.bool_) for bit, name in enumerate(MARKS)}
    having |= {
        "feasible": (opinions == 1) & ~lost,
        "neutral": (opinions == -1) | lost,
        "there": rows(True, np.bool_),
    }
    for name in ("disseminating", "working"):
        having[name] = having[name] & ~lost
    flags = np.zeros(robots, np.uint16)
    for bit, name in enumerate(FLAGS):
        flags |= having[name].astype(np.uint16) << np.uint16(bit)
    x, y = np.array(body["places"], np.uint16).reshape(-1, 2).T
    headings = rows(body["headings"], np.uint8)
    shown = Snapshot(rows(x, np.uint16), rows(y, np.uint16), flags, headings)
    tasks = np.array(body["tasks"], np.uint16).reshape(-1, 2)
    numbers: dict[str, Any] = {name: tuple(body[name]) for name in ("counts", "declared", "decision", "lost")}
    return View(body["t"], shown, is_cut=body["cut"], tasks=tasks, truth=body["truth"], **numbers)

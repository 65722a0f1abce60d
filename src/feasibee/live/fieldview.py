"""A viewer of the fields at one address: a thread receives their steps, and keeps them for the pages."""

from __future__ import annotations

import time
from threading import Condition, Thread
from typing import Any, Final

from feasibee.errors import FeasibeeError, one_line
from feasibee.field.checks import REFUSED, SCENE, STATE, VIEW
from feasibee.field.connections import Client
from feasibee.field.frames import Frame
from feasibee.field.links import Link, split_address
from feasibee.live.fieldsteps import FieldSteps

JOINING: Final = 5.0
"""Seconds that a field has to answer."""
SILENCE: Final = 5.0
"""Seconds without a packet after which a field is silent."""
ASKING: Final = 1.0
"""Seconds between two packets of a viewer."""
RETRY: Final = 0.2
"""Seconds between two packets of a viewer that has nothing yet."""


class FieldView:
    """A viewer of a field; when that has ended or is silent, of the next one at its address.

    Parameters
    ----------
    address : str
        Address of the field's world, HOST:PORT.
    key : bytes
        The shared key; empty for none.
    """

    def __init__(self, address: str, key: bytes = b"") -> None:
        host, port = split_address(address)
        self.address = address
        self._link = Link(host, port, listens=False)
        self._key = key
        self._session = 0
        self._steps: FieldSteps | None = None
        self._why = ""
        self._heard_at = time.monotonic()
        self._asked_at = 0.0
        self._closed = False
        self._changed = Condition()
        self._look()

    def join(self) -> None:
        """Wait until the field answers; then receive in a thread.

        Raises
        ------
        FeasibeeError
            If no field answers, or it takes no viewer.
        """
        until = time.monotonic() + JOINING
        while self._steps is None:
            self.receive()
            if self._why or time.monotonic() > until:
                self._link.close()
                raise FeasibeeError(f"{self.address}: {self._why or self._no_answer()}")
        Thread(target=self._receive_all, daemon=True).start()

    def _no_answer(self) -> str:
        port = self.address.rpartition(":")[2]
        return (
            f"no field answers; start feasibee launch --port {port}, or check the address and that "
            "--key-file gives its key"
        )

    def close(self) -> None:
        """Receive no more."""
        self._closed = True

    @property
    def field(self) -> FieldSteps:
        """The steps of the newest field, which has answered."""
        assert self._steps is not None
        return self._steps

    @property
    def is_silent(self) -> bool:
        """Whether the field says nothing any more, though it hasn't ended."""
        has_ended = self._steps is not None and self._steps.has_ended
        return not has_ended and time.monotonic() - self._heard_at > SILENCE

    def wait_for(self, field: FieldSteps, step: int, seconds: float) -> bool:
        """Wait until a step of a field or a later one has come, or another field; return whether it has."""
        with self._changed:
            return self._changed.wait_for(
                lambda: self.field.latest >= (step if self.field is field else 0), seconds
            )

    def _receive_all(self) -> None:
        while not self._closed:
            self.receive()
        self._link.close()

    def receive(self) -> None:
        """Ask for more if it is time, and take the next packet, if one comes soon."""
        now = time.monotonic()
        if self._has_scene and (self.field.has_ended or self.is_silent):
            self._look()
        if now - self._asked_at > (ASKING if self._has_scene and self.field.views else RETRY):
            self._client.send(*self._request())
            self._asked_at = now
        frame = self._client.receive(RETRY)
        if frame is not None:
            self._take(frame)

    def _look(self) -> None:
        """Ask from now on which field is there."""
        self._client = Client(self._link, self._key, self._request)

    def _request(self) -> tuple[int, dict[str, Any]]:
        return VIEW, {"has": self._has_scene}

    @property
    def _has_scene(self) -> bool:
        """Whether the scene that is kept is that of the field that answers."""
        return self._steps is not None and self._client.session == self._session

    def _take(self, frame: Frame) -> None:
        body = frame.body
        if frame.kind == STATE and self._has_scene and self.field.fits(body):
            with self._changed:
                self.field.keep(body)
                self._changed.notify_all()
        elif frame.kind == SCENE and body["faults"] and not self._has_scene:
            with self._changed:
                self._steps, self._session = FieldSteps(body), self._client.session
                self._changed.notify_all()
        elif frame.kind == REFUSED:
            self._why = one_line(body["why"])[:300]
            return
        self._heard_at = time.monotonic()

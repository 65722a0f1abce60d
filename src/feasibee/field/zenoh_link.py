"""The link over zenoh, which the extra ``zenoh`` installs: one key for each robot, over TCP."""

from __future__ import annotations

import json
import queue
from collections.abc import Hashable
from contextlib import suppress
from typing import Any

from feasibee.errors import FeasibeeError, how_to_install
from feasibee.field.addresses import join_address

QUEUE = 20_000
"""Number of packets that wait to be read; more are dropped."""
ROOT = "feasibee/field"


class ZenohLink:
    """A link over zenoh, with explicit TCP addresses and without multicast.

    Parameters
    ----------
    host, port : str and int
        Where the world listens.
    listens : bool
        Whether this is the world's end.
    name : str
        The robot's own name on the network.
    """

    def __init__(self, host: str, port: int, *, listens: bool, name: str = "") -> None:
        self.address = join_address(host, port)
        self._listens = listens
        self._name = name
        self._queue: queue.Queue[tuple[bytes, Hashable]] = queue.Queue(QUEUE)
        self._session = open_session(self.address, listens=listens)
        mine = f"{ROOT}/up/*" if listens else f"{ROOT}/down/{name}"
        self._subscriber = self._session.declare_subscriber(mine, self._keep)

    def _keep(self, sample: Any) -> None:
        """Queue a packet; zenoh calls this in a thread of its own."""
        peer = str(sample.key_expr).rpartition("/")[2]
        with suppress(queue.Full):
            self._queue.put_nowait((sample.payload.to_bytes(), peer))

    def send(self, packet: bytes, peer: Hashable = None) -> None:
        """Send a packet to a peer; without a peer, to the world."""
        key = f"{ROOT}/up/{self._name}" if peer is None else f"{ROOT}/down/{peer}"
        with suppress(Exception):  # the session is closed: the same as a lost packet
            self._session.put(key, packet)

    def receive(self, timeout: float) -> tuple[bytes, Hashable] | None:
        """Return the next packet with its peer, or None if none comes in so many seconds."""
        try:
            return self._queue.get(timeout > 0, timeout if timeout > 0 else None)
        except queue.Empty:
            return None

    def close(self) -> None:
        """Leave the network."""
        self._session.close()


def open_session(address: str, *, listens: bool) -> Any:
    """Return a session of zenoh that listens at an address, or connects to it, over TCP only.

    Raises
    ------
    FeasibeeError
        If eclipse-zenoh isn't installed, or the address can't be used.
    """
    try:
        import zenoh
    except ImportError:
        raise FeasibeeError(f"{address}: eclipse-zenoh isn't installed; {how_to_install('zenoh')}") from None
    try:
        return zenoh.open(_config(zenoh, address, listens))
    except zenoh.ZError as error:
        why = str(error).partition(" at /")[0]  # without the line of its source
        raise FeasibeeError(f"{address}: zenoh can't use it: {why}; use another address") from None


def _config(zenoh: Any, address: str, listens: bool) -> Any:
    """Return zenoh's settings: no discovery, one TCP address, and a silent peer is gone after 1 s."""
    config = zenoh.Config()
    endpoint = f"tcp/{address}"
    settings = {
        "mode": "router" if listens else "client",
        "listen/endpoints": [endpoint] if listens else [],
        "connect/endpoints": [] if listens else [endpoint],
        "connect/timeout_ms": -1,
        "connect/exit_on_failure": False,
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "transport/link/tx/lease": 1000,
    }
    for path, value in settings.items():
        config.insert_json5(path, json.dumps(value))
    return config

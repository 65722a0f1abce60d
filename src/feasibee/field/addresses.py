"""Addresses: HOST:PORT, as links and the command line write them."""

from __future__ import annotations

from feasibee.errors import FeasibeeError

DEFAULT_HOST = "127.0.0.1"


def join_address(host: str, port: int) -> str:
    """Return an address as HOST:PORT, or [HOST]:PORT for IPv6."""
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"


def split_address(text: str) -> tuple[str, int]:
    """Return host and port of an address.

    Raises
    ------
    FeasibeeError
        If it isn't HOST:PORT.
    """
    host, colon, port = text.rpartition(":")
    host = host.removeprefix("[").removesuffix("]")
    if not (colon and host and port.isascii() and port.isdigit() and 0 < int(port) < 65_536):
        raise FeasibeeError(f"address {text}: must be HOST:PORT, such as 127.0.0.1:7400")
    return host, int(port)


def is_loopback(host: str) -> bool:
    """Return whether an address can be reached from this machine only."""
    return host in ("localhost", "::1") or host.startswith("127.")

"""What keeps others out: the check of Host and Origin, so that only pages of this server may use it.

A page of another site can send requests to this machine. Its browser states where the page comes from
(Origin) and by which name it found the server (Host). Both must be the server's own. This also stops DNS
rebinding, where the name of another site suddenly leads to this machine. An IP address cannot be rebound.
"""

from __future__ import annotations

import socket
from collections.abc import Sequence
from ipaddress import ip_address
from typing import Final

HEADERS: Final = {
    "Content-Security-Policy": "base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
"""What each answer has. The page's own policy, in its markup, lets it load nothing from elsewhere."""


class Guard:
    """The names of a server: where it listens; beyond loopback, all addresses and this machine's names."""

    def __init__(self, host: str, port: int) -> None:
        self._port = str(port)
        self._addresses = not is_loopback(host)
        self._names = {"localhost"}
        if self._addresses:
            self._names |= {each.lower() for each in (host, socket.gethostname(), socket.getfqdn())}

    def refusal(self, hosts: Sequence[str], origins: Sequence[str], *, needs_origin: bool) -> str:
        """Return why a request with these headers is rejected; an empty string if it is accepted."""
        host = hosts[0].lower() if len(hosts) == 1 else ""
        if not self._is_own(host):
            return "Host: not the name and port of this server; open the address that feasibee watch printed"
        own = [f"http://{host}"], [f"https://{host}"]
        if (needs_origin or origins) and [each.lower() for each in origins] not in own:
            return "Origin: not a page of this server; open the address that feasibee watch printed"
        return ""

    def _is_own(self, host: str) -> bool:
        """Return whether a Host, with or without the port, names the server."""
        name = host.removesuffix(f":{self._port}")
        if name in self._names:
            return True
        try:
            address = ip_address(name.strip("[]"))
        except ValueError:
            return False
        written = f"[{address}]" if address.version == 6 else str(address)
        return name == written and "%" not in name and (self._addresses or address.is_loopback)


def is_loopback(host: str) -> bool:
    """Return whether a server on a host can be reached from this machine only."""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host.lower() == "localhost"

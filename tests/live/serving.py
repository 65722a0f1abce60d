"""A server of the live arena, for tests, and requests as a page sends them."""

from __future__ import annotations

import json
import re
import socket
import threading
from contextlib import contextmanager

from feasibee.live import serve
from feasibee.live.catalogue import Catalogue


@contextmanager
def serving_at(shown, port=0):
    """Run a server of a catalogue, or of routes, in a thread; give its port."""
    routes = serve.routes_of(shown) if isinstance(shown, Catalogue) else shown
    with serve.listen("127.0.0.1", port) as listening:
        server = serve.Server(routes, "127.0.0.1", listening)
        thread = threading.Thread(target=server.serve_forever, args=(0.02,))
        thread.start()
        try:
            yield listening.getsockname()[1]
        finally:
            server.shutdown()
            thread.join(60)
            assert not thread.is_alive()


def said(port, text):
    """Return status, headers and body of the answer to a request, given as text."""
    with socket.create_connection(("127.0.0.1", port), 60) as line:
        line.sendall(text if isinstance(text, bytes) else text.encode())
        received = b""
        while more := line.recv(65536):
            received += more
    head, _, body = received.partition(b"\r\n\r\n")
    first, *lines = head.decode().split("\r\n")
    headers = dict(each.split(": ", 1) for each in lines)
    return int(first.split()[1]), headers, body.decode()


def got(port, path="/"):
    return said(port, f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n")


def given(text):
    """Return what a page is given, from its HTML."""
    (found,) = re.findall(r'<script type="application/json" id="given">(.*?)</script>', text, re.DOTALL)
    return json.loads(found)


def posted(port, path, asked, more=""):
    """Return the status and the answer, of JSON if it is some, to a page's request."""
    body = asked if isinstance(asked, bytes) else json.dumps(asked).encode()
    place = f"127.0.0.1:{port}"
    head = f"POST {path} HTTP/1.1\r\nHost: {place}\r\nOrigin: http://{place}\r\n{more}"
    head += f"Content-Length: {len(body)}\r\n\r\n"
    status, headers, answer = said(port, head.encode() + body)
    return status, json.loads(answer) if headers["Content-Type"] == "application/json" else answer

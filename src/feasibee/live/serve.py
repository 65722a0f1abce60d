"""The web server of `feasibee watch`: a page, and without state what its JavaScript can't compute."""

from __future__ import annotations

import json
import logging
import os
import re
import socket
import sys
import webbrowser
from collections.abc import Callable, Mapping
from errno import EADDRINUSE
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import BoundedSemaphore, Thread
from typing import Any, Final

from pydantic import ValidationError

from feasibee.base.errors import FeasibeeError, Problem
from feasibee.base.files import named
from feasibee.live.catalogue import Catalogue, Request
from feasibee.live.form import form
from feasibee.live.guard import HEADERS, Guard
from feasibee.live.packet import wasm_of
from feasibee.live.page import page_with
from feasibee.live.prediction import prediction_of
from feasibee.live.scene import opened_of
from feasibee.scenario.runs import Runs

FIRST_PORT: Final = 8765
PORTS_TRIED: Final = 50
BODY_LIMIT: Final = 16 * 1024
"""Most bytes of a request's body."""
LIFETIME: Final = 20.0
"""Seconds until a connection ends that says nothing, or doesn't take its answer."""
WORKERS: Final = 16
"""Most requests that are answered at the same time."""

LOG: Final = logging.getLogger("feasibee.live")

Routes = Mapping[tuple[str, str], Callable[[bytes], Any]]
"""What answers a method and a path: it takes the query or body, and returns HTML, or what becomes JSON."""


def routes_of(catalogue: Catalogue) -> Routes:
    """Return the answers to pages that simulate; raise a FeasibeeError if no page can begin."""
    first, title = catalogue.scenario, named(catalogue.title)
    page = page_with(
        opened_of(first, Runs.single(catalogue.seed, catalogue.run)) | {"point": catalogue.point},
        title,
        server=True,
        form=form(),
        wasm=wasm_of(first),
        replays=catalogue.replays,
    )

    def opened(body: bytes) -> Any:
        asked = Request.model_validate_json(body)
        scenario, runs = catalogue.chosen(asked)
        wasm = None if scenario.manifest.source == first.manifest.source else wasm_of(scenario)
        return opened_of(scenario, runs) | {"point": asked.point, "wasm": wasm}

    def predicted(body: bytes) -> Any:
        return prediction_of(catalogue.chosen(Request.model_validate_json(body))[0])

    return {("GET", "/"): lambda _: page, ("POST", "/open"): opened, ("POST", "/predict"): predicted}


class Server(ThreadingHTTPServer):
    """A server that answers by routes, on a listening socket; ``host`` is where it listens."""

    daemon_threads = True  # the program ends before them

    def __init__(self, routes: Routes, host: str, listening: socket.socket) -> None:
        port = listening.getsockname()[1]
        super().__init__((host, port), _Handler, bind_and_activate=False)
        self.socket.close()
        self.socket = listening
        self.routes, self.guard = routes, Guard(host, port)
        self.working = BoundedSemaphore(WORKERS)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Report an error in the terminal, unless the page has gone."""
        if not isinstance(sys.exception(), OSError):
            LOG.exception("internal error in answering a page")


class _Handler(BaseHTTPRequestHandler):
    server: Server
    timeout = LIFETIME

    def do_GET(self) -> None:
        self._answer(self.path.partition("?")[2].encode)

    def do_POST(self) -> None:
        self._answer(self._body)

    def _answer(self, given: Callable[[], bytes | None]) -> None:
        """Answer with what a route makes of the query or body."""
        named = (self.headers.get_all(name, []) for name in ("Host", "Origin"))
        if why := self.server.guard.refusal(*named, needs_origin=self.command != "GET"):
            return self._say(403, why)
        route = self.server.routes.get((self.command, self.path.partition("?")[0]))
        if route is None:
            return self._say(404, "not found")
        asked = given()
        if asked is None:
            return None
        if not self.server.working.acquire(blocking=False):
            return self._say(503, f"{WORKERS} requests are being answered, which is the limit; try again")
        try:
            return self._say(*_found(route, asked))
        finally:
            self.server.working.release()

    def _body(self) -> bytes | None:
        """Return the body of a request; None if it is too long, or isn't there."""
        length = self.headers.get("Content-Length", "")
        if not re.fullmatch("[0-9]{1,15}", length):
            self._say(400, "Content-Length: must be the number of bytes of the body")
            return None
        data = self.rfile.read(min(int(length), 64 * BODY_LIMIT))  # a page that still sends reads no answer
        if int(length) > BODY_LIMIT:
            self._say(413, f"must be at most {BODY_LIMIT} bytes")
        return data if len(data) == int(length) <= BODY_LIMIT else None

    def _say(self, code: int, found: Any) -> None:
        """Send text, or what becomes JSON."""
        is_text, is_page = isinstance(found, str), isinstance(found, str) and code == 200
        body = (f"{found}\n" if is_text else json.dumps(found)).encode()
        kind = f"text/{'html' if is_page else 'plain'}; charset=utf-8" if is_text else "application/json"
        headers = {"Content-Type": kind, "Content-Length": str(len(body)), **HEADERS}
        self.send_response_only(code)
        for header in headers.items():
            self.send_header(*header)
        self.end_headers()
        self.wfile.write(body)

    def send_error(self, code: int, message: str | None = None, explain: str | None = None) -> None:
        """Answer a malformed request."""
        self._say(code, message or HTTPStatus(code).phrase)

    def log_message(self, format: str, *args: Any) -> None:  # noqa: A002  # as in the base class
        """Print no request of a page in the terminal."""


def _found(route: Callable[[bytes], Any], asked: bytes) -> tuple[int, Any]:
    """Return the status and the answer of a route; even a bug doesn't end the server."""
    try:
        return 200, route(asked)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False, include_input=False)[0]
        return 400, ": ".join([*map(str, first["loc"]), first["msg"]])
    except (FeasibeeError, MemoryError) as error:
        problems = [{"path": each.path, "text": str(each)} for each in getattr(error, "problems", ())]
        text = str(error) or "not enough memory; use fewer robots or tasks"
        return 422, {"problems": problems or [{"path": "", "text": text}]}
    except Exception:
        LOG.exception("internal error in answering a page")
        return 500, "internal error of feasibee; see the terminal for details"


def listen(host: str, port: int | None) -> socket.socket:
    """Return a listening socket: on a given port, or on the first free one from `FIRST_PORT`.

    Raise a FeasibeeError if the host is invalid or not this machine's, or the port is in use.
    """
    ports = range(FIRST_PORT, FIRST_PORT + PORTS_TRIED) if port is None else [port]
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:  # an empty host would be all of this machine's
        place = socket.getaddrinfo(host or "?", 0, family, socket.SOCK_STREAM)[0][4]
    except (OSError, ValueError):
        rule = "must be an address or a name of this machine"
        raise FeasibeeError(str(Problem("--host", host, rule, "use 127.0.0.1, or leave it out"))) from None
    for each in ports:
        try:
            return socket.create_server((str(place[0]), each), family=family, backlog=64)
        except OSError as error:
            if error.errno != EADDRINUSE:
                rule = f"can't listen: {os.strerror(error.errno or 0)}; leave both out for 127.0.0.1"
                raise FeasibeeError(f"--host {host} --port {each}: {rule}") from None
    if port is not None:
        raise FeasibeeError(f"--port {port}: in use; use another, or leave --port out for a free one")
    raise FeasibeeError(f"ports {ports[0]} to {ports[-1]}: all in use; use another with --port")


def address_of(host: str, port: int) -> str:
    """Return the URL of the page for a browser on this machine."""
    name = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(host, host)
    return f"http://[{name}]:{port}/" if ":" in name else f"http://{name}:{port}/"


def open_browser(address: str) -> None:
    """Open the page in a browser, without waiting for it."""
    Thread(target=webbrowser.open, args=(address,), daemon=True).start()

"""The web server of the live arena: static files, and a WebSocket per page."""

from __future__ import annotations

import asyncio
import logging
import mimetypes
import os
import socket
import webbrowser
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import closing, suppress
from errno import EADDRINUSE
from threading import Thread
from typing import Any, Final, TypeVar

import uvicorn
from starlette.applications import Starlette
from starlette.routing import Mount, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp
from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState

from feasibee.errors import FeasibeeError
from feasibee.live.catalogue import Catalogue
from feasibee.live.fieldsession import FieldCatalogue, FieldSession
from feasibee.live.form import form
from feasibee.live.guard import Connection, Guard, Once, check_host
from feasibee.live.messages import (
    MESSAGE_LIMIT,
    PROTOCOL,
    Advance,
    Inspect,
    Look,
    Open,
    Predict,
    Request,
    Seek,
    Why,
    problems_of,
    read,
)
from feasibee.live.page import STATIC
from feasibee.live.session import Session

FIRST_PORT: Final = 8765
PORTS_TRIED: Final = 50
SESSIONS_LIMIT: Final = 16
QUEUE: Final = 8
"""Most messages of a page that wait for an answer; the server reads no more until one is answered."""
PATIENCE: Final = 0.05
"""Seconds that a swarm advances before the server looks for messages of its page."""
SPARE: Final = 0.02
"""Seconds that a look ahead takes before the next message of the page."""
TRY_LATER = 1013
"""WebSocket close code: the server is full."""

LOG: Final = logging.getLogger("feasibee.live")
for each in (LOG, logging.getLogger("uvicorn.error")):
    each.addFilter(Once())

AnyCatalogue = Catalogue | FieldCatalogue
AnySession = Session | FieldSession
Waiting = asyncio.Queue[dict[str, Any] | None]
T = TypeVar("T")


def application(catalogue: AnyCatalogue, host: str = "127.0.0.1") -> ASGIApp:
    """Return the ASGI application: the page's files, and a session per open page."""
    mimetypes.add_type("text/javascript", ".js")  # some systems say text/plain, which browsers don't run
    sessions: set[AnySession] = set()

    async def connect(page: WebSocket) -> None:
        await page.accept()
        if len(sessions) >= SESSIONS_LIMIT:
            text = f"{SESSIONS_LIMIT} pages are open, which is the limit; close one and reload this page"
            await page.send_json({"type": "full", "text": text})
            await page.close(TRY_LATER)
            return
        session = catalogue.session() if isinstance(catalogue, FieldCatalogue) else Session(catalogue)
        sessions.add(session)
        try:
            await _serve(page, session, catalogue)
        except asyncio.CancelledError:
            pass  # the server stops while it computes for this page
        finally:
            sessions.discard(session)

    routes = [WebSocketRoute("/swarm", connect), Mount("/", StaticFiles(directory=STATIC, html=True))]
    return Guard(Starlette(routes=routes), host)


async def _serve(page: WebSocket, session: AnySession, catalogue: AnyCatalogue) -> None:
    """Answer the messages of a page in order, until it closes."""
    waiting: Waiting = asyncio.Queue(QUEUE)
    reading = asyncio.create_task(_read_all(page, waiting))
    predicting: asyncio.Task[None] | None = None
    try:
        welcome = {"type": "welcome", "protocol": PROTOCOL, "form": form(), **catalogue.to_dict()}
        await page.send_json(welcome)
        while (event := await waiting.get()) is not None:
            request = None
            try:
                message = read(event.get("text"))
                request = message.request if isinstance(message, Open) else None
                if isinstance(message, Predict) and isinstance(session, Session):
                    predicting = asyncio.create_task(_predict(page, session, message.lane, predicting))
                    continue
                await _answer(page, session, message, waiting)
            except (WebSocketDisconnect, RuntimeError):
                raise
            except Exception as error:  # even a bug must end neither the page nor the server
                await page.send_json({**problems_of(_reported(error)), "request": request})
    except (WebSocketDisconnect, RuntimeError):
        if (
            page.application_state is WebSocketState.CONNECTED
            and page.client_state is WebSocketState.CONNECTED
        ):
            raise  # the page is still open, so this is a bug
    finally:
        reading.cancel()
        if predicting is not None:
            predicting.cancel()


async def _predict(page: WebSocket, session: Session, lane: int, before: asyncio.Task[None] | None) -> None:
    """Send what the theory says of a swarm, after the prediction before; the run goes on meanwhile."""
    if before is not None:
        await before
    try:
        found = await _in_daemon_thread(lambda: session.prediction(lane))
    except Exception as error:
        found = problems_of(_reported(error))
    with suppress(WebSocketDisconnect, RuntimeError):  # the page may have closed
        await page.send_json(found)


def _reported(error: Exception) -> FeasibeeError:
    """Return the error for a page; a bug is also printed in the terminal."""
    if isinstance(error, FeasibeeError):
        return error
    if isinstance(error, MemoryError):
        return FeasibeeError("not enough memory; use fewer robots or tasks")
    LOG.error("internal error in answering a page", exc_info=error)
    return FeasibeeError("internal error of feasibee; see the terminal for details")


async def _read_all(page: WebSocket, waiting: Waiting) -> None:
    """Put the messages of a page into a queue, and None when it has closed."""
    with suppress(RuntimeError):
        while (event := await page.receive())["type"] != "websocket.disconnect":
            await waiting.put(dict(event))
    await waiting.put(None)


async def _answer(page: WebSocket, session: AnySession, message: Request, waiting: Waiting) -> None:
    match message:
        case Advance(steps=steps):
            await _send(page, await asyncio.to_thread(session.next_messages, steps, PATIENCE))
        case Inspect(robot=robot):
            session.inspect(robot)
        case Look():
            await page.send_json(await asyncio.to_thread(session.look, message, SPARE))
        case Why() if isinstance(session, Session):
            await page.send_json(await asyncio.to_thread(session.why, message))
        case Seek():
            await _seek(page, session, message, waiting)
        case Open():
            await _go(page, session, await _begin(page, session, message), waiting)


async def _send(page: WebSocket, messages: list[dict[str, Any] | bytes]) -> None:
    for each in messages:
        await (page.send_bytes(each) if isinstance(each, bytes) else page.send_json(each))


async def _go(page: WebSocket, session: AnySession, step: int, waiting: Waiting) -> None:
    """Advance to a step and send it, unless the page asks for something else meanwhile, or closes."""
    while not await asyncio.to_thread(session.advance, step, PATIENCE):
        if not waiting.empty():
            return
        await page.send_json({"type": "going", "step": session.step, "to": step})
    await _send(page, await asyncio.to_thread(session.messages))


async def _seek(page: WebSocket, session: AnySession, asked: Seek, waiting: Waiting) -> None:
    """Go to a step, or to the decision if the swarm decides."""
    step = asked.to
    if step == "decision":
        outlook = await asyncio.to_thread(lambda: session.lane(asked.lane).outlook)
        while outlook.decision_step < 0 and not await asyncio.to_thread(outlook.look, PATIENCE):
            if not waiting.empty():
                return
        step = outlook.decision_step if outlook.decision_step >= 0 else session.step
        if outlook.decision_step < 0:
            await page.send_json({"type": "undecided", "lane": asked.lane, "last": session.last})
    await asyncio.to_thread(session.rewind, step, asked.jump)
    await _go(page, session, min(step, session.last), waiting)


async def _begin(page: WebSocket, session: AnySession, asked: Open) -> int:
    """Begin a run and return the step to go to."""
    step = await _in_daemon_thread(lambda: session.begin(asked))
    for each in session.openings():
        await _send(page, [each if isinstance(each, bytes) else {**each, "request": asked.request}])
    return step


async def _in_daemon_thread(work: Callable[[], T]) -> T:
    """Return the result of work in a daemon thread, so that the program can end before it does."""
    done: Future[T] = Future()
    done.set_running_or_notify_cancel()

    def run() -> None:
        try:
            done.set_result(work())
        except BaseException as error:  # whoever awaits gets any error
            done.set_exception(error)

    Thread(target=run, daemon=True).start()
    return await asyncio.wrap_future(done)


def listen(host: str, port: int | None) -> socket.socket:
    """Return a listening socket: on a given port, or on the first free one from `FIRST_PORT`.

    Raise a FeasibeeError if the host is invalid or not this machine's, or the port is in use.
    """
    check_host(host)
    ports = range(FIRST_PORT, FIRST_PORT + PORTS_TRIED) if port is None else [port]
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    for each in ports:
        with closing(socket.socket(family, socket.SOCK_STREAM)) as tried:
            if os.name == "posix":
                # Not on Windows, where it would let two servers share a port.
                tried.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                tried.bind((host, each))
                tried.listen(64)
            except OSError as error:
                if port is None and error.errno == EADDRINUSE:
                    continue
                raise FeasibeeError(_why_not(host, each, error)) from None
            return tried.dup()
    raise FeasibeeError(f"ports {ports[0]} to {ports[-1]}: all in use; use another with --port")


def _why_not(host: str, port: int, error: OSError) -> str:
    """Return the message for a port that can't be opened."""
    if error.errno == EADDRINUSE:
        return f"--port {port}: in use; use another, or leave --port out for a free one"
    return f"--host {host} --port {port}: can't listen: {error.strerror}; leave both out for 127.0.0.1"


def address_of(host: str, port: int) -> str:
    """Return the URL of the page for a browser on this machine."""
    name = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(host, host)
    return f"http://[{name}]:{port}/" if ":" in name else f"http://{name}:{port}/"


def open_browser(address: str) -> None:
    """Open the page in a browser, without waiting for it."""
    Thread(target=webbrowser.open, args=(address,), daemon=True).start()


def server_of(catalogue: AnyCatalogue, host: str) -> uvicorn.Server:
    """Return the uvicorn server of a catalogue, not running yet."""
    return uvicorn.Server(
        uvicorn.Config(
            application(catalogue, host),
            http=Connection,
            log_level="error",  # its warnings are about malformed requests of others
            access_log=False,
            server_header=False,
            proxy_headers=False,
            lifespan="off",
            ws="websockets-sansio",
            ws_max_size=MESSAGE_LIMIT,
            ws_per_message_deflate=False,  # frames hardly compress, and stay on this machine
            timeout_graceful_shutdown=1,
        )
    )

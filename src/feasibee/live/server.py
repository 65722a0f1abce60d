"""The server: static files, and a WebSocket for each page."""

from __future__ import annotations

import asyncio
import logging
import mimetypes
import os
import socket
import webbrowser
from collections.abc import Callable
from contextlib import closing, suppress
from errno import EADDRINUSE
from pathlib import Path
from threading import Thread
from typing import Any, Final, TypeVar

import uvicorn
from starlette.applications import Starlette
from starlette.routing import Mount, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp
from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState

from feasibee.errors import FeasibeeError
from feasibee.live.catalogue import Programme
from feasibee.live.connections import Connection, Once, log_config
from feasibee.live.guard import Guard, check_host, is_loopback
from feasibee.live.messages import MESSAGE_LIMIT, PROTOCOL, Advance, Open, problems_of, read
from feasibee.live.session import ROBOTS_LIMIT, TASKS_LIMIT, Plan, Session, plan_of
from feasibee.simulation.ensemble import is_engine_compiled

__all__ = ["address_of", "application", "is_loopback", "listen", "open_browser", "server_of"]

STATIC: Final = Path(__file__).parent / "static"
FIRST_PORT: Final = 8765
PORTS_TRIED: Final = 50
SESSIONS_LIMIT: Final = 16
QUEUE: Final = 8
"""Messages of a page that wait to be answered; beyond, the server reads no more of it."""
PATIENCE: Final = 0.05
"""Seconds for which a swarm advances before the server looks at its page again."""
TRY_LATER = 1013

LOG: Final = logging.getLogger("feasibee.live")
LOG.addFilter(Once())

Result = TypeVar("Result")


def application(programme: Programme, host: str = "127.0.0.1") -> ASGIApp:
    """Return the application: the page, and the swarms of those that open it."""
    mimetypes.add_type("text/javascript", ".js")  # some systems call it plain text, which browsers won't run
    sessions: set[Session] = set()

    async def connect(page: WebSocket) -> None:
        await page.accept()
        if len(sessions) >= SESSIONS_LIMIT:
            text = (
                f"{SESSIONS_LIMIT} pages are open, as many as there may be; close one, and reload this page"
            )
            await page.send_json({"type": "full", "text": text})
            await page.close(TRY_LATER)
            return
        session = Session(programme)
        sessions.add(session)
        try:
            await _serve(page, session, programme)
        except asyncio.CancelledError:
            pass  # the server ends while it computes for this page
        finally:
            sessions.discard(session)

    routes = [WebSocketRoute("/swarm", connect), Mount("/", StaticFiles(directory=STATIC, html=True))]
    return Guard(Starlette(routes=routes), host)


async def _serve(page: WebSocket, session: Session, programme: Programme) -> None:
    """Answer a page's messages, one after the other, until it goes."""
    waiting: asyncio.Queue[dict[str, Any] | None] = asyncio.Queue(QUEUE)
    reading = asyncio.create_task(_read_all(page, waiting))
    try:
        limits = {"robots": ROBOTS_LIMIT, "tasks": TASKS_LIMIT}
        welcome = {"type": "welcome", "protocol": PROTOCOL, "limits": limits, **programme.to_dict()}
        await page.send_json(welcome)
        while (event := await waiting.get()) is not None:
            try:
                await _answer(page, session, programme, _message(event), waiting)
            except FeasibeeError as error:
                await page.send_json(problems_of(error))
            except MemoryError:
                text = "not enough memory; take fewer robots or tasks"
                await page.send_json(problems_of(FeasibeeError(text)))
            except (WebSocketDisconnect, RuntimeError):
                raise
            except Exception:  # an error of the program ends neither the page nor the server
                LOG.exception("an error in answering a page")
                await page.send_json(
                    problems_of(FeasibeeError("an error of feasibee; the terminal has more"))
                )
    except (WebSocketDisconnect, RuntimeError):
        if (
            page.application_state is WebSocketState.CONNECTED
            and page.client_state is WebSocketState.CONNECTED
        ):
            raise  # the page is there: it is ours
    finally:
        reading.cancel()


async def _read_all(page: WebSocket, waiting: asyncio.Queue[dict[str, Any] | None]) -> None:
    """Put a page's messages in a queue, and None when it has gone."""
    with suppress(RuntimeError):
        while (event := await page.receive())["type"] != "websocket.disconnect":
            await waiting.put(dict(event))
    await waiting.put(None)


def _message(event: dict[str, Any]) -> Open | Advance:
    text = event.get("text")
    if text is None:
        raise FeasibeeError("message: must be text, not bytes; reload the page")
    return read(text)


async def _answer(
    page: WebSocket,
    session: Session,
    programme: Programme,
    message: Open | Advance,
    waiting: asyncio.Queue[dict[str, Any] | None],
) -> None:
    if isinstance(message, Advance):
        await page.send_bytes(await asyncio.to_thread(session.advanced, message.steps, PATIENCE))
        return
    plan = await asyncio.to_thread(plan_of, message, programme)
    await _begin(page, session, plan)
    while not await asyncio.to_thread(session.advance, plan.step, PATIENCE):
        if not waiting.empty():
            return  # the page wants something else, or has gone
        await page.send_json({"type": "going", "step": session.swarm.step, "to": plan.step})
    await page.send_bytes(await asyncio.to_thread(session.frame))


async def _begin(page: WebSocket, session: Session, plan: Plan) -> None:
    if not await asyncio.to_thread(is_engine_compiled, plan.scenario):
        text = "Compiling the engine, once for this machine: 10 to 30 seconds"
        await page.send_json({"type": "compiling", "text": text})
    await in_thread_left_behind(lambda: session.begin(plan))
    await page.send_json(session.opened())
    await page.send_bytes(session.tasks())


async def in_thread_left_behind(work: Callable[[], Result]) -> Result:
    """Do work in a thread that doesn't hold up the end of the program, as compiling would."""
    loop = asyncio.get_running_loop()
    done: asyncio.Future[Result] = loop.create_future()

    def tell(result: Result | None, error: BaseException | None) -> None:
        if done.cancelled():
            return
        if error is not None:
            done.set_exception(error)
        else:
            done.set_result(result)  # type: ignore[arg-type]  # without an error there is a result

    def run() -> None:
        result, error = None, None
        try:
            result = work()
        except BaseException as raised:  # all of it goes to whoever waits
            error = raised
        with suppress(RuntimeError):  # the loop may have ended meanwhile
            loop.call_soon_threadsafe(tell, result, error)

    Thread(target=run, daemon=True).start()
    return await done


def listen(host: str, port: int | None) -> socket.socket:
    """Return a socket that listens: on a port or, if none is given, on the first free one from `FIRST_PORT`.

    Raises
    ------
    FeasibeeError
        If the port is taken or the host isn't this machine's.
    """
    check_host(host)
    ports = range(FIRST_PORT, FIRST_PORT + PORTS_TRIED) if port is None else [port]
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    for each in ports:
        with closing(socket.socket(family, socket.SOCK_STREAM)) as tried:
            if os.name == "posix":
                tried.setsockopt(
                    socket.SOL_SOCKET, socket.SO_REUSEADDR, 1
                )  # on Windows it means another thing
            try:
                tried.bind((host, each))
                tried.listen(64)
            except OSError as error:
                if port is None and error.errno == EADDRINUSE:
                    continue
                raise FeasibeeError(_why_not(host, each, error)) from None
            return tried.dup()
    raise FeasibeeError(f"ports {ports[0]} to {ports[-1]}: all are taken; give another with --port")


def _why_not(host: str, port: int, error: OSError) -> str:
    if error.errno == EADDRINUSE:
        return f"--port {port}: is taken; give another, or leave --port out for a free one"
    return f"--host {host} --port {port}: can't listen: {error.strerror}; give others, or leave them out"


def address_of(host: str, port: int) -> str:
    """Return the address of the page, as a browser on this machine finds it."""
    name = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}.get(host, f"[{host}]" if ":" in host else host)
    return f"http://{name}:{port}/"


def open_browser(address: str) -> None:
    """Open the page, without waiting for the browser."""
    Thread(target=webbrowser.open, args=(address,), daemon=True).start()


def server_of(programme: Programme, host: str) -> uvicorn.Server:
    """Return the server, not yet running."""
    return uvicorn.Server(
        uvicorn.Config(
            application(programme, host),
            http=Connection,
            log_config=log_config(),
            log_level="error",  # its warnings are of what others send
            access_log=False,
            server_header=False,
            proxy_headers=False,
            lifespan="off",
            ws="websockets-sansio",
            ws_max_size=MESSAGE_LIMIT,
            ws_per_message_deflate=False,  # frames are nearly random, and go no further than this machine
            timeout_graceful_shutdown=1,
        )
    )

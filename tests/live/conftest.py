"""Servers of tests, and their pages."""

from __future__ import annotations

import socket

import pytest

from feasibee import Scenario
from feasibee.live import server
from feasibee.live.catalogue import Catalogue


@pytest.fixture(scope="session")
def port():
    """The port of a server of the default scenario, with seed 1."""
    serving = pytest.importorskip("serving", reason="websockets isn't installed: install feasibee[live]")
    with serving.serving_at(Catalogue(Scenario(), seed=1)) as port:
        yield port


@pytest.fixture
def same_port():
    """A port that no other program gets between two servers of a test."""
    with socket.socket() as held:
        held.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        held.bind(("127.0.0.1", 0))
        yield held.getsockname()[1]


@pytest.fixture
def patient(monkeypatch):
    """A server that answers each message wholly, however long the machine is busy with other things."""
    monkeypatch.setattr(server, "PATIENCE", 60.0)


@pytest.fixture
def new_page(browser):
    """Give a function that makes a page; at the end, no page may have said an error on its console."""
    contexts, errors = [], []

    def heard(message):
        if message.type in ("error", "warning"):
            errors.append(message.text)

    def made(**options):
        context = browser.new_context(**options)
        context.set_default_timeout(60_000)  # milliseconds: the machine may be busy with other tests
        contexts.append(context)
        page = context.new_page()
        page.on("console", heard)
        page.on("pageerror", lambda error: errors.append(str(error)))
        return page

    made.errors = errors
    yield made
    for context in contexts:
        context.close()
    assert not errors


@pytest.fixture
def visit(new_page):
    """Give a function that opens a page of a server."""
    expect = pytest.importorskip("playwright.sync_api", reason="playwright isn't installed").expect

    def opened(port, more="", width=1280, height=800, ready=True, **options):
        page = new_page(viewport={"width": width, "height": height}, **options)
        page.goto(f"http://127.0.0.1:{port}/{more}")
        if ready:
            expect(page.locator("#arena[data-drawn]")).to_be_visible()
            expect(page.locator("#last")).not_to_have_text("0")
            expect(page.locator("#veil")).to_be_hidden()
        return page

    opened.errors = new_page.errors
    return opened

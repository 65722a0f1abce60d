"""Servers of tests, their pages, and the world of a page, played by node."""

from __future__ import annotations

import json
import shutil
import socket
import subprocess
from pathlib import Path

import numpy as np
import pytest

from feasibee import Scenario
from feasibee.live import server
from feasibee.live.catalogue import Catalogue
from feasibee.live.world.build import WASM
from feasibee.live.world.lowering import numbers_of, place_of
from feasibee.simulation.lowering import unit_of

PLAYER = Path(__file__).parent / "play.mjs"


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


@pytest.fixture(scope="session")
def node():
    """The JavaScript engine that runs the compiled world."""
    program = shutil.which("node")
    if program is None:
        pytest.skip("no node in PATH: install the Debian package nodejs")
    return program


@pytest.fixture
def play(node):
    """Give a function that plays runs; each gives flags by step and robot, last positions, missing robots."""

    def played(runs, world=WASM):
        cases = [
            {
                "named": numbers_of(scenario),
                "events": [each.model_dump(exclude_defaults=True) for each in scenario.events],
                "unit": [str(part) for part in unit_of(scenario).as_integer_ratio()],
                "place": place_of(scenario),
                "seed": str(seed),
                "run": run,
                "steps": scenario.run.steps,
            }
            for scenario, seed, run in runs
        ]
        said = subprocess.run(
            [node, str(PLAYER), str(world)], input=json.dumps(cases).encode(), capture_output=True, check=True
        ).stdout
        at = 0
        for scenario, _, _ in runs:
            robots, steps = scenario.most.robots, scenario.run.steps + 1
            flags = np.frombuffer(said, "<u2", robots * steps, at).reshape(steps, robots)
            at += flags.nbytes
            places = np.frombuffer(said, "<u4", 2 * robots, at).reshape(2, robots).T
            (missing,) = np.frombuffer(said, "<u4", 1, at + places.nbytes)
            at += places.nbytes + missing.nbytes
            yield flags, places, missing
        assert at == len(said)

    return played

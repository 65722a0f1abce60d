"""What several files of tests need."""

from __future__ import annotations

import os
import shutil
import signal
import sys
from collections import defaultdict

import pytest
from hypothesis import HealthCheck, settings

from feasibee.engine.build import build
from feasibee.engine.compilers import zig
from feasibee.engine.platforms import WEBASSEMBLY

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


def pytest_configure(config):
    """Generate the same examples on any machine, however slow; with the slow tests more of them.

    A shell has Ctrl-C ignored for tests in the background, and nohup the end of the terminal; and so for the
    programs that they interrupt.
    """
    for name, handler in (("SIGINT", signal.default_int_handler), ("SIGHUP", signal.SIG_DFL)):
        number = getattr(signal, name, None)  # Windows has no SIGHUP
        if number is not None and signal.getsignal(number) == signal.SIG_IGN:
            signal.signal(number, handler)
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # hundreds of programs would compile the package again
    sys.dont_write_bytecode = False
    harmless = (
        "too_slow",
        "data_too_large",
        "large_base_example",
        "filter_too_much",
        "function_scoped_fixture",
    )
    settings.register_profile(
        "tests",
        max_examples=12 if "not slow" in config.option.markexpr else 50,
        derandomize=True,
        database=None,
        deadline=None,
        suppress_health_check=[HealthCheck[name] for name in harmless],
    )
    settings.load_profile("tests")


@pytest.hookimpl(tryfirst=True)  # before slow tests are left out
def pytest_collection_modifyitems(items):
    """Mark the cases of quick tests slow, but so many; and what runs in a browser."""
    families = defaultdict(list)
    for item in items:
        if "browser" in item.fixturenames:
            item.add_marker("browser")
        if item.get_closest_marker("quick") and not item.get_closest_marker("slow"):
            families[item.nodeid.partition("[")[0]].append(item)
    for cases in families.values():
        chosen = min(len(cases), cases[0].get_closest_marker("quick").args[0])
        for place, item in enumerate(cases):
            if place * chosen // len(cases) == (place - 1) * chosen // len(cases):
                item.add_marker("slow")


def pytest_sessionstart(session):
    """Compile the engine if its files have changed, and the world of a page: workers would do so together."""
    if "PYTEST_XDIST_WORKER" not in os.environ:
        build()
        if zig():
            build(WEBASSEMBLY)


@pytest.fixture(scope="module")  # for a whole session, its event loop would be in the way of others
def browser():
    """A real browser; without one, what needs it is skipped."""
    api = pytest.importorskip("playwright.sync_api", reason="playwright isn't installed")
    program = next(filter(None, map(shutil.which, BROWSERS)), None)
    if program is None:
        pytest.skip(f"no browser: none of {', '.join(BROWSERS)} is in PATH")
    with api.sync_playwright() as playwright:
        options = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
        running = playwright.chromium.launch(executable_path=program, args=options)
        api.expect.set_options(timeout=60_000)  # milliseconds: the machine may be busy with other tests
        yield running
        running.close()

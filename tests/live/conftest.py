"""Pages of tests: files, and those of servers."""

from __future__ import annotations

import pytest
from serving import serving_at

from feasibee import Scenario
from feasibee.live.catalogue import Catalogue
from feasibee.live.page import page_of


@pytest.fixture(scope="session")
def port():
    """The port of a server of the default scenario, with seed 1."""
    with serving_at(Catalogue(Scenario(), seed=1)) as port:
        yield port


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
def show(new_page, tmp_path):
    """Give a function that opens a page of a scenario, or of a server's port, and waits for its run.

    It stands still at step 0, unless it is opened with other options. A file may load nothing.
    """
    visiting = pytest.importorskip("visiting", reason="playwright isn't installed")
    files = {}

    def asked(request):
        if not request.url.startswith(("file:", "data:", "blob:")):
            new_page.errors.append(request.url)

    def opened(of, more="", width=1280, height=800, seed=1, **options):
        is_file = isinstance(of, Scenario)
        options = {"reduced_motion": "reduce", "offline": is_file, **options}
        page = new_page(viewport={"width": width, "height": height}, **options)
        address = f"http://127.0.0.1:{of}/"
        if is_file:
            page.on("request", asked)
            path = files.setdefault((of, seed), tmp_path / f"{len(files)}.html")
            path.write_text(page_of(of, seed), encoding="utf-8")
            address = path.as_uri()
        page.goto(f"{address}{more}")
        visiting.expect_run(page)
        return page

    yield opened
    new_page.errors[:] = [each for each in new_page.errors if "422" not in each]  # told by the page, too

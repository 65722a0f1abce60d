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


LOOKS = {"viewport", "color_scheme", "reduced_motion", "offline"}
"""Options of a context that a page may change later."""


@pytest.fixture(scope="module")
def kept(browser):
    """Give a function that returns a page which tests use in turn: each new one takes a second to start."""
    pages = []

    def page():
        if not pages or pages[0].is_closed():
            pages[:] = [browser.new_context().new_page()]
        return pages[0]

    return page


def looking(page, viewport, color_scheme="light", reduced_motion="no-preference", offline=False):
    """Return a page after it has got these options."""
    page.set_viewport_size(viewport)
    page.emulate_media(color_scheme=color_scheme, reduced_motion=reduced_motion)
    page.context.set_offline(offline)
    return page


@pytest.fixture
def new_page(browser, kept):
    """Give a function that makes a page; at the end, no page may have said an error on its console."""
    pages, errors = [], []

    def heard(message):
        if message.type in ("error", "warning"):
            errors.append(message.text)

    def failed(error):
        errors.append(str(error))

    def made(**options):
        if {"viewport"} <= set(options) <= LOOKS and kept() not in pages:
            page = looking(kept(), **options)
        else:
            page = browser.new_context(**options).new_page()
        page.context.set_default_timeout(60_000)  # milliseconds: the machine may be busy with other tests
        pages.append(page)
        page.on("console", heard)
        page.on("pageerror", failed)
        return page

    made.errors = errors
    yield made
    for page in pages:
        if page.is_closed() or page is not kept():
            page.context.close()
            continue
        page.evaluate("() => { try { localStorage.clear(); } catch { /* a page without storage */ } }")
        page.mouse.move(0, 0)
        page.goto("about:blank")
        page.remove_listener("console", heard)
        page.remove_listener("pageerror", failed)
    assert not errors


@pytest.fixture
def show(new_page, tmp_path):
    """Give a function that opens a page of a scenario, or of a server's port, and waits for its run.

    It stands still at step 0, unless it is opened with other options. A file may load nothing.
    """
    visiting = pytest.importorskip("visiting", reason="playwright isn't installed")
    files, listening = {}, []

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
            listening.append(page)
            path = files.setdefault((of, seed), tmp_path / f"{len(files)}.html")
            path.write_text(page_of(of, seed), encoding="utf-8")
            address = path.as_uri()
        page.goto(f"{address}{more}")
        visiting.expect_run(page)
        return page

    yield opened
    for page in listening:
        page.remove_listener("request", asked)
    new_page.errors[:] = [each for each in new_page.errors if "422" not in each]  # told by the page, too

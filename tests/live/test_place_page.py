"""Walls, no-go areas and zones on the pages: below the robots, in the colours of the theme."""

from __future__ import annotations

import json
from contextlib import ExitStack

import pytest
from waiting import eventually
from walled import PLACE, SIDE

from feasibee import Scenario
from feasibee.live import page as page_module
from feasibee.live.catalogue import Catalogue
from feasibee.live.page import page_of
from feasibee.live.scene import plan_for_pages, scene_of

expect = pytest.importorskip("playwright.sync_api", reason="playwright isn't installed").expect
serving_at = pytest.importorskip("serving", reason="websockets isn't installed").serving_at

WALL_AT, NO_GO_AT, DOCK_AT, OPEN_AT = (10.0, 3.0), (15.2, 2.2), (2.7, 7.2), (13.2, 8.2)
SHADES = {"light": ("#1d2125", "#fdfdfc"), "dark": ("#e6e9eb", "#0c0f11")}
"""Ink and ground of base.css."""


def seen_at(page, place):
    """Return the colour of a place in units on the arena's canvas."""
    return page.locator("#arena").evaluate(
        """(at, [x, y]) => {
            const copy = new OffscreenCanvas(1, 1).getContext("2d");
            copy.drawImage(at, -Math.floor(x * at.width), -Math.floor((1 - y) * at.height));
            return [...copy.getImageData(0, 0, 1, 1).data].slice(0, 3);
        }""",
        [place[0] / SIDE[0], place[1] / SIDE[1]],
    )


def mixed(one, other, part):
    """Return the colour at a share of the way from one colour to another."""
    pairs = zip(*(bytes.fromhex(each[1:]) for each in (one, other)), strict=True)
    return [start + part * (end - start) for start, end in pairs]


def expect_colours(page, colours):
    def check():
        for place, colour in colours.items():
            assert seen_at(page, place) == pytest.approx(colour, abs=3), place

    eventually(page, check)


@pytest.fixture(scope="module")
def place_port():
    with ExitStack() as stack:
        yield stack.enter_context(serving_at(Catalogue(PLACE, seed=1)))


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_live_page_draws_the_plan_in_the_themes_ink(visit, place_port, scheme):
    page = visit(place_port, color_scheme=scheme, reduced_motion="reduce")
    ink, ground = SHADES[scheme]
    zone = {"light": "#009e73", "dark": "#22c595"}[scheme]
    colours = {
        WALL_AT: mixed(ink, ink, 0),
        NO_GO_AT: mixed(ground, ink, 64 / 255),
        DOCK_AT: mixed(ground, zone, 0.12),
        OPEN_AT: mixed(ground, ground, 0),
        (10.2, 7.2): mixed(ground, ground, 0),  # above the wall
    }
    expect_colours(page, colours)
    page.locator("#theme").click()  # "as the system" becomes "light"
    if scheme == "dark":
        expect_colours(page, {WALL_AT: mixed(SHADES["light"][0], "#000000", 0)})


def test_a_page_in_a_file_draws_it_and_grows_by_its_size(new_page, tmp_path, monkeypatch):
    monkeypatch.setattr(page_module, "check_scenario", lambda _: None)  # of any world, to see its drawing
    flat = PLACE.replace({"place.walls": [], "place.keepout": None, "place.zones": {}})
    texts = [page_of(each) for each in (PLACE, flat)]
    assert '"plan":null' in texts[1]
    assert texts[0].count(plan_for_pages(PLACE)["image"]) == 1
    path = tmp_path / "run.html"
    path.write_text(texts[0], "utf-8")
    page = new_page(reduced_motion="reduce", color_scheme="light", offline=True)
    page.goto(path.as_uri())
    ink, ground = SHADES["light"]
    colours = {WALL_AT: mixed(ink, ink, 0), NO_GO_AT: mixed(ground, ink, 64 / 255)}
    expect_colours(page, colours | {DOCK_AT: mixed(ground, "#009e73", 0.12)})


def test_a_scene_without_a_place_has_no_plan():
    assert scene_of(Scenario())["plan"] is None
    plan = plan_for_pages(PLACE)
    assert plan["size"] == SIDE
    assert [each["name"] for each in plan["zones"]] == ["<dock> & more"]
    assert len(json.dumps(plan)) < 2000

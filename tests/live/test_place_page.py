"""Walls, no-go areas and zones on the pages: below the robots, in the colours of the theme."""

from __future__ import annotations

import json
import tomllib
from contextlib import ExitStack

import numpy as np
import pytest
from visiting import click, control_of, drag, move, point_at, seen_at
from waiting import eventually
from walled import PLACE, SIDE

from feasibee import Scenario, Swarm
from feasibee.live.catalogue import Catalogue
from feasibee.live.page import page_of
from feasibee.live.scene import plan_for_pages, scene_of

expect = pytest.importorskip("playwright.sync_api", reason="playwright isn't installed").expect
serving_at = pytest.importorskip("serving", reason="websockets isn't installed").serving_at

WALL_AT, NO_GO_AT, DOCK_AT, OPEN_AT = (10.0, 3.0), (15.2, 2.2), (2.7, 7.2), (13.2, 8.2)
SHADES = {"light": ("#1d2125", "#fdfdfc"), "dark": ("#e6e9eb", "#0c0f11")}
"""Ink and ground of base.css."""


def mixed(one, other, part):
    """Return the colour at a share of the way from one colour to another."""
    pairs = zip(*(bytes.fromhex(each[1:]) for each in (one, other)), strict=True)
    return [start + part * (end - start) for start, end in pairs]


def expect_colours(page, colours):
    def check():
        for place, colour in colours.items():
            assert seen_at(page, place[0] / SIDE[0], 1 - place[1] / SIDE[1]) == pytest.approx(
                colour, abs=3
            ), place

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


def test_a_page_in_a_file_draws_it_and_grows_by_its_size(new_page, tmp_path):
    uniform = {"placement": "uniform", "points": []}
    place = PLACE.replace({f"{kind}.{key}": uniform[key] for kind in ("robots", "tasks") for key in uniform})
    flat = Scenario(arena={"side": SIDE, "boundary": "walls"})
    texts = [page_of(each) for each in (place, flat)]
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


@pytest.fixture
def drawing(visit, port):
    """A page of the paper's arena whose tool for drawing walls is in use, and where its units are."""
    page = visit(port, reduced_motion="reduce", height=1000)
    page.get_by_role("button", name="Draw walls").click()
    expect(page.locator("#tools p")).to_contain_text("Drag for a rectangle.")
    return page


def expect_walls(page, walls):
    """Expect that the scenario of the page has these walls, and that they are drawn."""

    def check():
        table = tomllib.loads(page.locator("#toml").text_content())
        assert table.get("place", {}).get("walls", []) == walls
        assert table["arena"]["boundary"] == "walls"

    eventually(page, check)
    for wall in walls:
        centre = np.mean(wall, axis=0) / 20 * SIDE  # as a share of the arena, which is not that of seen_at
        expect_colours(page, {tuple(centre): mixed(SHADES["light"][0], "#000000", 0)})


TRIANGLE = [[3.0, 12.0], [6.0, 14.0], [5.0, 16.0]]
RECTANGLE = [[10.0, 2.0], [10.4, 2.0], [10.4, 9.0], [10.0, 9.0]]


def test_walls_are_drawn_kept_in_the_address_and_erased(visit, port, drawing):
    page = drawing
    drag(page, (10, 2), (10.41, 9.02))
    expect_walls(page, [RECTANGLE])
    click(page, *TRIANGLE, (3.1, 12.1))
    expect_walls(page, [RECTANGLE, TRIANGLE])
    other = visit(port, f"#{page.url.partition('#')[2]}", reduced_motion="reduce", height=1000)
    expect_walls(other, [RECTANGLE, TRIANGLE])
    page.get_by_role("button", name="Erase walls").click()
    click(page, (15, 15))  # nothing is there
    click(page, (10.2, 5))
    expect_walls(page, [TRIANGLE])
    click(page, (4.7, 14))
    expect_walls(page, [])


def test_escape_drops_corners_then_the_tool_and_no_robot_is_inspected(drawing):
    page = drawing
    click(page, (3, 12), (6, 14))
    page.keyboard.press("Escape")
    click(page, *TRIANGLE, (3, 12))
    expect_walls(page, [TRIANGLE])
    expect(page.locator("#robot")).to_have_value("")
    page.keyboard.press("Escape")
    expect(page.get_by_role("button", name="Draw walls")).to_have_attribute("aria-pressed", "false")
    expect(page.locator("#tools p")).to_be_empty()
    move(page, 1, 1)
    point_at(
        page, Swarm(Scenario(arena={"boundary": "walls"}, place={"walls": [TRIANGLE]}), seed=1), 4, "click"
    )
    expect(page.locator("#robot")).to_have_value("4")


def test_walls_that_are_invalid_change_nothing(visit, port):
    page = visit(port, '#robots.placement="clusters"', reduced_motion="reduce", height=1000)
    page.get_by_role("button", name="Draw walls").click()
    drag(page, (10, 2), (10.41, 9.02))
    expect(page.locator("#problem")).to_contain_text("Not changed: the previous run continues.")
    expect(page.locator("#controls [aria-invalid=true]")).to_have_attribute("data-path", "robots.placement")
    assert "place.walls" not in page.url
    control_of(page, "robots.placement").select_option("uniform")
    expect(page.locator("#problem")).to_be_hidden()
    assert "place.walls" not in page.url
    drag(page, (10, 2), (10.41, 9.02))
    expect_walls(page, [RECTANGLE])

"""How the page looks: as its legend says, in both themes, with less motion, and by the rules of axe."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from playing import swarm_at
from serving import serving_at
from visiting import at, choose, expect_colours, expect_run, focus_nothing, press, seek, type_into
from waiting import drawn
from walled import PLACE, SIDE

from feasibee import Scenario
from feasibee.live.catalogue import Catalogue

expect = pytest.importorskip("playwright.sync_api", reason="playwright isn't installed").expect

AXE = Path(__file__).parents[2] / "node_modules/axe-core/axe.min.js"
WALL_AT, NO_GO_AT, DOCK_AT, OPEN_AT = (10.0, 3.0), (15.2, 2.2), (2.7, 7.2), (13.2, 8.2)
SHADES = {
    "light": ("#1d2125", "#fdfdfc", "#009e73", "#0072b2", "#d55e00"),
    "dark": ("#e6e9eb", "#0c0f11", "#22c595", "#3d9fdc", "#ee7d2b"),
}
"""Ink, ground, zone, feasible and infeasible of base.css."""
LOOKS = {
    "feasible": (1 + 16, {"centre": "F", "disc": "F", "rim": "F"}),
    "infeasible": (16, {"centre": "G", "disc": "I", "rim": "I"}),
    "no opinion": (2 + 16, {"centre": "U"}),
    "broadcasting": (1 + 4 + 16, {"centre": "F", "disc": "F", "rim": "F", "ring": "F"}),
    "declared feasible": (1 + 8 + 16, {"centre": "F", "disc": "F", "rim": "K"}),
    "declared infeasible": (8 + 16, {"centre": "G", "disc": "I", "rim": "K"}),
    "Byzantine": (1 + 16 + 32, {"centre": "F", "disc": "F", "rim": "F", "corner": "K"}),
}
PIXELS = """flags => {
    const { arena } = feasibee.lanes[0];
    arena.colours = { ...arena.colours,
        feasible: "#f00", infeasible: "#0f0", undecided: "#00f", ground: "#ff0", ink: "#000" };
    Object.assign(arena, { radius: 40, sprites: new Map() });
    const names = { "255,0,0": "F", "0,255,0": "I", "0,0,255": "U", "255,255,0": "G", "0,0,0": "K" };
    const places = [["centre", 0, 0], ["disc", 30, 0], ["rim", 37, 0], ["ring", 60, 0], ["corner", 46, 46]];
    return flags.map(each => {
        const sprite = arena.sprite(each), width = sprite.width, found = {};
        const data = sprite.getContext("2d").getImageData(0, 0, width, width).data;
        for (const [place, x, y] of places) {
            const at = 4 * ((width / 2 + y) * width + width / 2 + x), colour = data.slice(at, at + 3).join();
            if (data[at + 3]) found[place] = names[colour] ?? colour;
        }
        return found;
    });
}"""
DRAWN = """step => {
    const { lanes: [{ arena }], history } = feasibee, { context, scale, height, radius } = arena, calls = [];
    const told = name => (...given) => calls.push([name, ...given.map(Number)]);
    const get = (_, name) => typeof context[name] === "function" ? told(name) : context[name];
    arena.context = new Proxy(context, { get, set: () => true });
    arena.draw(history.frame(step), history.frame(step + 1), 0.5);
    arena.context = context;
    return { calls, scale, height, radius, places: [...arena.px].map((x, k) => [x, arena.py[k]]) };
}"""
"""What an arena draws half a step after one: each call of its canvas, and the robots' pixels."""


def mixed(one, other, part):
    """Return the colour at a share of the way from one colour to another."""
    pairs = zip(*(bytes.fromhex(each[1:]) for each in (one, other)), strict=True)
    return [start + part * (end - start) for start, end in pairs]


def test_robots_look_as_the_legend_says(show):
    seen = show(Scenario()).evaluate(PIXELS, [flags for flags, _ in LOOKS.values()])
    assert dict(zip(LOOKS, seen, strict=True)) == {name: look for name, (_, look) in LOOKS.items()}


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_plan_of_a_place_has_the_themes_ink(show, scheme):
    page = show(PLACE, color_scheme=scheme)
    ink, ground, zone, *opinions = SHADES[scheme]
    shades = page.evaluate(
        "(({ feasible, infeasible }) => [feasible, infeasible])(feasibee.lanes[0].arena.colours)"
    )
    assert shades == [f"rgb({', '.join(map(str, bytes.fromhex(each[1:])))})" for each in opinions]
    colours = {
        (18.0, 8.0): mixed("#e69f00", "#e69f00", 0),  # its only task
        WALL_AT: mixed(ink, ink, 0),
        NO_GO_AT: mixed(ground, ink, 64 / 255),
        DOCK_AT: mixed(ground, zone, 0.12),
        OPEN_AT: mixed(ground, ground, 0),
        (10.2, 7.2): mixed(ground, ground, 0),  # above the wall
    }
    expect_colours(page, colours, SIDE)
    box = page.locator("#arena").bounding_box()
    assert box["height"] / box["width"] == pytest.approx(0.5, abs=0.01)
    page.locator("#theme").click()  # "as the system" becomes "light"
    expect_colours(page, {WALL_AT: mixed(SHADES["light"][0], "#000000", 0)}, SIDE)


@pytest.mark.parametrize("step", [12, 21])
def test_robots_their_headings_aims_and_ranges_are_drawn_where_they_are(show, step):
    changes = {"acting.start": 20, "sensing.range": 3, "radio.range": 4, "run.steps": 60}
    page, scenario = show(Scenario().replace(changes)), Scenario().replace(changes)
    choose(page, 3)
    seek(page, step)
    drawn, now = page.evaluate(DRAWN, step), swarm_at(step, scenario, 1)

    def units(*pixels):
        x, y = np.transpose(pixels)
        return np.transpose([x / drawn["scale"], (drawn["height"] - y) / drawn["scale"]])

    way = swarm_at(step + 1, scenario, 1).positions - now.positions
    halfway = (now.positions + (way - 20 * np.round(way / 20)) / 2) % 20  # also across the edge
    assert np.abs(way).max() > 10 or step == 21
    assert units(*drawn["places"]) == pytest.approx(halfway, abs=0.01)
    ground, *pictures = (k for k, (name, *_) in enumerate(drawn["calls"]) if name == "drawImage")
    arcs = [each[3] / drawn["scale"] for each in drawn["calls"] if each[0] == "arc"]
    assert (ground, arcs[0], sorted(set(arcs))[1:]) == (
        0,
        3.0,
        [3.0, 4.0],
    )  # and the ring of the chosen robot
    pairs = [
        (at, one[1:3], end[1:3])
        for at, (one, end) in enumerate(pairwise(drawn["calls"]))
        if end[0] == "lineTo"
    ]
    aims, ticks = (
        [units(*each) for at, *each in pairs if (at > pictures[-1]) == is_tick] for is_tick in (0, 1)
    )
    for place, task in zip(halfway, now.targets, strict=True):
        expected = [place, now.tasks[task]]  # their numbers are their places
        if task >= 0 and np.abs(np.subtract(*expected)).max() < 10:
            assert any(each == pytest.approx(np.array(expected), abs=0.02) for each in aims)
    idle = np.flatnonzero((now.targets < 0) & ~now.standing)
    angles = [np.arctan2(*np.diff(each, axis=0)[0][::-1]) for each in ticks]
    assert len(idle) + len(aims) >= 20
    assert np.cos(angles - now.snapshot().heading[idle] * np.pi / 128) == pytest.approx(1, abs=0.001)


def test_the_theme_is_as_the_system_or_as_chosen(show):
    page, paper = show(Scenario(), color_scheme="dark"), "each => getComputedStyle(each).backgroundColor"
    grounds = [page.locator("body").evaluate(paper)]
    for _ in range(2):
        page.locator("#theme").click()
        grounds.append(page.locator("body").evaluate(paper))
    assert grounds[::-1] == ["rgb(17, 20, 23)", "rgb(246, 245, 242)", "rgb(17, 20, 23)"]


def test_less_motion_is_none_without_a_click_and_no_robot_between_two_steps(show):
    page = show(Scenario())
    drawn(page, 20)
    at(page, 0)
    page.keyboard.press(" ")
    expect(page.locator("#now")).not_to_have_text("0")
    assert {page.evaluate("feasibee.clock.between") for _ in range(20)} == {0}


def test_robots_are_seen_in_a_large_hall(show):
    page = show(Scenario(arena={"side": [4000.0, 1000.0]}, tasks={"count": 0}, run={"steps": 20}))
    assert page.evaluate(DRAWN, 0)["radius"] > 3  # pixels


def test_robots_that_have_left_are_not_drawn(show):
    page = show(Scenario(tasks={"count": 0}, events=[{"step": 10, "robots": -19}], run={"steps": 20}))
    pictures = [
        [name for name, *_ in page.evaluate(DRAWN, step)["calls"]].count("drawImage") for step in (8, 10)
    ]
    assert pictures[0] >= 21
    assert pictures[1] < 6  # with copies across the edges


@pytest.fixture(scope="module")
def served():
    with serving_at(
        Catalogue(Scenario(faults={"stopped": 0.1}, events=[{"step": 20, "tasks": 4}]), 1)
    ) as port:
        yield port


@pytest.mark.quick(2)
@pytest.mark.skipif(not AXE.is_file(), reason="needs axe-core, by npm")
@pytest.mark.parametrize(
    ("width", "scheme"), [(390, "dark"), (1440, "light"), (1440, "dark"), (390, "light")]
)
def test_axe_finds_nothing(show, served, width, scheme):
    page = show(served, "#against=census", width, 844, color_scheme=scheme)
    page.evaluate(AXE.read_text("utf-8"))
    expect_no_violation(page)
    press(page, (".", 1))
    page.locator("#arena").focus()
    page.keyboard.press("i")
    expect(page.locator("#reasons-1")).to_be_visible()
    expect_no_violation(page)
    page.get_by_role("button", name="Close").first.click()
    page.locator("details").evaluate_all("all => all.forEach(each => (each.open = true))")
    type_into(page, "sensing.gate", "-1")
    expect(page.locator(".problems")).to_be_visible()
    type_into(page, "robots.count", "-1")
    expect_no_violation(page)
    focus_nothing(page)
    page.keyboard.press("?")
    expect(page.get_by_role("dialog")).to_be_visible()
    expect_no_violation(page)


def expect_no_violation(page):
    expect_run(page)
    found = page.evaluate("axe.run()")["violations"]
    told = [(each["id"], [node["target"] for node in each["nodes"]][:5]) for each in found]
    assert not told


def test_the_first_key_skips_to_the_controls(show):
    page = show(Scenario())
    page.keyboard.press("Tab")
    expect(page.get_by_role("link", name="Skip to the playback controls")).to_be_focused()
    page.keyboard.press("Enter")
    page.keyboard.press("Tab")
    expect(page.locator("#step")).to_be_focused()

"""The live arena in a real browser: what somebody sees and does there."""

from __future__ import annotations

import re

import numpy as np
import pytest
from declaring import declaring
from playing import swarm_at, swept
from serving import serving_at
from visiting import (
    change,
    control_of,
    expect_no_scrolling,
    expect_picture,
    expect_shade,
    focus_nothing,
    picture_of,
    play_to_the_end,
    point_at,
    press,
    seek,
    step_of,
)
from waiting import eventually, expect_rest

from feasibee import Scenario, Swarm, simulate
from feasibee.live.catalogue import Catalogue, read_catalogue
from feasibee.live.reasons import sentence_of
from feasibee.live.timeline import History, Timeline

expect = pytest.importorskip("playwright.sync_api", reason="playwright isn't installed").expect


def test_keys_step_play_pause_and_restart(visit, port):
    page = visit(port)
    expect(page.locator("#now")).to_have_text("0")
    press(page, (".", 1), ("ArrowRight", 2))
    page.get_by_role("button", name="One step").click()
    expect(page.locator("#now")).to_have_text("3")
    faster, slower = (page.get_by_role("button", name=each) for each in ("Faster", "Slower"))
    for act, pace in (
        (lambda: page.keyboard.press("+"), 30),
        (faster.click, 60),
        (lambda: page.keyboard.press("-"), 30),
        (slower.click, 20),
    ):
        act()
        expect(page.locator("#speed")).to_have_text(f"{pace} steps / s")
    focus_nothing(page)
    page.keyboard.press(" ")
    expect(page.get_by_role("button", name="Pause")).to_be_visible()
    expect(page.locator("#now")).not_to_have_text("3")
    page.get_by_role("button", name="Pause").click()
    expect(page.get_by_role("button", name="Play", exact=True)).to_be_visible()
    expect_rest(page, step_of)
    press(page, ("r", 0))
    page.get_by_role("button", name="Play", exact=True).click()
    expect(page.locator("#now")).not_to_have_text("0")
    page.get_by_role("button", name="Restart").click()
    expect(page.locator("#now")).to_have_text("0")
    focus_nothing(page)
    page.keyboard.press("?")
    expect(page.get_by_role("dialog")).to_be_visible()
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog")).to_be_hidden()


def test_the_page_says_what_simulate_says(visit, port):
    page = visit(port, "#seed=1&run=4&tasks.count=24")
    expected = simulate(Scenario(tasks={"count": 24}), 1, 1, first_run=4, curves=True)
    play_to_the_end(page)
    word = {1: "feasible", 0: "infeasible"}[int(expected.decision[0])]
    expect(page.locator("#decision")).to_contain_text(word)
    expect(page.locator("#decision")).to_contain_text(f"step {int(expected.decision_step[0])}")
    expect(page.locator("#feasible")).to_have_text(str(int(expected.feasible_count[0, -1])))
    expect(page.locator("#truth")).to_have_text("infeasible (20 robots, 24 tasks)")
    right = "right" if word == "infeasible" else "wrong"
    expect(page.locator("#judgement")).to_have_text(f"The swarm's decision is {right}.")
    expect(page.locator("#announcer")).to_contain_text("The swarm has decided at step")


def test_the_theory_is_drawn_behind_the_swarms_curve(visit, port):
    page = visit(port, "#tasks.count=10")
    theory, marks = page.locator("#theory"), page.locator("#tasks-marks option")
    expect(theory).to_contain_text("75 % of such swarms decide feasible")
    expect(theory.get_by_role("listitem")).to_have_text([re.compile("^theory: "), "tipping point"])
    expect(marks).to_have_attribute("value", "20")
    expect_shade(page, "#plot", True)
    control_of(page, "decision.strategy").select_option("majority")
    expect(theory).to_contain_text("50 % of such swarms decide feasible")
    expect(marks).to_have_count(0)
    control_of(page, "decision.strategy").select_option("census")
    expect(theory).to_contain_text("No predicted curve: decision.strategy = 'census'")
    expect(theory.get_by_role("listitem")).to_have_count(0)
    expect_shade(page, "#plot", False)


def test_a_change_starts_anew_and_shows_the_scenario(visit, port):
    page = visit(port)
    page.locator("[data-slides='tasks.count']").fill("33")
    expect(page.locator("#question")).to_have_text("Can 20 robots do 33 tasks?")
    expect(page.locator("[data-path='tasks.count']")).to_have_value("33")
    expect(page.locator("#truth")).to_have_text("infeasible (20 robots, 33 tasks)")
    expect(page.locator("#now")).to_have_text("0")
    control_of(page, "arena.boundary").select_option("walls")
    page.get_by_label("Robots avoid collisions").check()
    page.get_by_text("Scenario as TOML").click()
    expect(page.locator("#toml")).to_contain_text("avoid_collisions = true")
    scenario = Scenario.from_toml(page.locator("#toml").inner_text())
    changes = {"tasks.count": 33, "arena.boundary": "walls", "robots.avoid_collisions": True}
    assert scenario == Scenario().replace(changes)
    page.reload()
    expect(page.locator("#truth")).to_have_text("infeasible (20 robots, 33 tasks)")
    page.get_by_role("button", name="Undo all changes").click()
    expect(page.locator("#truth")).to_have_text("feasible (20 robots, 20 tasks)")


@pytest.mark.slow
def test_bodies_bring_a_choice_of_what_blocked_robots_do(visit, port):
    page = visit(port)
    contact, bodies = page.get_by_label("Blocked robots"), page.get_by_label("Robots avoid collisions")
    control_of(page, "robots.avoid_collisions")
    expect(bodies).to_be_visible()
    expect(contact).to_be_hidden()
    bodies.check()
    contact.select_option("deflect")
    expect(page.locator("#toml")).to_contain_text('contact = "deflect"')
    bodies.uncheck()
    expect(page.locator("#note-robots-contact")).to_contain_text("set robots.avoid_collisions to true")
    contact.select_option("stand")
    expect(contact).to_be_hidden()
    expect(page.locator("#toml")).to_contain_text("avoid_collisions = false")


def test_a_wrong_value_is_told_at_its_control_and_the_swarm_goes_on(visit, port):
    page = visit(port)
    control = change(page, "robots.count", "-4")
    expect(control).to_have_attribute("aria-invalid", "true")
    expect(page.locator("#note-robots-count")).to_contain_text("robots.count = -4: must be ≥ 1")
    expect(page.locator("#problem")).to_contain_text("the previous run continues")
    change(page, "seed", "seven")
    expect(page.locator("#note-seed")).to_contain_text("must be a whole number")
    expect(page.locator("#note-robots-count")).to_be_visible()
    focus_nothing(page)
    press(page, (".", 1))
    change(page, "seed", "2")
    change(page, "robots.count", "25")
    expect(page.locator("#truth")).to_have_text("feasible (25 robots, 20 tasks)")
    expect(page.locator("#note-robots-count")).to_be_hidden()


@pytest.mark.slow
def test_markup_in_a_name_stays_text(visit):
    robots = {"classes": [{"name": "<img src=x onerror=alert(1)>", "count": 3, "skills": ["lift"]}]}
    tasks = {"classes": [{"name": "<b>", "count": 1, "needs": {"lift": 1}}]}
    scenario = Scenario(robots=robots, tasks=tasks, arena={"side": 4.0})
    with serving_at(Catalogue(scenario, title="<i>x</i>")) as port:
        page = visit(port)
        point_at(page, Swarm(scenario), 0, "move")
        expect(page.locator("#tip")).to_contain_text("class <img src=x onerror=alert(1)>")
        expect(page.locator("#title")).to_have_text("<i>x</i>")
        assert page.locator("main img").count() == 0


@pytest.mark.slow
def test_the_page_fits_any_width(visit, port):
    page = visit(port, width=360, height=740)
    for width, height in ((360, 740), (800, 600), (1440, 900), (1920, 1080)):
        page.set_viewport_size({"width": width, "height": height})
        expect_no_scrolling(page, width)
        eventually(page, lambda size=(width, height): expect_arena_within(page, *size))


def expect_arena_within(page, width, height):
    box = page.locator("#arena").bounding_box()
    assert box["x"] >= 0
    assert box["x"] + box["width"] <= width
    assert min(box["width"], box["height"]) >= 0.3 * min(width, height)
    assert box["y"] + box["height"] <= height


@pytest.mark.slow
def test_a_page_whose_server_stops_says_so_and_goes_on_when_it_is_back(visit, same_port):
    catalogue, port = Catalogue(Scenario(), seed=1), same_port
    with serving_at(catalogue, port):
        page = visit(port, "#seed=3&tasks.count=11", reduced_motion="reduce")
        for step in range(1, 4):
            press(page, (".", step))
        seen = picture_of(page)
    expect(page.get_by_role("alert").first).to_contain_text("The server doesn't answer")
    expect(page.locator("#connection")).to_have_text("not connected")
    expect(page.locator("#banner-text")).to_contain_text("next attempt in 2 s")  # two have failed
    with serving_at(catalogue, port):
        expect(page.locator("#connection")).to_have_text("live")
        expect(page.locator("#banner")).to_be_hidden()
        expect(page.locator("#now")).to_have_text("3")
        expect(page.locator("#truth")).to_have_text("feasible (20 robots, 11 tasks)")
        expect_picture(page, seen)
        press(page, (".", 4))
        page.goto("about:blank")
    visit.errors[:] = [each for each in visit.errors if "WebSocket connection" not in each]


def test_a_sweeps_wrong_runs_are_listed_and_replayed(visit, tmp_path):
    tables = {"runs": 20, "seed": 5, "scenario": {"run": {"steps": 1000}}, "sweep": {"tasks.count": [17, 24]}}
    catalogue = read_catalogue(swept(tables, tmp_path), "wrong")
    chosen = catalogue.replays[-1]
    with serving_at(catalogue) as port:
        page = visit(port)
        expect(page.locator("#replays-title")).to_have_text(f"{catalogue.found} runs that decided wrong")
        expect(page.locator("#replay-list button")).to_have_count(catalogue.found)
        groups = page.locator("#replay-list summary")
        expect(groups).to_contain_text(["tasks.count 17", "tasks.count 24"])
        groups.last.click()
        expect(page.locator("#replay-list button").last).to_be_hidden()
        page.keyboard.press("Enter")  # unfold again
        expect(page.locator("[aria-current='true']")).to_have_count(1)
        button = page.locator("#replay-list button").last
        words = {1: "feasible", 0: "infeasible"}
        decided = f"{words[chosen.decision]} at step {chosen.decision_step}"
        assert f"run {chosen.run}: {decided}" in button.inner_text()
        button.focus()
        page.keyboard.press("Enter")
        expect(page.get_by_role("button", name="Pause")).to_be_visible()  # picking a run plays it
        focus_nothing(page)
        page.keyboard.press(" ")
        expect(page.get_by_role("button", name="Play", exact=True)).to_be_visible()
        expect(page.locator("[data-path='run']")).to_have_value(str(chosen.run))
        expect(button).to_have_attribute("aria-current", "true")
        play_to_the_end(page)
        expect(page.locator("#verdict")).to_have_attribute("data-verdict", "wrong")
        expect(page.locator("#decision")).to_have_text(re.compile(rf"step {chosen.decision_step}\b"))


LOOKS = {
    "feasible": (1 + 16, {"centre": "F", "disc": "F", "rim": "F"}),
    "infeasible": (16, {"centre": "G", "disc": "I", "rim": "I"}),
    "no opinion": (2 + 16, {"centre": "U"}),
    "disseminating": (1 + 4 + 16, {"centre": "F", "disc": "F", "rim": "F", "ring": "F"}),
    "declared feasible": (1 + 8 + 16, {"centre": "F", "disc": "F", "rim": "K"}),
    "declared infeasible": (8 + 16, {"centre": "G", "disc": "I", "rim": "K"}),
    "Byzantine": (1 + 16 + 32, {"centre": "F", "disc": "F", "rim": "F", "corner": "K"}),
}
PIXELS = """async flags => {
    const { drawSprite } = await import("./sprites.js");
    const colours = { feasible: "#f00", infeasible: "#0f0", undecided: "#00f", ground: "#ff0", ink: "#000" };
    const names = { "255,0,0": "F", "0,255,0": "I", "0,0,255": "U", "255,255,0": "G", "0,0,0": "K" };
    const sprite = drawSprite(flags, 40, colours), width = sprite.width;
    const data = sprite.getContext("2d").getImageData(0, 0, width, width).data;
    const found = {}, places = [["centre", 0, 0], ["disc", 30, 0], ["rim", 37, 0], ["ring", 60, 0]];
    places.push(["corner", 46, 46]);
    for (const [place, x, y] of places) {
        const at = 4 * ((width / 2 + y) * width + width / 2 + x);
        const colour = data.slice(at, at + 3).join();
        if (data[at + 3]) found[place] = names[colour] ?? colour;
    }
    return found;
}"""

COLOURED = """at => {
    const { data } = at.getContext("2d").getImageData(0, 0, at.width, at.height);
    let seen = 0;
    for (let k = 0; k < data.length; k += 4)
        seen += Math.abs(data[k] - data[k + 2]) > 80;
    return seen;
}"""


@pytest.mark.quick(2)
@pytest.mark.parametrize("look", LOOKS)
def test_robots_look_as_the_legend_says(visit, port, look):
    flags, expected = LOOKS[look]
    assert visit(port).evaluate(PIXELS, flags) == expected


def test_the_page_says_what_is_seen_and_why_a_robot_holds_its_opinion(visit, port):
    page = visit(port, reduced_motion="reduce")
    seek(page, 80)
    page.get_by_text("What am I looking at?").click()
    terms = ["Exploring", "Broadcasting", "Opinion", "Declaration", "Truth"]
    expect(page.locator("#terms dt")).to_have_text(terms)
    swarm = swarm_at(80, seed=1)
    for robot in (3, 5):
        timeline = Timeline(Swarm(seed=1))
        timeline.advance(80)
        point_at(page, swarm, robot, "move")
        expect(page.locator("#tip")).to_contain_text(f"Robot {robot}: ")
        expect(page.locator("#tip")).to_contain_text(sentence_of(timeline.swarm, robot, History(timeline)))
    page.mouse.move(1, 1)
    expect(page.locator("#tip")).to_be_hidden()


def test_robots_are_seen_in_a_large_hall(visit, port):
    page = visit(port, "#arena.side=[4000.0,1000.0]&tasks.count=0", reduced_motion="reduce")
    expect(page.locator("#truth")).to_contain_text("0 tasks")

    def check():
        seen = page.locator("#arena").evaluate(COLOURED)
        assert seen > 20 * 25  # pixels of 20 robots

    eventually(page, check)


@pytest.mark.slow
def test_declarations_are_counted_and_told(visit, tmp_path):
    scenario = declaring(tmp_path, quiet=20.0, faults={"byzantine": 0.2}, run={"steps": 60})
    swarm = swarm_at(60, scenario, seed=1)
    feasible, infeasible = swarm.declared_counts
    assert feasible
    with serving_at(Catalogue(scenario, seed=1)) as port:
        page = visit(port)
        expect(page.locator("#legend-declared")).to_be_visible()
        expect(page.locator("#declared")).to_have_text("0 feasible, 0 infeasible, of 16")
        play_to_the_end(page)
        expect(page.locator("#declared")).to_have_text(f"{feasible} feasible, {infeasible} infeasible, of 16")
        robot = int(np.flatnonzero(swarm.declared == 1)[0])
        point_at(page, swarm, robot, "move")
        expect(page.locator("#tip")).to_contain_text(f"Robot {robot}: feasible")
        expect(page.locator("#tip")).to_contain_text("has declared")


@pytest.mark.slow
def test_ten_thousand_robots_are_drawn(visit, port):
    page = visit(port, "#robots.count=10000&tasks.count=9000&arena.side=447")
    press(page, (".", 1))
    expect(page.locator("#feasible")).to_have_text(re.compile("^[45],"))


@pytest.mark.quick(1)
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_light_and_dark_as_the_system_or_as_chosen(visit, port, scheme):
    page = visit(port, color_scheme=scheme, reduced_motion="reduce")
    paper = "each => getComputedStyle(each).backgroundColor"
    grounds = [page.locator("body").evaluate(paper)]
    for _ in range(2):
        page.locator("#theme").click()
        grounds.append(page.locator("body").evaluate(paper))
    assert grounds[1:] == ["rgb(246, 245, 242)", "rgb(17, 20, 23)"]
    assert grounds[0] == grounds[1 if scheme == "light" else 2]
    press(page, (".", 1))


def test_every_control_has_a_name(visit, port):
    page = visit(port)
    nameless = page.locator("button, input, select").evaluate_all(
        "all => all.filter(it => !(it.ariaLabel || it.textContent.trim() || it.labels?.length)).length"
    )
    assert nameless == 0
    for each in ("#declared-row", "#legend-declared"):
        expect(page.locator(each)).to_be_hidden()  # in a scenario without declarations
    expect(page.locator("#arena")).to_have_attribute("aria-label", re.compile("20 robots and 20 tasks"))


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    ("units", "shown"), [({}, "1 of 1,000"), ({"seconds": 90.0}, "1 of 1,000, 1 min 30 s")]
)
def test_the_clock_shows_the_time_if_a_step_has_a_length(visit, units, shown):
    with serving_at(Catalogue(Scenario(units=units), seed=1)) as port:
        page = visit(port)
        page.keyboard.press(".")
        expect(page.locator("#clock")).to_have_text(shown)

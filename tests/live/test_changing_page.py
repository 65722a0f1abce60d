"""A world that changes in a real browser: its truth, its marks, its preset, robots that leave."""

from __future__ import annotations

import re
from io import BytesIO

import numpy as np
import pytest
from PIL import Image
from playing import swarm_at
from serving import serving_at
from visiting import (
    at,
    change,
    colours_of,
    expect_picture,
    focus_nothing,
    picture_of,
    press,
    seek,
    unfolded,
)
from waiting import eventually

from feasibee import Scenario
from feasibee.live.catalogue import Catalogue
from feasibee.live.reasons import reasons_of

expect = pytest.importorskip("playwright.sync_api", reason="playwright isn't installed").expect

EVENTS = [{"step": 20, "tasks": 6}, {"step": 40, "robots": -8}, {"step": 70, "tasks": -20, "robots": 3}]
SCENARIO = Scenario(events=EVENTS, decision={"strategy": "census"}, run={"steps": 120})
TIMES = "\N{MULTIPLICATION SIGN}"


@pytest.fixture(scope="module")
def port():
    with serving_at(Catalogue(SCENARIO, 5)) as at:
        yield at


@pytest.fixture(scope="module")
def still():
    with serving_at(Catalogue(Scenario())) as at:
        yield at


@pytest.mark.slow
def test_the_truth_of_each_step_is_said_and_gone_to_by_keys(visit, port):
    page = visit(port, reduced_motion="reduce")
    expect(page.locator("#marks-text")).to_contain_text(
        "the world changes 3 times, the truth 2 times, at 20, 70"
    )
    expect(page.locator("#truth")).to_have_text("feasible (20 robots, 20 tasks)")
    for key, step, said in (
        ("]", 20, "infeasible (20 robots, 26 tasks)"),
        ("]", 70, "feasible (15 robots, 6 tasks)"),
        ("]", 70, "feasible (15 robots, 6 tasks)"),
        ("[", 20, "infeasible (20 robots, 26 tasks)"),
        (",", 19, "feasible (20 robots, 20 tasks)"),
    ):
        press(page, (key, step))
        expect(page.locator("#truth")).to_have_text(said)
    seek(page, 45)
    expect(page.locator("#truth")).to_have_text("infeasible (12 robots, 26 tasks)")
    held = {1: "feasible", 0: "infeasible", -1: "undecided"}[swarm_at(45, SCENARIO, 5).decision]
    expect(page.locator("#decision")).to_have_text(held)
    expect(page.locator("#arena")).to_have_attribute(
        "aria-label",
        "The arena: 12 robots and 26 tasks, census, at step 45. Arrow keys go from robot to robot.",
    )


def test_robots_and_tasks_are_drawn_while_they_are_there(visit, port):
    """A page at a step looks the same whether it came from before or from after."""
    page = visit(port, reduced_motion="reduce")
    expect(page.locator("#marks-text")).to_contain_text("the truth 2 times")
    focus_nothing(page)
    page.mouse.move(1, 1)
    seen = {}
    for step in (19, 39, 41, 119, 71, 41, 39, 19):
        seek(page, step)
        if step in seen:
            expect_picture(page, seen[step])
        else:
            seen[step] = picture_of(page)
    assert len(set(seen.values())) == 5


@pytest.mark.slow
def test_robots_that_have_left_are_not_drawn(visit):
    scenario = Scenario(tasks={"count": 0}, events=[{"step": 10, "robots": -19}], run={"steps": 20})
    with serving_at(Catalogue(scenario, 5)) as port:
        page = visit(port, reduced_motion="reduce")
        shares = []
        for step in (9, 10):
            seek(page, step)
            with Image.open(BytesIO(picture_of(page))) as picture:
                pixels = np.asarray(picture.convert("RGB")).astype(int)
            shares.append((np.ptp(pixels, axis=2) > 40).sum())
        page.goto("about:blank")
    assert 0 < shares[1] < shares[0] / 8


def expect_colours(page, selector, expected):
    assert expected <= colours_of(page, selector)


@pytest.mark.slow
def test_the_truth_is_a_band_on_the_seek_bar_and_behind_the_plot(visit, port):
    page = visit(port, reduced_motion="reduce")
    expect(page.locator("#legend-truth")).to_be_visible()
    expect(page.locator("#marks-text")).to_contain_text("the truth 2 times")
    eventually(page, lambda: expect_colours(page, "#marks", {"0,114,178", "98,103,109"}))  # truth, ticks
    seek(page, 120)
    focus_nothing(page)
    eventually(page, lambda: expect_stripes(page))


def expect_stripes(page):
    """Expect that the band is full in parts, and striped where the tasks are infeasible."""
    rows = page.evaluate(
        """() => { const it = document.querySelector("#plot"), pen = it.getContext("2d");
        const line = [...pen.getImageData(0, 5, it.width, 1).data], found = [];
        for (let x = 0; x < it.width; x++) found.push(line.slice(4 * x, 4 * x + 3).join());
        return found; }"""
    )
    full = [x for x, colour in enumerate(rows) if colour == "0,114,178"]
    assert full
    assert max(np.diff(full)) > len(rows) / 6


@pytest.mark.slow
def test_a_robot_that_leaves_is_inspected_and_arrows_pass_over_it(visit, port):
    before, after = swarm_at(39, SCENARIO, 5), swarm_at(41, SCENARIO, 5)
    gone = int(np.flatnonzero(before.present & ~after.present)[0])
    page = visit(port)
    seek(page, 39)
    page.locator("#robot").fill(str(gone))
    page.keyboard.press("Tab")
    expected = dict(reasons_of(before, gone))["Phase"]
    expect(page.locator("#reasons-0 dd").first).to_have_text(expected)
    focus_nothing(page)
    press(page, (".", 40))
    expect(page.locator("#reasons-0 dd").first).to_have_text("no robot has this number at this step")
    page.locator("#arena").focus()
    page.keyboard.press("PageDown")
    numbers = np.flatnonzero(after.present)
    following = int(numbers[numbers > gone][0]) if (numbers > gone).any() else int(numbers[0])
    expect(page.locator("#robot")).to_have_value(str(following))
    for key in 4 * ("ArrowLeft", "ArrowUp", "ArrowRight", "PageUp", "ArrowDown"):
        page.keyboard.press(key)
        assert int(page.locator("#robot").input_value()) in numbers  # as soon as the key is down
    page.keyboard.press("]")
    expect(page.locator("#reasons-0")).to_be_visible()


@pytest.mark.slow
def test_the_preset_and_the_rate_of_change_by_keyboard(visit, still):
    page = visit(still)
    expect(page.locator("#legend-truth")).to_be_hidden()
    expect(page.locator("#stream")).to_be_hidden()
    unfolded(page, "#changing summary")
    page.locator("#changing").evaluate("it => (it.open = false)")
    page.locator("#changing summary").focus()
    page.keyboard.press("Enter")
    expect(page.locator("#rate-row")).to_be_hidden()
    page.keyboard.press("Tab")
    expect(page.locator("#stream")).to_be_focused()
    page.keyboard.press("Enter")
    expect(page.locator("#last")).to_have_text("2,500")
    expect(page.locator("#play")).to_have_attribute("aria-label", "Pause")
    expect(page.locator("[data-path='tasks.lifetime']")).to_have_value("1800")
    expect(page.locator("#marks-text")).to_contain_text("the truth")
    page.locator("#rate").focus()
    for factor, rate, lifetime in ((2, "0.0228", "900"), (4, "0.0456", "450"), (8, "0.0912", "225")):
        page.keyboard.press("ArrowRight")
        expect(page.locator("[data-path='tasks.arrival_rate']")).to_have_value(rate)
        expect(page.locator("[data-path='tasks.lifetime']")).to_have_value(lifetime)
        expect(page.locator("#rate-shown")).to_have_text(f"{TIMES} {factor}")
        expect(page.locator("#rate")).to_have_attribute("aria-valuetext", f"{TIMES} {factor}")
    page.keyboard.press("Home")
    expect(page.locator("[data-path='tasks.lifetime']")).to_have_value("14400")
    expect(page.locator("#rate-shown")).to_have_text("÷ 8")
    change(page, "tasks.lifetime", "1000")  # a new middle
    expect(page.locator("#rate-shown")).to_have_text(f"{TIMES} 1")
    expect(page).to_have_url(re.compile("tasks.lifetime=1000"))
    page.reload()
    expect(page.locator("[data-path='tasks.lifetime']")).to_have_value("1000")
    page.get_by_role("button", name="Undo all changes").click()
    expect(page.locator("#last")).to_have_text("1,000")
    expect(page.locator("#truth")).to_have_text("feasible (20 robots, 20 tasks)")
    expect(page.locator("#rate-row")).to_be_hidden()


@pytest.mark.slow
def test_two_strategies_are_compared_in_one_changing_world(visit, port):
    page = visit(port, reduced_motion="reduce")
    page.locator("#against").select_option("dmmd")
    expect(page.locator("#caption-1")).to_contain_text("dmmd")
    seek(page, 45)
    expect(page.locator("#arena-1")).to_have_attribute(
        "aria-label",
        "The arena: 12 robots and 26 tasks, dmmd, at step 45. Arrow keys go from robot to robot.",
    )
    at(page, 45)


def test_events_are_typed_on_the_page(visit, port):
    page = visit(port)
    change(page, "events", "[{ step = 5, tasks = 1 }]")
    expect(page.locator("#marks-text")).to_contain_text("the world changes once, the truth once, at 5")
    change(page, "events", "[{ step = 500, tasks = 1 }]")
    expect(page.locator("#note-events")).to_contain_text("is after the end of a run")

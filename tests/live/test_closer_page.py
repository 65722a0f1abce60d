"""Seeking, comparing and inspecting in a real browser, by pointer and by keyboard alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from playing import looked, swarm_at
from visiting import (
    at,
    change,
    control_of,
    expect_no_scrolling,
    expect_picture,
    expect_reasons,
    focus_nothing,
    lines_of,
    picture_of,
    play_to_the_end,
    point_at,
    press,
    seek,
)
from waiting import eventually

from feasibee import Scenario, Swarm, simulate
from feasibee.live.reasons import reasons_of
from feasibee.live.timeline import Outlook

expect = pytest.importorskip("playwright.sync_api", reason="playwright isn't installed").expect

STRIP = """(at, steps) => {
  const copy = new OffscreenCanvas(at.width, at.height);
  const pen = copy.getContext("2d", { willReadFrequently: true });
  pen.drawImage(at, 0, 0);
  const x = (step) => Math.round(8 + ((at.width - 16) * step) / 1000);
  return steps.map((step) => [9, 13].map((y) => [...pen.getImageData(x(step), y, 1, 1).data]));
}"""
AXE = Path(__file__).parents[2] / "node_modules/axe-core/axe.min.js"


def test_the_seek_bar_goes_to_any_step_and_back(visit, port):
    page = visit(port, reduced_motion="reduce")
    seek(page, 30)
    focus_nothing(page)
    page.mouse.move(1, 1)
    seen = picture_of(page)
    seek(page, 700)
    expect(page.locator("#seek")).to_have_attribute("aria-valuetext", "step 700 of 1,000")
    page.locator("#seek").focus()
    press(page, ("ArrowLeft", 699), (".", 700))
    seek(page, 31)
    page.get_by_role("button", name="Step back").click()
    at(page, 30)
    focus_nothing(page)
    page.mouse.move(1, 1)
    expect_picture(page, seen)
    press(page, (",", 29), ("ArrowLeft", 28), (".", 29), ("ArrowRight", 30), ("r", 0), (",", 0))
    play_to_the_end(page)
    press(page, (",", 999))
    page.keyboard.press(" ")
    at(page, 1000)


@pytest.mark.slow
def test_a_seek_before_the_first_frame_is_kept(visit, port):
    page = visit(port)
    page.evaluate(
        """() => new MutationObserver((_, observer) => {
            observer.disconnect(); // the run is known, and nothing of it is shown yet
            const slider = document.querySelector("#seek");
            slider.value = "39";
            slider.dispatchEvent(new Event("input"));
        }).observe(document.querySelector("#last"), { childList: true })"""
    )
    page.locator("#another").click()
    at(page, 39)


@pytest.mark.slow
def test_the_decision_is_one_key_away(visit, port):
    decided = int(simulate(Scenario(), 1, 1).decision_step[0])
    page = visit(port)
    expect(page.locator("#marks-text")).to_have_text(f"Decision at step {decided}.")
    press(page, ("d", decided))
    expect(page.locator("#decision")).to_have_text(f"infeasible, since step {decided}")
    press(page, (",", decided - 1))
    expect(page.locator("#decision")).to_have_text("undecided")
    page.get_by_role("button", name="Go to the decision").click()
    at(page, decided)
    press(page, ("r", 0))
    change(page, "run.steps", "40")
    expect(page.locator("#marks-text")).to_have_text("No decision.")
    focus_nothing(page)
    press(page, (".", 1))
    page.keyboard.press("d")
    expect(page.locator("#announcer")).to_have_text("The swarm has not decided by step 40")
    at(page, 1)


def neighbour(positions, robot, direction):
    """Return the robot that an arrow leads to: the nearest within 45 degrees of its direction."""
    moved = positions - positions[robot]
    along, across = moved @ direction, np.abs(moved @ np.array([direction[1], direction[0]]))
    distance = np.where((along > 0) & (across <= along), (moved**2).sum(axis=1), np.inf)
    return robot if np.isinf(distance.min()) else int(distance.argmin())


ARROWS = {"ArrowLeft": (-1, 0), "ArrowRight": (1, 0), "ArrowUp": (0, 1), "ArrowDown": (0, -1)}


def test_robots_are_inspected_by_keyboard_alone(visit, port):
    page = visit(port)
    swarm = Swarm(Scenario(), 1)
    for _ in range(3):
        page.keyboard.press(".")
    at(page, 3)
    swarm.advance(3)
    for _ in range(20):
        if page.evaluate("document.activeElement.id") == "arena":
            break
        page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.id") == "arena"
    page.keyboard.press("Enter")
    robot = 0
    for key in ("ArrowLeft", "ArrowUp", "ArrowUp", "ArrowRight", "ArrowDown", "ArrowRight"):
        expect(page.locator("#robot")).to_have_value(str(robot))
        page.keyboard.press(key)
        robot = neighbour(swarm.positions, robot, np.array(ARROWS[key]))
    expect(page.locator("#robot")).to_have_value(str(robot))
    page.keyboard.press("PageDown")
    robot = (robot + 1) % 20
    expect(page.locator("#robot")).to_have_value(str(robot))
    expect_reasons(page, swarm, robot)
    at(page, 3)  # arrows went from robot to robot, not from step to step
    press(page, (".", 4))
    swarm.advance()
    expect_reasons(page, swarm, robot)
    page.keyboard.press("Escape")
    expect(page.locator("#reasons-0")).to_be_hidden()
    expect(page.locator("#robot")).to_have_value("")


@pytest.mark.slow
def test_the_changes_of_a_robot_are_marked_and_gone_to(visit, port):
    page = visit(port)
    page.locator("#robot").fill("5")
    page.keyboard.press("Tab")
    found = looked(Outlook(Swarm(seed=1), 1000), 5)
    steps = [step for step, _ in found["changes"]]
    decided = found["decision"]
    expect(page.locator("#marks-text")).to_have_text(
        f"Decision at step {decided}, robot 5 changes opinion or phase {len(steps) - 1} times."
    )
    focus_nothing(page)
    press(page, ("]", steps[1]), ("]", steps[2]), ("[", steps[1]), ("[", 0), ("]", steps[1]))
    ends = [*steps[1:], 1000]
    middles = [(a + b) / 2 for a, b in zip(steps, ends, strict=True) if b - a > 20]
    flags = [dict(found["changes"])[max(each for each in steps if each <= middle)] for middle in middles]
    seen = page.locator("#marks").evaluate(STRIP, middles)
    blue, vermilion, none = [0, 114, 178, 255], [213, 94, 0, 255], [0, 0, 0, 0]
    assert seen == [[blue, blue] if each & 1 else [vermilion, none] for each in flags]
    assert {each & 5 for each in flags} >= {0, 4}  # it explores and broadcasts with the same look


@pytest.mark.slow
def test_a_robot_that_is_clicked_is_inspected_while_time_goes_on(visit, port):
    page = visit(port, reduced_motion="reduce")
    point_at(page, Swarm(Scenario(), 1), 11, "click")
    expect(page.locator("#robot")).to_have_value("11")
    page.keyboard.press(" ")
    expect(page.locator("#now")).not_to_have_text("0")
    expect_reasons_of_the_step_that_is_shown(page)
    page.keyboard.press(" ")
    expect(page.get_by_role("button", name="Play", exact=True)).to_be_visible()
    expect_reasons_of_the_step_that_is_shown(page)
    page.keyboard.press("n")  # the next run shows the same robot
    expect(page.locator("[data-path='run']")).to_have_value("1")
    expect_reasons(page, Swarm(Scenario(), 1, 1), 11)
    page.locator("#robot-none").click()
    expect(page.locator("#reasons-0")).to_be_hidden()


def expect_reasons_of_the_step_that_is_shown(page):
    def check():
        step, lines = lines_of(page)
        swarm = swarm_at(step, Scenario(), 1)
        assert lines == reasons_of(swarm, 11)
        assert step

    eventually(page, check)


def test_two_strategies_are_compared_on_one_clock(visit, port):
    page = visit(port, width=1000)
    expect(page.locator("#arena-1")).to_be_hidden()
    page.get_by_label("Compare with").select_option("census")
    expect(page.locator("#arena-1")).to_be_visible()
    steps = []
    for place, strategy in enumerate(("dmmd", "census")):
        expected = simulate(Scenario(decision={"strategy": strategy}), 1, 1, curves=True)
        steps.append(int(expected.decision_step[0]))
        caption = page.locator(f"#caption{'-1' if place else ''}")
        expect(caption.locator("strong")).to_have_text(strategy)
    focus_nothing(page)
    press(page, ("D", steps[1]))
    expect(page.locator("#caption-1")).to_contain_text(f"feasible at step {steps[1]}: right")
    expect(page.locator("#caption")).to_contain_text("undecided")
    press(page, ("d", steps[0]))
    expect(page.locator("#caption")).to_contain_text(f"infeasible at step {steps[0]}: wrong")
    play_to_the_end(page)
    for place, strategy in enumerate(("dmmd", "census")):
        expected = simulate(Scenario(decision={"strategy": strategy}), 1, 1, curves=True)
        feasible, infeasible = (
            int(each[0, -1]) for each in (expected.feasible_count, expected.infeasible_count)
        )
        expect(page.locator(f"#caption{'-1' if place else ''}")).to_contain_text(
            f"{feasible} feasible, {infeasible} infeasible"
        )
    page.keyboard.press("i")
    page.keyboard.press("PageDown")
    expect(page.locator("#reasons-1 h3")).to_have_text("Right: census")
    expect(page.locator(".which")).to_have_text(3 * ["Left: dmmd"])
    expect(page.locator("#verdict .which")).to_be_visible()
    expect(page.locator("#reasons-1")).to_contain_text("20 robots and 20 tasks, by name")
    expect(page.locator("#reasons-0")).to_contain_text("Heard")
    page.reload()
    expect(page.locator("#caption-1 strong")).to_have_text("census")  # the address keeps it
    page.get_by_label("Compare with").select_option("turns")
    expect(page.locator("#problem, .note").filter(has_text="know_count").first).to_be_visible()
    page.get_by_role("button", name="Undo all changes").click()
    expect(page.locator("#arena-1")).to_be_hidden()


def test_the_theory_is_said_of_both_strategies(visit, port):
    page = visit(port, "#tasks.count=10")
    page.get_by_label("Compare with").select_option("majority")
    lines = page.locator("#theory").get_by_role("listitem"), page.locator("#theory-1").get_by_role("listitem")
    expect(page.locator("#theory")).to_contain_text("75 % of such swarms decide feasible")
    expect(page.locator("#theory-1")).to_contain_text("50 % of such swarms decide feasible")
    expect(lines[1]).to_have_text(lines[0].all_text_contents())


@pytest.mark.slow
def test_every_field_is_under_more(visit, port):
    page = visit(port)
    page.get_by_text("All settings").click()
    page.get_by_text("More", exact=True).click()
    changes = {
        "sensing.count_self": True,
        "robots.placement": "clusters",
        "decision.declare": "{rounds = 2}",
        "decision.inbox_size": 4,
        "tasks.classes": '[{name = "carry", count = 3, needs = {lift = 2}}]',
        "robots.classes": '[{name = "arm", count = 9, skills = ["lift"]}]',
    }
    shown = {"tasks": 'name = "carry"', "robots": 'name = "arm"'}
    for path, value in changes.items():
        control = control_of(page, path)
        if value is True:
            control.check()
        elif path == "robots.placement":
            control.select_option(value)
        else:
            control.fill(str(value))
            control.press("Tab")
        section, _, key = path.partition(".")
        expect(page.locator("#toml")).to_contain_text(key if "classes" not in path else shown[section])
    used = {
        **changes,
        "decision.declare": {"rounds": 2},
        "tasks.classes": [{"name": "carry", "count": 3, "needs": {"lift": 2}}],
        "robots.classes": [{"name": "arm", "count": 9, "skills": ["lift"]}],
    }
    eventually(page, lambda: expect_scenario(page, Scenario().replace(used)))
    control = page.locator("[data-path='decision.declare']")
    control.fill("{rounds = 0}")
    control.press("Tab")
    expect(page.locator("#note-decision-declare")).to_contain_text("must be")
    control.fill("")
    control.press("Tab")
    expect(page.locator("#toml")).not_to_contain_text("[decision.declare]")
    control_of(page, "preset").select_option("ros2swarm-voter")
    expect(page.locator("#last")).to_have_text("10,000")
    page.reload()
    expect(page.locator("#last")).to_have_text("10,000")
    expect(page.locator("[data-path='preset']")).to_have_value("ros2swarm-voter")


def expect_scenario(page, scenario):
    assert Scenario.from_toml(page.locator("#toml").text_content()) == scenario


@pytest.mark.slow
def test_settings_and_arena_are_seen_together_at_900_pixels(visit, port):
    page = visit(port, width=900, height=800)
    for more in ("", "#against=census"):
        page.goto(f"http://127.0.0.1:{port}/{more}")
        page.reload()
        expect(page.locator("#last")).to_have_text("1,000")
        expect(page.locator("#arena-1")).to_be_visible(visible=bool(more))
        eventually(page, lambda least=240 if more else 480: expect_all_seen(page, least))
    for width in (360, 900, 1440):
        page.set_viewport_size({"width": width, "height": 800})
        expect_no_scrolling(page, width)


def expect_all_seen(page, least):
    """Expect that arena, clock and settings are seen without scrolling, and the arena's least width."""
    parts = ("#arena", "#transport", "[data-path='decision.strategy']")
    boxes = [page.locator(each).bounding_box() for each in parts]
    for box in boxes:
        assert 0 <= box["y"] < box["y"] + box["height"] <= 800
        assert 0 <= box["x"] < box["x"] + box["width"] <= 900
    assert boxes[0]["width"] >= least


@pytest.mark.quick(1)
@pytest.mark.skipif(not AXE.is_file(), reason="needs axe-core, by npm")
@pytest.mark.parametrize(
    "look",
    [(360, "light"), (1440, "dark"), (360, "dark"), (900, "light"), (900, "dark"), (1440, "light")],
)
def test_axe_finds_no_serious_violation(visit, port, look):
    width, scheme = look
    page = visit(port, "#against=census&faults.stopped=0.1", width=width, height=800, color_scheme=scheme)
    page.keyboard.press("i")
    page.keyboard.press("d")
    expect(page.locator("#reasons-1")).to_be_visible()
    page.get_by_text("All settings").click()
    page.locator("#more summary").first.click()
    page.locator("#more-fields summary").first.click()
    page.locator("#scenario summary").click()
    page.locator("[data-path='robots.count']").fill("-1")
    page.keyboard.press("Tab")
    expect(page.locator("#note-robots-count")).to_be_visible()
    page.evaluate(AXE.read_text("utf-8"))
    for opened in (False, True):
        if opened:
            focus_nothing(page)
            page.keyboard.press("?")
        found = page.evaluate("axe.run()")["violations"]
        serious = [each for each in found if each["impact"] in ("serious", "critical")]
        told = [(each["id"], [node["target"] for node in each["nodes"]][:5]) for each in serious]
        assert not told

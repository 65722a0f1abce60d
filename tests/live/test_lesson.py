"""The lesson: what it says of swarms is so, and what somebody predicts and sees there."""

from __future__ import annotations

import re

import numpy as np
import pytest
from commands import invoke
from visiting import expect_no_scrolling

from feasibee import Swarm, simulate
from feasibee.cli import watch
from feasibee.live.lesson import SEED, figures
from feasibee.scenario.feasibility import truth

FIGURES = figures()


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    out = tmp_path_factory.mktemp("lesson") / "lesson.html"
    assert invoke("watch", "--lesson", "--out", out).stdout == f"Wrote {out}\n"
    assert watch._lesson(None)["GET", "/"](b"") == out.read_text("utf-8")
    return out


def decisions(name):
    return simulate(FIGURES[name].scenario, runs=100, seed=SEED).decision.values


def right(name):
    return int((decisions(name) == truth(FIGURES[name].scenario)).sum())


def test_the_lesson_is_small_and_loads_nothing(file):
    text = file.read_text("utf-8")
    assert len(text) < 300_000
    assert not re.search(r"""(src|href)=["'](?!data:|#)""", text)
    assert not re.search(r"(?m)^\s*(import|export)\b|https?:(?!//www\.w3\.org)", text)


def test_what_the_lesson_says_is_so():
    assert 80 <= (decisions("enough") == 0).sum() < 100, "most swarms find it, but not all"
    assert 50 < right("near") <= 60, "little better than coins"
    assert [right(name) for name in ("names", "lies", "bears", "start", "ask")] == [100, 0, 100, 0, 100]
    assert (decisions("start") == 1).sum() >= 95, "they take silence for feasible"
    assert right("hall") > right("rooms") + 10
    assert (decisions("hall") >= 0).all()
    assert (decisions("rooms") < 0).sum() > 10


@pytest.fixture
def visit(new_page, file):
    """Give a function that opens the lesson, without network, and waits for its worlds."""

    def opened(**options):
        page = new_page(viewport={"width": 390, "height": 800}, offline=True, **options)
        page.goto(file.as_uri())
        page.locator("body[data-ready]").wait_for()
        return page

    return opened


def test_by_keyboard_one_predicts_and_then_sees_what_the_engine_has(visit):
    page = visit(reduced_motion="reduce")
    expect_no_scrolling(page, 390)
    section = page.locator("#enough")
    assert section.locator(".after").is_hidden()
    assert section.locator(".figure button:visible").all_inner_texts() == ["Predict, then look"]
    section.get_by_label("feasible", exact=True).focus()
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    step = simulate(FIGURES["enough"].scenario, runs=1, seed=SEED).decision_step.item()
    told = f"The swarm decides infeasible at step {step}. That is right. You predicted: infeasible"
    section.locator(".result").filter(has_text=told).wait_for()
    assert section.locator(".after").is_visible()
    assert page.evaluate("document.activeElement.textContent") == "Play again"


@pytest.mark.parametrize("name", ["near", "rooms", "lies"])
def test_a_hundred_swarms_are_those_of_the_engine(name, visit):
    page = visit()
    section = page.locator(f"#{name}")
    section.get_by_role("slider").fill("93")
    section.get_by_role("button").click()
    told = f"{right(name)} of 100 swarms decided rightly"
    section.locator(".result").filter(has_text=told).filter(has_text="You predicted 93.").wait_for()


def test_the_tasks_that_a_robot_sees_are_counted_on_the_torus(visit):
    page = visit()
    swarm, seen = Swarm(FIGURES["one"].scenario, SEED), set()
    for _ in range(11):
        way = np.abs(swarm.tasks - swarm.positions[0])
        seen |= set(np.flatnonzero(np.hypot(*np.minimum(way, 20 - way).T) <= 2.0))
        swarm.advance()
    section = page.locator("#one")
    section.get_by_label("fewer than 5").check()
    section.get_by_role("button").click()
    section.locator(".result").filter(has_text=f"It had {len(seen)} of the 50 tasks in sight.").wait_for()


def test_a_number_in_the_text_is_stepped_by_keyboard(visit):
    page = visit(reduced_motion="reduce")
    section = page.locator("#names")
    section.get_by_role("button", name="Predict").click()
    number = section.get_by_role("spinbutton", name="Does it hold with")
    number.press("ArrowDown")
    said = section.locator(".result").filter(has_text="Can 20 robots do 21 tasks? No: 1 robot is missing.")
    scenario = FIGURES["names"].scenario.replace({"tasks.count": 21})
    step = int(np.sort(simulate(scenario, runs=100, seed=SEED).decision_step)[49])
    said.filter(has_text="Right in 100 of 100 swarms (96 to 100 % of all such swarms). ").filter(
        has_text="0 feasible, 100 infeasible. "
    ).filter(has_text=f"decisions: {step}.").wait_for()
    number.fill("19")
    section.locator(".result").filter(has_text="Yes: 1 robot to spare. Right in 100 of 100 swarms").wait_for()


def test_a_reader_sets_a_swarm_of_their_own_by_keyboard(visit):
    page = visit(reduced_motion="reduce")
    section = page.locator("#free")
    for name, keys in (("Robots", ["PageUp"]), ("Tasks", ["ArrowUp"] * 3), ("Range of sight", ["ArrowUp"])):
        for key in keys:
            section.get_by_role("slider", name=name).press(key)
    changes = {
        "robots.count": int(section.get_by_role("slider", name="Robots").input_value()),
        "tasks.count": 25,
        "sensing.range": 3,
    }
    assert changes["robots.count"] > 20
    section.get_by_role("slider", name="Range of sight").press("Enter")
    for scenario in (FIGURES["near"].scenario, FIGURES["names"].scenario):
        decisions = simulate(scenario.replace(changes), runs=100, seed=SEED).decision.values
        said = f"{(decisions == 1).sum()} feasible, {(decisions == 0).sum()} infeasible"
        section.locator(".result").filter(has_text=said).wait_for()
        section.get_by_role("checkbox").press("Space")


def test_a_word_is_explained_on_focus_and_on_hover(visit):
    page = visit()
    word = page.get_by_role("button", name="opinion", exact=True)
    note = page.get_by_text("What the robot holds.")
    assert note.is_hidden()
    word.focus()
    assert note.is_visible()
    expect_no_scrolling(page, 390)
    page.keyboard.press("Escape")
    assert note.is_hidden()
    word.hover()
    assert note.is_visible()


def test_a_screen_reader_reads_questions_controls_and_answers_in_order(visit):
    """Each control has a name, and each answer is a status, which is a live region."""
    page = visit(reduced_motion="reduce")

    def read(*roles):
        found = rf'(?m)^ *- (?:{"|".join(roles)})(?: "(.+?)")?(?: \[.*\])?:?$'
        return re.findall(found, page.locator("main").aria_snapshot())

    controls = ("button", "radio", "slider", "checkbox", "spinbutton")
    assert len(read(*controls)) > 20
    assert all(read(*controls))
    asked = [(figure.question, "Predict, then look") for figure in FIGURES.values() if figure.question]
    order = [each for each in read("group", "button") if each in {*sum(asked, ()), "Simulate"}]
    assert order == [*sum(asked, ()), "Simulate"]
    assert [each[0] for each in read("heading") if each[0].isdigit()] == list("12345678")
    for name, figure in FIGURES.items():
        section = page.locator(f"#{name}")
        if figure.asks in ("decision", "sight"):
            section.get_by_role("radio").first.check()
        section.locator("button.primary").click()
        section.locator(".result:not(:empty)").wait_for()
    assert all(read(*controls))
    shown = page.locator(".result").all_inner_texts()
    assert all(shown)
    assert page.get_by_role("status").all_inner_texts() == shown

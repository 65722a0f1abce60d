"""Inputs that come faster than the server's answers, in a real browser: none is lost, the last one counts."""

from __future__ import annotations

import pytest
from playing import swarm_at
from serving import serving_at
from visiting import at, expect_reasons, unfolded

from feasibee import Scenario
from feasibee.live import server
from feasibee.live.catalogue import STREAM, Catalogue

expect = pytest.importorskip("playwright.sync_api", reason="playwright isn't installed").expect

INPUT = """(path, value, ...events) => {
    const input = document.querySelector(path);
    input[input.type === "checkbox" ? "checked" : "value"] = value;
    for (const type of events) input.dispatchEvent(new Event(type, { bubbles: true }));
}"""


def at_once(page, *inputs, before="", after=""):
    """Give a page all inputs in one task, so that no answer comes between them."""
    given = "".join(f"input({', '.join(map(repr, each))});" for each in inputs)
    return page.evaluate(f"() => {{ const input = {INPUT}; {before} {given} {after} }}")


def key_down(key):
    """Return the JavaScript that presses a key."""
    return f"document.body.dispatchEvent(new KeyboardEvent('keydown', {{ key: '{key}', bubbles: true }}));"


def test_a_robot_chosen_on_the_way_to_a_step_stops_nothing(visit, port, monkeypatch):
    page = visit(port)
    monkeypatch.setattr(server, "PATIENCE", 0.0)  # it looks for other messages after each step
    at_once(page, ("#seek", "150", "input"), ("#robot", "7", "change"))
    at(page, 150)
    swarm = swarm_at(150, Scenario(), 1)
    expect_reasons(page, swarm, 7)


@pytest.mark.slow
def test_a_robot_chosen_on_the_way_to_the_decision_does_not_undo_it(visit, port):
    page = visit(port)
    expect(page.locator("#marks-text")).to_contain_text("Decision at step")
    decided = int(page.locator("#marks-text").inner_text().split()[-1].rstrip("."))
    at_once(page, ("#robot", "7", "change"), before=key_down("d"))
    swarm = swarm_at(decided, Scenario(), 1)
    expect_reasons(page, swarm, 7)
    at(page, decided)


@pytest.mark.slow
def test_many_seeks_in_a_row_end_at_the_last(visit, port):
    page = visit(port, "#robots.count=2000&tasks.count=1900&arena.side=200")
    for key, times, step in ((".", 30, 30), (",", 20, 10)):
        for _ in range(times):
            page.keyboard.press(key)
        at(page, step)
    at_once(page, *(("#seek", step, "input") for step in ("900", "3", "400", "55")))
    at(page, 55)


@pytest.mark.slow
def test_a_step_counts_while_the_page_is_on_the_way_to_another(visit, port):
    page = visit(port, "#robots.count=5000&tasks.count=4900&arena.side=310")
    at_once(page, ("#seek", "150", "input"), after="".join(map(key_down, "..,.")))
    at(page, 152)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("counts", "truth"),
    [
        (("30", "31"), "infeasible (20 robots, 31 tasks)"),
        (("-1", "12"), "feasible (20 robots, 12 tasks)"),  # the problem comes late, and hides no run
    ],
)
def test_a_seek_after_two_changes_is_one_in_the_last_run(visit, port, counts, truth):
    page = visit(port)
    changes = [("[data-path='tasks.count']", count, "change") for count in counts]
    at_once(page, *changes, ("#seek", "40", "input"))
    at(page, 40)
    expect(page.locator("#truth")).to_have_text(truth)


@pytest.mark.slow
def test_the_answer_to_an_earlier_change_resets_no_control(visit, port):
    page = visit(port)
    watch = """const seen = [], box = document.querySelector("[data-path='robots.avoid_collisions']");
        const done = new Promise(done => new MutationObserver(() => {
            seen.push(box.checked);
            if (seen.length === 2) done(seen);
        }).observe(document.querySelector("#toml"), { childList: true }));"""
    changes = [
        ("[data-path='tasks.count']", "30", "change"),
        ("[data-path='robots.avoid_collisions']", "on", "change"),
    ]
    assert at_once(page, *changes, before=watch, after="return done;") == [True, True]


def test_an_answer_fills_no_field_that_has_the_focus(visit, port):
    page = visit(port, "#acting.start=30")
    start = unfolded(page, "[data-path='acting.start']")
    start.select_text()
    reset = "document.querySelector('#reset').click()"  # the field keeps the focus
    page.evaluate(reset)
    expect(page.locator("#toml")).not_to_contain_text("start = 30")
    page.keyboard.press("ArrowRight")
    page.keyboard.type("0")
    page.keyboard.press("Enter")
    expect(page.locator("#toml")).to_contain_text("start = 300")
    page.evaluate(reset)
    expect(page.locator("#toml")).not_to_contain_text("start = 300")
    expect(start).to_have_value("300")
    start.press("Tab")
    expect(start).to_have_value("")  # what the answer says


@pytest.mark.slow
def test_the_slider_of_the_rate_may_move_before_a_run_has_begun(visit):
    with serving_at(Catalogue(Scenario().replace(STREAM))) as port:
        page = visit(port)
        at_once(page, *(("#rate", str(value), "input", "change") for value in (1, 2, 3)))
        expect(page.locator("[data-path='tasks.lifetime']")).to_have_value("225")
        expect(page.locator("#rate-shown")).to_have_text("\N{MULTIPLICATION SIGN} 8")
        page.goto("about:blank")

"""Sliders that change the world during a run, in a real browser: as events that the scenario keeps."""

from __future__ import annotations

import re

import pytest
from declaring import declaring
from playing import swarm_at
from serving import serving_at
from visiting import at, change, click, control_of, drag, focus_nothing, press, seek

from feasibee import Scenario
from feasibee.live.catalogue import Catalogue
from feasibee.live.packet import MOST
from feasibee.live.page import write_page

expect = pytest.importorskip("playwright.sync_api", reason="playwright isn't installed").expect


def slider(page, path):
    return page.locator(f"[data-slides='{path}']")


def expect_swarm(page, step, events):
    """Expect that a page shows a step of the run with these events, and has them in its scenario."""
    scenario = Scenario(events=events)
    swarm = swarm_at(step, scenario, 1)
    word = ("infeasible", "feasible")[swarm.truth]
    there = int(swarm.present.sum())
    at(page, step)
    expect(page.locator("#truth")).to_have_text(f"{word} ({there} robots, {len(swarm.tasks)} tasks)")
    expect(page.locator("#feasible")).to_have_text(str(swarm.feasible_count))
    assert Scenario.from_toml(page.locator("#toml").text_content()) == scenario
    expect(slider(page, "robots.count")).to_have_value(str(there))
    expect(slider(page, "tasks.count")).to_have_value(str(len(swarm.tasks)))
    at(page, step)  # still, once all of it is shown


def test_a_slider_changes_the_world_during_a_run_and_the_scenario_keeps_it(visit, port):
    page = visit(port, reduced_motion="reduce")
    seek(page, 30)
    slider(page, "tasks.count").fill("33")
    events = [{"step": 31, "tasks": 13}]
    expect_swarm(page, 31, events)
    expect(control_of(page, "tasks.count")).to_have_value("20")  # at the start
    slider(page, "robots.count").fill("40")  # at the same step, as time stands still
    events.append({"step": 32, "robots": 20})
    expect_swarm(page, 32, events)
    slider(page, "robots.count").fill("36")
    events[1]["robots"] = 16
    expect_swarm(page, 32, events)
    seek(page, 60)
    expect_swarm(page, 60, events)
    page.reload()
    expect(page.locator("#last")).to_have_text("1,000")
    expect(page.locator("#truth")).not_to_be_empty()
    seek(page, 60)
    expect_swarm(page, 60, events)
    seek(page, 32)
    slider(page, "robots.count").fill("20")  # as without the event
    expect_swarm(page, 32, events[:1])
    focus_nothing(page)
    press(page, ("r", 0))
    slider(page, "tasks.count").fill("5")  # at step 0, the start
    expect(page.locator("#truth")).to_have_text("feasible (20 robots, 5 tasks)")
    expect(control_of(page, "tasks.count")).to_have_value("5")


def test_a_run_goes_on_after_a_slider_has_changed_its_world(visit, port):
    page = visit(port)
    page.keyboard.press(" ")
    expect(page.locator("#now")).not_to_have_text("0")
    slider(page, "tasks.count").fill("40")
    expect(page.locator("#truth")).to_have_text("infeasible (20 robots, 40 tasks)")
    expect(page.get_by_role("button", name="Pause")).to_be_visible()
    (event,) = Scenario.from_toml(page.locator("#toml").text_content()).events
    assert event.step > 0
    assert event.tasks == 20


def test_a_change_that_cannot_be_is_told_and_dropped(visit, port):
    page = visit(port, "#robots.most=21", reduced_motion="reduce")
    seek(page, 30)
    slider(page, "robots.count").fill("40")
    expect(page.locator("#note-events")).to_contain_text("above robots.most = 21")
    expect(slider(page, "robots.count")).to_have_value("20")
    press(page, (".", 31))
    slider(page, "robots.count").fill("21")
    expect(page.locator("#truth")).to_have_text("feasible (21 robots, 20 tasks)")


def test_where_events_cannot_be_a_change_starts_the_run_again(visit, tmp_path):
    with serving_at(Catalogue(declaring(tmp_path, quiet=20.0), 1)) as port:
        page = visit(port, reduced_motion="reduce")
        expect(page.locator("#touching")).to_contain_text("Each change starts this run again.")
        seek(page, 30)
        slider(page, "tasks.count").fill("33")
        at(page, 0)
        expect(page.locator("#truth")).to_have_text("infeasible (20 robots, 33 tasks)")


def test_ranges_and_speed_have_sliders(visit, port):
    page = visit(port)
    for path, value in (("sensing.range", "3.5"), ("radio.range", "4"), ("robots.speed", "0.5")):
        slider(page, path).fill(value)
        expect(control_of(page, path)).to_have_value(value)
    expect(page.locator("#toml")).to_contain_text("speed = 0.5")
    scenario = Scenario.from_toml(page.locator("#toml").text_content())
    assert (scenario.sensing.range, scenario.radio.range, scenario.robots.speed) == (3.5, 4.0, 0.5)


def test_fields_take_and_show_units(visit):
    with serving_at(Catalogue(Scenario(units={"metres": 0.5, "seconds": 2.0}), 1)) as port:
        page = visit(port)
        for path, text, number, shown in (
            ("sensing.range", "1.5 m", "3", "units (1.5 m)"),
            ("run.steps", "10 min", "300", "steps (10 min)"),
            ("tasks.arrival_rate", "6 per min", "0.2", "per step (0.1 per s)"),
            ("sensing.gate", "1 m", "2", "units (1 m)"),  # in "More"
            ("robots.speed", "0.75", "0.75", "units per step (0.1875 m/s)"),
        ):
            expect(change(page, path, text)).to_have_value(number)
            expect(page.locator("label", has=page.locator(f"[data-path='{path}']"))).to_have_attribute(
                "data-unit", shown
            )
        change(page, "radio.range", "6 s")
        expect(page.locator("#note-radio-range")).to_contain_text("must be a length, not a time")
        found = Scenario.from_toml(page.locator("#toml").text_content())
        assert (found.sensing.range, found.run.steps, found.robots.speed) == (3.0, 300, 0.75)


def test_a_touched_run_is_copied_as_a_scenario(visit, port):
    page = visit(port, reduced_motion="reduce", permissions=["clipboard-read", "clipboard-write"])
    seek(page, 30)
    slider(page, "tasks.count").fill("33")
    at(page, 31)
    page.get_by_role("button", name="Copy as scenario").click()
    expect(page.get_by_role("button", name="Copied")).to_be_visible()
    copied = page.evaluate("navigator.clipboard.readText()")
    assert Scenario.from_toml(copied) == Scenario(events=[{"step": 31, "tasks": 13}])


@pytest.fixture
def file(tmp_path):
    """A page of one file with events of its own."""
    write_page(Scenario(events=[{"step": 20, "tasks": 4}]), tmp_path / "run.html", seed=1)
    return (tmp_path / "run.html").as_uri()


def expect_page(page, step, events, **tables):
    """Expect that a page of one file shows a step of the run with these events, and has its scenario."""
    scenario = Scenario(events=events, **tables)
    swarm = swarm_at(step, scenario, 1)
    there, tasks = int(swarm.present.sum()), len(swarm.tasks)
    expect(page.locator("#now")).to_have_text(str(step))
    expect(page.locator("#question")).to_have_text(f"Can {there} robots do {tasks} tasks?")
    expect(page.locator("#truth")).to_contain_text("Yes" if swarm.truth else "No")
    expect(page.locator("#feasible")).to_have_text(str(swarm.feasible_count))
    expect(page.locator("#infeasible")).to_have_text(str(swarm.infeasible_count))
    expect(page.locator("#robots-slider")).to_have_value(str(there))
    expect(page.locator("#tasks-slider")).to_have_value(str(tasks))
    assert Scenario.from_toml(page.locator("#toml").text_content()) == scenario


def test_sliders_of_a_page_of_one_file_change_the_world_during_a_run(new_page, file):
    page = new_page(reduced_motion="reduce", permissions=["clipboard-read", "clipboard-write"])
    page.goto(file)
    page.locator("#seek").fill("30")
    events = [{"step": 20, "tasks": 4}]
    expect_page(page, 30, events)
    page.locator("#tasks-slider").fill("33")
    events.append({"step": 31, "tasks": 9})
    expect_page(page, 31, events)
    page.locator("#tasks-slider").fill("13")  # at the same step, as time stands still
    events[1]["tasks"] = -11
    expect_page(page, 31, events)
    page.locator("#robots-slider").fill("12")
    events.append({"step": 32, "robots": -8})
    expect_page(page, 32, events)
    page.locator("#seek").fill("90")
    page.locator("#robots-slider").fill("40")
    events.append({"step": 91, "robots": 28})
    expect_page(page, 91, events)
    page.locator("#strategy").select_option("census")  # it starts again, with its events
    page.locator("#seek").fill("120")
    expect_page(page, 120, events, decision={"strategy": "census"})
    page.get_by_role("button", name="Copy as scenario").click()
    expect(page.get_by_role("button", name="Copied")).to_be_visible()
    copied = Scenario.from_toml(page.evaluate("navigator.clipboard.readText()"))
    assert copied == Scenario(events=events, decision={"strategy": "census"})
    expect(page).to_have_url(re.compile("events="))
    page.reload()
    page.locator("#seek").fill("120")
    expect_page(page, 120, events, decision={"strategy": "census"})


def test_hands_change_the_world_of_a_page_of_one_file(new_page, file):
    page = new_page(reduced_motion="reduce", viewport={"width": 1200, "height": 1000})
    page.goto(file)
    page.locator("#seek").fill("30")
    events = [{"step": 20, "tasks": 4}]
    for tool, act in (
        ("Add tasks", lambda: click(page, (5.0, 7.0))),
        ("Add robots", lambda: click(page, (15.0, 3.0))),
        ("Move", lambda: drag(page, (5.0, 7.0), (12.0, 11.0))),
        ("Remove", lambda: click(page, (12.0, 11.0))),
    ):
        use(page, tool)
        act()
        expect(page.locator("#announcer")).to_contain_text("From step 31 on: ")
        events = Scenario.from_toml(page.locator("#toml").text_content()).events
        expect_page(page, 31, events)
    _, task, robot, moved, removed = events
    assert (task.tasks, robot.robots, moved.task, removed.task, removed.at) == (1, 1, 24, 24, None)
    assert [*task.at, *moved.at] == pytest.approx([5.0, 7.0, 12.0, 11.0], abs=0.1)
    page.locator("#seek").fill("90")
    expect_page(page, 90, events)
    expect(page).to_have_url(re.compile("task%22%3A24%7D"))
    page.reload()
    page.locator("#seek").fill("90")
    expect_page(page, 90, events)


def test_a_page_of_one_file_refuses_more_robots_than_it_simulates(new_page, tmp_path, monkeypatch):
    for name, most in (("robots.count", 200), ("tasks.count", 400)):
        monkeypatch.setitem(MOST, name, most)
    write_page(Scenario(), tmp_path / "run.html", seed=1)
    page = new_page(reduced_motion="reduce")
    page.goto((tmp_path / "run.html").as_uri())
    page.locator("#seek").fill("30")
    page.locator("#tasks-slider").fill("100")
    page.locator("#robots-slider").fill("90")
    expect(page.locator("#question")).to_have_text("Can 90 robots do 100 tasks?")
    page.locator("#seek").fill("60")
    page.locator("#robots-slider").fill("1")
    page.locator("#seek").fill("70")
    page.locator("#robots-slider").fill("100")
    expect(page.locator("#question")).to_have_text("Can 100 robots do 100 tasks?")
    page.locator("#seek").fill("80")
    page.locator("#robots-slider").fill("1")
    expect(page.locator("#question")).to_have_text("Can 1 robot do 100 tasks?")
    page.locator("#seek").fill("85")
    page.locator("#robots-slider").fill("100")  # 268 in all
    expect(page.locator("#announcer")).to_have_text(
        "Not changed: a run has 1 robot or more, and at most 200 robots and 400 tasks."
    )
    expect(page.locator("#robots-slider")).to_have_value("1")


def test_a_page_of_one_file_says_where_a_change_starts_the_run_again(new_page, tmp_path):
    write_page(declaring(tmp_path, quiet=20.0), tmp_path / "run.html", 1)
    page = new_page(reduced_motion="reduce")
    page.goto((tmp_path / "run.html").as_uri())
    expect(page.locator("#touching")).to_contain_text("Each change starts this run again.")
    page.locator("#seek").fill("30")
    page.locator("#tasks-slider").fill("33")
    expect(page.locator("#now")).to_have_text("0")
    expect(page.locator("#question")).to_have_text("Can 20 robots do 33 tasks?")


def use(page, tool):
    page.locator("#tools").get_by_role("button", name=tool, exact=True).click()


def test_tasks_and_robots_are_put_moved_and_removed_in_a_run_that_anyone_repeats(visit, port):
    page = visit(port, reduced_motion="reduce", height=1000)
    seek(page, 30)
    events = []

    def now(step, at=None, **named):
        """Expect that the last touch is an event of the scenario, near to where the pointer was."""
        scenario = Scenario.from_toml(page.locator("#toml").text_content())
        *before, last = scenario.events
        assert (before, last.step) == (events, step)
        assert last.model_dump(include={*named}) == named
        if at:
            assert last.at == pytest.approx(at, abs=0.1)
        events.append(last)
        expect_swarm(page, step, events)

    use(page, "Add tasks")
    expect(page.locator("#tools p")).to_have_text("Click where a task is to appear.")
    click(page, (5.0, 7.0))
    at(page, 31)
    expect(page.locator("#truth")).to_have_text("infeasible (20 robots, 21 tasks)")
    now(31, (5.0, 7.0), tasks=1)
    use(page, "Add robots")
    click(page, (15.0, 3.0))  # at the same step, as time stands still
    expect(page.locator("#truth")).to_have_text("feasible (21 robots, 21 tasks)")
    now(31, (15.0, 3.0), robots=1)
    use(page, "Move")
    drag(page, (5.0, 7.0), (12.0, 11.0))
    expect(page.locator("#toml")).to_contain_text("task = 20")
    now(31, (12.0, 11.0), task=20)
    press(page, (".", 32))
    there = swarm_at(32, Scenario(events=events), 1).positions[20]
    drag(page, there, (4.0, 4.0))
    at(page, 33)
    now(33, (4.0, 4.0), robot=20)
    use(page, "Remove")
    click(page, (12.0, 11.0))
    expect(page.locator("#truth")).to_have_text("feasible (21 robots, 20 tasks)")
    now(33, task=20)
    page.keyboard.press("Escape")
    expect(page.locator("#tools p")).to_be_empty()
    page.locator("#robot").fill("7")
    page.locator("#robot").press("Tab")
    page.keyboard.press("Delete")
    expect(page.locator("#truth")).to_have_text("feasible (20 robots, 20 tasks)")
    now(33, robot=7)


def test_the_start_is_touched_at_step_0_and_a_running_world_at_its_next_step(visit, port):
    page = visit(port)
    use(page, "Add tasks")
    click(page, (5.0, 7.0))
    expect(page.locator("#truth")).to_have_text("infeasible (20 robots, 21 tasks)")
    page.keyboard.press(" ")
    expect(page.locator("#now")).not_to_have_text("0")
    click(page, (9.0, 7.0))
    expect(page.locator("#truth")).to_have_text("infeasible (20 robots, 22 tasks)")
    expect(page.get_by_role("button", name="Pause")).to_be_visible()
    first, second = Scenario.from_toml(page.locator("#toml").text_content()).events
    assert first.step == 0 < second.step


def test_where_the_pointer_finds_nothing_or_no_place_nothing_changes(visit, port):
    page = visit(port, "#arena.boundary=%22walls%22&place.walls=[[[8,8],[12,8],[12,12],[8,12]]]", height=1000)
    seek(page, 3)
    toml = page.locator("#toml").text_content()
    use(page, "Add robots")
    click(page, (10.0, 10.0))
    expect(page.locator("#note-events")).to_contain_text("is in a wall, or where no robot gets")
    use(page, "Remove")
    click(page, (10.0, 10.0))
    expect(page.locator("#announcer")).to_have_text("There is no robot or task.")
    assert page.locator("#toml").text_content() == toml

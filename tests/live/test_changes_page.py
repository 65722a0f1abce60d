"""A world changed in the page, by hand, by walls, by a second strategy; and that anybody can repeat."""

from __future__ import annotations

import base64
import re
import tomllib
from urllib.parse import quote

import numpy as np
import pytest
import visiting as on
from playing import swarm_at
from serving import serving_at
from waiting import eventually

from feasibee import Scenario, Swarm, simulate
from feasibee.live.catalogue import Catalogue
from feasibee.live.page import STATIC

expect = pytest.importorskip("playwright.sync_api", reason="playwright isn't installed").expect

EVENTS = [{"step": 20, "tasks": 4}]
WORDS = ("infeasible", "feasible")
SQUARE = [[3.0, 12.0], [6.0, 12.0], [6.0, 15.0], [3.0, 15.0]]
RECTANGLE = [[10.0, 2.0], [10.4, 2.0], [10.4, 9.0], [10.0, 9.0]]
INK = (29, 33, 37)
"""Of the light theme."""
PLAYED = """async film => {
    const video = Object.assign(document.createElement("video"), { muted: true });
    video.src = `data:video/webm;base64,${film}`;
    await video.play();
    await new Promise(done => (video.onended = done));
    return video.getVideoPlaybackQuality().totalVideoFrames;
}"""
"""How many pictures a film has."""


@pytest.mark.parametrize("served", [False, True])
def test_hands_put_move_and_take_away_in_a_run_that_anyone_repeats(show, served):
    scenario = Scenario(events=EVENTS, run={"steps": 200})
    with serving_at(Catalogue(scenario, 1)) as port:
        page = show(port if served else scenario, height=1000)
        on.seek(page, 30)
        before = [*scenario.events]

        def expect_event(step, at=None, **named):
            """Expect that what was done is an event of the scenario, near to where the pointer was."""
            expect(page.locator("#notice")).to_contain_text(f"From step {step} on: ")
            *events, last = on.scenario_of(page).events
            assert (events, last.step) == (before, step)
            assert last.model_dump(include={*named}) == named
            assert last.at == (pytest.approx(at, abs=0.1) if at else None)
            before.append(last)
            on.expect_swarm(page, step, scenario.replace({"events": before}))

        on.use(page, "Add tasks")
        expect(page.locator("#tools p")).to_have_text("Click where a task is to appear.")
        on.click(page, (5.0, 7.0))
        on.at(page, 31)
        expect_event(31, (5.0, 7.0), tasks=1)
        on.use(page, "Add robots")
        on.click(page, (15.0, 3.0))  # at the same step, as time stands still
        on.asked(page, 21, 25)
        expect_event(31, (15.0, 3.0), robots=1)
        on.use(page, "Move")
        on.drag(page, (5.0, 7.0), (12.0, 11.0))
        expect(page.locator("#toml")).to_contain_text("task = 24")
        expect_event(31, (12.0, 11.0), task=24)
        on.press(page, (".", 32))
        there = swarm_at(32, scenario.replace({"events": before}), 1).positions[20]
        on.drag(page, there, (4.0, 4.0))
        on.at(page, 33)
        expect_event(33, (4.0, 4.0), robot=20)
        on.use(page, "Remove")
        on.click(page, (12.0, 11.0))
        on.asked(page, 21, 24)
        expect_event(33, task=24)
        page.keyboard.press("Escape")
        expect(page.locator("#tools p")).to_be_empty()
        on.choose(page, 7)
        page.keyboard.press("Delete")
        on.asked(page, 20, 24)
        expect_event(33, robot=7)
        expect(page).to_have_url(re.compile("robot%22%3A7%7D"))
        page.reload()
        on.expect_run(page)
        on.seek(page, 120)
        on.expect_swarm(page, 120, scenario.replace({"events": before}))


def test_the_start_is_touched_at_step_0_and_a_running_world_at_its_next_step(show):
    page = show(Scenario())
    on.use(page, "Add tasks")
    on.click(page, (5.0, 7.0))
    on.asked(page, 20, 21)
    page.keyboard.press(" ")
    expect(page.locator("#now")).not_to_have_text("0")
    on.click(page, (9.0, 7.0))
    on.asked(page, 20, 22)
    expect(page.get_by_role("button", name="Pause")).to_be_visible()
    first, second = on.scenario_of(page).events
    assert first.step == 0 < second.step


def test_what_hands_cannot_do_is_told(show):
    walls = [[[8.0, 8.0], [12.0, 8.0], [12.0, 12.0], [8.0, 12.0]]]
    scenario = Scenario(
        arena={"boundary": "walls"}, place={"walls": walls}, robots={"count": 2, "diameter": 0.5}
    )
    page = show(scenario.replace({"run.steps": 50}))
    toml = page.locator("#toml").text_content()
    on.use(page, "Add robots")
    on.click(page, (10.0, 10.0))
    expect(page.locator("#notice")).to_have_text("Not changed: no robot gets there.")
    on.use(page, "Remove")
    on.click(page, (10.0, 10.0))
    expect(page.locator("#announcer")).to_have_text("There is no robot or task.")
    assert page.locator("#toml").text_content() == toml
    on.click(page, Swarm(scenario, 1).positions[0])
    on.asked(page, 1, 20)
    on.click(page, Swarm(scenario, 1).positions[1])
    expect(page.locator("#notice")).to_contain_text("Not changed: a run has 1 robot or more")
    on.asked(page, 1, 20)
    on.seek(page, 50)
    on.use(page, "Add tasks")
    on.click(page, (3.0, 3.0))
    expect(page.locator("#notice")).to_contain_text("The run is over")


def expect_walls(page, walls):
    """Expect that the scenario of the page has these walls, and that they are drawn."""

    def check():
        table = tomllib.loads(page.locator("#toml").text_content())
        assert table.get("place", {}).get("walls", []) == walls

    eventually(page, check)
    on.expect_colours(page, {tuple(np.mean(each, axis=0)): INK for each in walls})


@pytest.fixture
def drawing(show, port):
    """A page whose tool for drawing walls is in use, at a step of a run."""
    page = show(port, height=1000, color_scheme="light")
    on.use(page, "Draw walls")
    expect(page.locator("#tools p")).to_contain_text("Drag for a rectangle.")
    on.seek(page, 30)
    return page


def test_walls_are_drawn_kept_in_the_address_and_erased(show, port, drawing):
    page = drawing
    on.drag(page, (10, 2), (10.41, 9.02))
    expect(page.locator("#notice")).to_contain_text("this run begins again")
    expect_walls(page, [RECTANGLE])
    on.at(page, 0)
    expect(page.locator("#notice")).to_contain_text("this run begins again")
    on.drag(page, (3, 12), (6, 15))
    expect_walls(page, [RECTANGLE, SQUARE])
    scenario = on.scenario_of(page)
    on.seek(page, 20)
    on.expect_swarm(page, 20, scenario)
    expect(page).to_have_url(re.compile("place.walls=.*%5B6%2C15%5D"))
    other = show(port, f"#{page.url.partition('#')[2]}", color_scheme="light")
    expect_walls(other, [RECTANGLE, SQUARE])
    on.use(page, "Erase walls")
    on.click(page, (15, 15))  # nothing is there
    on.click(page, (4, 13))
    expect_walls(page, [RECTANGLE])


def test_escape_drops_a_wall_then_the_tool_and_no_robot_is_inspected(drawing):
    page = drawing
    on.move(page, 3, 12)
    page.mouse.down()
    on.move(page, 6, 15)
    page.keyboard.press("Escape")
    page.mouse.up()
    on.drag(page, (3, 12), (6, 15))
    expect_walls(page, [SQUARE])
    expect(page.locator("#robot")).to_have_value("")
    page.keyboard.press("Escape")
    expect(page.get_by_role("button", name="Draw walls")).to_have_attribute("aria-pressed", "false")
    on.point_at(page, Swarm(on.scenario_of(page), 1), 4)
    page.mouse.down()
    page.mouse.up()
    expect(page.locator("#robot")).to_have_value("4")


def test_walls_that_cannot_be_change_nothing_and_their_problem_is_told(show, port):
    page = show(port, '#robots.placement="clusters"', height=1000)
    on.use(page, "Draw walls")
    on.drag(page, (10, 2), (10.41, 9.02))
    expect(page.locator(".problems")).to_contain_text("Not changed: the previous run continues.")
    expect(page.locator("[aria-invalid=true]")).to_have_attribute("data-path", "robots.placement")
    assert "place.walls" not in page.url
    on.control_of(page, "robots.placement").select_option("uniform")
    expect(page.locator(".problems")).to_be_hidden()
    assert "place.walls" not in page.locator("#toml").text_content()


@pytest.mark.parametrize("served", [False, True])
def test_two_strategies_are_compared_on_one_clock(show, port, served):
    scenario = Scenario(tasks={"count": 24})
    page = show(port, "#tasks=24") if served else show(scenario)
    expect(page.locator("#arena-1")).to_be_hidden()
    on.control_of(page, "against").select_option("census")
    expect(page.locator("#arena-1")).to_be_visible()
    on.expect_run(page)
    expect(page.locator("#swarms")).to_have_attribute("aria-busy", "false")
    swarms = {
        name: simulate(scenario.replace({"decision.strategy": name}), 100, 1, curves=True)
        for name in ("dmmd", "census")
    }
    steps = [int(each.decision_step[0]) for each in swarms.values()]
    for (name, each), more, place in zip(swarms.items(), ("", "-second"), ("", "-1"), strict=True):
        decided = (
            f"{name}: The swarm decides {WORDS[int(each.decision[0])]} at step {int(each.decision_step[0])}."
        )
        expect(page.locator(f"#decision{more}")).to_contain_text(decided)
        right = int((each.decision == 0).sum())
        expect(page.locator(f"#many{more}")).to_contain_text(f"{name}: Right in {right} of 100 swarms (")
        expect(page.locator("#plot")).to_contain_text(name)
        expect(page.locator(f"#caption{place}")).to_contain_text(f"{name}: ")
        expect(page.locator(f"#caption{place}")).to_contain_text("undecided")
    on.focus_nothing(page)
    for key, step in (("D", steps[1]), ("d", steps[0])):
        on.press(page, (key, step))
        for (name, each), place in zip(swarms.items(), ("", "-1"), strict=True):
            feasible, infeasible = (int(row[0, step]) for row in (each.feasible_count, each.infeasible_count))
            held = f"{name}: {feasible} feasible, {infeasible} infeasible"
            expect(page.locator(f"#caption{place}")).to_contain_text(held)
    expect(page.locator("#marks-text")).to_have_text(
        f"Left: decision at step {steps[0]}. Right: decision at step {steps[1]}."
    )
    page.keyboard.press("i")
    for lane, name in enumerate(swarms):
        expect(page.locator(f"#reasons-{lane} h3")).to_have_text(name)
    expect(page.locator("#reasons-0")).to_contain_text("Heard")
    expect(page.locator("#reasons-1")).to_contain_text("Knows")
    expect(page).to_have_url(re.compile("against=census"))
    page.reload()
    expect(page.locator("#caption-1")).to_contain_text("census: ")
    on.expect_run(page)
    page.get_by_role("button", name="Undo all changes").click()
    expect(page.locator("#arena-1")).to_be_hidden()
    expect(page.locator("#decision-second")).to_be_hidden()
    expect(page.locator("#decision")).to_contain_text(re.compile("^The swarm"))


def test_what_only_python_changes_is_simulated_and_stays_at_its_step(show, port):
    page = show(port)
    on.seek(page, 40)
    on.type_into(page, "radio.loss", "0.3")
    changed = Scenario(radio={"loss": 0.3})
    on.expect_scenario(page, changed)
    on.expect_swarm(page, 40, changed)
    on.slider(page, "sensing.range").fill("3.5")
    changed = changed.replace({"sensing.range": 3.5, "radio.range": 2.0})
    on.expect_swarm(page, 40, changed)
    on.type_into(page, "events", "[{ step = 5, tasks = 1 }]")
    changed = changed.replace({"events": [{"step": 5, "tasks": 1}]})
    on.expect_swarm(page, 40, changed)
    expect(page).to_have_url(re.compile("events=.*step"))
    page.reload()
    on.expect_scenario(page, changed)
    page.locator("#settings-fold").evaluate("it => (it.open = true)")
    on.control_of(page, "preset").select_option("ros2swarm-voter")
    expect(page.locator("#last")).to_have_text("10,000")
    page.get_by_role("button", name="Undo all changes").click()
    on.expect_swarm(page, 0, Scenario())


def test_a_page_whose_server_stops_says_so_and_goes_on_by_itself(show, new_page):
    with serving_at(Catalogue(Scenario(), 1)) as port:
        page = show(port)
    on.type_into(page, "radio.loss", "0.3")
    expect(page.locator(".problems")).to_contain_text("feasibee watch doesn't answer")
    on.slider(page, "tasks.count").fill("33")
    on.asked(page, 20, 33)
    expect(page.locator(".problems")).to_be_hidden()
    on.expect_run(page)
    on.expect_swarm(page, 0, Scenario(tasks={"count": 33}))
    new_page.errors[:] = [each for each in new_page.errors if "ERR_CONNECTION" not in each]


def test_a_clip_is_saved_as_a_film(show, new_page, tmp_path):
    page = show(Scenario())
    on.unfolded(page, "#clip").click()
    expect(page.locator("#clip")).to_have_text("Save the clip")
    on.focus_nothing(page)
    for step in range(1, 9):
        on.press(page, (".", step))
    with page.expect_download() as told:
        page.locator("#clip").click()
    assert re.fullmatch(r"feasibee-20-robots-20-tasks\.(webm|mp4)", told.value.suggested_filename)
    told.value.save_as(tmp_path / "film")
    film = (tmp_path / "film").read_bytes()
    assert len(film) > 2000
    assert film[:4] == b"\x1aE\xdf\xa3" or film[4:8] == b"ftyp"
    expect(page.locator("#clip")).to_have_text("Record a clip")
    assert new_page().evaluate(PLAYED, base64.b64encode(film).decode()) >= 4


def test_the_grids_spacing_jumps_never_by_much(new_page):
    module = f"data:text/javascript,{quote((STATIC / 'ground.js').read_text('utf-8'))}"
    asked = "async it => Array.from({ length: 196 }, ((at) => (_, k) => at.gapOf(5 + k))(await import(it)))"
    gaps = new_page().evaluate(asked, module)
    cells = np.arange(5, 201) / gaps
    assert cells.min() >= 8
    assert cells.max() <= 20
    assert np.divide(gaps[1:], gaps[:-1]).max() <= 2.5
    assert np.diff(gaps).min() >= 0

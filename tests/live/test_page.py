"""The page as a file: it loads nothing, and its runs are those of feasibee; clock, keys, and what it says."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
import visiting as on
from playing import swarm_at
from waiting import drawn, eventually
from walled import PLACE

from feasibee import Scenario, Swarm, decision_counts, simulate, wilson
from feasibee.live.page import STATIC
from feasibee.simulation.snapshot import FLAGS
from tests.places import rectangle

expect = pytest.importorskip("playwright.sync_api", reason="playwright isn't installed").expect
SITE = Path(__file__).parents[2] / "docs" / "_static"
FIFTY = Scenario(tasks={"count": 50})
OWN = """
def decide(mind, inbox):
    return 1 if inbox.feasible_votes > inbox.infeasible_votes else mind.opinion
"""
EYES = [{"name": "eye", "count": 9, "skills": ["see"]}, {"name": "<b>arm", "count": 9, "skills": ["grip"]}]
JOBS = [{"name": "look", "count": 5, "needs": {"see": 1}}, {"name": "lift", "count": 4, "needs": {"grip": 2}}]
EVENTS = [{"step": 20, "tasks": 6}, {"step": 40, "robots": -8}, {"step": 70, "tasks": -20, "robots": 3}]
WALLS = {"arena.boundary": "walls", "arena.side": [20.0, 14.0], "robots.diameter": 0.5}
WORLDS = {
    "paper": {},
    "changing": {"events": EVENTS, "robots.failure_rate": 0.002},
    "bodies": WALLS
    | {"robots.avoid_collisions": True, "faults.stopped": {"count": 2}, "faults.byzantine": 0.1},
    "acting": {"acting.start": 30, "tasks.work": 20},
    "classes": {"robots.classes": EYES, "tasks.classes": JOBS},
    "place": WALLS | {"place.walls": [rectangle(8.0, 0.0, 8.2, 14.0)], "radio.walls": 0.7},
    "own": {},
}


CLOUD = """() => {
    const { plot } = feasibee, { cloud } = plot, pen = cloud.getContext("2d"), seen = [];
    pen.lineTo = (_, y) => seen.push(1 - y / cloud.height);
    plot.painted = { key: "" };
    plot.paintCloud();
    delete pen.lineTo;
    return seen;
}"""


def world(name, folder):
    changes = WORLDS[name]
    if name == "own":
        pytest.importorskip("ziglang", reason="ziglang isn't installed")
        (folder / "mine.py").write_text(OWN, encoding="utf-8")
        changes = {"decision.strategy": str(folder / "mine.py")}
    return Scenario(run={"steps": 150}).replace(changes)


@pytest.mark.quick(4)
@pytest.mark.parametrize("seed", [1, 2**64 - 1])
@pytest.mark.parametrize("name", WORLDS)
def test_each_step_is_that_of_a_swarm(show, tmp_path, name, seed):
    scenario = world(name, tmp_path)
    swarm, page = Swarm(scenario, seed), show(scenario, seed=seed)
    for step, frame in enumerate(on.frames_of(page, range(151))):
        swarm.advance(step - swarm.step)
        own, places = swarm.snapshot(), swarm.task_places()
        expected = {
            **{"step": step, "there": swarm.present.sum(), "tasks": len(swarm.tasks)},
            **{"feasible": swarm.feasible_count, "infeasible": swarm.infeasible_count},
            **{"counted": swarm.counted.sum(), "decision": swarm.decision, "bits": swarm.bits_sent},
            **{"x": own.x.tolist(), "y": own.y.tolist(), "flags": own.flags.tolist()},
            **dict(zip(("taskX", "taskY"), (each.tolist() for each in places), strict=True)),
        }
        if scenario.acts:
            expected |= {"taken": swarm.acting.looks.tolist()}
        assert {each: frame[each] for each in expected} == expected
        assert (frame["missing"] == 0) == swarm.truth
    on.asked(page, int(Swarm(scenario, seed).present.sum()), len(Swarm(scenario, seed).tasks))
    on.expect_scenario(page, scenario)


def test_the_page_knows_the_flags_of_robots():
    known = re.findall(r"\b([A-Z]+) = (\d+)", (STATIC / "frames.js").read_text("utf-8"))
    assert known == [(name.upper(), str(1 << k)) for k, name in enumerate(FLAGS)]


@pytest.mark.quick(1)
@pytest.mark.parametrize("name", ["paper", "place", "acting", "bodies"])
def test_a_hundred_swarms_are_those_of_simulate(show, tmp_path, name):
    scenario = world(name, tmp_path).replace({"run.steps": 400})
    page, swarms = show(scenario), simulate(scenario, runs=100, seed=1, curves=True)
    expect(page.locator("#swarms")).to_have_attribute("aria-busy", "false")
    found = page.evaluate(
        "feasibee.lanes[0].outcomes.map(at => [at.decision, at.step, at.isRight, ...at.course])"
    )
    marks = {1: "dot feasible", 0: "dot hollow infeasible", -1: "dot undecided"}
    on.unfolded(page, "#runs")

    def check():
        shown = page.locator("#runs i").evaluate_all("all => all.map(each => each.className)")
        assert shown == [marks[each] for each in swarms.decision.values.tolist()]

    eventually(page, check)
    right = 0
    for run, (decision, step, is_right, *course) in enumerate(found):
        decided, curve = int(swarms.decision[run]), swarms.feasible_count.values[run]
        last = int(swarms.decision_step[run]) if decided >= 0 else 400
        assert (decision, step) == (decided, last), run
        assert course[: last + 1] == curve[: last + 1].tolist(), run
        right += is_right
    counts = decision_counts(swarms.decision)
    said = [f"{counts[word]} {word}" for word in ("feasible", "infeasible")]
    said += [f"{counts['undecided']} undecided"] if counts["undecided"] else []
    expect(page.locator("#sentences")).to_contain_text(f"100 swarms: {', '.join(said)}.")
    low, high = (round(100 * each) for each in wilson(right, 100)[1:])
    told = f"Right in {right} of 100 swarms ({low} to {high} % of all such swarms)."
    expect(page.locator("#many")).to_have_text(told)
    for run in (0, 1):
        if (step := int(swarms.decision_step[run])) >= 0:
            word = ("infeasible", "feasible")[int(swarms.decision[run])]
            expect(page.locator("#decision")).to_contain_text(f"The swarm decides {word} at step {step}.")
            on.press(page, ("d", step))
            expect(page.locator("#feasible")).to_have_text(str(int(swarms.feasible_count[run, step])))
        else:
            expect(page.locator("#decision")).to_have_text("The swarm doesn't decide by step 400.")
        page.keyboard.press("n")
        expect(on.control_of(page, "run")).to_have_value(str(run + 1))
        on.expect_run(page)
        on.focus_nothing(page)
    page.locator("#runs span").nth(99).click()
    expect(on.control_of(page, "run")).to_have_value("99")


def test_the_answer_is_there_before_time_has_come_to_it(show):
    page, decided = show(FIFTY), int(simulate(FIFTY, 1, 1).decision_step[0])
    on.at(page, 0)
    on.asked(page, 20, 50)
    expect(page.locator("#truth")).to_contain_text("Truth: No: 30 robots are missing")
    expect(page.locator("#decision")).to_have_text(
        f"The swarm decides infeasible at step {decided}. That is right."
    )
    expect(page.locator("#announcer")).to_contain_text(f"decides infeasible at step {decided}")
    expect(page.locator("#marks-text")).to_have_text(f"Decision at step {decided}.")
    expect(page.locator("#marks > svg").first).to_have_attribute("x", f"{decided / 10}%")
    expect(page.locator("#now-held")).to_contain_text("At this step: 10 agree, of the 19 robots")
    on.seek(page, decided)
    expect(page.locator("#now-held")).to_have_text("At this step it has decided.")


def test_the_plot_has_the_curves_of_all_swarms(show):
    page, curves = show(FIFTY), simulate(FIFTY, runs=100, seed=1, curves=True).feasible_count.values / 20
    expect(page.locator("#swarms")).to_have_attribute("aria-busy", "false")
    expect(page.locator("#plot")).to_contain_text("theory")
    on.seek(page, 60)
    labels, data = page.evaluate(
        "(({ series, data }) => [series.map(at => at.label), data])(feasibee.plot.chart)"
    )
    assert labels == ["Step", "infeasible", "feasible", "mean by theory"]
    assert data[2][:61] == pytest.approx(curves[0, :61])
    assert data[1][:61] == pytest.approx(1 - curves[0, :61])
    assert page.evaluate(CLOUD)[:90] == pytest.approx(curves[0, :90])
    (across,) = page.locator(".u-over line[x2='100%']").evaluate_all(
        "all => all.map(at => at.getAttribute('y1'))"
    )
    assert float(across[:-1]) == pytest.approx(100 - 90)


def test_keys_and_buttons_move_time(show):
    page = show(Scenario())
    on.press(page, (".", 1), ("ArrowRight", 2), (",", 1), ("ArrowLeft", 0), (",", 0))
    for name, step in (("One step", 1), ("One step", 2), ("Step back", 1), ("Restart", 0)):
        page.get_by_role("button", name=name, exact=True).click()
        on.at(page, step)
    on.seek(page, 700)
    expect(page.locator("#seek")).to_have_attribute("aria-valuetext", "step 700 of 1,000")
    page.locator("#seek").focus()
    on.press(page, ("ArrowLeft", 699), (".", 700), ("r", 0))
    decided = int(simulate(Scenario(), 1, 1).decision_step[0])
    on.press(page, ("d", decided), (",", decided - 1))
    page.get_by_role("button", name="Go to the decision").click()
    on.at(page, decided)
    for key, pace in (("+", 30), ("+", 60), ("-", 30)):
        page.keyboard.press(key)
        expect(page.locator("#speed")).to_have_text(f"{pace} steps / s")
    for name, pace in (("Slower", 20), ("Faster", 30)):
        page.get_by_role("button", name=name, exact=True).click()
        expect(page.locator("#speed")).to_have_text(f"{pace} steps / s")
    on.focus_nothing(page)
    page.keyboard.press("?")
    expect(page.get_by_role("dialog")).to_be_visible()
    page.keyboard.press("r")  # a dialog takes the keys
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog")).to_be_hidden()
    on.at(page, decided)


def test_it_plays_by_itself_pauses_and_ends(show):
    page = show(Scenario(run={"steps": 300}), reduced_motion="no-preference")
    expect(page.locator("#now")).not_to_have_text("0")
    page.keyboard.press(" ")
    expect(page.get_by_role("button", name="Play", exact=True)).to_be_visible()
    page.wait_for_function("() => feasibee.clock.head === feasibee.clock.target")
    there = page.evaluate("feasibee.clock.step")
    drawn(page, 20)
    on.at(page, there)
    later = "(({ clock }) => (clock.goTo(0), clock.play(true), clock.tick(clock.history, 0.5), clock.head))"
    assert page.evaluate(f"{later}(feasibee)") == 10  # half a second at 20 steps per second
    for _ in range(8):
        page.keyboard.press("+")
    on.at(page, 300)
    expect(page.get_by_role("button", name="Play", exact=True)).to_be_visible()
    for _ in range(5):
        page.keyboard.press("-")
    page.keyboard.press(" ")  # from the start
    expect(page.get_by_role("button", name="Pause")).to_be_visible()
    expect(page.locator("#now")).not_to_have_text("300")


def test_a_step_looks_the_same_from_before_and_from_after(show):
    """Robots and tasks are drawn while they are there."""
    page = show(Scenario(events=EVENTS, run={"steps": 120}))
    on.focus_nothing(page)
    page.mouse.move(1, 1)
    seen = {}
    for step in (19, 39, 41, 119, 71, 41, 39, 19):
        on.seek(page, step)
        assert on.picture_of(page) == seen.setdefault(step, on.picture_of(page)), step
    assert len(set(seen.values())) == 5


def test_a_seek_and_steps_that_come_at_once_add_up(show):
    scenario = Scenario(robots={"count": 1000}, tasks={"count": 900}, arena={"side": 141.0})
    page = show(scenario)
    keys = "document.body.dispatchEvent(new KeyboardEvent('keydown', { key: '.', bubbles: true }));"
    page.evaluate(
        f"""() => {{ const it = document.querySelector("#seek");
        for (it.value of [900, 3, 150]) it.dispatchEvent(new Event("input"));
        {3 * keys} }}"""
    )
    on.at(page, 153)
    for step, frame in zip((250, 800), on.frames_of(page, (250, 800)), strict=True):  # they came in parts
        own = swarm_at(step, scenario, 1).snapshot()
        assert [frame["x"], frame["flags"]] == [own.x.tolist(), own.flags.tolist()]


def test_no_run_has_a_word_of_another(show):
    """Counts of tasks that come faster than runs are simulated: the last one counts."""
    page = show(Scenario())
    page.evaluate(
        """() => { const it = document.querySelector("[data-path='tasks.count']");
        for (it.value of ["30", "500", "25"]) it.dispatchEvent(new Event("change", { bubbles: true })); }"""
    )
    on.asked(page, 20, 25)
    on.expect_run(page)
    expect(page.locator("#swarms")).to_have_attribute("aria-busy", "false")
    swarms = simulate(Scenario(tasks={"count": 25}), 100, 1)
    expect(page.locator("#many")).to_contain_text(f"Right in {int((swarms.decision == 0).sum())} of 100")
    expect(page.locator("#decision")).to_contain_text(f"at step {int(swarms.decision_step[0])}.")


def test_the_truth_of_a_world_that_changes(show):
    scenario = Scenario(events=EVENTS, decision={"strategy": "census"}, run={"steps": 120})
    page = show(scenario)
    told = "the world changes 3 times, the truth 2 times, at 20, 70"
    expect(page.locator("#marks-text")).to_contain_text(told)
    for key, step, robots, tasks, answer in (
        ("]", 20, 20, 26, "No: 6 robots are missing"),
        ("]", 70, 15, 6, "Yes: 9 robots to spare"),
        ("]", 70, 15, 6, "Yes: 9 robots to spare"),
        ("[", 20, 20, 26, "No: 6 robots are missing"),
        (",", 19, 20, 20, "Yes: just enough"),
    ):
        on.press(page, (key, step))
        on.asked(page, robots, tasks)
        expect(page.locator("#truth")).to_contain_text(answer)
    on.seek(page, 45)
    held = swarm_at(45, scenario, 1).decision
    words = {1: "holds feasible", 0: "holds infeasible", -1: "holds no decision"}
    expect(page.locator("#decision")).to_contain_text(f"The swarm {words[held]} at this step.")
    expect(page.locator("#arena")).to_have_attribute(
        "aria-label",
        "The arena: 12 robots and 26 tasks, census, at step 45. Arrow keys go from robot to robot.",
    )


def test_robots_that_act_say_whether_they_did_it(show):
    scenario = Scenario(acting={"start": 30}, run={"steps": 150})
    page, step = show(scenario), int(simulate(scenario, 1, 1).all_taken_step[0])
    expect(page.locator("#done")).to_have_text(
        "Did 20 robots do 20 tasks? Not yet: robots stand at 0 of 20 tasks."
    )
    taken = f"robots stand at all tasks that they can, at step {step}"
    expect(page.locator("#marks-text")).to_contain_text(taken)
    for name, shown in {"free": True, "taken": True, "done": False, "task": False, "liar": False}.items():
        expect(on.unfolded(page, f"#legend-{name}")).to_be_visible(visible=shown)
    on.seek(page, step)
    expect(page.locator("#done")).to_contain_text(
        f"Yes: robots stand at 20 of 20 tasks, from step {step} on."
    )


def test_declarations_are_counted(show):
    scenario = Scenario(
        decision={"strategy": "quiet-census"},
        robots={"know_count": True},
        faults={"byzantine": 0.1},
        run={"steps": 300},
    )
    swarm, page = swarm_at(300, scenario, 1), show(scenario)
    feasible, infeasible = swarm.declared_counts
    assert feasible + infeasible > 0
    expect(page.locator("#marks-text")).to_contain_text("declaration at step")
    expect(on.unfolded(page, "#legend-declared")).to_be_visible()
    on.seek(page, 300)
    told = f"{feasible} feasible, {infeasible} infeasible, of 18"
    expect(on.unfolded(page, "#counts dl")).to_contain_text(f"have declared{told}")
    on.point_at(page, swarm, int(np.flatnonzero(swarm.declared >= 0)[0]))
    expect(page.locator("#tip")).to_contain_text("has declared")


def test_the_theory_is_said_and_drawn_of_the_scenario_that_the_page_was_made_of(show):
    page = show(FIFTY)
    theory = on.unfolded(page, "#theory")
    expect(theory).to_contain_text("Up to 20 tasks, most swarms decide feasible.")
    expect(page.locator("#plot")).to_contain_text("theory")
    on.slider(page, "tasks.count").fill("51")
    expect(theory).to_be_empty()
    on.slider(page, "tasks.count").fill("50")
    expect(theory).to_contain_text("Up to 20 tasks, most swarms decide feasible.")


@pytest.mark.slow  # it compiles the strategy
def test_a_strategy_that_fails_ends_the_run_and_says_its_line(show, tmp_path):
    pytest.importorskip("ziglang", reason="ziglang isn't installed")
    strategy = tmp_path / "mine.py"
    strategy.write_text(
        "def decide(mind, inbox):\n    return mind.opinion + 0 // (1 - inbox.feasible_votes)\n", "utf-8"
    )
    page = show(Scenario(decision={"strategy": str(strategy)}, tasks={"count": 5}))
    expect(page.locator("#decision")).to_contain_text("Line 2 of the strategy fails here")
    last = int(page.locator("#last").inner_text())
    assert 0 < last < 1000
    on.seek(page, last)
    on.control_of(page, "decision.strategy").select_option("voter")
    expect(page.locator("#decision")).to_contain_text("The swarm decides")


def test_markup_in_names_stays_text(show):
    robots = {"classes": [{"name": "<img src=x onerror=alert(1)>", "count": 3, "skills": ["lift"]}]}
    tasks = {"classes": [{"name": "</script><b>", "count": 1, "needs": {"lift": 1}}]}
    scenario = Scenario(robots=robots, tasks=tasks, arena={"side": 20.0})
    page = show(scenario)
    on.point_at(page, Swarm(scenario, 1), 0)
    expect(page.locator("#tip")).to_contain_text("class <img src=x onerror=alert(1)>")
    on.choose(page, 0)
    expect(page.locator("#reasons-0")).to_contain_text("<img src=x onerror=alert(1)>")
    assert page.locator("main :is(img, b)").count() == 0
    on.expect_scenario(page, scenario)
    show(PLACE)  # whose zone is called <dock> & more


@pytest.mark.slow
def test_ten_thousand_robots_are_drawn(show):
    page = show(
        Scenario(robots={"count": 10_000}, tasks={"count": 9000}, arena={"side": 447.0}, run={"steps": 60})
    )
    on.press(page, (".", 1))
    expect(page.locator("#feasible")).to_have_text(re.compile("^[45],"))
    assert page.evaluate("feasibee.history.frame(60).aims.length") == 0  # though its steps came in parts


@pytest.mark.slow
def test_in_a_frame_it_has_the_sites_theme_and_its_own_height(show, new_page, tmp_path):
    show(FIFTY)
    shutil.copy(tmp_path / "0.html", tmp_path / "swarm.html")
    shutil.copy(SITE / "swarm.js", tmp_path)
    (tmp_path / "index.html").write_text(
        '<!doctype html><body data-theme="dark"><iframe class="swarm" src="swarm.html"></iframe>'
        '<script src="swarm.js" defer></script>'
    )
    page = new_page(reduced_motion="reduce")
    page.goto((tmp_path / "index.html").as_uri())
    inside = page.frame_locator("iframe")
    expect(inside.locator("html")).to_have_attribute("data-theme", "dark")
    expect(inside.locator("header")).to_be_hidden()

    def check():
        height = page.locator("iframe").bounding_box()["height"]
        assert abs(height - inside.locator("body").evaluate("body => body.scrollHeight")) < 8
        assert height > 400

    eventually(page, check)
    page.evaluate("document.body.dataset.theme = 'light'")
    expect(inside.locator("html")).to_have_attribute("data-theme", "light")

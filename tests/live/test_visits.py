"""The page in a real browser, from a file and without network: what somebody sees and does there."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from visiting import expect_shade, point_at, press, seen_at, step_of
from waiting import drawn, eventually

from feasibee import Scenario, Swarm, decision_counts, simulate, wilson
from feasibee.live.page import write_page
from feasibee.scenario.feasibility import truth

expect = pytest.importorskip("playwright.sync_api", reason="playwright isn't installed").expect
SITE = Path(__file__).parents[2] / "docs" / "_static"
FIFTY = Scenario(tasks={"count": 50})


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "run.html"
    write_page(FIFTY, path, seed=1)
    return path


@pytest.fixture
def visit(new_page):
    """Give a function that opens a file; no page may load anything but files."""

    def asked(request):
        if not request.url.startswith(("file:", "data:")):
            new_page.errors.append(request.url)

    def opened(path, more="", width=1280, ready=True, **options):
        options = {"reduced_motion": "reduce", **options}
        page = new_page(viewport={"width": width, "height": 800}, offline=True, **options)
        page.on("request", asked)
        page.goto(f"{path.as_uri()}{more}")
        if ready:  # it listens to keys by then
            expect(page.locator("#question")).not_to_be_empty()
        return page

    return opened


def test_the_theory_is_drawn_for_the_scenario_that_the_page_was_made_of(visit, file):
    page = visit(file)
    theory = page.locator("#theory")
    expect(theory).to_contain_text("Up to 20 tasks, most swarms decide feasible.")
    expect_shade(page, "#curve", True)
    page.locator("#run").fill("7")
    expect(theory).to_be_visible()
    page.locator("#tasks").fill("51")
    expect(theory).to_be_hidden()
    expect_shade(page, "#curve", False)
    page.locator("#tasks").fill("50")
    expect(theory).to_be_visible()


def test_it_plays_by_itself_and_by_keys(visit, file):
    page = visit(file, reduced_motion="no-preference")
    expect(page.locator("#now")).not_to_have_text("0")
    page.keyboard.press(" ")
    expect(page.get_by_role("button", name="Play", exact=True)).to_be_visible()
    drawn(page, 10)  # it comes to the next step, a third of a step each time it is drawn
    there = step_of(page)
    press(page, (".", there + 1))
    page.keyboard.press("ArrowLeft")
    press(page, (",", there - 1), ("r", 0))
    page.keyboard.press("+")
    expect(page.locator("#speed")).to_have_text("30 steps / s")
    page.keyboard.press("g")
    expect(page.locator("#ranges")).to_have_attribute("aria-pressed", "true")


def test_it_says_what_is_seen_and_since_when_a_robot_holds_its_opinion(visit, file):
    page = visit(file)
    page.locator("#seek").fill("80")
    expect(page.locator("#now")).to_have_text("80")
    page.get_by_text("What am I looking at?").click()
    expect(page.locator("#terms dd")).to_have_count(5)
    walk = Swarm(FIFTY, 1)
    opinions, sends = [walk.opinions], [walk.disseminating]
    for _ in range(80):
        walk.advance()
        opinions.append(walk.opinions)
        sends.append(walk.disseminating)
    for robot in (7, 9):
        held, begun = (
            max((k for k in range(1, 81) if each[k][robot] != each[k - 1][robot]), default=0)
            for each in (opinions, sends)
        )
        since = [f"step {each}" if each else "the start" for each in (held, begun)]
        word = ("infeasible", "feasible")[walk.opinions[robot]]
        does = "Broadcasts" if walk.disseminating[robot] else "Explores"
        point_at(page, walk, robot, "move")
        expect(page.locator("#tip")).to_contain_text(f"Robot {robot}: {word}")
        expect(page.locator("#tip")).to_contain_text(
            f"Holds {word} since {since[0]}. {does} since {since[1]}."
        )


def test_decision_and_hundred_swarms_are_the_engines(visit, file):
    page = visit(file)
    swarms = simulate(FIFTY, runs=100, seed=1, curves=True)
    counts = decision_counts(swarms.decision)
    expect(page.locator("#swarm-counts")).to_have_text(
        f"100 swarms: {counts['feasible']} feasible, {counts['infeasible']} infeasible."
    )
    rate, low, high = wilson(counts["feasible"], 100)
    expect(page.locator("#swarm-feasible")).to_have_text(
        f"Share feasible: {rate:.2f} ({low:.2f} to {high:.2f})."
    )
    for run in (0, 1):
        page.keyboard.press("d")
        step = int(swarms.decision_step[run])
        word = ("infeasible", "feasible")[int(swarms.decision[run])]
        expect(page.locator("#decision")).to_contain_text(f"The swarm decided {word} at step {step}.")
        expect(page.locator("#feasible")).to_have_text(str(int(swarms.feasible_count[run, step])))
        page.keyboard.press("n")
        expect(page.locator("#run")).to_have_value(str(run + 1))


def test_knowledge_walls_and_a_bad_radio_are_the_engines(visit, tmp_path):
    changes = {"arena.boundary": "walls", "arena.side": [20.0, 14.0], "radio.loss": 0.3, "sensing.miss": 0.2}
    scenario = FIFTY.replace(changes)
    write_page(scenario, file := tmp_path / "walls.html", seed=1)
    page = visit(file)
    expect(page.locator("#legend-declared")).to_be_hidden()
    page.get_by_label("Strategy").select_option("turns")
    expect(page.locator("#legend-declared")).to_be_visible()
    other = {"decision.strategy": "turns", "robots.know_count": True}
    alone = simulate(scenario.replace(other), seed=1)
    page.locator("h1").click()
    page.keyboard.press("d")
    word = ("infeasible", "feasible")[int(alone.decision[0])]
    decided = f"The swarm decided {word} at step {int(alone.decision_step[0])}."
    expect(page.locator("#decision")).to_contain_text(decided)
    box = page.locator("#arena").bounding_box()
    assert abs(box["height"] / box["width"] - 0.7) < 0.01


def test_rooms_are_the_engines(visit, tmp_path):
    wall = [[8.0, 0.0], [8.2, 0.0], [8.2, 14.0], [8.0, 14.0]]
    scenario = FIFTY.replace(
        {
            **{"arena.boundary": "walls", "arena.side": [20.0, 14.0], "place.walls": [wall]},
            **{"robots.diameter": 0.5, "tasks.count": 20, "radio.walls": 0.7},
        }
    )
    assert truth(scenario)
    write_page(scenario, file := tmp_path / "rooms.html", seed=1)
    page = visit(file)
    expect(page.locator("#truth")).to_have_text("Yes: just enough")
    swarms = simulate(scenario, runs=100, seed=1)
    counts = decision_counts(swarms.decision)
    told = ", ".join(
        f"{counts[word]} {word}" for word in ("feasible", "infeasible", "undecided") if counts[word]
    )
    expect(page.locator("#swarm-counts")).to_have_text(f"100 swarms: {told}.")
    swarm = Swarm(scenario, seed=1)
    for step in range(1, 4):
        press(page, (".", step))
        swarm.advance()
    expect(page.locator("#feasible")).to_have_text(str(swarm.feasible_count))
    discs = swarm.positions[swarm.opinions == 1]
    assert len(discs) > 5
    for x, y in discs:
        colour = seen_at(page, x / 20, 1 - y / 14)
        assert colour == pytest.approx([0, 114, 178], abs=60), (x, y)
    page.get_by_label("Tasks", exact=True).fill("21")
    expect(page.locator("#truth")).to_have_text("No: 1 robot is missing")
    page.get_by_label("Robots", exact=True).fill("1")
    page.get_by_label("Tasks", exact=True).fill("1")
    expect(page.locator("#truth")).to_have_text("Yes: just enough")


def test_robots_that_act_and_faulty_ones_are_the_engines(visit, tmp_path):
    changes = {"acting.start": 15, "faults.stopped": {"count": 2}, "faults.stop_step": 5, "tasks.count": 19}
    scenario = Scenario().replace({**changes, "events": [{"step": 30, "tasks": 1, "radio": {"loss": 0.5}}]})
    write_page(scenario, file := tmp_path / "acts.html", seed=1)
    page = visit(file)
    for name, shown in {"free": True, "taken": True, "task": False, "stopped": True, "liar": False}.items():
        assert page.locator(f"#legend-{name}").is_visible() == shown
    expect(page.locator("#touching")).to_contain_text("The numbers at the start are those of the scenario")
    swarm = Swarm(scenario, seed=1)
    swarm.advance(45)
    page.locator("#seek").fill("45")
    expect(page.locator("#now")).to_have_text("45")
    expect(page.locator("#feasible")).to_have_text(str(swarm.feasible_count))
    expect(page.locator("#infeasible")).to_have_text(str(swarm.infeasible_count))
    robot = int(swarm.standing.nonzero()[0][0])
    point_at(page, swarm, robot, "move")
    expect(page.locator("#tip")).to_contain_text("stands at a task")
    page.locator("#tasks-slider").fill("25")
    expect(page.locator("#question")).to_have_text("Can 20 robots do 25 tasks?")
    added = [*scenario.events, {"step": 46, "tasks": 5}]
    told = Scenario.from_toml(page.locator("#toml").text_content())
    assert told == scenario.replace({"events": added})
    expect(page.locator("#swarms")).to_have_attribute("aria-busy", "false")
    page.reload()
    expect(page.locator("#now")).to_have_text("0")
    page.locator("#seek").fill("46")
    expect(page.locator("#question")).to_have_text("Can 20 robots do 25 tasks?")


@pytest.mark.slow  # it compiles the strategy
def test_a_strategy_that_fails_ends_the_run_and_says_its_line(visit, tmp_path):
    pytest.importorskip("ziglang", reason="ziglang isn't installed")
    strategy, file = tmp_path / "mine.py", tmp_path / "mine.html"
    strategy.write_text(
        "def decide(mind, inbox):\n    return mind.opinion + 0 // (1 - inbox.feasible_votes)\n"
    )
    write_page(Scenario(decision={"strategy": str(strategy)}, tasks={"count": 5}), file, seed=1)
    page = visit(file)
    page.keyboard.press("d")
    expect(page.locator("#decision")).to_have_text("Line 2 of the strategy fails here.")
    assert 0 < step_of(page) < 1000
    page.get_by_label("Strategy").select_option("voter")
    page.keyboard.press("d")
    expect(page.locator("#decision")).to_contain_text("The swarm decided")


def test_sliders_change_the_swarm_and_the_address_keeps_it(visit, file):
    page = visit(file)
    page.get_by_label("Tasks, slider").focus()
    for _ in range(32):
        page.keyboard.press("ArrowLeft")
    expect(page.locator("#question")).to_have_text("Can 20 robots do 18 tasks?")
    expect(page.locator("#truth")).to_have_text("Yes: 2 robots to spare")
    page.get_by_label("Strategy").select_option("voter")
    page.get_by_label("Seed", exact=True).fill("18446744073709551615")
    page.get_by_label("Robots", exact=True).fill("17")
    kept = "#robots=17&tasks=18&strategy=voter&seed=18446744073709551615&run=0"
    expect(page).to_have_url(f"{file.as_uri()}{kept}")
    other = visit(file, kept)
    expect(other.locator("#question")).to_have_text("Can 17 robots do 18 tasks?")
    expect(other.locator("#truth")).to_have_text("No: 1 robot is missing")
    for each in (page, other):
        each.locator("h1").click()
        each.keyboard.press("d")
    changes = {"robots.count": 17, "tasks.count": 18, "decision.strategy": "voter"}
    alone = simulate(FIFTY.replace(changes), seed=2**64 - 1)
    for each in (page, other):
        expect(each.locator("#decision")).to_contain_text(f"at step {int(alone.decision_step[0])}.")


def test_an_invalid_number_is_marked_and_changes_nothing(visit, file):
    page = visit(file)
    robots = page.get_by_label("Robots", exact=True)
    robots.fill("20001")
    expect(robots).to_have_attribute("aria-invalid", "true")
    expect(page.locator("#question")).to_have_text("Can 20 robots do 50 tasks?")
    robots.press("Tab")
    expect(robots).to_have_value("20")
    drawn(page, 10)
    assert step_of(page) == 0  # it rests, since motion is to be reduced


@pytest.mark.quick(2)
@pytest.mark.parametrize("width", [360, 740, 900, 1440])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_fits_and_has_the_systems_colours(visit, file, width, scheme):
    page = visit(file, width=width, color_scheme=scheme)
    expect(page.locator("#arena[data-drawn]")).to_be_visible()
    eventually(page, lambda: expect_fit(page, width, scheme))


def expect_fit(page, width, scheme):
    assert page.evaluate("document.documentElement.scrollWidth") == width
    stage, faster = (page.locator(each).bounding_box() for each in ("#stage", "#faster"))
    assert faster["x"] + faster["width"] <= stage["x"] + stage["width"] + 1
    ground = page.evaluate(
        "[...document.getElementById('arena').getContext('2d').getImageData(2, 2, 1, 1).data]"
    )
    assert (max(ground[:3]) < 60) == (scheme == "dark")


def expect_own_height(page, inside):
    height = page.locator("iframe").bounding_box()["height"]
    assert abs(height - inside.locator("body").evaluate("body => body.scrollHeight")) < 8
    assert height > 500


@pytest.mark.slow
def test_in_a_frame_it_has_the_sites_theme_and_its_own_height(visit, file, tmp_path):
    shutil.copy(file, tmp_path / "swarm.html")
    shutil.copy(SITE / "swarm.js", tmp_path)
    (tmp_path / "index.html").write_text(
        '<!doctype html><body data-theme="dark"><iframe class="swarm" src="swarm.html"></iframe>'
        '<script src="swarm.js" defer></script>'
    )
    page = visit(tmp_path / "index.html", ready=False)
    inside = page.frame_locator("iframe")
    expect(inside.locator("html")).to_have_attribute("data-theme", "dark")
    expect(inside.locator("header")).to_be_hidden()
    eventually(page, lambda: expect_own_height(page, inside))
    page.evaluate("document.body.dataset.theme = 'light'")
    expect(inside.locator("html")).to_have_attribute("data-theme", "light")

"""The form of the page in a real browser: what it takes and shows, and that it moves nothing by itself."""

from __future__ import annotations

import html
import re
from importlib.metadata import EntryPoint

import pytest
import visiting as on
from playing import swept
from serving import serving_at

from feasibee import Scenario
from feasibee.live.catalogue import Catalogue, read_catalogue
from feasibee.live.form import form
from feasibee.live.page import page_of
from feasibee.scenario import plugins

expect = pytest.importorskip("playwright.sync_api", reason="playwright isn't installed").expect
SCENARIO = Scenario(
    tasks={"count": 50},
    decision={"listen": {"last": 3}},
    units={"metres": 0.5},
    events=[{"step": 20, "tasks": 4}],
)
ROOM = """all => all.filter(each => each.checkVisibility()).map(each => each.labels?.[0] ?? each)
    .filter(each => each.getBoundingClientRect().height < 44).map(each => each.textContent)"""


@pytest.fixture(scope="module")
def served():
    """The port of a server of a scenario whose values aren't all numbers."""
    with serving_at(Catalogue(SCENARIO, seed=1)) as port:
        yield port


def field(page, path):
    return page.locator(f"[data-path='{path}']")


def folds(page):
    return page.locator("details").evaluate_all("all => all.map(each => each.open)")


def expect_described(page, path, text):
    expect(field(page, path)).to_have_accessible_description(re.compile(re.escape(text)))


def test_slider_and_number_always_agree(show):
    page = show(Scenario())
    for path, *values, slid in (
        ("robots.count", "33", "300", "40"),
        ("tasks.count", "0", "250", "40"),
        ("sensing.range", "2.55", "10", "4.5"),
        ("run", "4", "1234", "40"),
    ):
        for value in values:
            on.type_into(page, path, value)
            expect(on.slider(page, path)).to_have_value(value)
        on.slider(page, path).fill(slid)
        expect(field(page, path)).to_have_value(slid)
    on.type_into(page, "robots.count", "300")
    on.slider(page, "tasks.count").fill("41")
    on.asked(page, 300, 41)
    for each in (field, on.slider):
        expect(each(page, "robots.count")).to_have_value("300")
    on.type_into(page, "seed", "18446744073709551615")
    expect(on.slider(page, "seed")).to_be_hidden()  # it can't be so exact
    expect(page).to_have_url(re.compile("robots=300&.*seed=18446744073709551615"))


def test_an_invalid_number_is_marked_and_changes_nothing(show):
    page = show(Scenario())
    for path, text, rule in (
        ("robots.count", "0", "must be a whole number; type 1 to 20,000."),
        ("robots.count", "20001", "type 1 to 20,000."),
        ("tasks.count", "many", "type 0 to 20,000."),
        ("sensing.range", "2 m", "must be a number; type 0.01 to 10."),
        ("sensing.range", "12", "type 0.01 to 10."),
        ("radio.range", "10.1", "type 0.01 to 10."),
        ("robots.speed", "10.1", "type 0 to 10."),
        ("seed", "18446744073709551616", "type 0 to 18,446,744,073,709,551,615."),
    ):
        control = on.type_into(page, path, text)
        expect(control).to_have_attribute("aria-invalid", "true")
        expect(control).to_have_value(text)
        expect_described(page, path, rule)
        on.asked(page, 20, 20)
    on.slider(page, "robots.count").fill("25")
    on.asked(page, 25, 20)
    expect(field(page, "robots.count")).to_have_attribute("aria-invalid", "false")
    expect(field(page, "tasks.count")).to_have_value("many")  # still marked
    page.get_by_role("button", name="Undo all changes").click()
    on.asked(page, 20, 20)
    expect(page.locator("[aria-invalid='true']")).to_have_count(0)


def test_ranges_are_bounded_by_the_scenario_that_is_shown(show, served):
    page, half = show(served), "must be at most half the side of the torus"
    on.type_into(page, "sensing.range", "12")
    expect_described(page, "sensing.range", f"{half}, 10 units; set arena.side to 24")
    on.type_into(page, "arena.side", "30")
    expect(field(page, "sensing.range")).to_have_value("2")
    on.type_into(page, "sensing.range", "12")
    expect(on.slider(page, "sensing.range")).to_have_value("12")
    on.expect_scenario(page, SCENARIO.replace({"arena.side": 30, "sensing.range": 12, "radio.range": 2}))
    expect(page).to_have_url(re.compile("arena.side=30&sight=12&"))
    page.reload()
    expect(field(page, "sensing.range")).to_have_value("12")
    on.type_into(page, "arena.side", "8")
    expect_described(page, "sensing.range", f"{half}, 4 units")
    on.type_into(page, "sensing.range", "3")
    on.type_into(page, "arena.side", "8")
    expect(on.slider(page, "sensing.range")).to_have_attribute("max", "4")


def test_a_problem_is_listed_and_nothing_unfolds_without_a_click(show, served):
    page = show(served)
    problems = page.locator(".problems")
    on.type_into(page, "sensing.gate", "3 s")
    expect_described(page, "sensing.gate", "must be a length, not a time")
    expect(problems).to_have_text("Not changed: the previous run continues.")  # the rest is at its field
    page.locator("summary", has_text="Sensing").click()
    before = folds(page)
    field(page, "sensing.gate").evaluate("at => { at.value = '-1'; at.dispatchEvent(new Event('change')); }")
    expect(problems.locator("li")).to_contain_text("sensing.gate = -1: must be")
    assert folds(page) == before
    on.asked(page, 20, 50)
    page.get_by_role("button", name="Go to sensing.gate").click()
    expect(field(page, "sensing.gate")).to_be_focused()
    expect(on.type_into(page, "sensing.gate", "3 m")).to_have_value("6")
    expect(problems).to_be_hidden()


def test_values_and_units_are_shown_as_they_are_typed(show, served):
    page = show(served)
    expect(field(page, "events")).to_have_value(re.compile(r"^\[\{ ?step = 20, tasks = 4.*\}\]$"))
    expect(field(page, "decision.listen")).to_have_value(re.compile(r"^\{ ?last = 3 ?\}$"))
    expect(on.type_into(page, "sensing.range", "1.5 m")).to_have_value("3")
    expect_described(page, "sensing.range", "units (1.5 m)")
    on.type_into(page, "events", "[{step = 30, robots = 2}]")
    on.control_of(page, "arena.boundary").select_option("walls")
    on.control_of(page, "sensing.count_self").check()
    on.type_into(page, "radio.id_bits", "4")
    on.type_into(page, "faults.stubborn", "{count = 1}")
    changes = {"sensing.range": 3, "radio.range": 2, "arena.boundary": "walls"}
    more = {"sensing.count_self": True, "radio.id_bits": 4, "events": [{"step": 30, "robots": 2}]}
    changes |= more | {"faults.stubborn": {"count": 1}}
    on.expect_scenario(page, SCENARIO.replace(changes))
    expect(field(page, "faults.stubborn")).to_have_value(re.compile(r"^\{ ?count = 1 ?\}$"))
    on.type_into(page, "radio.id_bits", "")
    on.expect_scenario(page, SCENARIO.replace({**changes, "radio.id_bits": None}))


def test_what_was_changed_has_a_mark_and_is_taken_back(show, served):
    page = show(served)
    expect_described(page, "tasks.count", "Not the default.")
    expect(page.locator("summary", has_text="Decision")).to_contain_text("1 changed")
    radio = page.locator("summary", has_text="Radio")
    expect(radio).not_to_contain_text("changed")
    on.type_into(page, "radio.loss", "0.2")
    expect(radio).to_contain_text("1 changed")
    expect_described(page, "radio.loss", "Changed.")
    on.slider(page, "robots.count").fill("30")
    on.asked(page, 30, 50)
    page.get_by_role("button", name="Take back: Robots").click()
    on.asked(page, 20, 50)
    expect(field(page, "robots.count")).to_be_focused()
    page.get_by_role("button", name="Take back: Loss").click()
    expect(radio).not_to_contain_text("changed")
    on.expect_scenario(page, SCENARIO)


def test_a_setting_is_found_by_its_words(show, served):
    page = show(served)
    finder, found = page.locator("#find"), page.locator(".find [role='status']")
    before = folds(page)
    finder.fill("misses message")
    expect(found).to_have_text(re.compile(r"^1 of \d\d settings$"))
    expect(field(page, "radio.loss")).to_be_visible()
    expect(field(page, "radio.delay")).to_be_hidden()
    finder.fill("no such thing")
    expect(found).to_have_text(re.compile("^0 of"))
    finder.fill("")
    assert folds(page) == before


def test_the_density_is_kept_where_robots_are_more(show, served):
    page = show(served)
    page.get_by_role("switch", name="Keep the density").check()
    on.slider(page, "robots.count").fill("80")
    on.expect_scenario(page, SCENARIO.replace({"robots.count": 80, "arena.side": 40.0}))
    on.type_into(page, "arena.side", "30")
    expect(page.get_by_role("switch", name="Keep the density")).not_to_be_checked()


def test_what_is_chosen_is_copied_and_stays_in_the_address(show):
    page = show(SCENARIO, permissions=["clipboard-read", "clipboard-write"])
    on.slider(page, "tasks.count").fill("18")
    on.slider(page, "sensing.range").fill("3.5")
    field(page, "decision.strategy").select_option("voter")
    field(page, "against").select_option("census")
    changes = {"tasks.count": 18, "sensing.range": 3.5, "radio.range": 2, "decision.strategy": "voter"}
    on.expect_scenario(page, SCENARIO.replace(changes))
    page.get_by_role("button", name="Copy as scenario").click()
    expect(page.get_by_role("button", name="Copied")).to_be_visible()
    assert Scenario.from_toml(page.evaluate("navigator.clipboard.readText()")) == SCENARIO.replace(changes)
    page.get_by_role("button", name="Next run").click()
    expect(page).to_have_url(re.compile("tasks=18&sight=3.5&strategy=voter&against=census&run=1&seed=1$"))
    page.reload()
    on.asked(page, 20, 18)
    expect(field(page, "against")).to_have_value("census")
    expect(field(page, "run")).to_have_value("1")
    on.expect_scenario(page, SCENARIO.replace(changes))


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """Name of a strategy that another package registers."""
    text = '"""Fable: robots hope."""\n\ndef decide(mind, inbox):\n    return 1\n'
    (tmp_path / "fabled.py").write_text(text)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(plugins, "entry_points", lambda group: [EntryPoint("fable", "fabled", group)])
    form.cache_clear()
    yield "fable"
    form.cache_clear()


def test_a_strategy_of_another_package_is_chosen_where_python_has_it(show, installed):
    """Catches a page that goes on with the engine it was made with, without that strategy."""
    pytest.importorskip("ziglang", reason="ziglang isn't installed: it compiles WebAssembly")
    with serving_at(Catalogue(SCENARIO, seed=1)) as port:
        page = show(port)
        field(page, "decision.strategy").select_option(installed)
        fable = SCENARIO.replace({"decision.strategy": installed})
        on.expect_scenario(page, fable)
        expect_described(page, "decision.strategy", "Robots hope.")
        on.type_into(page, "radio.loss", "0.2")
        on.expect_scenario(page, fable.replace({"radio.loss": 0.2}))
        expect(page).to_have_url(re.compile("strategy=fable&.*radio.loss="))
        page.reload()
        on.expect_run(page)
        on.seek(page, 150)
        on.expect_swarm(page, 150, fable.replace({"radio.loss": 0.2}))
        field(page, "decision.strategy").select_option("voter")
        on.expect_scenario(page, SCENARIO.replace({"decision.strategy": "voter", "radio.loss": 0.2}))
        on.type_into(page, "radio.loss", "0.1")
        on.expect_scenario(page, SCENARIO.replace({"decision.strategy": "voter", "radio.loss": 0.1}))
        page.close()  # it would ask the server that ends now


@pytest.mark.parametrize(
    "more",
    [
        "#robots=-4&tasks=1e9&seed=%3Cb%3E&run=__proto__&strategy=constructor&against=toString&point=-1",
        '#events=[{"step":1,"robots":-99}]&sight=NaN&speed=-1&radio=Infinity',
        '#events=[{"step":1,"__proto__":{"tasks":3}}]&%E0%A4%A&__proto__.x=1',
        "#events=[[[&robots=2.5&robots=&seed=99999999999999999999999",
    ],
)
def test_a_hostile_address_changes_nothing(show, more):
    page = show(SCENARIO, more)
    on.asked(page, 20, 50)
    on.expect_scenario(page, SCENARIO)


def test_an_address_that_cannot_be_is_told_and_the_page_shows_what_it_has(show, served):
    page = show(served, "#place.walls=1&point=7&tasks=24")
    on.asked(page, 20, 50)
    expect(page.locator(".problems")).to_be_visible()
    on.slider(page, "tasks.count").fill("12")
    on.asked(page, 20, 12)


def test_a_sweeps_runs_are_listed_and_shown(show, tmp_path):
    tables = {"runs": 20, "seed": 5, "scenario": {"run": {"steps": 1000}}, "sweep": {"tasks.count": [17, 24]}}
    catalogue = read_catalogue(swept(tables, tmp_path), "wrong")
    with serving_at(catalogue) as port:
        page = show(port)
        runs = page.locator(".replays button")
        expect(page.locator(".replays h3")).to_have_text(
            f"{catalogue.replays['found']} runs that decided wrong"
        )
        expect(page.locator(".replays summary")).to_contain_text(["tasks.count 17", "tasks.count 24"])
        expect(page.locator(".replays [aria-current='true']")).to_have_count(1)
        runs.last.focus()
        page.keyboard.press("Enter")
        expect(runs.last).to_have_attribute("aria-current", "true")
        expect(field(page, "run")).to_have_value(catalogue.replays["replays"][-1]["run"])
        expect(page.locator("#verdict")).to_have_attribute("data-verdict", "wrong")
        on.asked(page, 20, 24)
        page.close()  # it would ask the server that ends now


def test_a_frame_without_an_address_works(show, new_page):
    page = new_page()
    source = html.escape(page_of(Scenario(), 1))
    page.set_content(f'<iframe sandbox="allow-scripts" width=1280 height=800 srcdoc="{source}"></iframe>')
    frame = page.frame_locator("iframe")
    frame.locator("[data-slides='robots.count']").fill("33")
    expect(frame.locator("#question")).to_have_text("Can 33 robots do 20 tasks?")
    page.wait_for_timeout(500)  # it would write its address by now
    frame.get_by_role("button", name="Copy as scenario").click()
    expect(frame.get_by_role("button", name="Selected")).to_be_visible()


def test_fingers_find_room_on_a_telephone(show, served):
    page = show(served, width=390, height=844, has_touch=True, is_mobile=True)
    expect(page.locator("#form")).to_be_hidden()  # folded: the answer is on the first screen
    page.locator("#settings summary").first.click()
    assert page.locator("#form :is(button, input, select, summary)").evaluate_all(ROOM) == []
    on.expect_no_scrolling(page, 390)

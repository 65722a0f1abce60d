"""The first page of an assessment: the one action, what stands on it, and that it fits."""

from __future__ import annotations

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from feasibee import Scenario
from feasibee.results.statistics import Interval, wilson
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.studies.assess import _Assessing, assess
from feasibee.studies.comparison import compare, ending_early, outcome_of, percent, wait_for, wait_interval
from feasibee.studies.pages import write_report
from feasibee.studies.report import action, sections
from feasibee.sweeps.sweep import Rounds

SHORT = Scenario(arena={"side": 12.0}, tasks={"count": 8}, run={"steps": 150})


@pytest.fixture(scope="module")
def assessment():
    """An assessment of few strategies, whose searches are short."""
    few = {name: SHORT.replace({"decision.strategy": name}) for name in ("dmmd", "dmvd", "census")}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("feasibee.studies.assess.suitable", lambda scenario: (dict(few), {}))
        patch.setattr("feasibee.studies.recommend.all_strategies", lambda scenario: list(few))
        patch.setattr("feasibee.studies.assess.LEAST_RUNS", 60)
        return assess(SHORT, runs=30, seed=2)


def having(outcome, share, **values):
    """Return an outcome of 400 runs of which this share is right."""
    return replace(outcome, right=np.arange(400) < 400 * share, **values)


def with_changes(assessment, *, here=0.5, there=1.0, robots=None, shares=()):
    """Return an assessment without a recommendation, whose cheapest changes have these pairs of shares."""
    ordered = sorted(assessment.limits, key=lambda each: each.price)
    shares = [*shares, *[(0, 0)] * (len(ordered) - len(shares))]
    limits = [
        replace(
            each,
            outcome=having(each.outcome, one),
            opposite=having(assessment.opposite, other),
            difference=Interval(0.5, 0.4, 0.6),
        )
        for each, (one, other) in zip(ordered, shares, strict=True)
    ]
    edge = SimpleNamespace(enough=robots)
    return replace(
        assessment,
        outcome=having(assessment.outcome, here),
        opposite=having(assessment.opposite, there),
        recommended=None,
        strategies=[],
        limits=limits[::-1],  # the order in which they are found doesn't count
        sizing=SimpleNamespace(edge=edge),
    )


def test_nothing_is_changed_in_a_swarm_that_is_ready(assessment):
    ready = with_changes(assessment, here=1.0, robots=24, shares=[(1.0, 1.0)])
    assert action(ready) == "Use the swarm as it is, with dmmd."


def test_another_strategy_comes_before_other_changes(assessment):
    worst = SimpleNamespace(right=Interval(0.99, 0.97, 1.0), outcome=assessment.opposite)
    asked = SimpleNamespace(needs=("names of tasks",))
    found = SimpleNamespace(strategy="census", worst=worst, asked=asked)
    better = replace(with_changes(assessment, robots=24, shares=[(1.0, 1.0)]), recommended=found)
    assert action(better) == (
        "Use the strategy census instead of dmmd. Then 99.0 % (97.0 to 100.0) are right with 50 tasks."
        " It needs names of tasks."
    )
    found.strategy = "dmmd"
    assert action(better) == "Use the swarm as it is, with dmmd. Further runs show that it is enough."


def test_the_cheapest_change_is_chosen_that_is_enough_in_both_worlds(assessment):
    def chosen(*shares, **values):
        return action(with_changes(assessment, shares=shares, **values))

    assert chosen((1, 1), (1, 1)).startswith(
        "Change this: explorations 3 times as long. Then 100.0 % (99.0 to"
    )
    assert chosen((0.9, 1), (1, 0.9), (1, 1)).startswith("Change this: robots that count themselves.")
    assert chosen((1, 0.9), robots=24).startswith("Use 24 robots, 4 more.")
    assert chosen((1, 1), robots=24).startswith("Change this: explorations")
    said = ["None of the strategies and changes that were tried is shown to be enough."]
    nothing = " Of the strategies, ".join(said + assessment.recommendation.probably)
    assert chosen((1, 0.9), (0.95, 1)) == chosen(robots=24, there=0.9) == chosen(robots=20) == nothing


def test_what_ended_early_is_not_taken_for_tried(assessment):
    early = replace(with_changes(assessment), missing=("comparing changes",))
    assert "Allow more time: not all of them were tried." in action(early)


def test_a_change_that_may_be_enough_has_all_runs_in_both_worlds(assessment):
    trial = replace(
        assessment.limits[0], outcome=replace(assessment.outcome, contender="robots that count themselves")
    )
    better = replace(trial, difference=Interval(0.5, 0.4, 0.6))
    other = replace(trial, outcome=replace(trial.outcome, contender="3 times as many steps"))
    with Rounds(None, most=None) as rounds:
        near, far = _Assessing(rounds, SHORT, 7, 2, 0.0)._turned(
            [better, replace(other, difference=Interval(0.1, -0.1, 0.3))]
        )
    assert (near.opposite.tasks, near.opposite.runs, near.outcome.runs, near.price) == (50, 7, 7, 2)
    assert (far.opposite, far.outcome, far.price) == (None, other.outcome, 1)


def test_a_longer_run_is_as_long_as_is_shown_to_be_enough(assessment):
    longer = with_changes(assessment, shares=[(0, 0), (1, 1)])
    trial = min(longer.limits, key=lambda each: -each.outcome.right_at.size)
    right_at = np.where(np.arange(451) < 200, 370, 400)
    other = np.where(np.arange(451) < 230, 370, 400)
    trial = replace(
        trial,
        outcome=replace(trial.outcome, right_at=right_at),
        opposite=replace(trial.opposite, right_at=other),
    )
    text = action(replace(longer, limits=[trial]))
    assert text.startswith("Let the swarm run until step 230, 80 steps longer. Then 100.0 %")


def test_an_interval_of_a_wait_has_the_wait_and_is_wilsons():
    (outcome,) = compare({"x": SHORT}, (), 40, 1)
    low, high = wait_interval(outcome, 0.5)
    assert low <= wait_for(outcome, 0.5)
    assert high is None or wait_for(outcome, 0.5) <= high
    rising = replace(outcome, right_at=np.arange(41))
    assert wait_for(rising, 0.5) == 20
    low, high = wait_interval(rising, 0.5)
    assert wilson(low, 40).high >= 0.5 > wilson(low - 1, 40).high
    assert wilson(high, 40).low >= 0.5 > wilson(high - 1, 40).low
    assert wait_interval(replace(outcome, right_at=np.full(41, 20)), 0.99) == (None, None)


def test_page_one_has_the_answer_and_a_figure_and_details_follow(assessment, tmp_path):
    write_report(assessment, tmp_path / "a.html")
    first, details = (tmp_path / "a.html").read_text().split("<h1>Details</h1>")
    assert first.count("data:image/png;base64,") == 1
    titles = [title for title in sections(assessment) if f"<h2>{title}</h2>" in first]
    assert titles == ["What to do", "What to expect", "If something fails", "What this rests on"]
    rest = {*sections(assessment), "Strategies", "Changes", "Faults"} - {"Verdict", *titles}
    assert {*re.findall("<h2>(.*)</h2>", details)} - {"Not recommended"} == rest
    assert action(assessment) == assessment.to_dict()["action"]


def test_a_report_fits_screens_and_page_one_one_sheet_and_fetches_nothing(assessment, tmp_path, browser):
    write_report(assessment, tmp_path / "a.html")
    page, asked = browser.new_page(), []
    page.on("request", lambda request: asked.append(request.url.partition(":")[0]))
    page.goto((tmp_path / "a.html").as_uri())
    for width, height in ((1280, 800), (390, 844)):
        page.set_viewport_size({"width": width, "height": height})
        assert page.evaluate("document.documentElement.scrollWidth") == width
        assert page.locator(".verdict").bounding_box()["height"] < height / 2
    assert {*asked} <= {"file", "data"}
    sheet = page.pdf(prefer_css_page_size=True, print_background=True, page_ranges="1")
    assert b"/MediaBox [0 0 594.95" in sheet  # A4
    assert len(re.findall(rb"/Subtype ?/Image", sheet)) == 1
    page.set_viewport_size({"width": 688, "height": 1017})  # A4 within its margins, in pixels of CSS
    page.emulate_media(media="print")
    assert page.evaluate("document.querySelector('.first').getBoundingClientRect().bottom") < 1017
    page.close()


def test_a_place_adds_its_plan_to_the_details(assessment, tmp_path):
    wall = [[[5.0, 0.0], [6.0, 0.0], [6.0, 8.0]]]
    placed = replace(assessment, scenario=SHORT.replace({"arena.boundary": "walls", "place.walls": wall}))
    counts = []
    for each in (assessment, placed):
        write_report(each, tmp_path / "a.html")
        first, details = (tmp_path / "a.html").read_text().split("<h1>Details</h1>")
        assert first.count("data:image/png;base64,") == 1
        counts.append(details.count("data:image/png;base64,"))
    assert counts[1] == counts[0] + 1
    assert 'alt="Floor plan: ' in details


def test_what_robots_that_act_do_is_told(assessment):
    acts = SHORT.replace({"acting.start": 20})
    declares = acts.replace({"decision.strategy": "quiet-census", "robots.know_count": True})
    assert ending_early(declares) is declares
    assert ending_early(declares.replace({"acting.start": None})).run.stop_at_declarations
    own, other = (
        outcome_of("dmmd", each, simulate_record(each, Runs(30, 2), curves=True))
        for each in (acts, acts.replace({"tasks.count": 25}))
    )
    shown = replace(assessment, scenario=acts, outcome=own, opposite=other)
    did = own.found.acting
    said = sections(shown)["What to expect"]
    done = (
        f"In {percent(did.done)} of the swarms, robots stand at all tasks that they can do: in half of the "
    )
    assert (
        f"{done}swarms by step {did.all_taken_step.median}, in 95 % by step {did.all_taken_step.p95}." in said
    )
    vain = [each for each in said if "although they are infeasible" in each]
    assert vain == [
        f"With 25 tasks, in {percent(other.found.acting.started_in_vain)} of the swarms, a robot takes "
        "a task although they are infeasible."
    ]


def test_a_change_has_a_column_for_each_number_of_tasks_it_was_turned_to(assessment):
    one, other = assessment.limits[:2]
    turned = [
        replace(one, opposite=assessment.opposite),
        replace(other, opposite=replace(assessment.opposite, tasks=9)),
    ]
    page = replace(assessment, limits=turned)._repr_html_().split("<summary>Changes</summary>")[1]
    assert page.index("right with 9 tasks") < page.index("right with 50 tasks") < page.index("</thead>")
    cells = [re.findall("<td>(.*)</td>", row) for row in page.split("</tbody>")[0].split("<tr>")[2:]]
    assert [[bool(cell) for cell in row[1:3]] for row in cells] == [[False, True], [True, False]]

"""The first page of an assessment: the one action, what stands on it, and that it fits."""

from __future__ import annotations

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import binom

from feasibee import Scenario
from feasibee.results.statistics import Interval, wilson
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.sequential import SequentialDesign, looks
from feasibee.simulation.sweep import Rounds
from feasibee.studies.assess import _Assessing, assess, changes_of
from feasibee.studies.comparison import compare, ending_early, outcome_of, wait_for, wait_interval
from feasibee.studies.files import write_report
from feasibee.studies.report import Trial, in_percent, sections

SHORT = Scenario(arena={"side": 12.0}, tasks={"count": 8}, run={"steps": 150})
CENSUS = {"decision.strategy": "census"}


@pytest.fixture(scope="module")
def assessment():
    """An assessment of few strategies, whose searches are short."""
    few = {name: SHORT.replace({"decision.strategy": name}) for name in ("dmmd", "dmvd", "census")}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("feasibee.studies.assess.suitable", lambda scenario: (dict(few), {}))
        patch.setattr("feasibee.studies.constraints.all_strategies", lambda scenario: list(few))
        patch.setattr("feasibee.studies.assess.LEAST_RUNS", 60)
        return assess(SHORT, runs=30, seed=2)


def action(assessment):
    """Return what an assessment says to do."""
    return assessment.advice[0]


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
        recommendation=None,
        strategies=[],
        limits=limits[::-1],  # the order in which they are found doesn't count
        sizing=SimpleNamespace(edge=edge),
    )


def test_nothing_is_changed_in_a_swarm_that_is_ready(assessment):
    ready = with_changes(assessment, here=1.0, robots=24, shares=[(1.0, 1.0)])
    assert action(ready) == "Use the swarm as it is, with dmmd."


def candidate(assessment, right, *, strategy="census", more=None):
    """Return a tested strategy; with the number of runs that would settle it, it is only probably enough."""
    world = replace(assessment.opposite, contender=strategy, test=SimpleNamespace(interval=right))
    about = {"step": 9, "bits": 1.0, "is_probable": bool(more), "more_runs": f"about {more}"}
    about |= {"worlds": [world], "worst": world, "scenario": SHORT.replace(CENSUS)}
    return SimpleNamespace(strategy=strategy, **about)


def test_another_strategy_comes_before_other_changes(assessment):
    changed, sure = with_changes(assessment, robots=24, shares=[(1.0, 1.0)]), Interval(0.99, 0.97, 1.0)
    other = replace(changed, recommended=candidate(assessment, sure))
    assert action(other) == "Use the strategy census instead of dmmd: right in 99 % (97 to 100) of the runs."
    assert other.table[0] == ["", "dmmd, as it is", "census"]
    own = replace(changed, recommended=candidate(assessment, sure, strategy="dmmd"))
    assert action(own) == "Use the swarm as it is, with dmmd. Further runs show that it is enough."


def test_a_strategy_that_is_probably_enough_is_used_if_nothing_is_shown_to_be(assessment):
    def told(**values):
        tested = [candidate(assessment, Interval(0.95, 0.8, 0.997), **values)]
        return action(replace(with_changes(assessment), recommendation=SimpleNamespace(tested=tested)))

    assert told(more=400) == (
        "Use the strategy census instead of dmmd: right in 95 % (80 to 99.7) of the runs. "
        "That is probably enough; about 400 more runs would settle it."
    )
    assert told(more=400, strategy="dmmd").startswith("Use the swarm as it is, with dmmd. That is probably")


def test_the_cheapest_change_is_chosen_that_is_enough_in_both_worlds(assessment):
    def chosen(*shares, **values):
        return action(with_changes(assessment, shares=shares, **values))

    assert chosen((1, 1), (1, 1)).startswith(
        "Change this: explorations 3 times as long: right in 100 % (99.0 to"
    )
    assert chosen((0.9, 1), (1, 0.9), (1, 1)).startswith("Change this: robots that count themselves:")
    assert chosen((1, 0.9), robots=24).startswith("Use 24 robots, 4 more.")
    assert chosen((1, 1), robots=24).startswith("Change this: explorations")
    nothing = "None of the strategies and changes that were tried is shown to be enough."
    assert chosen((1, 0.9), (0.95, 1)) == chosen(robots=24, there=0.9) == chosen(robots=20) == nothing


def test_what_ended_early_is_not_taken_for_tried(assessment):
    early = replace(with_changes(assessment), missing=("comparing changes",))
    assert "Allow more time: not all of them were tried." in action(early)
    excluded = {"map": "needs the number of robots", "dc": "right in 1 of 20"}
    left = replace(early, recommendation=SimpleNamespace(tested=[], excluded=excluded))
    assert action(left).endswith("map needs the number of robots: try --set robots.know_count=true.")


def test_a_change_that_may_be_enough_has_all_runs_in_both_worlds(assessment, monkeypatch):
    """As may those with a clear gain and the share that is asked for, or more."""
    gain, none = Interval(0.5, 0.01, 0.6), Interval(0.1, 0.0, 0.3)
    names = "explorations 3 times as long", "3 times as many steps", "robots that count themselves"
    raced = [
        Trial(
            SHORT, replace(assessment.outcome, contender=name, right=np.arange(30) < right), difference=each
        )
        for name, right, each in zip(names, (15, 30, 14), (gain, none, gain), strict=True)
    ]
    monkeypatch.setattr(_Assessing, "_raced", lambda *_: raced)
    with Rounds(None, most=None) as rounds:
        asking = _Assessing(rounds, SHORT, 7, 2, 0.5)
        found = {each.price: each for each in asking._changes(asking.changed)}
    assert (found[0].opposite.tasks, found[0].opposite.runs, found[0].outcome.runs) == (50, 7, 7)
    for price in (1, 2):
        assert (found[price].opposite, found[price].outcome) == (None, raced[price].outcome)


def test_without_details_changes_are_tried_up_to_one_that_is_enough(assessment, monkeypatch):
    changes = {each.name: each for each in with_changes(assessment, shares=[(1, 0), (1, 1)]).limits}
    monkeypatch.setattr(_Assessing, "_changes", lambda _, names: [changes[name] for name in names])
    monkeypatch.setattr(_Assessing, "_sizing", lambda _: pytest.fail("the search began"))
    unchanged = replace(with_changes(assessment), limits=[], sizing=None)
    found = _Assessing(None, SHORT, 400, 2, 0.95, details=False)._with_changes(unchanged)
    assert {each.name for each in found.limits} == {*[*changes_of(SHORT)][:2]}
    assert found.advice[1].price == 1


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
    assert text.startswith("Let the swarm run until step 230, 80 steps longer: right in 100 %")


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
    assert re.findall("<h2>(.*)</h2>", first) == ["What to do", "What this rests on"]
    assert assessment.advice[0] == assessment.to_dict()["action"]
    assert assessment.advice[0].partition(" %")[0] in first
    rest = {*sections(assessment), "Strategies", "Changes", "Faults"} - {"Answer", "What this rests on"}
    assert {*re.findall("<h2>(.*)</h2>", details)} - {"Not recommended"} == rest


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
    cells = {row[0]: row[1] for row in shown.table[1]}
    did, vain = own.found.acting, other.found.acting.started_in_vain
    assert cells["robots at all tasks they can do"] == in_percent(did.done)
    assert cells["half of the runs are there"] == f"by step {did.all_taken_step.median}"
    assert cells["acts in vain with 25 tasks"] == in_percent(vain)


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


def test_without_details_only_what_the_answer_rests_on_is_simulated(assessment, monkeypatch):
    few = {name: SHORT.replace({"decision.strategy": name}) for name in ("dmmd", "dmvd", "census")}
    monkeypatch.setattr("feasibee.studies.constraints.all_strategies", lambda scenario: list(few))
    monkeypatch.setattr("feasibee.studies.assess.LEAST_RUNS", 60)
    brief = assess(SHORT, runs=30, seed=2, details=False)
    assert brief.advice[0] == assessment.advice[0]
    assert brief.table == assessment.table
    assert (brief.sizing, brief.strategies) == (None, ())
    hopeless = {(each.name, 20) for each in assessment.limits}  # 30 of 30 would not show 95 %
    assert {(each.name, each.outcome.runs) for each in brief.limits} == hopeless
    ready = assess(SHORT, runs=30, seed=2, right=0.01, details=False)
    assert (ready.level, ready.recommendation, ready.limits) == ("ready", None, ())
    assert [each.scenario.decision.strategy for each in ready.faults] == 3 * ["dmmd"]


def failed(right, runs, most=400):
    """Return the test that ends the runs at the opposite truth, if it does."""
    outcome = SimpleNamespace(right=np.arange(runs) < right, runs=runs)
    return _Assessing(None, SHORT, most, 2, 0.95, details=False)._failed(outcome)


def test_the_opposite_truth_ends_only_where_all_runs_would_give_the_same_verdict():
    """The interval that is printed then holds as often as that of all runs: exactly, over all paths."""
    assert failed(0, 45) is None
    assert {test.answer for right in range(101) if (test := failed(right, 100, 101))} == {"too few"}
    *early, _ = looks(100, 400)
    for runs in early:
        most = max(right for right in range(runs + 1) if failed(right, runs))
        assert wilson(400 - runs + most, 400).high < 0.95
    for rate in (0.05, 0.3, 0.5, 0.7, 0.85, 0.9, 0.92, 0.94, 0.95, 0.97):
        path, before, missed = np.ones(1), 0, 0.0
        for runs in (*early, 400):
            path = np.convolve(path, binom.pmf(np.arange(runs - before + 1), runs - before, rate))
            tests = [failed(right, runs) for right in range(runs + 1)]
            ended = np.array([test is not None for test in tests])
            outside = [
                test is not None and not test.interval.low <= rate <= test.interval.high for test in tests
            ]
            missed, path, before = missed + path[outside].sum(), np.where(ended, 0.0, path), runs
        whole = np.array([not low <= rate <= high for _, low, high in (wilson(r, 400) for r in range(401))])
        of_all = binom.pmf(np.flatnonzero(whole), 400, rate).sum()
        assert missed + path[whole].sum() <= max(0.05, of_all) + 1e-9  # rounding


def test_fewer_runs_at_the_opposite_truth_are_said_and_calibration_weighs_both_truths_alike(assessment):
    fewer = replace(
        assessment, opposite=replace(assessment.opposite, right=np.arange(10) < 5, said=np.ones(10))
    )
    assert "(infeasible), right in 50 % (24 to 76) of 10 runs. Asked for" in sections(fewer)["Answer"][0]
    assert "of 30 runs" not in sections(assessment)["Answer"][0]
    assert fewer.to_dict()["opposite"]["runs"] == 10
    assert fewer.calibration.uncertainty == 0.25
    assert sum(each.runs for each in fewer.calibration.bins) == 20


def test_a_swarm_that_nobody_would_deploy_has_no_faults_without_details(monkeypatch):
    """Nor do changes run with its tasks that few runs exclude at the opposite truth, where it is worse."""
    monkeypatch.setattr("feasibee.studies.constraints.all_strategies", lambda scenario: ["dmvd"])
    many = SHORT.replace({"robots.count": 12, "tasks.count": 9, "decision.strategy": "dmvd"})
    brief = assess(many, runs=120, seed=2, details=False)
    assert (brief.level, brief.advice[1], brief.faults) == ("not ready", None, ())
    assert (brief.outcome.runs, brief.opposite.runs, brief.own.worst is brief.opposite) == (120, 100, True)
    assert (
        brief.opposite.judged == SequentialDesign(120).tested(0.95, brief.opposite.right.sum(), 100).interval
    )
    assert not brief.limits

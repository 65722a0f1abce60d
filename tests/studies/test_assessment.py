"""What engineers ask: assessments."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner
from declaring import declaring

from feasibee import FeasibeeError, Scenario
from feasibee.cli import main
from feasibee.results.calibration import OWN
from feasibee.results.measures import declarations
from feasibee.results.statistics import Interval, in_percent, plain
from feasibee.scenario.feasibility import Piece, Verdict, Violator
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.studies.assess import assess, changes_of, faults_of
from feasibee.studies.comparison import compare, wait_for
from feasibee.studies.files import write_report
from feasibee.studies.needs import suitable, untested_in_words
from feasibee.studies.report import MARGIN, Trial, in_points, sections
from feasibee.studies.size import Axis, dimension
from tests.places import rectangle

SHORT = Scenario(arena={"side": 12.0}, tasks={"count": 8}, run={"steps": 150})


@pytest.fixture(scope="module")
def assessment():
    """An assessment whose searches are short."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("feasibee.studies.assess.LEAST_RUNS", 60)
        return assess(SHORT, runs=30, seed=2)


def text_of(assessment):
    """Return all that is said of an assessment."""
    return "\n".join(line for lines in sections(assessment).values() for line in lines)


def column(assessment, place=1):
    """Return a column of an assessment's table: the first one is of the swarm as it is."""
    return {row[0]: row[place] for row in assessment.table[1]}


def test_an_assessment_is_of_the_same_runs_as_a_comparison(assessment):
    (outcome,) = compare({"as it is": SHORT}, (), 30, 2)
    np.testing.assert_array_equal(assessment.outcome.right, outcome.right)
    assert abs(sum(share.estimate for share in assessment.shares.values()) - 1) < 1e-12
    assert assessment.shares["right"].estimate == outcome.right.mean()


@pytest.mark.slow
def test_declarations_are_assessed(tmp_path):
    found = assess(declaring(tmp_path, quiet=20.0, run={"steps": 150}), runs=6, seed=1)
    record = simulate_record(found.scenario, Runs(6, 1))
    expected = declarations(record, found.scenario)
    told = found.to_dict()
    assert told["declared"] == plain(expected)
    assert {each["name"]: each["declared"] for each in told["strategies"]}["dmmd"] is None
    cells = column(found)
    assert cells["declared rightly"] == in_percent(expected.ok)
    assert cells["a robot declared wrongly"] == in_percent(expected.wrong)
    assert cells["95 % have declared"] == f"by step {expected.step_90.p95}"


@pytest.mark.parametrize(
    ("changes", "outside"),
    [
        ({}, None),
        ({"arena.side": [4.0, 100.0], "walk.mean_run": 1.0, "robots.count": 5}, None),
        ({"arena.side": [4.0, 101.0]}, "longer side of the arena per shorter side 25.25, tested 1 to 25"),
        (
            {"walk.mean_run": 0.9, "robots.count": 4},
            "robots 4, tested 5 to 200; mean run in steps 0.9, tested 1 to 100",
        ),
        ({"walk.mean_run": 0.9, "decision.parameters": {"quiet": 80.0}}, None),
        ({"walk.mean_run": 0.9, "decision.strategy": "map"}, None),
    ],
)
def test_quiet_times_beyond_tested_worlds_are_warned_of(changes, outside):
    """They are computed in `quiet-census`; a given one is its user's, and `map` has none."""
    own = {"decision.strategy": "quiet-census", "robots.know_count": True, "run.steps": 5}
    scenario = Scenario().replace({**own, **changes})
    warnings = untested_in_words(scenario)
    assert len(warnings) == (outside is not None)
    assert outside is None or f"({outside})" in warnings[0]


def test_for_how_long_robots_wait_for_names_to_flood_a_place_is_told(assessment):
    wall = {"place.walls": [rectangle(2.0, 0.0, 2.2, 2.0)], "arena.boundary": "walls"}
    scenario = assessment.scenario.replace({**wall, "acting.start": "safe"})
    known = scenario.with_flooding(100)
    assert "Names flood this place by step 100," in text_of(replace(assessment, scenario=known))


def test_other_strategies_are_tried_best_first(assessment):
    names = [trial.outcome.contender for trial in assessment.strategies]
    assert {*names} == {*suitable(SHORT)[0]} - {"dmmd"}
    gains = [trial.difference.estimate for trial in assessment.strategies]
    assert gains == sorted(gains, reverse=True)


@pytest.mark.slow
def test_what_looks_better_is_also_tried_where_the_truth_is_the_other(tmp_path):
    """A swarm that always says feasible is always right here, and never there, which is said."""
    rule = tmp_path / "yes.py"
    rule.write_text("def decide(mind, inbox):\n    return 1\n")
    found = assess(SHORT, runs=30, seed=2)
    (other,) = compare({"as it is": SHORT.replace({"tasks.count": 50})}, (), 30, 2)
    assert found.opposite is not None
    np.testing.assert_array_equal(found.opposite.right, other.right)
    assert not other.feasible
    yes = SHORT.replace({"decision.strategy": str(rule)})
    here, there = compare({"yes": yes}, (8, 50), 30, 2)
    assert here.right.all()
    assert not there.right.any()
    trial = Trial(yes, here, there, Interval(0.5, 0.4, 0.6))
    assert replace(trial, opposite=None).helps(0.8)
    assert not trial.helps(0.8)
    assert "; 0 % (0 to 11) right with 50 tasks." in text_of(replace(found, strategies=[trial]))
    assert "With 50 tasks (infeasible), right in " in text_of(found)
    assert found.to_dict()["opposite"]["tasks"] == 50


def test_how_long_to_wait_is_until_the_last_lapse(assessment):
    outcome = assessment.outcome
    right_at = np.array([0, 29, 30, 20, 29, 30, 30])
    assert wait_for(type(outcome)(**{**vars(outcome), "right_at": right_at})) == 4  # 29 of 30 is 0.967
    assert wait_for(type(outcome)(**{**vars(outcome), "right_at": right_at[:4]})) is None
    for right, step in ((54, None), (55, 1)):  # in floats, 0.55 * 100 is 55.00000000000001
        assert wait_for(SimpleNamespace(right_at=np.array([54, right]), runs=100), 0.55) == step


def test_words_json_and_a_page_that_begin_with_the_verdict(assessment, tmp_path):
    title, lines = next(iter(sections(assessment).items()))
    assert title == "Answer"
    assert lines[0].startswith("■ Not ready: right in ")
    assert assessment.to_dict()["verdict"]["colour"] == "red"
    text = text_of(assessment)
    assert assessment.to_dict()["declared"] is None
    assert "declared rightly" not in column(assessment)
    assert "The tasks are feasible: each task can have its own robots, and 12 robots are left over." in text
    assert json.loads(json.dumps(assessment.to_dict()))["runs"] == 30
    write_report(assessment, tmp_path / "page.html", "feasibee assess mine.toml")
    page = (tmp_path / "page.html").read_text()
    assert '<section class="verdict red">' in page
    assert page.index("Not ready") < page.index("<h2>")
    assert "<code>feasibee assess mine.toml</code>" in page
    assert page.count("data:image/png;base64,") == 4
    assert page.count('<th scope="col">right with 50 tasks</th>') == 1
    assert page.count("<img ") == page.count('<img alt="Share of ')
    assert page.index("What to do") < page.index("bits per robot-step") < page.index("<img ")
    assert "30 simulated runs of the swarm, seed 2. Shares have" in page
    assert "http" not in page  # one page by itself


@pytest.mark.slow
def test_words_fit_a_narrow_terminal(monkeypatch):
    monkeypatch.setenv("COLUMNS", "40")
    told = CliRunner().invoke(main, ["assess", "--runs", "5", "--steps", "20", "--details"]).stdout
    assert "\u00a0" not in told
    assert max(map(len, told.splitlines())) <= 40
    assert "The tasks are feasible" in told
    assert not any(line.lstrip().startswith("%") for line in told.splitlines())


def test_the_command_takes_short_options():
    done = CliRunner().invoke(
        main, ["assess", "--robots", "5", "--tasks", "6", "--arena", "8", "--steps", "20", "--runs", "3"]
    )
    assert done.exit_code == 0, done.output
    assert "ready: right in" in " ".join(done.stdout.split())
    assert "What to expect" not in done.stdout


def test_ranges_are_read_and_checked():
    texts = "decision.gain", "robots.count", "radio.loss=0:0.5", "decision.own_vote", "arena.boundary"
    space = [dimension(Scenario(), text) for text in texts]
    assert space[0] == Axis("decision.gain", 2.0, 50.0)
    assert (space[1].at(0.0), space[1].at(1.0)) == (4, 100)
    assert (space[2].at(0.5), space[2].by_ratio) == (0.25, False)
    assert space[3].choices == (False, True)
    assert space[4].choices == ("torus", "walls")


@pytest.mark.parametrize(
    ("text", "rule"),
    [
        ("decision.strategy=dmmd|nope|dmvd", "decision.strategy = 'nope': must be"),
        ("arena.side=wide|5", "arena.side = 'wide': must be"),
        ("decision.strategy", "decision.strategy=a|b|c"),
        ("decision.gian", "decision.gian: isn't a field"),
        ("gain", "gain: isn't a field"),
        ("radio.loss", "has no default range"),
        ("decision.gain=5:2", "must be LOW:HIGH"),
        ("sensing.range=1:50", "sensing.range up to 50: "),
    ],
)
def test_choices_that_cant_be_are_told(text, rule):
    with pytest.raises(FeasibeeError) as told:
        dimension(Scenario(), text)
    assert rule in str(told.value)


@pytest.mark.parametrize("arguments", [("size", "--out", "which.gif"), ("size", "--out", "nope/which.png")])
def test_a_figure_that_cant_be_written_is_told_before_the_work(monkeypatch, arguments):
    monkeypatch.setattr("feasibee.engine.runner.simulate", lambda *_, **__: pytest.fail("the work began"))
    told = CliRunner().invoke(main, arguments)
    assert told.exit_code == 2
    assert "which." in told.stderr


def judged(assessment, here, there, target):
    """Return the verdict on swarms that are right with these shares, here and at the opposite truth."""

    def having(outcome, share):
        return replace(outcome, right=np.arange(1000) < 1000 * share, agreed=np.ones(1000, bool))

    return replace(
        assessment,
        target=target,
        outcome=having(assessment.outcome, here),
        opposite=having(assessment.opposite, there),
    )


@pytest.mark.parametrize(
    ("here", "there", "level", "tasks"),
    [
        (0.99, 0.98, "ready", 50),
        (0.97, 1.0, "ready", 8),
        (0.95, 1.0, "uncertain", 8),
        (1.0, 0.2, "not ready", 50),
        (0.9, 1.0, "not ready", 8),
        (0.2, 0.1, "not ready", 50),
    ],
)
def test_the_verdict_is_on_the_worse_of_two_worlds(assessment, here, there, level, tasks):
    found = judged(assessment, here, there, 0.95)
    verdict = found.to_dict()["verdict"]
    assert (found.level, verdict["level"], verdict["tasks"]) == (level, level, tasks)


def test_an_assessment_says_what_its_probability_is(assessment):
    """Of the share of robots, or their own; and Murphy's parts of its score."""
    assert assessment.to_dict()["brier_of"] == "share of robots"
    assert "Brier score of the share of robots: " in text_of(assessment)
    parts = assessment.calibration
    assert f"{parts.reliability:.3f} - {parts.resolution:.3f} + {parts.uncertainty:.3f}." in text_of(
        assessment
    )
    outcome, opposite = (replace(each, said_by=OWN) for each in (assessment.outcome, assessment.opposite))
    own = replace(assessment, outcome=outcome, opposite=opposite)
    assert own.to_dict()["brier_of"] == "robots' own probability"
    assert "Brier score of the robots' own probability: " in text_of(own)


def test_robots_are_among_the_changes(assessment):
    assert "30 robots instead of 20" in {trial.outcome.contender for trial in assessment.limits}
    mixed = {"classes": [{"name": "arm", "count": 5, "skills": ["lift"]}]}
    tasks = {"classes": [{"name": "carry", "count": 3, "needs": {"lift": 1}}]}
    assert not any("robots instead" in name for name in changes_of(Scenario(robots=mixed, tasks=tasks)))


def test_classes_of_robots_have_neither_sizes_nor_an_opposite_truth(monkeypatch):
    monkeypatch.setattr("feasibee.studies.assess.LEAST_RUNS", 60)
    mixed = {"classes": [{"name": "arm", "count": 5, "skills": ["lift"]}]}
    tasks = {"classes": [{"name": "carry", "count": 3, "needs": {"lift": 1}}]}
    found = assess(Scenario(robots=mixed, tasks=tasks, arena={"side": 6.0}, run={"steps": 40}), 20, right=0.4)
    assert found.recommended is not None
    assert (found.opposite, found.sizing, found.recommended_band) == (None, None, None)
    assert next(iter(column(found))) == "right"


def test_errors_that_a_scenario_has_are_among_the_changes():
    scenario = Scenario(sensing={"false_tasks": 0.1}, radio={"loss": 0.2}, faults={"byzantine": 0.1})
    errors = {"a perfect sensor", "no message lost", "no faulty robot"}
    assert changes_of(scenario).keys() >= errors
    usual = changes_of(Scenario())
    assert not usual.keys() & errors
    assert usual["sight 1.5 times as far"].radio.range == Scenario().radio.range


def test_single_faults_are_added_to_those_that_are_there():
    faults = faults_of(Scenario(faults={"byzantine": 0.1}, radio={"loss": 0.5}))
    assert faults["with 3 Byzantine robots"].faulty == (0, 3, 0)
    assert faults["with 1 broken robot"].faulty == (1, 2, 0)
    assert faults["with a fifth of the messages lost"].radio.loss == pytest.approx(0.6)


def test_a_strategy_that_can_tolerate_a_liar_is_also_tried_with_that():
    scenario = Scenario(decision={"strategy": "quiet-census"})
    tolerant = faults_of(scenario)["with 1 Byzantine robot and tolerates = 1"]
    assert tolerant.decision.parameters["tolerates"] == 1
    assert tolerant.faulty == (0, 1, 0)


def test_what_is_asked_of_robots_is_said(assessment):
    census = SHORT.replace({"decision.strategy": "census"})
    cells = column(replace(assessment, scenario=census))
    assert cells["robots need"] == "names of tasks,\nids that are never misread"
    assert column(assessment)["robots need"] == "nothing"
    asked = assessment.to_dict()["asked"]
    assert column(assessment)["longest message, bits"] == str(asked["message_bits"])
    assert column(assessment)["memory of a robot, bytes"] == str(-(-asked["memory_bits"] // 8))


@pytest.mark.parametrize(
    ("shown", "none"),
    [
        (Interval(0.0, -0.02, 0.03), True),
        (Interval(0.0, -0.06, 0.06), False),
        (Interval(0.16, 0.056, 0.258), False),
        (Interval(0.02, 0.01, MARGIN), True),
    ],
)
def test_a_difference_is_called_none_only_if_it_is_shown_to_be_small(assessment, shown, none):
    fault = replace(assessment.faults[0], difference=shown)
    cell = column(replace(assessment, faults=[fault]), -1)[fault.outcome.contender]
    assert cell == ("as without it" if none else in_percent(fault.outcome.judged))


@pytest.mark.parametrize(
    ("share", "words"),
    [
        (Interval(0.507, 0.459, 0.556), "51 % (46 to 56)"),
        (Interval(0.95, 0.8, 0.997), "95 % (80 to 99.7)"),
        (Interval(0.002, 0.0, 0.31), "0.2 % (0 to 31)"),
        (Interval(1.0, 0.99, 1.0), "100 % (99 to 100)"),
    ],
)
def test_shares_are_said_as_people_do(share, words):
    assert in_percent(share) == words


def test_differences_are_said_with_their_signs():
    assert in_points(Interval(0.507, -0.004, 0.556)) == "+51 points (-0.4 to +56)"


def test_the_piece_of_a_place_that_lacks_robots_is_named(assessment):
    piece = Piece(2, (10.7, 19.4), (0.6, 19.4), {})
    truth = Verdict({}, Violator(("any",), 12, 10), 2, (piece,))
    line = sections(replace(assessment, truth=truth))["What to expect"][0]
    where = "in piece 2 (x 10.7 to 19.4, y 0.6 to 19.4)"
    assert line == f"The tasks are infeasible: {where}, they need 12 robots, and there are 10 of 20."


def test_what_a_user_named_stays_text_in_a_page(assessment, tmp_path):
    name = "<script>alert('&')</script>"
    trial = replace(assessment.faults[0], outcome=replace(assessment.faults[0].outcome, contender=name))
    write_report(replace(assessment, faults=[trial]), tmp_path / "a.html", f"feasibee assess {name}")
    page = (tmp_path / "a.html").read_text()
    assert "<script" not in page
    assert page.count("&lt;script&gt;alert(&#39;&amp;&#39;)&lt;/script&gt;") == 3

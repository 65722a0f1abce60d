"""Sizes of swarms: how many robots are enough, and the blind band."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from feasibee import FeasibeeError, Scenario
from feasibee.cli import main
from feasibee.results.statistics import Interval, confidence_sequence
from feasibee.studies import size as size_module
from feasibee.studies.comparison import compare
from feasibee.studies.size import (
    Band,
    Edge,
    Finding,
    Rule,
    Sizing,
    band_sentence,
    edge_sentence,
    ladder,
    size,
)

SMALL = Scenario(
    arena={"side": 9.0},
    robots={"count": 6},
    tasks={"count": 4},
    decision={"strategy": "tally"},
    run={"steps": 200},
)
RULE = Rule(0.8, first=50, most=300)


@pytest.fixture(scope="module")
def sizing():
    return size(SMALL, rule=RULE, seed=1)


def test_only_numbers_of_robots_that_can_do_the_tasks_are_tried(sizing):
    assert min(value for value, _ in sizing.edge.tested) == 4
    assert sizing.edge.enough >= 4


def test_the_blind_band_lies_on_both_sides_of_the_truth(sizing):
    below, above = sizing.band.below, sizing.band.above
    assert {value for value, _ in below.tested} <= set(range(1, 7))
    assert min(value for value, _ in above.tested) == 7
    assert sizing.band.first <= 6
    assert sizing.band.last >= 7 or sizing.band.empty or above.enough == 7


def test_all_tests_that_the_searches_could_make_share_the_error(sizing):
    """They have 45, 6 and 42 values, so 3 tests for each of 6, 3 and 6 bits: 45 at 95 % together."""
    band = sizing.band
    assert [len(edge.values) for edge in (sizing.edge, band.below, band.above)] == [45, 6, 42]
    for edge in (sizing.edge, band.below, band.above):
        for _, found in edge.tested:
            expected = confidence_sequence(found.successes, found.trials, 1 - 0.05 / 45)
            assert found.interval == pytest.approx(expected, abs=1e-12)


def test_the_shares_are_those_of_simulated_swarms(sizing):
    value, finding = sizing.edge.tested[0]
    (outcome,) = compare({"": SMALL.replace({"robots.count": value})}, (), finding.trials, 1)
    assert int(outcome.right.sum()) == finding.successes


def edge_of(path, values, answers):
    """Return an edge whose places were all tested, with these answers."""
    findings = tuple(
        Finding(place, 9, 10, Interval(0.9, 0.8, 1.0), answer) for place, answer in enumerate(answers)
    )
    enough = answers.index("enough") if "enough" in answers else None
    short = [place for place, answer in enumerate(answers) if answer == "too few"]
    return Edge(path, values, findings, enough, max(short, default=-1) + 1)


ENOUGH, SHORT, OPEN = "enough", "too few", "open"


@pytest.mark.parametrize(
    ("below", "above", "ends", "firsts", "lasts", "words"),
    [
        (
            [SHORT, SHORT, OPEN, ENOUGH],
            [SHORT, OPEN, ENOUGH],
            (18, 22),
            (18, 19),
            (21, 22),
            "with 18 to 22 tasks",
        ),
        ([ENOUGH], [ENOUGH], (21, 20), (21, 21), (20, 20), "none"),
        ([SHORT] * 4, [SHORT, OPEN, OPEN], (17, 23), (None, None), (21, None), "ends at 21 or more."),
        ([ENOUGH], [SHORT, ENOUGH], (21, 21), (21, 21), (21, 21), "with 21 tasks, 20 robots are not shown"),
        ([OPEN, ENOUGH], [SHORT, ENOUGH], (20, 21), (20, 21), (21, 21), "begins between 20 and 21."),
        ([OPEN, ENOUGH], [OPEN, ENOUGH], (20, 21), (20, 21), (20, 21), "It may be empty."),
    ],
)
def test_the_ends_of_a_band_and_their_intervals(below, above, ends, firsts, lasts, words):
    """It goes as far as was tried, and may be empty if its ends may be in the other order."""
    band = Band(edge_of("tasks.count", [20, 19, 18, 17], below), edge_of("tasks.count", [21, 22, 23], above))
    assert (band.first, band.last, band.firsts, band.lasts) == (*ends, firsts, lasts)
    assert band.empty == (ends == (21, 20))
    assert band.to_dict()["from"] == (None if band.empty else band.first)
    assert words in band_sentence(band, 20, 0.95)
    assert ("may be empty" in band_sentence(band, 20, 0.95)) == ("may be empty" in words)


@pytest.fixture
def exact(monkeypatch):
    """Swarms that are always right from 10 robots on and else never; more than 9 tasks aren't valid."""

    def right(rounds, design, runs, seed):
        return runs if design.scenario.robots.count >= 10 and design.scenario.tasks.count <= 6 else 0

    monkeypatch.setattr(size_module, "_right", right)
    monkeypatch.setattr(
        size_module, "valid_values", lambda _, path, values: 4 if path == "tasks.count" else len(values)
    )


def test_by_default_95_percent_must_be_right_of_up_to_8_times_as_many_robots_as_tasks(exact):
    found = size(SMALL)
    assert (found.rule.target, found.edge.interval) == (0.95, (10, 10))
    few = size(SMALL.replace({"robots.count": 2, "tasks.count": 6}))
    assert few.edge.values == list(range(6, 8 * 6 + 1))


def test_numbers_of_robots_that_leave_no_honest_one_are_not_tried(exact):
    liars = SMALL.replace({"robots.count": 6, "tasks.count": 1, "faults.byzantine": {"count": 2}})
    assert size(liars).edge.values == list(range(3, 8 * 6 + 1))


def test_gaps_within_the_resolution_are_left(exact):
    """Places 0, 1, 3 and 7 are robots 4, 5, 7 and 11; the gap between the last two is half of place 7."""
    found = size(SMALL, rule=Rule(0.95, resolution=0.6))
    assert [value for value, _ in found.edge.tested] == [4, 5, 7, 11]
    assert found.edge.interval == (8, 11)


def test_numbers_of_tasks_that_are_not_valid_are_not_tried(exact):
    """Of 6 to 10 tasks, four are valid: 6 to 9."""
    found = size(SMALL.replace({"robots.count": 6}))
    assert found.band.above.values == [7, 8, 9]


def test_robots_for_tasks_of_classes_are_those_that_all_of_them_need():
    scenario = Scenario(tasks={"classes": [{"name": "lift", "count": 5, "needs": {"arm": 2, "eye": 1}}]})
    with pytest.raises(FeasibeeError, match=r"robots\.count=15:30"):
        size(scenario, "robots.count=1:3", RULE)


def test_an_answer_as_tables_has_the_runs_of_each_value_and_the_confidence():
    edge = edge_of("radio.range", [1.0, 2.0], [SHORT, ENOUGH])
    found = Sizing(SMALL, Rule(0.8, confidence=0.9), edge, None, 0).to_dict()
    assert [(each["value"], each["runs"]) for each in found["radio.range"]["tested"]] == [
        (1.0, 10),
        (2.0, 10),
    ]
    assert found["confidence"] == 0.9


def test_no_value_that_is_enough_is_said():
    edge = edge_of("radio.range", [1.0, 2.0], [SHORT, SHORT])
    assert edge.interval == (None, None)
    assert "None of the values tried (radio.range from 1.0 to 2.0)" in edge_sentence(
        Sizing(SMALL, RULE, edge, None, 0)
    )


@pytest.mark.parametrize(
    ("over", "words"),
    [
        ("robots", "isn't a field with a number;"),
        ("radio.rnage", "did you mean radio.range?"),
        ("decision.strategy", "isn't a field with a number;"),
        ("radio.range=5", "must be a range"),
        ("radio.range=3:2", "must be LOW:HIGH"),
        ("robots.count=1:3", "too few for the tasks; search higher, such as --over robots.count=4:8"),
    ],
)
def test_what_cant_be_searched_is_an_error_with_a_remedy(over, words):
    with pytest.raises(FeasibeeError, match=words):
        size(SMALL, over, RULE)


def test_robots_with_given_places_cant_vary():
    scenario = SMALL.replace({"robots.placement": "points", "robots.points": [[1, 1]] * 6})
    with pytest.raises(FeasibeeError, match=r"since robots\.points says how many there are"):
        size(scenario, rule=RULE)


def test_a_ladder_goes_from_a_fifth_to_five_times_a_value_or_to_where_the_scenario_is_invalid():
    path, values = ladder(Scenario(), "radio.range")
    assert path == "radio.range"
    assert values[0] == pytest.approx(0.4)
    assert values[-1] == 10.0
    assert values == sorted(values)
    scenario = Scenario(sensing={"range": 4.0})
    path, values = ladder(scenario, "sensing.range")
    assert 9.0 < values[-1] <= 10.0  # a longer range would reach round the torus
    scenario.replace({path: values[-1]})


def test_a_parameter_of_a_strategy_is_searched_in_a_given_range():
    changes = {"decision.strategy": "quiet-census", "decision.parameters": {}, "robots.know_count": True}
    waiting = SMALL.replace({**changes, "tasks.count": 7})
    found = size(waiting, "decision.parameters.quiet=1:100", RULE, seed=1)
    assert found.edge.path == "decision.parameters.quiet"
    assert 1.0 < found.edge.interval[0] <= found.edge.enough < 100.0
    with pytest.raises(FeasibeeError, match=r"no default range; give one, such as \S+quiet=20:400"):
        ladder(waiting, "decision.parameters.quiet")


def test_the_command_prints_the_answer_and_draws_it(tmp_path):
    file = tmp_path / "small.toml"
    file.write_text(SMALL.to_toml())
    picture = tmp_path / "size.png"
    command = ["size", str(file), "--right", "0.8", "--steps", "100", "--runs", "100"]
    done = CliRunner().invoke(main, [*command, "--out", str(picture)])
    assert done.exit_code == 0, done.output
    assert "at step 100" in done.stdout
    assert "Blind band: " in done.stdout
    assert "if the share of right swarms" not in done.stdout
    told = CliRunner().invoke(main, [*command, "--details"]).stdout
    assert "if the share of right swarms doesn't fall as robots.count" in told.replace("\n", " ")
    assert "robots.count = 4 " in told
    assert "robots.count = 4: right in " in done.stderr
    assert picture.stat().st_size > 10_000
    found = json.loads(CliRunner().invoke(main, [*command, "--json"]).stdout)
    assert set(found["robots"]) == {"least", "interval", "tested"}
    assert set(found["blind_band"]) == {"from", "to", "intervals", "tested"}
    assert found["by"] == 100


def test_a_share_that_falls_again_has_no_least_value():
    """With a longer radio range the opinions of `dmmd` agree sooner, and more often on the wrong answer."""
    tasks = {"count": 2, "placement": "points", "points": [[3.0, 4.0], [10.0, 8.0]]}
    scenario = Scenario(arena={"side": 14.0}, robots={"count": 10}, tasks=tasks, run={"steps": 400})
    sizing = size(scenario, "radio.range=2:6.9", Rule(0.67, first=100, most=1500), 1)
    (least, first), *_, (last, fallen) = sizing.edge.tested
    assert (least, last) == (2.0, 6.9)
    assert first.interval.low >= 0.67 > fallen.interval.high
    assert sizing.edge.enough is None
    words = edge_sentence(sizing)
    assert "with radio.range = 2 units, but not with radio.range = 6.9 units: the share falls again" in words
    assert "Search a shorter range, such as --over radio.range=2:3.69." in words
    found = sizing.to_dict()
    assert found["radio.range"]["least"] is None
    assert found["assumes"]["refuted"]


def test_an_answer_says_what_it_assumes(sizing):
    text = "the share of right swarms doesn't fall as robots.count grows, nor as tasks.count goes away from 6"
    assert sizing.to_dict()["assumes"] == {"text": text, "refuted": False}

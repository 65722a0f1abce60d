"""Comparisons: the same worlds for all, counts that add up, figures and tables."""

from __future__ import annotations

import json

import numpy as np
import pytest
from commands import invoke, rows_of
from declaring import declaring

from feasibee import FeasibeeError, Scenario
from feasibee.base.record import Record
from feasibee.results import statistics
from feasibee.results.calibration import calibration
from feasibee.results.statistics import decision_rates, paired_difference, pareto
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.strategies import STRATEGIES
from feasibee.studies.comparison import (
    Comparison,
    by_contender,
    calibrations,
    compare,
    contenders_of,
    mean_bits,
    outcome_of,
    overall,
)
from feasibee.studies.files import write_comparison
from feasibee.studies.needs import suitable

SHORT = Scenario(arena={"side": 12.0}, run={"steps": 200})


@pytest.fixture(scope="module")
def outcomes():
    return compare(contenders_of(SHORT, ["dmmd", "census", "bayes"]), (10, 30), runs=20, seed=3)


def test_contenders_are_the_scenario_under_each_strategy():
    found = contenders_of(Scenario(decision={"strategy": "bayes", "parameters": {"credence": 0.8}}))
    assert list(found) == [*contenders_of(Scenario())]
    assert found["bayes"].decision.parameters["credence"] == 0.8  # its own parameters stay
    assert found["dmmd"].decision.parameters == {}


def test_a_strategy_that_a_scenario_does_not_support_is_left_out_and_told():
    scenario = Scenario(sensing={"false_tasks": 0.1})
    scenarios, problems = suitable(scenario)
    assert list(scenarios) == [*contenders_of(scenario)]
    assert {*scenarios, *problems} == {*STRATEGIES}
    assert not {*scenarios} & {*problems}
    assert "census counts things by name" in str(problems["census"])


def test_presets_are_laid_under_the_scenario():
    found = contenders_of(Scenario(decision={"gain": 7.0}), presets=["default", "ros2swarm-voter"])
    assert [each.decision.gain for each in found.values()] == [7.0, 7.0]
    assert found["ros2swarm-voter"].decision.exploration == 19


@pytest.mark.parametrize(
    ("strategies", "presets", "told"),
    [
        (["dmmd", "dmmd"], [], "dmmd: is named twice"),
        ([], ["nobody-1999"], "nobody-1999: is no preset; choose from default, valentini-2016"),
        (["dmmd"], ["default"], "can't be compared at once"),
        (["dmnd"], [], "decision.strategy = 'dmnd'"),
    ],
)
def test_contenders_that_there_are_not_are_told(strategies, presets, told):
    with pytest.raises(FeasibeeError, match=told):
        contenders_of(Scenario(), strategies, presets)


def test_two_files_of_one_name_are_both_compared(tmp_path):
    text = "def decide(mind, inbox):\n    return 1\n"
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "mine.py").write_text(text)
    assert len(contenders_of(Scenario(), [str(tmp_path / each / "mine.py") for each in "ab"])) == 2


def test_outcomes_are_those_of_the_runs(outcomes):
    """Right at step t: strictly more than 90 % of the robots hold the truth; recomputed from the curves."""
    for number, tasks in enumerate((10, 30)):
        scenario = SHORT.replace({"tasks.count": tasks, "decision.strategy": "bayes"})
        record = simulate_record(scenario, Runs(20, 3, number * 1_000_000), curves=True)
        held = record.feasible_count if tasks == 10 else record.infeasible_count
        (found,) = [each for each in outcomes if each.contender == "bayes" and each.tasks == tasks]
        np.testing.assert_array_equal(found.right_at, (held >= 19).sum(axis=0))
        np.testing.assert_array_equal(found.right, held[:, -1] >= 19)
        assert found.found.rates == decision_rates(record.decision)
        np.testing.assert_allclose(found.bits, record.bits_sent / (20 * 200))


def test_stopped_and_lying_robots_do_not_count():
    scenario = SHORT.replace({"faults.stopped": 0.3, "faults.stop_step": 50, "faults.byzantine": 0.12})
    assert [scenario.counted(step) for step in (0, 49, 50)] == [18, 18, 12]  # 0.12 of 20 rounds to 2
    (found,) = compare({"it": scenario.replace({"tasks.count": 2})}, runs=30)
    record = simulate_record(scenario.replace({"tasks.count": 2}), Runs(30, 0), curves=True)
    assert found.right.sum() == (record.feasible_count[:, -1] >= 11).sum()


def test_swarms_are_right_at_a_step_with_more_than_the_threshold_of_who_counts_then():
    """29 of 50 are 58 %, in floats more. Of 20 robots 6 stop at step 2: 13 are enough from then on."""
    half = Scenario(robots={"count": 50}, decision={"threshold": 0.58}, run={"steps": 1})
    stopping = Scenario(faults={"stopped": 0.3, "stop_step": 2}, run={"steps": 3})
    for scenario, holding, right in ((half, [29, 30], [0, 1]), (stopping, [18, 19, 13, 13], [0, 1, 1, 1])):
        for more, name in ((0, "feasible_count"), (1, "infeasible_count")):
            record = Record.empty(0, 1, len(holding))
            getattr(record, name)[:] = holding
            tasks = scenario.robots.count + more
            found = outcome_of("", scenario.replace({"tasks.count": tasks}), record)
            assert found.right_at.tolist() == right


def test_sums_are_over_all_runs(outcomes):
    groups = by_contender(outcomes)
    assert list(groups) == ["dmmd", "census", "bayes"]
    assert overall(groups["census"]).estimate == np.mean([each.right.mean() for each in groups["census"]])
    assert mean_bits(groups["census"]) > 20 * mean_bits(groups["dmmd"])


@pytest.fixture(scope="module")
def with_quiet(tmp_path_factory):
    """Outcomes of dmmd and of a strategy whose robots declare, at 10 and 30 tasks."""
    quiet = declaring(tmp_path_factory.mktemp("own"), quiet=20.0, run={"steps": 150})
    contenders = {"dmmd": SHORT.replace({"run.steps": 150}), "quiet": quiet}
    return compare(contenders, [10, 30], runs=20, seed=3)


def test_declarations_are_those_of_the_runs(with_quiet):
    declared = [each.declared for each in with_quiet]
    assert declared[:2] == [None, None]
    for each in declared[2:]:
        assert each.ok.estimate + each.wrong.estimate == 1
        assert 20 < each.step_90.median <= each.step_90.p95 < 150
    plain = Comparison(with_quiet, 20, 3).to_dict()
    assert plain == json.loads(json.dumps(plain))
    assert [each["declared"] for each in plain["outcomes"]] == [statistics.plain(each) for each in declared]
    assert plain["outcomes"][1]["right_at_end"] == with_quiet[1].accuracy._asdict()


def test_figures_and_a_table_are_written_that_have_declarations(with_quiet, tmp_path):
    write_comparison(tmp_path, Comparison(with_quiet, 20, 3))
    names = ("compare_ratio", "compare_time", "compare_bits", "compare_declared", "calibration")
    figures = {f"{name}.{suffix}" for name in names for suffix in ("png", "pdf")}
    assert {path.name for path in tmp_path.iterdir()} == {*figures, "compare.csv", "calibration.csv"}
    rows = rows_of(tmp_path / "compare.csv")
    assert [(row["contender"], row["tasks"]) for row in rows[:3]] == [
        ("dmmd", "10"),
        ("dmmd", "30"),
        ("quiet", "10"),
    ]
    assert float(rows[0]["difference_from_dmmd"]) == 0
    assert float(rows[2]["accuracy"]) == with_quiet[2].accuracy.estimate
    assert {rows[0][name] for name in rows[0] if name.startswith("declare")} == {""}
    for row, each in zip(rows[2:], with_quiet[2:], strict=True):
        *robots, ok, wrong, steps = each.declared
        shown = [float(row[name]) for name in ("robots_declared", "robots_declared_wrong")]
        assert shown == pytest.approx([sum(robots), robots[each.feasible]], abs=1e-6)
        names = ("ok", "ok_low", "ok_high", "wrong", "wrong_low", "wrong_high")
        assert [float(row[f"declared_{name}"]) for name in names] == [*ok, *wrong]
        assert [int(row[f"declare_step_{name}"]) for name in ("median", "p95")] == [*steps[:2]]


def test_calibration_is_of_all_runs_of_a_contender_and_needs_both_truths(outcomes, tmp_path):
    found = calibrations(outcomes)
    assert list(found) == ["dmmd", "census", "bayes"]
    said = np.concatenate([each.said for each in by_contender(outcomes)["bayes"]])
    assert found["bayes"] == calibration(said, [True] * 20 + [False] * 20)
    mean = sum(each.brier.estimate for each in by_contender(outcomes)["bayes"]) / 2
    assert found["bayes"].brier.estimate == pytest.approx(mean)
    told = Comparison(outcomes, 20, 3).to_dict()["calibration"]
    assert told["bayes"]["brier"]["estimate"] == pytest.approx(mean)
    write_comparison(tmp_path, Comparison(outcomes, 20, 3))
    rows = rows_of(tmp_path / "calibration.csv")
    assert [int(row["runs"]) for row in rows if row["contender"] == "bayes"] == [
        each.runs for each in found["bayes"].bins
    ]
    assert {float(row["brier"]) for row in rows_of(tmp_path / "compare.csv")} == {
        each.brier.estimate for each in outcomes
    }
    assert calibrations([each for each in outcomes if each.feasible]) == {}


def test_a_comparison_says_what_its_probabilities_are(outcomes):
    """The robots' own where the strategy has one: then the score of their shares is told in addition."""
    plain = Comparison(outcomes, 20, 3).to_dict()
    own = ["share of robots"] * 4 + ["robots' own probability"] * 2
    assert [each["brier_of"] for each in plain["outcomes"]] == own
    assert list(plain["calibration_of_shares"]) == ["bayes"]
    held = np.concatenate([each.held for each in by_contender(outcomes)["bayes"]])
    shares = calibration(held, [True] * 20 + [False] * 20).brier.estimate
    assert plain["calibration_of_shares"]["bayes"]["brier"]["estimate"] == pytest.approx(shares)
    assert plain["calibration"]["bayes"]["brier"]["estimate"] != pytest.approx(shares)


@pytest.mark.slow
def test_the_command_prints_declarations_by_number_of_tasks(tmp_path):
    declaring(tmp_path, quiet=20.0)
    words = ("compare", "--strategies", f"dmmd,{tmp_path / 'quiet.py'}", "--tasks", "10,30", "--runs", 5)
    words = (*words, "--set", "run.steps=150", "--out", tmp_path / "out")
    shown = invoke(*words, "--details").stdout
    assert "Swarms that declared rightly (%), of 5 each" in " ".join(shown.split())
    plain = json.loads(invoke(*words, "--json").stdout)
    assert [(each["contender"], each["tasks"]) for each in plain["outcomes"]] == [
        ("dmmd", 10),
        ("dmmd", 30),
        ("quiet.py", 10),
        ("quiet.py", 30),
    ]
    for each in plain["outcomes"][2:]:
        steps = each["declared"]["step_90"]
        assert f"{steps['median']}/{steps['p95']}" in shown
    words = ("compare", "--strategies", "dmmd", "--tasks", 10, "--runs", 2, "--out", tmp_path / "b")
    assert "declared" not in invoke(*words, "--details").stdout


def test_a_paired_difference_is_bonetts_and_prices():
    """By hand: 30 runs, 9 gained, 2 lost: p12 = 10/32, p21 = 3/32, difference 7/32 +- 1.96 sqrt(...)."""
    one = [True] * 9 + [False] * 2 + [True] * 10 + [False] * 9
    other = [False] * 9 + [True] * 2 + [True] * 10 + [False] * 9
    estimate, low, high = paired_difference(one, other)
    half = 1.959964 * np.sqrt((10 / 32 + 3 / 32 - (7 / 32) ** 2) / 32)
    np.testing.assert_allclose((estimate, low, high), (7 / 30, 7 / 32 - half, 7 / 32 + half), rtol=1e-6)
    with pytest.raises(ValueError, match="both must have the same number"):
        paired_difference([True], [True, False])


def test_the_frontier_has_what_nothing_beats():
    assert pareto([2, 1, 3, 3], [5, 5, 6, 7]) == [1, 3]
    assert pareto([1.0], [0.0]) == [0]

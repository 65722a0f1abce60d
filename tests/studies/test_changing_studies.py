"""Studies of worlds that change: contenders and assessments are judged by the steps."""

from __future__ import annotations

import json

import numpy as np
import pytest
from changing import TOML
from commands import invoke, rows_of

from feasibee import FeasibeeError, Scenario
from feasibee.results.measures import tracking
from feasibee.results.statistics import in_percent, mean_difference
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.studies.assess import assess
from feasibee.studies.comparison import Comparison, compare, contenders_of, difference
from feasibee.studies.constraints import compare_under
from feasibee.studies.files import write_comparison, write_report
from feasibee.studies.report import sections
from feasibee.studies.size import size

CHANGING = Scenario.from_toml(TOML)
MEASURED = {"right_share", "detection_delay", "missed", "false_alarms"}


@pytest.fixture(scope="module")
def outcomes():
    return compare(contenders_of(CHANGING, ["dmmd", "census"]), (), runs=20, seed=3)


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "changing.toml"
    path.write_text(TOML)
    return path


# --- Comparisons ---


def test_contenders_are_measured_by_the_truth_of_each_step(outcomes):
    for outcome in outcomes:
        scenario = CHANGING.replace({"decision.strategy": outcome.contender})
        record = simulate_record(scenario, Runs(20, 3))
        assert outcome.tracking == tracking(record, scenario)
        assert outcome.judged == outcome.tracking.right_share
        np.testing.assert_array_equal(outcome.right_at, (record.held == record.truth).sum(axis=0))
        np.testing.assert_array_equal(outcome.infeasible_at, [0.0] * 120 + [1.0] * 121)
        np.testing.assert_allclose(outcome.bits, record.bits_sent / 2400)
        np.testing.assert_array_equal(outcome.right, record.held[:, -1] == record.truth[:, -1])
        assert outcome.to_dict().keys() >= MEASURED


def test_census_sees_tasks_appear_and_dmmd_does_not(outcomes):
    dmmd, census = outcomes
    assert census.tracking.missed.estimate < 0.2
    assert dmmd.tracking.missed.estimate > 0.8
    gain = difference(census, dmmd)
    assert gain == mean_difference(census.shares, dmmd.shares)
    assert gain.low > 0


def test_a_comparison_writes_its_measures_and_figures(outcomes, tmp_path):
    write_comparison(tmp_path, Comparison(outcomes, 20, 3))
    assert {path.name for path in tmp_path.glob("*.png")} == {
        "compare_time.png",
        "compare_bits.png",
        "compare_delay.png",
    }
    for row, outcome in zip(rows_of(tmp_path / "compare.csv"), outcomes, strict=True):
        found = outcome.tracking
        assert float(row["right_share"]) == found.right_share.estimate
        median = found.detection_delay.median
        assert row["detection_delay_median"] == ("" if median is None else str(median))
        assert (float(row["missed_high"]), int(row["changes"])) == (found.missed.high, found.changes)
        assert float(row["false_alarms_low"]) == found.false_alarms.low


@pytest.mark.slow
def test_numbers_of_tasks_have_figures_of_their_own(tmp_path):
    few = compare(contenders_of(CHANGING, ["dmmd"]), (4, 5), runs=2, seed=3)
    write_comparison(tmp_path, Comparison(few, 20, 3))
    assert len(list(tmp_path.glob("compare_delay_*.png"))) == 2


@pytest.mark.slow
def test_a_comparison_is_printed_with_delays(file, tmp_path):
    words = ("compare", file, "--strategies", "dmmd,census", "--runs", 20, "--seed", 3, "--out", tmp_path)
    printed = invoke(*words).stdout
    assert "How swarms track the truth, 20 runs each" in printed
    assert "Swarms that are right at the end" not in printed
    table = json.loads(invoke(*words, "--json").stdout)["outcomes"]
    assert [each["contender"] for each in table] == ["dmmd", "census"]
    assert {each["tasks"] for each in table} == {5}
    assert all(each.keys() >= MEASURED for each in table)


# --- Assessments ---


@pytest.fixture(scope="module")
def assessment():
    return assess(CHANGING.replace({"decision.strategy": "census"}), runs=8, seed=2)


def test_an_assessment_judges_by_the_share_of_right_steps(assessment):
    assert assessment.own.worst.judged == assessment.outcome.tracking.right_share
    assert (assessment.sizing, assessment.opposite, assessment.recommended) == (None, None, None)
    table = assessment.to_dict()
    assert table.keys() >= MEASURED
    assert all(each.keys() >= MEASURED for each in (*table["strategies"], *table["limits"]))
    trial = assessment.strategies[0]
    middle, low, high = difference(trial.outcome, assessment.outcome)
    assert trial.difference.estimate == middle
    assert trial.difference.low < low < high < trial.difference.high  # all hold together


def test_an_assessment_says_how_swarms_track_the_truth(assessment, tmp_path):
    said = {title: " ".join(lines) for title, lines in sections(assessment).items()}
    cells = {row[0]: row[1] for row in assessment.table[1]}
    share, found = in_percent(assessment.outcome.judged), assessment.outcome.tracking
    assert f"right in {share} of the steps, in 8 runs of 240 steps" in said["Answer"]
    assert list(cells)[:2] == ["right, of the steps", "half of the changes followed"]
    assert cells["right, of the steps"] == share
    assert cells["changes missed"] == in_percent(found.missed)
    assert cells["false alarms per 1,000 steps"] == f"{found.false_alarms.estimate:.2g}"
    assert "The world changes. Before any change, the tasks are feasible." in said["What to expect"]
    write_report(assessment, tmp_path / "report.html")
    page = " ".join((tmp_path / "report.html").read_text().split())
    assert page.count("<figure>") == 3
    assert "of the steps are right. " in page.replace(".</p>", ". ")
    assert "right in the steps" in page


# --- Questions of one truth ---


@pytest.mark.parametrize(("ask", "name"), [(size, "size"), (compare_under, "compare with constraints")])
def test_questions_of_one_truth_are_refused(ask, name):
    with pytest.raises(FeasibeeError, match=f"{name}: needs a world that stays"):
        ask(CHANGING)

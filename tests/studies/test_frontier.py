"""The frontier: what robots said by their own word, recounted from the runs, and drawn with the limits."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from commands import invoke, refused_in_a_line
from declaring import declaring
from matplotlib.colors import to_hex

from feasibee import FeasibeeError, Scenario
from feasibee.figures.limits import BANDS, WORD, Panel, Word, draw_frontier
from feasibee.scenario.runs import RUNS_APART, Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.studies.limits import (
    CONTENDERS,
    RULE,
    Contender,
    contenders_named,
    frontier,
    limits_near,
    tasks_near,
    write_frontier,
    write_limits,
)

SHORT = Scenario(arena={"side": 10.0}, robots={"count": 10}, run={"steps": 300})
TASKS = (10, 11)


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    """The file of a strategy whose robots declare."""
    return declaring(tmp_path_factory.mktemp("own")).decision.strategy


@pytest.fixture(scope="module")
def contenders(own):
    return [Contender("quiet", own, {"quiet": 40.0}), Contender("census, by votes", "census")]


@pytest.fixture(scope="module")
def found(contenders):
    return frontier(SHORT, contenders, TASKS, runs=30, seed=2)


def across(patch):
    """Return where a band begins and ends."""
    places = patch.get_path().transformed(patch.get_patch_transform()).vertices[:, 0]
    return places.min(), places.max()


def test_contenders_are_in_order_and_in_the_same_worlds(found):
    assert [(each.contender, each.tasks, each.feasible) for each in found] == [
        ("quiet", 10, True),
        ("quiet", 11, False),
        ("census, by votes", 10, True),
        ("census, by votes", 11, False),
    ]


def test_declarations_are_those_of_the_runs(found, own):
    decision = {"decision.strategy": own, "decision.parameters": {"quiet": 40.0}}
    record = simulate_record(SHORT.replace({**decision, "tasks.count": 11}), Runs(30, 2, RUNS_APART))
    (each,) = [each for each in found if each.contender == "quiet" and each.tasks == 11]
    ok = (record.declared_infeasible > 9) & (record.declared_feasible == 0)
    assert each.ok.estimate == ok.mean()
    assert each.wrong.estimate == (record.declared_feasible > 0).mean()
    steps = np.where(record.declare_step < 0, np.inf, record.declare_step)
    assert each.times.median == np.sort(steps)[14]
    assert each.bits == pytest.approx(record.bits_sent.mean() / (10 * 300))


def test_robots_declare_by_votes_where_their_strategy_does_not(found):
    by_votes = {"decision.strategy": "census", "decision.declare": RULE, "tasks.count": 10}
    record = simulate_record(SHORT.replace(by_votes), Runs(30, 2))
    (each,) = [each for each in found if each.contender == "census, by votes" and each.tasks == 10]
    ok = (record.declared_feasible > 9) & (record.declared_infeasible == 0)
    assert 0 < each.ok.estimate == ok.mean()
    assert each.times.median == np.sort(np.where(record.declare_step < 0, 300, record.declare_step))[14]


def test_robots_know_their_number_where_they_must(own):
    assert Contender("it", own, knows_count=True).scenario(SHORT).robots.know_count
    assert not Contender("it", own).scenario(SHORT).robots.know_count
    assert Contender("it", own).scenario(SHORT.replace({"robots.know_count": True})).robots.know_count


def test_the_default_contenders_fit_the_paper():
    scenarios = [each.scenario(Scenario()) for each in CONTENDERS]
    assert all(each.declares for each in scenarios)
    assert sum(each.manifest.declares for each in scenarios) >= 8
    assert len({each.hash for each in scenarios}) == len(CONTENDERS)
    assert tasks_near(Scenario()) == [19, 20, 21, 22]


def test_contenders_by_name():
    assert [each.name for each in contenders_named(["dc", "a/mine.py"])] == ["dc", "mine.py"]
    assert contenders_named([]) == list(CONTENDERS)
    with pytest.raises(FeasibeeError, match="dc: is named twice"):
        contenders_named(["dc", "dc"])


def test_the_figure_and_its_data_are_written(found, tmp_path):
    bounds = limits_near(SHORT, TASKS, 20, 2)
    write_frontier(tmp_path, found, bounds)
    write_limits(tmp_path / "limits.csv", bounds)
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "frontier.csv",
        "frontier.pdf",
        "frontier.png",
        "limits.csv",
    ]
    with (tmp_path / "frontier.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["ok"]) for row in rows] == [each.ok.estimate for each in found]
    with (tmp_path / "limits.csv").open() as file:
        rows = {(row["tasks"], row["limit"]): row for row in csv.DictReader(file)}
    assert int(rows["11", "flooding"]["step_median"]) == bounds[11].times["flooding"].median


def test_a_panel_has_a_row_for_each_contender_and_a_band_for_each_limit():
    words = [
        Word("dear", 400.0, 1.0, 80, 120),
        Word("cheap", 6.0, 0.5, 300, None),
        Word("mute", 50.0, 0.0, None, None),
    ]
    limits = {"pooled": (20, 40), "flooding": (70, 90), "area": (60, 90), "complete_map": (110, None)}
    drawn = draw_frontier([Panel("m = 20", words, limits), Panel("m = 21", words, limits)], 1000)
    bits, first, _ = drawn.axes
    assert [text.get_text() for text in bits.get_yticklabels()] == ["cheap", "mute", "dear"]
    edges = [across(patch) for patch in first.patches]
    assert edges == [(20, 40), (70, 90), (110, 1000)]
    dots = [line for line in first.get_lines() if line.get_marker() == "o"]
    assert [line.get_xydata().tolist() for line in dots] == [[[300.0, 0.0]], [[80.0, 2.0]]]
    assert [to_hex(line.get_markerfacecolor()) for line in dots] == ["#ffffff", WORD.lower()]
    written = [text.get_text() for text in first.texts]
    assert written[:3] == ["0.500", "0.000", "1.000"]
    assert [text for text in written if text in {band.replace("_", " ") for band in BANDS}] == [
        "pooled",
        "flooding",
        "complete map",
    ]


def test_the_command_prints_writes_and_resumes(own, tmp_path):
    arguments = [
        "compare",
        "--limits",
        "--strategies",
        f"{own},tally",
        "--tasks",
        "10,11",
        "--runs",
        5,
        "--seed",
        1,
    ]
    for change in ("arena.side=10.0", "robots.count=10", "run.steps=100"):
        arguments += ["--set", change]
    done = invoke(*arguments, "--out", tmp_path / "out")
    assert done.exit_code == 0, done.output
    assert "quiet.py" in done.stdout
    assert "m = 11" in done.stdout
    assert (tmp_path / "out" / "frontier.png").stat().st_size > 10_000
    again = invoke(*arguments, "--out", tmp_path / "out")
    assert again.stdout == done.stdout


def test_the_command_refuses_before_it_makes_a_folder(tmp_path):
    told = refused_in_a_line("compare", "--limits", "--strategies", "dmnd", "--out", tmp_path / "out")
    assert "dmnd" in told
    told = refused_in_a_line(
        "compare", "--limits", "--strategies", "dc", "--tasks", -1, "--out", tmp_path / "out"
    )
    assert "tasks.count = -1" in told
    assert not (tmp_path / "out").exists()

"""The frontier: what robots said by their own word, recounted from the runs, and drawn with the limits."""

from __future__ import annotations

import numpy as np
import pytest
from commands import invoke, refused_in_a_line, rows_of
from declaring import declaring
from matplotlib.colors import to_hex

from feasibee import FeasibeeError, Scenario
from feasibee.figures.limits import BANDS, WORD, Panel, Word, draw_frontier
from feasibee.scenario.runs import RUNS_APART, Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.studies.comparison import compare
from feasibee.studies.limits import (
    CONTENDERS,
    RULE,
    limits,
    speakers,
    spoken,
    tasks_near,
)

SHORT = Scenario(arena={"side": 10.0}, robots={"count": 10}, run={"steps": 300})
TASKS = (10, 11)


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    """The file of a strategy whose robots declare."""
    return declaring(tmp_path_factory.mktemp("own")).decision.strategy


@pytest.fixture(scope="module")
def found(own):
    return compare(speakers(SHORT, [own, "census"]), TASKS, runs=30, seed=2, curves=False)


def across(patch):
    """Return where a band begins and ends."""
    places = patch.get_path().transformed(patch.get_patch_transform()).vertices[:, 0]
    return places.min(), places.max()


@pytest.mark.parametrize(("row", "tasks"), [(1, 11), (2, 10)])
def test_what_is_said_is_that_of_the_runs(found, own, row, tasks):
    """By a word of the strategy's own, and by votes where it has none; both in the same worlds."""
    decision = [{"decision.strategy": own}, {"decision.strategy": "census", "decision.declare": RULE}][
        row // 2
    ]
    runs = Runs(30, 2, RUNS_APART * TASKS.index(tasks))
    record = simulate_record(SHORT.replace({**decision, "tasks.count": tasks}), runs)
    right, wrong = record.declared_feasible, record.declared_infeasible
    if tasks > 10:
        right, wrong = wrong, right
    said = spoken(found[row])
    assert (said["tasks"], said["feasible"]) == (tasks, tasks == 10)
    assert 0 < said["ok"]["estimate"] == ((right > 9) & (wrong == 0)).mean()
    assert said["wrong"]["estimate"] == (wrong > 0).mean()
    assert said["times"]["median"] == np.sort(np.where(record.declare_step < 0, 300, record.declare_step))[14]
    assert said["bits"] == pytest.approx(record.bits_sent.mean() / (10 * 300))


@pytest.mark.parametrize("stop", [40, 150])
def test_runs_that_end_once_all_have_declared_say_the_same(own, monkeypatch, stop):
    """Also if a robot stops before, or later. Bits are those of the first runs."""
    scenario = SHORT.replace({"faults.stopped": {"count": 1}, "faults.stop_step": stop, "tasks.count": 11})
    chosen = speakers(scenario, [own, "quiet-census", "census"])
    whole = compare(chosen, TASKS, 40, 2)
    first = compare(chosen, TASKS, 10, 2)
    monkeypatch.setattr("feasibee.studies.comparison.WHOLE", 10)
    for each, same, bits in zip(compare(chosen, TASKS, 40, 2), whole, first, strict=True):
        assert {**spoken(each), "bits": 0} == {**spoken(same), "bits": 0}
        assert each.runs == same.runs == 40
        for name in ("right", "agreed", "right_at", "said"):
            np.testing.assert_array_equal(getattr(each, name), getattr(same, name), name)
        assert each.found.times == same.found.times
        assert each.found.bits == pytest.approx(bits.found.bits)
        np.testing.assert_array_equal(each.bits, bits.bits)


def test_robots_know_their_number_where_they_must(own):
    def knows(scenario, strategy):
        (it,) = speakers(scenario, [strategy]).values()
        return it.robots.know_count

    assert knows(SHORT, "map")
    assert not knows(SHORT, own)
    assert knows(SHORT.replace({"robots.know_count": True}), own)


def test_contenders_that_a_world_rejects_are_left_out():
    names = speakers(Scenario(sensing={"view": 120}))
    assert set(speakers(Scenario())) - set(names) == {"map"}


def test_the_default_contenders_fit_the_paper():
    scenarios = speakers(Scenario())
    assert list(scenarios) == [name for name, _ in CONTENDERS]
    assert all(each.declares for each in scenarios.values())
    assert sum(each.manifest.declares for each in scenarios.values()) >= 8
    assert len({each.hash for each in scenarios.values()}) == len(CONTENDERS)
    known = {name: each.robots.know_count for name, each in scenarios.items() if name.startswith("quiet")}
    assert known == {"quiet census, n known": True, "quiet census, n unknown": False}
    assert tasks_near(Scenario()) == [19, 20, 21, 22]


def test_contenders_by_name(own):
    assert list(speakers(SHORT, ["dc", own])) == ["dc", "quiet.py"]
    with pytest.raises(FeasibeeError, match="dc: is named twice"):
        speakers(SHORT, ["dc", "dc"])


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


def test_the_command_prints_writes_and_resumes(found, own, tmp_path):
    """The figure and its data are of the same runs as those of the functions."""
    arguments = ["compare", "--limits", "--strategies", f"{own},census", "--tasks", "10,11", "--runs", 30]
    for change in ("arena.side=10.0", "robots.count=10", "run.steps=300"):
        arguments += ["--set", change]
    arguments += ["--seed", 2, "--out", tmp_path]
    done = invoke(*arguments)
    assert done.exit_code == 0, done.output
    assert "quiet.py" in done.stdout
    assert "m = 11" in done.stdout
    assert {"frontier.csv", "frontier.pdf", "limits.csv"} < {path.name for path in tmp_path.iterdir()}
    assert (tmp_path / "frontier.png").stat().st_size > 10_000
    rows = rows_of(tmp_path / "frontier.csv")
    assert [float(row["ok"]) for row in rows] == [each.declared.ok.estimate for each in found]
    rows = {(row["tasks"], row["limit"]): row for row in rows_of(tmp_path / "limits.csv")}
    flooding = limits(SHORT.replace({"tasks.count": 11}), 30, 2).times["flooding"]
    assert int(rows["11", "flooding"]["step_median"]) == flooding.median
    assert invoke(*arguments).stdout == done.stdout


def test_the_command_refuses_before_it_makes_a_folder(tmp_path):
    told = refused_in_a_line("compare", "--limits", "--strategies", "dmnd", "--out", tmp_path / "out")
    assert "dmnd" in told
    told = refused_in_a_line(
        "compare", "--limits", "--strategies", "dc", "--tasks", -1, "--out", tmp_path / "out"
    )
    assert "tasks.count = -1" in told
    assert not (tmp_path / "out").exists()

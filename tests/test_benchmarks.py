"""The benchmarks: measurements in turn, the history of releases, the program in C, the figure of the docs."""

from __future__ import annotations

import sys
from functools import partial
from importlib import import_module
from itertools import count
from pathlib import Path

import numpy as np
import pytest

import feasibee

ROOT = Path(__file__).parents[1]
BENCHMARKS = ROOT / "benchmarks"
MODULES = {path.stem for path in BENCHMARKS.glob("*.py")} | {"speed"}


@pytest.fixture
def benchmarks(monkeypatch):
    pytest.importorskip("resource", reason="benchmarks ask the system for CPU time")
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "_extensions"))
    for name in MODULES:  # tests may have modules of these names
        monkeypatch.delitem(sys.modules, name, raising=False)
    yield import_module
    for name in MODULES:
        sys.modules.pop(name, None)


@pytest.fixture
def history(benchmarks):
    return benchmarks("history")


@pytest.fixture
def measure(benchmarks):
    return benchmarks("measure")


def session(version, yardstick, ours, peak):
    rows = [
        {"name": "feasibee", "unit": "ns/robot-step", "best": ours},
        {"name": "brute-force loop in numba", "unit": "ns/robot-step", "best": yardstick},
    ]
    cases = {"The paper's swarm: 20 robots": rows, "Memory": [{"name": "1 run", "unit": "MiB", "best": peak}]}
    return {"machine": {"feasibee": version}, "cases": cases}


def test_a_slower_machine_changes_no_ratio_and_slower_code_does(history):
    then = session("0.1.0", 300.0, 20.0, 100.0)
    assert [each.ratio for each in history.changes(session("0.2.0", 600.0, 40.0, 110.0), then)] == [1.0, 1.1]
    assert [each.ratio for each in history.changes(session("0.2.0", 300.0, 30.0, 100.0), then)] == [1.5, 1.0]


def test_the_latest_release_is_the_highest_version(history, tmp_path):
    assert history.latest(tmp_path) is None
    for version in ("0.9.0", "0.10.0", "0.2.0"):
        saved = session(version, 300.0, 20.0, 100.0)
        assert history.read(history.save(saved, tmp_path)) == saved
    assert history.latest(tmp_path).stem == "0.10.0"


def test_what_only_one_session_has_is_left_out(history):
    then, now = session("0.1.0", 300.0, 20.0, 100.0), session("0.2.0", 300.0, 20.0, 100.0)
    del then["cases"]["Memory"]
    assert [each.name for each in history.changes(now, then)] == ["feasibee"]


def test_things_are_measured_in_turn_after_each_was_warmed(measure):
    done = []
    samples = {
        name: measure.Sample(lambda name=name: done.append(f"warm {name}"), partial(take, done, name))
        for name in "ab"
    }
    assert measure.in_turn(samples, 2) == {"a": [1.0, 1.0], "b": [2.0, 2.0]}
    assert done == ["warm a", "warm b", "a", "b", "a", "b"]


def take(done, name):
    done.append(name)
    return {"a": 1.0, "b": 2.0}[name]


def test_a_ratio_is_the_median_of_those_of_neighbours_in_time(measure):
    ours, theirs = [1.0, 2.0, 4.0], [3.0, 4.0, 40.0]
    row = measure.Row.of("theirs", measure.NS_PER_ROBOT_STEP, theirs)
    row = row.compared(measure.ratios(theirs, ours), "ours")
    assert (row.low, row.ratio, row.high, row.best, row.median) == (2.5, 3.0, 6.5, 3.0, 4.0)


@pytest.mark.parametrize(
    ("figure", "bound", "meets"),
    [
        ("ratio", {"least": 2.0}, True),
        ("ratio", {"least": 2.1}, False),
        ("best", {"most": 10.0}, True),
        ("best", {"most": 9.9}, False),
        ("speed", {"least": 100.0}, True),
        ("speed", {"least": 101.0}, False),
        ("speed", {}, None),
    ],
)
def test_a_row_says_whether_it_meets_its_target(measure, figure, bound, meets):
    row = measure.Row("name", measure.NS_PER_ROBOT_STEP, 10.0, 12.0, ratio=2.0)
    assert row.aiming(figure, **bound).meets is meets


def test_two_versions_take_turns_at_being_first(benchmarks):
    against, clock = benchmarks("against"), count()

    class Asked:
        def ask(self, name):
            return next(clock)

    assert against.ask_in_turn([Asked(), Asked()], "any", 3) == ([2, 5, 6], [3, 4, 7])


@pytest.mark.parametrize("tasks", [10, pytest.param(100, marks=pytest.mark.slow)])
def test_the_program_in_c_has_the_decisions_of_feasibee(benchmarks, tasks):
    """Catches shares that differ by 0.02 and times that differ by 5 %, at least 4 standard errors."""
    by_hand = benchmarks("rivals").ByHand()
    if by_hand.why:
        pytest.skip(by_hand.why)
    runs, more = 4000, 16_000
    theirs = by_hand.play(tasks, more)
    scenario = feasibee.Scenario(tasks={"count": tasks}, decision={"inbox": "every-message"})
    ours = feasibee.simulate(scenario, runs, seed=1)
    decided = ours.decision.values >= 0
    assert theirs.feasible / more == pytest.approx((ours.decision.values == 1).mean(), abs=0.02)
    assert (theirs.feasible + theirs.infeasible) / more == pytest.approx(decided.mean(), abs=0.02)
    steps = np.quantile(ours.decision_step.values[decided], (0.25, 0.5, 0.75))
    assert theirs.quartiles == pytest.approx(steps, rel=0.05)


def test_the_stored_benchmarks_have_what_the_figure_of_the_docs_shows(benchmarks):
    speed = benchmarks("speed")
    drawn = speed.draw_cost(speed.stored())
    (ax,) = drawn.axes
    assert {text.get_text() for text in ax.texts} == {look.label for look in speed.LOOKS}
    sizes = {text.get_text(): line.get_xdata() for text, line in zip(ax.texts, ax.lines, strict=True)}
    assert (min(sizes["feasibee, one thread"]), max(sizes["feasibee, one thread"])) == (20, 1_000_000)
    assert all(min(sizes[name]) == 20 for name in ("Mesa", "all pairs, a loop in numba"))

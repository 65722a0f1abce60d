"""The history of benchmarks: one file per release, compared in units of a loop that is measured along."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"


@pytest.fixture
def history(monkeypatch):
    pytest.importorskip("resource", reason="benchmarks ask the system for CPU time")
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    import history

    yield history
    for name in ("history", "measure"):
        sys.modules.pop(name, None)


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

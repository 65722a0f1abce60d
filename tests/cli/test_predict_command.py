"""feasibee predict: what it prints, draws and refuses."""

from __future__ import annotations

import pytest
from commands import json_of, output_of, refused

from feasibee.cli import predict as module

TEN = ("predict", "--set", "tasks.count=10")


def test_a_prediction_for_programs():
    found = json_of(*TEN)
    assert {"feasible", "infeasible", "undecided", "median_step", "error"} <= found.keys()
    assert found["feasible"] + found["infeasible"] + found["undecided"] == pytest.approx(1)
    assert found["right"] == found["feasible"]
    assert 0.5 < found["noise"]["coins_share"] < 0.6
    assert found["scenario"]["tasks"]["count"] == 10


def test_a_prediction_for_people_says_what_and_when_and_why_if_asked():
    text = output_of(*TEN)
    assert text.startswith("By theory, 75 % of the swarms rightly decide feasible")
    assert len(text.splitlines()) == 3
    assert "Half have decided by step 125" in text
    more = output_of(*TEN, "--details")
    assert more.startswith(text)
    assert "Opinions tip where" in more
    assert "the coins at the start" in more
    assert "do not tip" in output_of(*TEN, "--set", "decision.strategy=voter")


def test_runs_of_the_engine_beside_it(tmp_path):
    plot = tmp_path / "both.svg"
    found = json_of(*TEN, "--against", 500, "--seed", 3, "--plot", plot)
    assert found["engine"]["runs"] == 500
    assert found["agree"] is True
    low, high = (found["engine"]["feasible"][end] for end in ("low", "high"))
    assert low - found["error"] <= found["feasible"] <= high + found["error"]
    assert "<svg" in plot.read_text("utf-8")


def test_a_field_is_followed_as_far_as_the_theory_reaches(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "POINTS", 3)
    shown = output_of(*TEN, "--over", "decision.gain=0.5:40", "--plot", tmp_path / "gain.png")
    assert shown.startswith("By theory, ")
    assert "Beyond reach: decision.gain = 0.5" in shown
    assert (tmp_path / "gain.png").stat().st_size > 10_000
    found = json_of(*TEN, "--over", "decision.gain=0.5:40")
    assert found["field"] == "decision.gain"
    first, *others = found["points"]
    assert "beyond_reach" in first
    assert [point["value"] for point in others] == pytest.approx([20**0.5, 40])
    assert all(0.6 < point["feasible"] < 0.8 for point in others)


def test_what_is_beyond_reach_is_refused():
    (line,) = refused("predict", "--set", "decision.strategy=census")
    assert "decision.strategy = 'census'" in line
    (line,) = refused("predict", "--over", "decision.gain=0.1:0.2")
    assert "decision.gain" in line
    (line,) = refused(*TEN, "--plot", "figure.txt")
    assert "figure.txt" in line

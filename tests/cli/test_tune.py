"""`feasibee tune` tells a gain from chance."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from feasibee.cli.tune import _as_dict, _print_tuned
from feasibee.results.statistics import Interval
from feasibee.studies.tuning import Tuned


@pytest.mark.parametrize(
    ("gain", "beginning", "clear"),
    [
        ((0.02, -0.01, 0.05), "No clear gain. Right within 500 steps", False),
        ((0.01, 0.0, 0.02), "No clear gain. Right", False),
        ((0.03, 0.01, 0.05), "Right within 500 steps: 63.0 %", True),
        ((-0.03, -0.05, -0.01), "Worse than the start. Right", False),
    ],
)
def test_a_gain_whose_interval_includes_zero_is_told(capsys, gain, beginning, clear):
    tuned = Tuned(
        {"decision.gain": 4.0}, Interval(0.6, 0.5, 0.7), Interval(0.63, 0.6, 0.7), Interval(*gain), []
    )
    _print_tuned(tuned, 500, 2000, Path("tune.png"))
    values, told = capsys.readouterr().out.splitlines()
    assert values == "--set decision.gain=4"
    assert told.startswith(beginning)
    assert tuned.gains is clear


def test_theory_that_proposed_is_named(capsys):
    same = Interval(0.6, 0.5, 0.7)
    tuned = Tuned({"decision.gain": 4.0}, same, same, Interval(0.0, -0.1, 0.1), [], predicted=0.625)
    _print_tuned(tuned, 500, 2000, Path("tune.png"))
    assert (
        "Theory proposed parameters, and simulation judged them: 62.5 % predicted." in capsys.readouterr().out
    )
    assert _as_dict(tuned)["predicted"] == 0.625
    assert "predicted" not in _as_dict(replace(tuned, predicted=None))

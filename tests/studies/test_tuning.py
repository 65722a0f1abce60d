"""A search that theory proposes for, and simulation judges."""

from __future__ import annotations

import pytest

from feasibee import Scenario
from feasibee.studies.space import dimensions
from feasibee.studies.tuning import _proposed, tune
from feasibee.sweeps.sweep import Execution

optuna = pytest.importorskip("optuna")
QUICK = Scenario(tasks={"count": 10}, decision={"gain": 4.0}, run={"steps": 300, "stop_at_decision": False})
GAIN = ["decision.gain=3:30"]


def searched(scenario, over, **more):
    """Return the result of a short search, and the number of its runs."""
    counts = [0]
    execution = Execution(progress=lambda progress: counts.append(progress.runs_done))
    return tune(scenario, dimensions(scenario, over), 12, 40, 3, execution, **more), counts[-1]


def test_theory_proposes_and_simulation_judges():
    tuned, runs = searched(QUICK, GAIN)
    simulated, of_old = searched(QUICK, GAIN, theory=False)
    assert runs == 40 * (3 * 5 + 2 * 10)  # the start and two proposals; then the start and the best
    assert of_old == 40 * (12 + 6 * 5 + 2 * 10)
    assert len(tuned.trials) == 12
    assert tuned.values in [values for values, _ in tuned.trials]
    assert tuned.gains
    assert abs(tuned.predicted - tuned.best.estimate) < 0.06
    assert simulated.predicted is None


def test_the_start_is_kept_if_proposals_are_worse(monkeypatch):
    monkeypatch.setattr("feasibee.theory.screen.Screen.right", lambda _, it: 1 / it.decision.gain)
    start = QUICK.replace({"decision.gain": 12.0})
    tuned, _ = searched(start, ["decision.gain=1:12"])
    assert (tuned.values, tuned.predicted) == ({"decision.gain": 12.0}, 1 / 12)


@pytest.mark.parametrize(
    ("changes", "over"),
    [
        ({"decision.strategy": "census"}, "decision.gain"),
        ({}, "decision.gain=0.1:3"),  # most of the range, and the start, are beyond reach
        ({}, "decision.gain,decision.strategy=dmmd|census"),
        ({}, "decision.gain,sensing.range=1:3"),
        ({"faults.byzantine": 0.1}, "decision.gain"),
    ],
)
def test_beyond_reach_all_trials_are_run(changes, over):
    scenario = QUICK.replace(changes)
    assert _proposed(scenario, dimensions(scenario, over.split(",")), 12, 3) is None


def test_with_long_explorations_all_trials_are_run(monkeypatch):
    space = dimensions(QUICK, ["decision.exploration=8:25"])
    assert _proposed(QUICK, space, 4, 3)
    monkeypatch.setattr("feasibee.studies.tuning.LONGEST", 20)
    assert _proposed(QUICK, space, 4, 3) is None


def test_other_measures_are_searched_by_runs(monkeypatch):
    monkeypatch.setattr("feasibee.studies.tuning._proposed", lambda *_: pytest.fail("proposed"))
    changing = Scenario(events=[{"step": 50, "tasks": 30}], run={"steps": 100})
    tuned, runs = searched(changing, GAIN)
    assert (tuned.predicted, runs) == (None, 40 * (12 + 6 * 5 + 2 * 10))

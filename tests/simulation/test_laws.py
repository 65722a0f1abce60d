"""Statistical laws: fixed seeds, bounds at alpha of about 1e-7 each, the smallest error each catches named.

The rates and times of model.md section 5 come from an independent brute-force simulation of 2,000 runs a row.
"""

from __future__ import annotations

import numpy as np
import pytest

from feasibee import FeasibeeError, Scenario, Swarm, decision_times
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from tests.shares import assert_even, assert_share, bound

RUNS = 2000
ROUNDED = 0.005
"""Shares were published to half a per cent."""

# model.md section 5: tasks, share deciding feasible, quartiles and median of the decision step.
SECTION_5 = [
    (2, 0.945, (80, 105, 140)),
    (4, 0.89, (82, 111, 153)),
    (8, 0.80, (91, 125, 169)),
    (10, 0.74, (92, 128, 178)),
    (16, 0.59, (95, 132, 185)),
    (20, 0.51, (97, 132, 183)),
    (25, 0.44, (98, 136, 188)),
    (40, 0.23, (93, 124, 170)),
    (50, 0.16, (86, 115, 158)),
    (100, 0.05, (76, 102, 136)),
    (200, 0.02, (72, 94, 123)),
]
TEN = {"tasks.count": 10}
CHOICES = [  # changes, share deciding feasible, and whether swarms are three times as slow
    ({"decision.own_vote": False}, 0.94, False),
    ({"decision.inbox": "every-message"}, 0.95, False),
    ({"decision.listen": "dissemination", "run.steps": 3000}, 0.59, True),
    ({"sensing.count_self": True}, 0.96, False),
    ({"sensing.count_self": True, "tasks.count": 40}, 0.65, False),  # leans at ratio 1/2, too
    ({"decision.exploration": 100.0, "decision.gain": 100.0, "run.steps": 5000}, 0.74, True),
]


def decided(changes, share, other_runs):
    """Return quartiles and median of the steps of decisions, of which a share is feasible."""
    record = simulate_record(Scenario().replace(changes), Runs(RUNS, 11))
    found = (record.decision == 1).mean()
    assert abs(found - share) < bound(share, RUNS, other_runs) + ROUNDED
    return decision_times(record.decision_step)


@pytest.mark.slow
@pytest.mark.parametrize(("tasks", "share", "quartiles"), SECTION_5)
def test_rates_and_times_are_those_of_section_5(tasks, share, quartiles):
    """Catches a share off by 0.08 near 1/2, by 0.03 at the ends, and a quartile off by a tenth."""
    np.testing.assert_allclose(decided({"tasks.count": tasks}, share, 2000), quartiles, rtol=0.11)


@pytest.mark.slow
@pytest.mark.parametrize(("changes", "share", "slow"), CHOICES)
def test_choices_matter_as_section_5_says(changes, share, slow):
    """Catches a choice that has no effect, or another: shares off by 0.05 to 0.1; slow is three times."""
    times = decided({**TEN, **changes}, share, 1000)
    assert not slow or 2.4 < times.median / decided(TEN, 0.74, 2000).median < 3.9


@pytest.mark.slow
def test_starts_are_uniform_in_place_heading_and_opinion():
    """Catches a density off by 6 % in any sixteenth of the arena, and a bias of 1.2 % in the opinion."""
    swarms = [Swarm(Scenario(tasks={"count": 20}), seed=3, run=run) for run in range(2500)]
    for places in (np.concatenate([s.positions for s in swarms]), np.concatenate([s.tasks for s in swarms])):
        assert_even(places // 5 @ (1, 4), -0.5, 15.5)
    assert_share(np.concatenate([s.opinions for s in swarms]), 0.5)


def test_robots_walk_straight_runs_of_mean_ten_at_speed_one():
    """Catches a mean run off by 3 %, a speed off by one part in 10**8, and headings that aren't uniform."""
    scenario = Scenario(robots={"count": 1000}, arena={"side": 100.0}, tasks={"count": 0})
    swarm = Swarm(scenario, seed=4)
    places = [swarm.positions]
    for _ in range(400):
        swarm.advance()
        places.append(swarm.positions)
    moves = (np.diff(np.array(places), axis=0) + 50) % 100 - 50
    np.testing.assert_allclose(np.hypot(*np.moveaxis(moves, -1, 0)), 1.0, atol=5e-8)
    turned = (np.abs(np.diff(moves, axis=0)) > 1e-9).any(axis=-1)
    assert_share(
        turned, 1 - np.exp(-1 / 10)
    )  # an exponential rounded up ends after each step with this chance
    assert_even(np.arctan2(moves[1:, :, 1][turned], moves[1:, :, 0][turned]), -np.pi, np.pi)


@pytest.mark.parametrize("steps", [-1, "1", 2.5, 2**40])
def test_a_swarm_goes_whole_steps_forward(steps):
    with pytest.raises(FeasibeeError, match=r"^steps = .*: must be a whole number from 0 to 2147483647"):
        Swarm().advance(steps)

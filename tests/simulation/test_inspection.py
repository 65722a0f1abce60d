"""`restore` returns to the very step; what `Swarm.robot` says is compared in the conformance suite."""

from __future__ import annotations

import numpy as np
import pytest

from feasibee import FeasibeeError, Scenario, Swarm
from tests.worlds import fields_of, world

LARGE = Scenario(robots={"count": 1500}, tasks={"count": 1400}, arena={"side": 170.0}, run={"steps": 60})
SAVED = [*range(0, len(fields_of()), 3), pytest.param(-1, id="1,500 robots")]


@pytest.mark.parametrize("number", SAVED)
def test_restore_returns_to_the_step_that_was_saved(number):
    """Catches what isn't saved, be it shown or only used to go on: what robots see after a restored step."""
    scenario = LARGE if number < 0 else world(number)
    swarm, kept, steps = Swarm(scenario, 3, 2), [], min(60, scenario.run.steps)
    for step in (0, steps // 3, steps // 2, steps):
        swarm.advance(step - swarm.step)
        saved, there = swarm.save(), look(swarm)
        assert saved.step == step
        assert saved.nbytes > 100 * swarm.present.sum()
        swarm.advance(5)
        kept.append((saved, there, look(swarm)))
        swarm.restore(saved)
    for saved, there, later in reversed(kept):
        swarm.restore(saved)
        assert_same(look(swarm), there)
        swarm.advance(0)
        assert_same(look(swarm), there)
        swarm.advance(5)
        assert_same(look(swarm), later)


def look(swarm):
    """Return all that a swarm shows at its step."""
    arrays = (
        *("positions", "headings", "present", "tasks", "task_numbers", "opinions", "counted", "knowledge"),
        *("truths", "robot_counts", "task_counts", "counted_counts", "feasible_counts"),
    )
    outcomes = [swarm.step, swarm.truth, swarm.decision, swarm.bits_sent, swarm.declaration_step]
    return [
        *(np.array(getattr(swarm, name)) for name in arrays),
        *swarm.snapshot(),
        *swarm.task_places(),
        [*outcomes, *swarm.first_decision, *swarm.declared_counts],
        [swarm.robot(int(each)) for each in np.flatnonzero(swarm.present)[::7]],
    ]


def assert_same(one, other):
    for mine, yours in zip(one, other, strict=True):
        if isinstance(mine, np.ndarray):
            np.testing.assert_array_equal(mine, yours)
        else:
            assert mine == yours


@pytest.mark.parametrize("number", [-1, 20, 0.5, True, None])
def test_a_robot_that_is_not_there_is_an_error(number):
    with pytest.raises(FeasibeeError, match=r"robot = .* must be a whole number from 0 to 19|robot"):
        Swarm().robot(number)

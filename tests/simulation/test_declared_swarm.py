"""What a swarm says of declarations, step by step, is what the model in plain Python says."""

from __future__ import annotations

import numpy as np
from declaring import declaring

from feasibee import Swarm, reference
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.snapshot import FLAGS


def test_each_robot_declares_when_its_double_does(tmp_path):
    scenario = declaring(
        tmp_path, quiet=20.0, tasks={"count": 21}, faults={"byzantine": 0.1, "stubborn": 0.1}
    )
    swarm, plain = Swarm(scenario, seed=3), reference.Swarm(scenario, seed=3, run=0)
    before = swarm.declared
    assert (before == -1).all()
    for _ in range(90):
        swarm.advance()
        plain.step()
        declared = swarm.declared
        np.testing.assert_array_equal(declared, [each.mind.declared for each in plain.robots])
        assert ((declared == before) | (before == -1)).all()  # once and for good
        assert swarm.declared_counts == (plain.declared(1), plain.declared(0))
        flags = swarm.snapshot().flags >> FLAGS.index("declared") & 1
        np.testing.assert_array_equal(flags, declared >= 0)
        before = declared
    assert {0, 1} <= set(declared.tolist())


def test_at_the_end_a_swarm_has_declared_as_simulate_says(tmp_path):
    scenario = declaring(tmp_path, quiet=20.0, run={"steps": 70})
    swarm = Swarm(scenario, seed=1, run=4)
    swarm.advance(70)
    record = simulate_record(scenario, Runs(1, 1, 4))
    assert swarm.declared_counts == (record.declared_feasible[0], record.declared_infeasible[0])
    assert sum(swarm.declared_counts) > 0
    assert (swarm.feasible_count, swarm.infeasible_count) == (
        record.feasible_at_end[0],
        record.infeasible_at_end[0],
    )

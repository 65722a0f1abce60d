"""What a swarm says of declarations at its end is what `simulate` says."""

from __future__ import annotations

from declaring import declaring

from feasibee import Swarm
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record


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

"""Engine and reference, written apart, agree bit for bit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from feasibee import Scenario, Swarm, reference
from feasibee.simulation import simulate_record


def assert_equal(scenario, seed, runs=1, first_run=0):
    engine = simulate_record(scenario, runs, seed, first_run=first_run, curves=True)
    plain = simulate_record(scenario, runs, seed, first_run=first_run, curves=True, backend="reference")
    for name in ("decision", "decision_step", "feasible_count"):
        np.testing.assert_array_equal(getattr(engine, name), getattr(plain, name), err_msg=name)


@st.composite
def scenarios(draw):
    side = draw(st.floats(2, 40))
    robots = draw(st.one_of(st.integers(1, 34), st.integers(60, 70)))
    reach = st.floats(0.01, 0.5).map(lambda share: share * side)
    return Scenario(
        arena={"side": side},
        robots={"count": robots, "speed": draw(st.floats(0, 0.5)) * side},
        tasks={"count": draw(st.one_of(st.integers(0, 70), st.just(200)))},
        walk={"mean_run": draw(st.floats(0.1, 30))},
        sensing={"range": draw(reach), "count_self": draw(st.booleans())},
        radio=draw(st.one_of(st.just({}), st.builds(dict, range=reach))),
        decision={
            "exploration": draw(st.floats(0.1, 15)),
            "gain": draw(st.floats(0.1, 30)),
            "listen": draw(st.sampled_from(["always", "dissemination"])),
            "inbox": draw(st.sampled_from(["latest-per-robot", "every-message"])),
            "own_vote": draw(st.booleans()),
            "threshold": draw(st.floats(0.5, 0.99)),
        },
        run={"steps": draw(st.integers(1, 40)), "stop_at_decision": draw(st.booleans())},
    )


@settings(max_examples=120, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
@given(scenarios(), st.integers(0, 2**64 - 1), st.integers(0, 2**32 - 2))
def test_engine_equals_reference_over_generated_scenarios(scenario, seed, first_run):
    assert_equal(scenario, seed, first_run=first_run)


@pytest.mark.parametrize("tasks", [2, 20, 200])
def test_engine_equals_reference_on_the_papers_runs(tasks):
    assert_equal(Scenario(tasks={"count": tasks}, run={"steps": 300}), seed=1, runs=2)


@pytest.mark.parametrize("listen", ["always", "dissemination"])
@pytest.mark.parametrize("inbox", ["latest-per-robot", "every-message"])
def test_engine_equals_reference_in_a_crowd_where_inbox_tables_grow(listen, inbox):
    """70 robots that all hear each other for long fill tables of 64 slots."""
    scenario = Scenario(
        arena={"side": 4.0},
        robots={"count": 70},
        tasks={"count": 50},
        decision={"gain": 60.0, "listen": listen, "inbox": inbox},
        run={"steps": 100},
    )
    assert_equal(scenario, seed=2, runs=2)


@pytest.mark.parametrize("count", [20, 40])
def test_a_swarm_step_by_step_is_the_references_swarm(count):
    scenario = Scenario(robots={"count": count}, arena={"side": 6.0}, decision={"gain": 40.0})
    swarm = Swarm(scenario, seed=5, run=3)
    plain = reference.Swarm(scenario, seed=5, run=3)
    unit = 6.0 / 2**32
    for _ in range(60):
        np.testing.assert_array_equal(
            swarm.positions, np.array([robot.place for robot in plain.robots]) * unit
        )
        np.testing.assert_array_equal(swarm.tasks, np.array(plain.tasks) * unit)
        np.testing.assert_array_equal(swarm.opinions, [robot.mind.opinion for robot in plain.robots])
        np.testing.assert_array_equal(
            swarm.disseminating, [robot.mind.disseminating for robot in plain.robots]
        )
        assert swarm.feasible_count == plain.feasible_count
        assert swarm.decision == plain.decision
        swarm.advance()
        plain.step()

"""One swarm of a world that changes: what is there, what is true, and the way back to an earlier step."""

from __future__ import annotations

import numpy as np
import pytest

from feasibee import FeasibeeError, Scenario, Swarm, truth, truth_at
from feasibee.scenario.feasibility import explain
from feasibee.scenario.runs import Runs
from feasibee.simulation import ensemble
from feasibee.simulation.ensemble import simulate_record

SCENARIO = Scenario(
    robots={"arrival_rate": 0.05, "failure_rate": 0.005},
    tasks={"arrival_rate": 0.3, "lifetime": 60.0},
    events=[{"step": 0, "tasks": 2}, {"step": 30, "robots": -6}, {"step": 50, "tasks": -9}],
    decision={"strategy": "census"},
    run={"steps": 200},
)


@pytest.mark.parametrize("faults", [{}, {"byzantine": 0.2, "stopped": 0.2, "stop_step": 20}])
def test_the_curves_are_those_of_simulate(faults):
    scenario = SCENARIO.replace({f"faults.{name}": value for name, value in faults.items()})
    swarm = Swarm(scenario, seed=2, run=7)
    swarm.advance(200)
    record = simulate_record(scenario, Runs.single(2, 7), curves=True)
    curves = {"truths": "truth", "robot_counts": "robots_present", "task_counts": "tasks_present"}
    for name, column in (curves | {"feasible_counts": "feasible_count"}).items():
        np.testing.assert_array_equal(getattr(swarm, name), getattr(record, column)[0])
    assert len(set(swarm.truths)) == 2
    assert len(swarm.tasks) == swarm.task_counts[-1]


@pytest.mark.parametrize(
    ("scenario", "curves", "what"), [(SCENARIO, False, "truths"), (Scenario(), True, "curves")]
)
def test_what_would_not_fit_is_refused_before_the_work(scenario, curves, what, monkeypatch):
    most = 4 * 2 * (scenario.run.steps + 1)
    monkeypatch.setattr(ensemble, "CURVES_LIMIT", most)
    simulate_record(scenario, Runs(2), curves=curves)
    with pytest.raises(FeasibeeError, match=f"{what} of 3 runs .* at most 2 runs per call"):
        simulate_record(scenario, Runs(3), curves=curves)


def test_numbers_without_a_robot_show_none():
    swarm = Swarm(SCENARIO, seed=2)
    swarm.advance(40)
    gone = ~swarm.present
    assert gone.any()
    assert swarm.present.size == SCENARIO.most.robots == len(swarm.positions) == len(swarm.knowledge)
    assert np.isnan(swarm.positions[gone]).all()
    assert np.isnan(swarm.headings[gone]).all()
    assert (swarm.opinions[gone] == -1).all()
    assert (swarm.declared[gone] == -1).all()
    shown = swarm.counted, swarm.knowledge, swarm.snapshot().flags
    assert not any(each[gone].any() for each in shown)
    with pytest.raises(FeasibeeError, match="no robot has this number at step 40; use a number"):
        swarm.robot(int(np.flatnonzero(gone)[0]))
    assert swarm.robot(int(np.flatnonzero(~gone)[0])).place == tuple(swarm.positions[~gone][0])


def test_the_page_of_a_notebook_shows_what_is_there():
    swarm = Swarm(SCENARIO, seed=2)
    swarm.advance(40)
    shown = swarm._repr_html_()
    assert f"An arena with {swarm.present.sum()} robots and {len(swarm.tasks)} tasks" in shown
    assert f"(truth: {'feasible' if swarm.truth else 'infeasible'})" in shown
    assert "nan" not in shown
    assert "truth at the start: <strong>feasible" in shown
    assert "events" in shown


def test_truth_at_is_the_truth_of_the_step():
    swarm = Swarm(SCENARIO, seed=4, run=3)
    for step in (0, 30, 200):
        swarm.advance(step - swarm.step)
        verdict = truth_at(SCENARIO, step, 4, 3)
        assert verdict == swarm.verdict
        assert verdict.feasible == swarm.truth
    still = Scenario(tasks={"count": 21})
    assert truth_at(still, 1000) == explain(still)
    assert truth_at(still, 0).feasible == truth(still)


@pytest.mark.parametrize(("step", "seed"), [(-1, 0), (201, 0), (1.5, 0), (0, -1)])
def test_truth_at_refuses_steps_and_seeds_that_there_are_not(step, seed):
    with pytest.raises(FeasibeeError, match=r"must be a whole number from 0 to"):
        truth_at(SCENARIO, step, seed)


def test_the_certificate_counts_classes():
    scenario = Scenario(
        robots={"classes": [{"name": "arm", "count": 4, "skills": ["lift"]}]},
        tasks={"classes": [{"name": "carry", "count": 2, "needs": {"lift": 2}}]},
        events=[{"step": 5, "tasks": 3}],
        run={"steps": 10},
    )
    assert truth_at(scenario, 4).assignment == {("arm", "carry", "lift"): 4}
    violator = truth_at(scenario, 5).violator
    assert (violator.skills, violator.demand) == (("lift",), 10)


def test_a_world_that_stays_has_constant_curves():
    swarm = Swarm(Scenario(faults={"stopped": 0.25, "byzantine": 0.1, "stop_step": 3}))
    swarm.advance(5)
    assert swarm.counted_counts.tolist() == [18, 18, 18, 13, 13, 13]
    assert swarm.counted_counts[-1] == swarm.counted.sum()
    assert swarm.truths.tolist() == [True] * 6
    assert swarm.robot_counts.tolist() == swarm.task_counts.tolist() == [20] * 6
    assert swarm.present.all()
    assert swarm.task_numbers.tolist() == list(range(20))


def at_step_6(*events, **others):
    """Return a swarm at step 5, and the same one step later, at which these events happen."""
    scenario = Scenario(events=[{"step": 6, **each} for each in events]).replace(others)
    before, after = (Swarm(scenario, seed=3) for _ in range(2))
    before.advance(5)
    after.advance(6)
    return before, after


def test_tasks_appear_where_an_event_says():
    before, after = at_step_6({"tasks": 2, "at": [3.0, 4.0]})
    assert len(before.tasks) == 20
    np.testing.assert_allclose(after.tasks[20:], [[3.0, 4.0]] * 2, atol=1e-8)


@pytest.mark.parametrize("kind", ["robot", "task"])
def test_the_one_that_an_event_names_goes(kind):
    _, after = at_step_6({kind: 7})
    there = np.flatnonzero(after.present) if kind == "robot" else after.task_numbers
    assert set(range(20)) - set(there.tolist()) == {7}
    assert after.truth == (kind == "task")


def test_a_task_that_is_put_elsewhere_keeps_its_number():
    before, after = at_step_6({"task": 7, "at": [3.0, 4.0]})
    np.testing.assert_allclose(after.tasks[7], [3.0, 4.0], atol=1e-8)
    np.testing.assert_array_equal(np.delete(after.tasks, 7, 0), np.delete(before.tasks, 7, 0))


def test_a_robot_that_is_put_elsewhere_goes_on_from_there():
    before, after = at_step_6({"robot": 7, "at": [3.0, 4.0]})
    heading = before.headings[7]
    there = [3.0 + np.cos(heading), 4.0 + np.sin(heading)]
    np.testing.assert_allclose(after.positions[7], there, atol=1e-6)
    assert after.opinions[7] == before.opinions[7]


def test_a_robot_that_would_overlap_another_there_stays_or_does_not_come():
    apart = {"robots.avoid_collisions": True, "robots.speed": 0.0}
    clear, _ = at_step_6({"robots": 1}, **apart)
    place = clear.positions[3].tolist()
    before, after = at_step_6({"robot": 7, "at": place}, {"robots": 1, "at": place}, **apart)
    np.testing.assert_array_equal(after.positions[:20], before.positions[:20])
    assert after.present.sum() == 20
    other = [place[0], (place[1] + 1.1) % 20]
    gap = np.abs(clear.positions[:20] - other)
    assert np.hypot(*np.minimum(gap, 20 - gap).T).min() > 1.0, "nobody is there"
    _, after = at_step_6({"robot": 3, "at": [place[0], place[1] - 0.2]}, **apart)
    np.testing.assert_allclose(
        after.positions[3], [place[0], place[1] - 0.2], atol=1e-8
    )  # not in its own way
    _, after = at_step_6({"robots": 1, "at": other}, **apart)
    np.testing.assert_allclose(after.positions[20], other, atol=1e-8)

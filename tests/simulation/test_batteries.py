"""Robots that charge, away from the arena (model.md 6.23)."""

from __future__ import annotations

import math
from collections import Counter
from itertools import groupby

import numpy as np
import pytest

from feasibee import FeasibeeError, Scenario, ScenarioError, Swarm, reference, simulate
from feasibee.scenario.feasibility import who_counts
from feasibee.strategies import quiet_census, turns

WORK, CHARGE = 12, 5
BATTERY = {"robots.work": WORK, "robots.charge": CHARGE}
BODIES = {"robots.avoid_collisions": True, "robots.contact": "deflect", "robots.diameter": 0.9}
DOCK = {
    "arena.boundary": "walls",
    "place.zones": {"dock": [[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]]},
    "robots.zone": "dock",
    "place.cell": 0.5,
}
FULL = {
    **DOCK,
    **BODIES,
    "robots.speed": 0.02,
    "robots.diameter": 1.1,
    "robots.count": 4,
    "place.zones": {"dock": [[[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]]]},
}
"""Robots that hardly leave their dock, which is as good as full."""


def in_world(**changes):
    return Scenario().replace({"arena.side": 10.0, "run.steps": 60, **BATTERY, **changes})


def watched(scenario, seed=5, steps=60):
    """Return whether each robot was in the arena at each step from 1 on: shape (steps, robots)."""
    swarm = Swarm(scenario, seed)
    rows = []
    for _ in range(steps):
        swarm.advance()
        rows.append(swarm.present)
    return np.array(rows)


def test_robots_work_and_charge_in_turn_and_their_first_batteries_differ():
    there = watched(in_world(**{"robots.count": 300, "arena.side": 40.0}))
    firsts = Counter()
    for own in there.T:
        first, *spans = [(here, len(list(span))) for here, span in groupby(own)]
        firsts[first[1]] += first[0]
        assert set(spans[:-1]) <= {(True, WORK), (False, CHARGE)}
    assert set(firsts) == set(range(1, WORK + 1))
    assert max(firsts.values()) < 2.2 * 300 / WORK


def test_a_robot_that_charges_keeps_its_mind_and_comes_back_to_the_zone():
    plain = reference.Swarm(in_world(**DOCK), 5, 0)
    kept, back = {}, 0
    for _ in range(40):
        plain.step()
        for robot in plain.away:
            mind = (
                robot.mind.phase_left,
                robot.mind.opinion,
                dict(robot.mind._latest),
                robot.mind.robots_seen[:],
            )
            assert kept.setdefault(robot, mind) == mind
        for robot in [each for each in kept if each not in plain.away]:
            del kept[robot]
            back += 1
            x, y = plain.world.in_units(robot.place)
            assert max(x, y) <= 2.0 + plain.scenario.robots.speed  # it has made a step since
    assert back > 20


def test_robots_wait_until_a_place_in_their_zone_is_free():
    there = watched(in_world(**FULL))
    away = [len(list(span)) for own in there.T for here, span in groupby(own) if not here]
    assert max(away) > CHARGE


def test_robots_that_charge_count_and_keep_their_vote():
    runs = simulate(in_world(**{"decision.strategy": "census", "tasks.count": 18}), runs=3, seed=1)
    total = runs.feasible_at_end.values + runs.infeasible_at_end.values
    assert (total == 20).all()
    swarm = Swarm(in_world(), 5)
    swarm.advance(14)
    assert swarm.present.sum() < 20
    assert (swarm.opinions >= 0).all()
    assert swarm.robot_counts[-1] == swarm.counted.sum() == 20
    assert np.isnan(swarm.positions[~swarm.present]).all()


def test_without_them_the_truth_is_about_robots_at_work():
    scenario = in_world(**{"robots.away": "missing", "tasks.count": 15, "faults.byzantine": 0.2})
    swarm = Swarm(scenario, 5)
    honest = swarm.counted
    swarm.advance(60)
    there = watched(scenario).sum(axis=1)
    assert (swarm.robot_counts[1:] == there).all()
    assert (swarm.truths[1:] == (there >= 15)).all()
    assert 0 < swarm.truths.mean() < 1
    assert (swarm.counted == honest & swarm.present).all()


def test_a_stopped_robot_stays_where_it_is():
    there = watched(in_world(**{"faults.stopped": {"count": 19}, "faults.stop_step": 9}))
    stays = (there[8:] == there[8]).all(axis=0)
    assert stays.sum() == 19
    assert 0 < there[8, stays].sum() < 19


@pytest.mark.parametrize(
    ("changes", "path", "rule"),
    [
        ({"robots.charge": None}, "robots.work", "needs robots.charge"),
        ({"robots.work": None}, "robots.charge", "needs robots.work"),
        (
            {"robots.work": None, "robots.charge": None, "robots.away": "missing"},
            "robots.away",
            "needs robots.work",
        ),
        ({"robots.away": "missing", "decision.strategy": "quiet-census"}, "decision.strategy", "is for good"),
    ],
)
def test_what_batteries_need_is_told(changes, path, rule):
    with pytest.raises(ScenarioError) as error:
        in_world(**changes)
    (problem,) = error.value.problems
    assert problem.path == path
    assert rule in problem.rule


@pytest.mark.parametrize(("work", "charge"), [(300, 100), (40, 40)])
def test_a_quiet_time_has_as_many_steps_at_work_as_without_batteries(work, charge):
    """The longest time without so many steps at work begins with a charge."""
    for name, steps in (
        ("turns", turns.quiet_steps),
        ("quiet-census", lambda s: quiet_census.quiet_steps(20, s)),
    ):
        plain = Scenario().replace({"decision.strategy": name, "robots.know_count": True})
        wait = steps(plain.replace({"robots.work": work, "robots.charge": charge}).setting)
        needed = steps(plain.setting)
        cycle = ([0] * charge + [1] * work) * math.ceil(wait / (work + charge))
        assert needed <= sum(cycle[:wait]) <= needed + work
        assert wait == math.ceil(needed * (1 + charge / work) + charge)


@pytest.mark.parametrize("name", ["quiet-census", "turns"])
def test_a_robot_that_was_away_takes_its_absence_for_no_silence(name):
    """With the quiet time of robots that never charge, a robot declares wrongly in 0.5 of the swarms."""
    changes = {"decision.strategy": name, "robots.know_count": name == "turns", "tasks.count": 21}
    world = Scenario().replace(
        {**changes, "robots.work": 300, "robots.charge": 100, "run.stop_at_declarations": True}
    )
    assert simulate(world, runs=60, seed=4).declared_feasible.values.sum() == 0


def test_which_robots_count_is_told():
    assert who_counts(Scenario()) == ""
    assert "all 20, of which 14.1 are at work" in who_counts(in_world())
    assert "those at work, on average 14.1 of 20" in who_counts(in_world(**{"robots.away": "missing"}))


def test_robots_of_a_field_dont_charge(tmp_path):
    from feasibee.field.plan import Plan
    from feasibee.field.supervisor import Field

    plan = Plan(
        in_world(), 1, 0, True, hz=10.0, drift=0.0, jitter=0.0, delay=0.0, faults=(), patience=1.0, wait=1.0
    )
    with pytest.raises(FeasibeeError, match=r"robots.work = 12: robots of a field don't charge"):
        Field(plan, tmp_path, print)

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
from tests.places import rectangle

WORK, CHARGE = 12, 5
DOCK = {"arena.boundary": "walls", "robots.zone": "dock", "place.cell": 0.5}
DOCK |= {"place.zones": {"dock": rectangle(0.0, 0.0, 2.0, 2.0)}}
FULL = {
    **{**DOCK, "place.zones": {"dock": rectangle(0.0, 0.0, 3.0, 3.0)}, "robots.avoid_collisions": True},
    **{"robots.contact": "deflect", "robots.speed": 0.02, "robots.diameter": 1.1, "robots.count": 4},
}
"""Robots that hardly leave their dock, which is as good as full."""


def in_world(**changes):
    battery = {"robots.work": WORK, "robots.charge": CHARGE}
    return Scenario().replace({"arena.side": 10.0, "run.steps": 60, **battery, **changes})


def watched(scenario):
    """Return whether each robot was in the arena at each step from 1 to 60: shape (steps, robots)."""
    swarm = Swarm(scenario, 5)
    return np.array([swarm.present for _ in range(60) if swarm.advance() is None])


def spans_of(there):
    """Return for each robot how long it was in the arena and away, in turn."""
    return [[(here, len(list(span))) for here, span in groupby(own)] for own in there.T]


def test_robots_work_and_charge_in_turn_and_their_first_batteries_differ():
    spans = spans_of(watched(in_world(**{"robots.count": 300, "arena.side": 40.0})))
    assert {span for own in spans for span in own[1:-1]} <= {(True, WORK), (False, CHARGE)}
    firsts = Counter(own[0][1] for own in spans if own[0][0])
    assert set(firsts) == set(range(1, WORK + 1))
    assert max(firsts.values()) < 2.2 * 300 / WORK


def test_robots_wait_until_a_place_in_their_zone_is_free():
    spans = spans_of(watched(in_world(**FULL)))
    assert max(steps for own in spans for here, steps in own if not here) > CHARGE


def test_a_robot_that_charges_keeps_its_mind_and_comes_back_to_the_zone():
    plain = reference.Swarm(in_world(**DOCK), 5, 0)
    kept, back = {}, 0
    for _ in range(40):
        plain.step()
        for robot in plain.away:
            own = robot.mind
            mind = own.phase_left, own.opinion, dict(own._latest), own.robots_seen[:]
            assert kept.setdefault(robot, mind) == mind
        for robot in [each for each in kept if each not in plain.away]:
            del kept[robot]
            back += 1
            x, y = plain.world.in_units(robot.place)
            assert max(x, y) <= 2.0 + plain.scenario.robots.speed  # it has made a step since
    assert back > 20


def test_robots_that_charge_count_and_keep_their_vote():
    runs = simulate(in_world(**{"decision.strategy": "census", "tasks.count": 18}), runs=3, seed=1)
    assert (runs.feasible_at_end.values + runs.infeasible_at_end.values == 20).all()
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


NEITHER = {"robots.work": None, "robots.charge": None}


@pytest.mark.parametrize(
    ("changes", "path", "rule"),
    [
        ({"robots.charge": None}, "robots.work", "needs robots.charge"),
        ({"robots.work": None}, "robots.charge", "needs robots.work"),
        ({**NEITHER, "robots.away": "missing"}, "robots.away", "needs robots.work"),
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
@pytest.mark.parametrize(
    ("name", "steps"),
    [("turns", turns.quiet_steps), ("quiet-census", lambda setting: quiet_census.quiet_steps(20, setting))],
)
def test_a_quiet_time_has_as_many_steps_at_work_as_without_batteries(name, steps, work, charge):
    """The longest time without so many steps at work begins with a charge."""
    plain = Scenario().replace({"decision.strategy": name, "robots.know_count": True})
    wait = steps(plain.replace({"robots.work": work, "robots.charge": charge}).setting)
    needed = steps(plain.setting)
    cycle = ([0] * charge + [1] * work) * math.ceil(wait / (work + charge))
    assert needed <= sum(cycle[:wait]) <= needed + work
    assert wait == math.ceil(needed * (1 + charge / work) + charge)


def test_which_robots_count_is_told():
    assert who_counts(Scenario()) == ""
    assert "all 20, of which 14.1 are at work" in who_counts(in_world())
    assert "those at work, on average 14.1 of 20" in who_counts(in_world(**{"robots.away": "missing"}))


def test_robots_of_a_field_dont_charge(tmp_path):
    from feasibee.field.plan import FieldPlan
    from feasibee.field.supervisor import Field

    pace = {"hz": 10.0, "drift": 0.0, "jitter": 0.0, "delay": 0.0, "faults": (), "patience": 1.0, "wait": 1.0}
    with pytest.raises(FeasibeeError, match=r"robots.work = 12: robots of a field don't charge"):
        Field(FieldPlan(in_world(), 1, 0, True, **pace), tmp_path, print)

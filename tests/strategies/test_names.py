"""Quiet census and turns: how long robots wait, lies, what a message costs, and how often swarms are right.

What single robots of both do in each step is compared with C in tests/robot/test_knowledge_same_as_python.py.
"""

from __future__ import annotations

import math
from functools import partial

import pytest
from minds import declared, knowing

from feasibee import Scenario
from feasibee.robot.knowledge import Knowledge
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.strategies.certified import NEVER, steps_for
from feasibee.strategies.contract import Mind, Thing
from feasibee.strategies.quiet_census import lasting, patience, quiet_steps
from feasibee.strategies.turns import patience_in_turn

robot_of = partial(knowing, "quiet-census")
turning = partial(knowing, "turns")


def robots(*numbers):
    return [Thing(True, number, 0, 0) for number in numbers]


def tasks(*numbers):
    return [Thing(False, number, 0, 0) for number in numbers]


def message_of(*numbers, like, robots_too=()):
    """Return the message of a robot that knows these tasks, and these robots in addition to itself."""
    other = Knowledge(like._strategy, like.me._replace(id=19))
    other.observe([*tasks(*numbers), *robots(*robots_too)])
    return other.message()


# --- Declaring ---


def test_the_quiet_time_is_c_over_the_rate_of_finding_a_task():
    """20 robots sweep strips 4 units wide, 1 unit a step, half of the time: 40 of 400 square units."""
    setting = robot_of().me.setting
    assert steps_for(10.0, 20, setting) == 100
    assert steps_for(10.0, 10, setting) == 200
    assert steps_for(10.0, 20, setting._replace(exploration=10.0, dissemination=30.0)) == 200
    assert steps_for(10.0, 20, setting._replace(width=40.0, height=40.0)) == 400
    assert steps_for(10.0, 20, setting._replace(walled=True)) == 200
    assert steps_for(10.0, 20, setting._replace(sight=1.0, speed=0.5)) == 400
    assert steps_for(10.0, 20, setting._replace(exploration=30.0, dissemination=10.0)) == 200
    assert steps_for(10.0, 20, setting._replace(radio=1.0)) == 200
    assert steps_for(10.0, 20, setting._replace(speed=0.0)) == steps_for(math.inf, 20, setting) == NEVER


@pytest.mark.parametrize(
    ("walled", "mean_run", "steps"), [(False, 10.0, 239), (True, 10.0, 977), (True, 1.0, 4955)]
)
def test_the_quiet_time_is_longer_in_long_arenas_and_where_robots_turn_often(walled, mean_run, steps):
    setting = robot_of().me.setting._replace(width=100.0, height=4.0, walled=walled, mean_run=mean_run)
    assert quiet_steps(20, setting) == steps


LONG = {"arena.side": [100, 4], "run.steps": 500}
CHARGING = {"robots.work": 300, "robots.charge": 100}
ENDS = {"run.stop_at_declarations": True}
WORLDS = [  # strategy, world, runs, seed, how many may be wrong; share wrong without the longer time
    ("quiet-census", LONG, 100, 5, 0),  # 0.25
    ("quiet-census", {**LONG, "arena.boundary": "walls"}, 100, 5, 0),  # 0.71
    ("turns", LONG, 100, 5, 0),  # 0.06
    ("quiet-census", {**CHARGING, **ENDS, "robots.know_count": False}, 60, 4, 0),  # 0.5
    ("turns", {**CHARGING, **ENDS}, 60, 4, 0),  # 0.5
    ("quiet-census", {"radio.delay": 100, "run.steps": 600, **ENDS}, 300, 5, 2),  # 0.07
    pytest.param(
        *("quiet-census", {"sensing.view": 60.0, "run.steps": 1500, **ENDS}, 400, 5, 4),
        marks=pytest.mark.slow,
    ),
]


@pytest.mark.parametrize(("strategy", "changes", "runs", "seed", "wrong"), WORLDS)
def test_robots_wait_long_enough_for_one_task_too_many(strategy, changes, runs, seed, wrong):
    """In long arenas, with batteries, late messages and a narrow view."""
    world = {"decision.strategy": strategy, "robots.know_count": True, "tasks.count": 21, **changes}
    record = simulate_record(Scenario().replace(world), Runs(runs, seed))
    assert (record.declared_feasible > 0).sum() <= wrong


def test_swarms_in_a_hurry_declare_sooner_and_rightly():
    """Half of the swarms declare infeasible 8 steps sooner, and feasible 9, in 4,000 runs."""
    steps = {}
    for tasks in (20, 21):
        for hurry in (0.0, 0.3):
            world = {"decision.strategy": "quiet-census", "robots.know_count": True, "tasks.count": tasks}
            parameters = {"hurry": hurry, "lasts": 20.0 if hurry else 0.0}
            scenario = Scenario().replace({**world, "decision.parameters": parameters, "run.steps": 300})
            record = simulate_record(scenario, Runs(100, 8))
            assert ((record.declared_feasible == 20) == (tasks == 20)).all()
            steps[tasks, hurry] = record.declare_step.mean()
    assert steps[20, 0.3] < steps[20, 0.0] - 3
    assert steps[21, 0.3] < steps[21, 0.0] - 3


@pytest.mark.parametrize(("tasks", "lasts"), [(0, 0.0), (29, 0.0), (30, 20.0), (40, 20.0)])
def test_a_robot_in_a_hurry_broadcasts_for_one_step_only(tasks, lasts):
    """With 100 robots, as long as it knows fewer than 30 tasks: a mean of 0 steps is rounded up."""
    mind = Mind(0, 0.5, 100 / (100 + tasks), 1, [], [0.0, 0.0, 0.3, 20.0])
    assert lasting(mind, 10.0) == lasts


def test_more_robots_and_more_liars_take_more_patience():
    alone = [patience(n, 0) for n in (1, 5, 20, 50, 200)]
    assert alone == sorted(alone)
    assert patience(20, 0) == pytest.approx(10, abs=0.01)
    with_liars = [patience(20, f) for f in range(10)]
    assert with_liars == sorted(with_liars)
    assert with_liars[9] < math.inf == patience(20, 10)
    assert with_liars[1] == pytest.approx(with_liars[0] + 1.0)  # a task is found once more for a liar of 20


def test_the_fewer_names_a_message_holds_the_longer_is_the_quiet_time():
    """Of 20 robots, 1.4 times as long for one name, 1.2 times for two, and no longer for all."""
    waits = [patience_in_turn(turning(names=names).me.setting) / patience(20, 0) for names in (1, 2, -1)]
    assert waits == pytest.approx([1.4, 1.2, 1.0])


# --- Believing ---


def test_more_liars_than_robots_are_as_many_as_robots():
    own = robot_of(tolerates=1e300)
    assert len(own.words) == 2 + 2 + 2 * 31 * 20


# --- Lies ---


@pytest.mark.parametrize(
    ("counts", "colluding", "feasible", "added"),
    [
        ((20, 17), False, 0, range(17, 38)),
        ((20, 17), True, 0, range(17, 21)),
        ((20, 20), True, 0, range(20, 21)),
        ((20, 21), False, 1, ()),
    ],
)
def test_a_lie_for_infeasible_adds_tasks_to_what_is_known(counts, colluding, feasible, added):
    own = robot_of(counts, colluding=colluding)
    own.observe(tasks(2, 9))
    assert own.lie(own.message(), feasible, ()) == message_of(2, 9, *added, like=own)


def test_a_colluding_lie_for_feasible_denies_all():
    own = robot_of((20, 21), colluding=True)
    own.observe(tasks(2, 9))
    assert own.lie(own.message(), 1, ()) == (0, 0)


def test_a_colluding_census_denies_what_it_knows_only_for_feasible():
    own = knowing("census", (20, 17), colluding=True)
    own.observe(tasks(2, 9))
    honest = own.message()
    own.observe(tasks(17))
    assert own.lie(honest, 0, tasks(17)) == own.message()
    assert sum(each.bit_count() for each in own.lie(honest, 1, robots(20))) == 1


@pytest.mark.parametrize(
    ("colluding", "robots_told"), [(True, range(20, 23)), (False, (0, 1, *range(20, 43)))]
)
def test_without_n_a_lie_for_feasible_is_robots(colluding, robots_told):
    own = robot_of((20, 23), colluding=colluding, knows_count=False)
    own.observe(robots(1))
    words = [0, 0]
    for k in robots_told:
        words[k // 31] |= 1 << k % 31
    assert own.lie(own.message(), 1, ()) == (*words, 0, 0)


@pytest.mark.parametrize(
    ("name", "parameters", "steps"), [("quiet-census", {}, 350), ("turns", {"names": 6.0}, 450)]
)
@pytest.mark.parametrize("tolerates", [0, 1])
def test_one_colluding_robot_makes_twenty_wrong_unless_one_is_tolerated(name, parameters, steps, tolerates):
    changes = {"decision.strategy": name, "decision.parameters": {**parameters, "tolerates": tolerates}}
    liar = {"faults.byzantine": 0.05, "faults.byzantine_says": "colluding"}
    scenario = Scenario().replace({**changes, **liar, "robots.know_count": True, "run.steps": steps})
    record = simulate_record(scenario, Runs(20, 1))
    assert (record.declared_feasible == 19 * tolerates).all()
    assert (record.declared_infeasible == 19 * (1 - tolerates)).all()


# --- Messages and scenarios ---


def test_a_message_costs_its_names():
    own = robot_of()
    assert own.bits(own.message()) == 1
    own.observe([*tasks(0, 1, 30, 31), *robots(4)])
    assert own.bits(own.message()) == 4 * 33 + 1
    unaware = robot_of(knows_count=False)
    unaware.observe([*tasks(0, 1), *robots(4)])
    assert unaware.bits(unaware.message()) == 2 * (1 + 5) + 1 + 2 * 33 + 1
    certified = robot_of(tolerates=1.0)
    assert certified.bits(certified.message()) == 5 + 1


def test_a_robot_is_not_silent_and_has_no_opinion_until_it_is_sure():
    quiet = {"decision.strategy": "quiet-census", "decision.parameters": {"quiet": 50.0}, "run.steps": 200}
    record = simulate_record(Scenario().replace(quiet), Runs(5, 1), curves=True)
    held = record.feasible_count + record.infeasible_count
    assert (held[:, :50].max(), held[:, -1].min()) == (0, 20)
    assert (record.bits_sent > 100 * 20 * 200).all()


def named(*names, name_bits=20):
    """Return tasks of these names; their hashes have arbitrary low bits."""
    return [Thing(False, k, 0, (name << (32 - name_bits)) + 5) for k, name in enumerate(names)]


# --- Turns: Bits ---


@pytest.mark.parametrize(("names", "length"), [(0.0, 6), (1.0, 26), (3.0, 66), (6.0, 126)])
def test_a_message_of_names_in_turn_has_one_length(names, length):
    own = turning(names=names)
    for seen in ((), named(3, 4, 5, 6)):
        own.observe(seen)
        assert own.bits(own.message()) == length
    assert turning(names=3.0, name_bits=19.0).bits((0, 0, 0, 0)) == 63


# --- Turns: Lies ---


def honest(names, **parameters):
    own = turning((20, 18), names=names, **parameters)
    own.observe(named(100, 200))
    return own


def test_a_lie_for_infeasible_is_an_alarm_and_invented_names():
    """As many as are needed, in turn; all colluding robots tell the same."""
    own = honest(1.0, colluding=True)
    told = set()
    for _ in range(12):
        alarm, name = own.lie(own.message(), 0, ())
        assert alarm == 1
        told.add(name)
        own.end_step(explores=True)
    assert len(told) == 21 - 18
    assert not told & {0, 100, 200}
    everything = honest(-1.0, colluding=True)
    alarm, *names = everything.lie(everything.message(), 0, ())
    assert (alarm, {*names}) == (1, {0, 100, 200, *told})
    assert names[:5] == sorted(names[:5])


def test_without_collusion_the_lie_invents_one_name_more_than_robots():
    own = honest(-1.0)
    alarm, *names = own.lie(own.message(), 0, ())
    assert alarm == 1
    assert len(set(names)) == 21
    assert names == sorted(names)


def test_a_lie_for_feasible_denies_the_alarm_and_colluding_all_names():
    for colluding, expected in ((False, (0, 100, 200)), (True, (0, 0, 0))):
        own = honest(2.0, colluding=colluding)
        message = (1, *own.message()[1:])
        assert own.lie(message, 1, ()) == expected


# --- Turns: The quiet time ---


def test_a_robot_that_can_not_be_sure_waits_for_ever():
    for names in (0.0, 1.0):
        own = turning((4, 4), tolerates=2.0, names=names)
        assert own.words[2] == NEVER
        assert declared(own, 50) == -1


# --- Turns: Second looks ---


@pytest.mark.parametrize(("looks", "right"), [(1.0, 0), (2.0, 50)])
def test_false_sightings_have_no_second_look(looks, right):
    """With a false sighting in twenty steps all swarms see too many tasks; with second looks none does."""
    scenario = Scenario(
        robots={"know_count": True},
        sensing={"false_tasks": 0.05},
        decision={"strategy": "turns", "parameters": {"looks": looks}},
    )
    record = simulate_record(scenario, Runs(50, 1))
    assert ((record.declared_feasible == 20) & (record.declared_infeasible == 0)).sum() == right

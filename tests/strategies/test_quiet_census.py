"""Quiet census and certified propagation: who is believed, when a robot is sure, what a message costs."""

from __future__ import annotations

import math
from functools import partial

import pytest
from minds import declared, knowing

from feasibee import Scenario, ScenarioError
from feasibee.robot.knowledge import Knowledge
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.strategies import STRATEGIES
from feasibee.strategies.certified import NEVER, steps_for
from feasibee.strategies.contract import Mind, Thing
from feasibee.strategies.quiet_census import patience, quiet_steps

robot_of = partial(knowing, "quiet-census")


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


def test_with_n_known_one_task_more_is_infeasible_at_once():
    own = robot_of(quiet=1000.0)
    own.observe(tasks(*range(20)))
    assert declared(own, 1) == -1
    own.merge(message_of(20, like=own), 19)
    assert declared(own, 1) == 0


@pytest.mark.parametrize("news", [0, 7])
def test_feasible_is_declared_after_the_quiet_time_without_a_new_name(news):
    own = robot_of(quiet=30.0)
    own.observe(tasks(*range(5)))
    assert declared(own, news) == -1
    own.merge(message_of(4, 5, like=own), 19)
    assert declared(own, 30) == -1
    own.merge(message_of(1, 5, like=own), 19)  # nothing new
    assert declared(own, 1) == 1


@pytest.mark.parametrize(("tasks_known", "answer"), [(3, 1), (4, 1), (5, 0)])
def test_without_n_either_answer_takes_the_quiet_time_over_robots_and_tasks(tasks_known, answer):
    """The robot itself and three others are known."""
    own = robot_of(quiet=30.0, knows_count=False)
    own.observe([*tasks(*range(tasks_known)), *robots(1, 2)])
    assert declared(own, 20) == -1
    own.merge(message_of(0, like=own), 19)  # the sender's name is news
    assert declared(own, 30) == -1
    assert own.counted() == ([4], [tasks_known])
    assert declared(own, 1) == answer


def test_robots_in_sight_are_no_news_to_a_robot_that_knows_n():
    own = robot_of(quiet=10.0)
    assert declared(own, 5) == -1
    own.observe(robots(1, 2, 3))
    assert declared(own, 6) == 1
    assert own.counted() == ([20], [0])


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
    ("changes", "steps"),
    [
        ({"width": 100.0, "height": 4.0}, 80 + 0.5 * (0.24 * 921.6 + 96)),
        ({"width": 4.0, "height": 100.0}, 80 + 0.5 * (0.24 * 921.6 + 96)),
        ({"width": 100.0, "height": 4.0, "speed": 0.5}, 160 + 0.5 * (0.24 * 3686.4 + 192)),
        ({"width": 100.0, "height": 4.0, "dissemination": 30.0}, 160 + (0.24 * 921.6 + 96)),
        ({"width": 100.0, "height": 4.0, "walled": True}, 160 + 0.5 * (0.96 * 921.6 + 0.3 * 96 * 26)),
        ({"mean_run": 1.0}, 80 + 0.5 * 0.24 * 512),
        ({"mean_run": 0.1}, 80 + 0.5 * 0.48 * 512),
        ({"mean_run": 0.1, "sight": 4.0}, 80 + 0.5 * 0.48 * 512),
        ({"mean_run": 100.0}, 100),
    ],
)
def test_the_quiet_time_grows_where_a_robot_takes_long_to_get_anywhere(changes, steps):
    """In arenas of 400 square units: long ones, ones with walls, or with robots that turn often."""
    assert steps_for(10.0, 20, robot_of().me.setting._replace(**changes)) == math.ceil(steps)


@pytest.mark.parametrize(
    ("strategy", "boundary"), [("quiet-census", "torus"), ("quiet-census", "walls"), ("turns", "torus")]
)
def test_robots_wait_long_enough_in_long_arenas(strategy, boundary):
    """With the quiet time of a square arena, 0.25, 0.71 and 0.06 of these swarms are wrong."""
    world = {"arena.side": [100, 4], "arena.boundary": boundary, "robots.know_count": True}
    changes = {"decision.strategy": strategy, "tasks.count": 21, "run.steps": 500}
    record = simulate_record(Scenario().replace(world | changes), Runs(100, 5))
    assert (record.declared_feasible == 0).all()


@pytest.mark.parametrize(
    ("tasks_known", "hurry", "lasts", "steps"),
    [(0, 0, 0, 10), (0, 0.3, 0, 0), (5, 0.3, 20, 0), (6, 0.3, 0, 10), (6, 0.3, 20, 20), (21, 2, 5, 0)],
)
def test_a_robot_in_a_hurry_broadcasts_for_one_step_as_long_as_it_knows_little(
    tasks_known, hurry, lasts, steps
):
    mind = Mind(-1, 0.5, 20 / (20 + tasks_known), 1, [], [0.0, 0.0, hurry, lasts])
    assert STRATEGIES["quiet-census"].lasting(mind, 10.0) == steps


@pytest.mark.parametrize(("lasts", "steps"), [(0.0, 100), (20.0, 100), (40.0, 150), (80.0, 250)])
def test_long_broadcasts_make_the_quiet_time_longer(lasts, steps):
    """Robots that explore less find tasks more rarely: 20 robots, n known, 10 steps of exploration."""
    setting = robot_of().me.setting._replace(parameters=(0.0, 0.0, 0.3, lasts))
    assert quiet_steps(20, setting) == steps


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


def test_more_robots_and_more_liars_take_more_patience():
    alone = [patience(n, 0) for n in (1, 5, 20, 50, 200)]
    assert alone == sorted(alone)
    assert patience(20, 0) == pytest.approx(10, abs=0.01)
    with_liars = [patience(20, f) for f in range(10)]
    assert with_liars == sorted(with_liars)
    assert with_liars[9] < math.inf == patience(20, 10)


# --- Believing ---


@pytest.mark.parametrize("f", [1, 2, 3])
@pytest.mark.parametrize("known", [True, False])
def test_a_name_counts_from_f_plus_1_different_neighbours_and_not_before(f, known):
    own = robot_of(tolerates=float(f), knows_count=known)
    invented = message_of(33, like=own, robots_too=(25,))
    before = own.message()
    for _ in range(3):
        for sender in range(1, f + 1):
            own.merge(invented, sender)
    assert own.message() == before
    assert own.counted() == ([20 if known else 1], [0])
    own.merge(invented, f + 1)
    assert own.message() != before
    assert own.counted() == ([20 if known else 3], [1])


def test_a_name_in_sight_counts_at_once_and_is_passed_on():
    own, other = robot_of(tolerates=2.0), robot_of(tolerates=2.0, number=1)
    own.observe(tasks(3, 31))
    assert own.counted() == ([20], [2])
    other.merge(own.message(), 0)
    assert other.counted() == ([20], [0])
    assert other.message() == (0, 0)


def test_each_name_has_its_own_list_of_tellers():
    own = robot_of(tolerates=1.0)
    own.merge(message_of(0, 30, like=own), 5)
    own.merge(message_of(1, 31, 40, like=own), 6)
    assert own.counted() == ([20], [0])
    own.merge(message_of(0, 31, like=own), 7)
    assert own.message() == message_of(0, 31, like=own)


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
@pytest.mark.parametrize(("f", "ok"), [(0, 0), (1, 1)])
def test_one_colluding_robot_makes_twenty_wrong_unless_one_is_tolerated(name, parameters, steps, f, ok):
    changes = {"decision.strategy": name, "decision.parameters": {**parameters, "tolerates": float(f)}}
    liar = {"faults.byzantine": 0.05, "faults.byzantine_says": "colluding"}
    scenario = Scenario().replace({**changes, **liar, "robots.know_count": True, "run.steps": steps})
    record = simulate_record(scenario, Runs(20, 1))
    assert ((record.declared_feasible == 19) == ok).all()
    assert ((record.declared_infeasible == 19) != ok).all()


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
    scenario = Scenario().replace(
        {"decision.strategy": "quiet-census", "decision.parameters": {"quiet": 50.0}, "run.steps": 200}
    )
    record = simulate_record(scenario, Runs(5, 1), curves=True)
    assert (record.feasible_count + record.infeasible_count)[:, :50].max() == 0
    assert (record.feasible_count + record.infeasible_count)[:, -1].min() == 20
    assert (record.bits_sent > 100 * 20 * 200).all()


@pytest.mark.parametrize(("name", "known"), [("quiet-census", False), ("turns", True), ("totals", True)])
def test_strategies_that_compare_two_numbers_refuse_classes(name, known):
    robots = {"know_count": known, "classes": [{"name": "a", "count": 3, "skills": ["x"]}]}
    with pytest.raises(ScenarioError, match=rf"robots\.classes = '1 classes': {name} compares one number"):
        Scenario(decision={"strategy": name}, robots=robots)

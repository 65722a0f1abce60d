"""Quiet census and turns: names in turn, whom to believe, when a robot is sure, what a message costs."""

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
from feasibee.strategies.turns import patience_alone, patience_in_turn

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


def named(*names, name_bits=20):
    """Return tasks of these names; their hashes have arbitrary low bits."""
    return [Thing(False, k, 0, (name << (32 - name_bits)) + 5) for k, name in enumerate(names)]


def turns_of(robot, messages):
    """Return what a robot says in so many messages, less the alarm."""
    return [robot.message()[1:] for _ in range(messages)]


# --- Turns: Names in turn ---


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (1.0, [(3,), (5,), (9,), (3,), (5,)]),
        (2.0, [(3, 5), (9, 3), (5, 9)]),
        (4.0, [(3, 5, 9, 0), (3, 5, 9, 0)]),
        (0.0, [(), ()]),
    ],
)
def test_names_have_their_turn_in_order(names, said):
    own = turning(names=names)
    assert turns_of(own, 1) == [(0,) * int(names)]
    own.observe(named(9, 3, 5, 3))
    assert turns_of(own, len(said)) == said


def test_a_new_name_costs_no_other_its_turn():
    own = turning()
    own.observe(named(10, 20, 30))
    assert turns_of(own, 2) == [(10,), (20,)]
    own.observe(named(5, 25))
    assert turns_of(own, 6) == [(25,), (30,), (5,), (10,), (20,), (25,)]


def test_all_names_are_sent_up_to_one_more_than_robots():
    own = turning((4, 9), names=-1.0)
    own.observe(named(7, 2, 9))
    assert own.message() == (0, 2, 7, 9, 0, 0)
    own.observe(named(1, 8, 3))
    assert own.message() == (1, 1, 2, 7, 8, 9)


def test_a_name_is_the_first_bits_of_the_hash_and_never_0():
    own = turning(names=-1.0, name_bits=4.0)
    own.observe([Thing(False, 0, 0, 0xF0000000), Thing(False, 1, 0, 0xFFFFFFFF), Thing(False, 2, 0, 99)])
    assert own.message()[1:4] == (1, 15, 0)
    own.observe([Thing(True, 0, 0, 0x50000000)])  # a robot has no part in it
    assert own.counted() == ([20], [2])


# --- Turns: The alarm ---


def test_one_name_more_than_robots_is_an_alarm_and_infeasible():
    own = turning((3, 9), quiet=1000.0)
    own.observe(named(1, 2))
    own.merge((0, 3), 1)
    assert declared(own, 1) == -1
    assert own.counted() == ([3], [3])
    own.merge((0, 4), 1)
    assert own.message()[0] == 1
    assert declared(own, 1) == 0


@pytest.mark.parametrize("f", [0, 1, 2])
def test_an_alarm_counts_from_f_plus_1_different_neighbours(f):
    own = turning(tolerates=float(f), names=0.0)
    for _ in range(3):
        for sender in range(1, f + 1):
            own.merge((1,), sender)
    assert (own.message(), own.counted()) == ((0,), ([20], [0]))
    own.merge((1,), f + 1)
    assert (own.message(), own.counted()) == ((1,), ([20], [21]))
    assert declared(own, 1) == 0


@pytest.mark.parametrize("f", [1, 2])
def test_in_turns_a_name_counts_from_f_plus_1_different_neighbours_and_not_before(f):
    own = turning(tolerates=float(f), names=3.0)
    for _ in range(3):
        for sender in range(1, f + 1):
            own.merge((0, 77, 5, 0), sender)
    assert (own.message(), own.counted()) == ((0, 0, 0, 0), ([20], [0]))
    own.observe(named(5))
    own.merge((0, 77, 8, 0), f + 1)
    assert (own.message(), own.counted()) == ((0, 5, 77, 0), ([20], [2]))


def test_names_that_wait_fill_their_room_and_no_more():
    """Two robots and two tasks: 2 + 3 names, as many as a scenario with liars can have."""
    own = turning((2, 2), tolerates=1.0)
    for name in range(1, 9):
        own.merge((0, name), 1)
    assert own.counted() == ([2], [0])
    for name in range(1, 9):
        own.merge((0, name), 0)
    assert own.counted() == ([2], [3])  # of 1 to 5; the third raises the alarm


# --- Turns: Bits ---


def test_a_message_of_names_in_turn_has_one_length():
    for names, length in ((0.0, 6), (1.0, 26), (3.0, 66), (6.0, 126)):
        own = turning(names=names)
        assert own.bits(own.message()) == length
        own.observe(named(3, 4, 5, 6))
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


def test_in_turns_feasible_is_declared_after_the_quiet_time_without_a_new_name():
    own = turning(quiet=30.0)
    assert declared(own, 20) == -1
    own.observe(named(8))
    assert declared(own, 30) == -1
    own.merge((0, 8), 1)
    assert declared(own, 1) == 1


def test_alone_the_time_runs_from_the_start():
    own = turning(quiet=30.0, names=0.0)
    assert declared(own, 25) == -1
    own.observe(named(8))
    assert declared(own, 6) == 1


def test_the_fewer_names_a_message_holds_the_longer_is_the_quiet_time():
    times = [patience_in_turn(turning(names=names).me.setting) for names in (-1.0, 21.0, 6.0, 3.0, 1.0)]
    assert times == sorted(times)
    assert times[0] == patience(20, 0)
    assert times[-1] == pytest.approx(1.4 * patience(20, 0))
    assert patience_in_turn(turning(tolerates=1.0).me.setting) == pytest.approx(1.8 * patience(20, 1))
    assert patience_in_turn(turning(tolerates=10.0).me.setting) == math.inf


@pytest.mark.parametrize(("n", "f"), [(1, 0), (5, 0), (20, 0), (20, 3), (200, 0)])
def test_alone_it_lasts_until_f_plus_1_robots_have_seen_all(n, f):
    """In all but 1 run of 1,000, if each sighting is as likely in every step."""
    setting = turning((n, n), names=0.0, tolerates=float(f)).me.setting
    visits = patience_alone(setting) - patience(n, f) / n
    sees_all = (1 - math.exp(-visits)) ** (n + 1)
    none_in_a_group = (1 - sees_all) ** ((n - f) / (f + 1))
    assert (f + 1) * none_in_a_group == pytest.approx(0.001)


def test_a_robot_that_can_not_be_sure_waits_for_ever():
    for names in (0.0, 1.0):
        own = turning((4, 4), tolerates=2.0, names=names)
        assert own.words[2] == NEVER
        assert declared(own, 50) == -1


# --- Turns: Second looks ---


@pytest.mark.parametrize("tolerates", [0.0, 1.0])
def test_a_name_counts_at_the_second_look(tolerates):
    own = turning(names=-1.0, looks=2.0, tolerates=tolerates)
    own.observe(named(7, 9))
    assert own.counted()[1] == [0]
    own.observe(named(9))
    assert own.counted()[1] == [1]
    own.observe(named(9, 7))
    assert own.counted()[1] == [2]


def test_sixteen_names_wait_for_a_second_look():
    own = turning(looks=2.0)
    own.observe(named(*range(1, 18)))
    own.observe(named(1))  # the seventeenth has taken its place, and now it takes that of 2
    assert own.counted()[1] == [0]
    own.observe(named(17, 3, 1, 2))
    assert own.counted()[1] == [3]


def test_names_that_count_take_no_place():
    own = turning(looks=2.0)
    for name in range(1, 18):
        own.merge((0, name), 3)
    own.observe(named(100, *range(1, 18), 100))
    assert own.counted()[1] == [18]


def test_waiting_names_do_not_reach_the_names_seen_once():
    own = turning((2, 2), looks=2.0, tolerates=1.0)  # five ids, so five names can wait
    own.observe(named(100))
    for name in range(1, 12):
        own.merge((0, name), 3)
    own.observe(named(100))
    assert own.counted()[1] == [1]


def test_names_heard_need_no_second_look():
    own = turning(looks=2.0)
    own.merge((0, 7), 3)
    assert own.counted()[1] == [1]


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

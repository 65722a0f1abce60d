"""Turns: names in turn, the alarm, messages to the bit, lies, and when a robot is sure."""

from __future__ import annotations

import math
from functools import partial

import pytest
from minds import declared, knowing

from feasibee import Scenario
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.strategies import STRATEGIES
from feasibee.strategies.certified import NEVER
from feasibee.strategies.contract import Thing
from feasibee.strategies.quiet_census import patience
from feasibee.strategies.turns import patience_alone, patience_in_turn

robot_of = partial(knowing, "turns")


def tasks(*names, name_bits=20):
    """Return tasks of these names; their hashes have arbitrary low bits."""
    return [Thing(False, k, 0, (name << (32 - name_bits)) + 5) for k, name in enumerate(names)]


def turns_of(robot, messages):
    """Return what a robot says in so many messages, less the alarm."""
    return [robot.message()[1:] for _ in range(messages)]


# --- Names in turn ---


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
    own = robot_of(names=names)
    assert turns_of(own, 1) == [(0,) * int(names)]
    own.observe(tasks(9, 3, 5, 3))
    assert turns_of(own, len(said)) == said


def test_a_new_name_costs_no_other_its_turn():
    own = robot_of()
    own.observe(tasks(10, 20, 30))
    assert turns_of(own, 2) == [(10,), (20,)]
    own.observe(tasks(5, 25))
    assert turns_of(own, 6) == [(25,), (30,), (5,), (10,), (20,), (25,)]


def test_all_names_are_sent_up_to_one_more_than_robots():
    own = robot_of((4, 9), names=-1.0)
    own.observe(tasks(7, 2, 9))
    assert own.message() == (0, 2, 7, 9, 0, 0)
    own.observe(tasks(1, 8, 3))
    assert own.message() == (1, 1, 2, 7, 8, 9)


def test_a_name_is_the_first_bits_of_the_hash_and_never_0():
    own = robot_of(names=-1.0, name_bits=4.0)
    own.observe([Thing(False, 0, 0, 0xF0000000), Thing(False, 1, 0, 0xFFFFFFFF), Thing(False, 2, 0, 99)])
    assert own.message()[1:4] == (1, 15, 0)
    own.observe([Thing(True, 0, 0, 0x50000000)])  # a robot has no part in it
    assert own.counted() == ([20], [2])


# --- The alarm ---


def test_one_name_more_than_robots_is_an_alarm_and_infeasible():
    own = robot_of((3, 9), quiet=1000.0)
    own.observe(tasks(1, 2))
    own.merge((0, 3), 1)
    assert declared(own, 1) == -1
    assert own.counted() == ([3], [3])
    own.merge((0, 4), 1)
    assert own.message()[0] == 1
    assert declared(own, 1) == 0


@pytest.mark.parametrize("f", [0, 1, 2])
def test_an_alarm_counts_from_f_plus_1_different_neighbours(f):
    own = robot_of(tolerates=float(f), names=0.0)
    for _ in range(3):
        for sender in range(1, f + 1):
            own.merge((1,), sender)
    assert (own.message(), own.counted()) == ((0,), ([20], [0]))
    own.merge((1,), f + 1)
    assert (own.message(), own.counted()) == ((1,), ([20], [21]))
    assert declared(own, 1) == 0


@pytest.mark.parametrize("f", [1, 2])
def test_a_name_counts_from_f_plus_1_different_neighbours_and_not_before(f):
    own = robot_of(tolerates=float(f), names=3.0)
    for _ in range(3):
        for sender in range(1, f + 1):
            own.merge((0, 77, 5, 0), sender)
    assert (own.message(), own.counted()) == ((0, 0, 0, 0), ([20], [0]))
    own.observe(tasks(5))
    own.merge((0, 77, 8, 0), f + 1)
    assert (own.message(), own.counted()) == ((0, 5, 77, 0), ([20], [2]))


def test_names_that_wait_fill_their_room_and_no_more():
    """Two robots and two tasks: 2 + 3 names, as many as a scenario with liars can have."""
    own = robot_of((2, 2), tolerates=1.0)
    for name in range(1, 9):
        own.merge((0, name), 1)
    assert own.counted() == ([2], [0])
    for name in range(1, 9):
        own.merge((0, name), 0)
    assert own.counted() == ([2], [3])  # of 1 to 5; the third raises the alarm


@pytest.mark.parametrize(("tasks_known", "opinion"), [(0, 1), (3, 1), (4, 0)])
def test_the_opinion_is_feasible_until_there_are_more_names_than_robots(tasks_known, opinion):
    own = robot_of((3, 9))
    own.observe(tasks(*range(1, tasks_known + 1)))
    (known,), (found,) = own.counted()
    quality = STRATEGIES["turns"].quality(known, found)
    assert int(quality >= 0.5) == opinion


# --- Bits ---


def test_a_message_of_names_in_turn_has_one_length():
    for names, length in ((0.0, 6), (1.0, 26), (3.0, 66), (6.0, 126)):
        own = robot_of(names=names)
        assert own.bits(own.message()) == length
        own.observe(tasks(3, 4, 5, 6))
        assert own.bits(own.message()) == length
    assert robot_of(names=3.0, name_bits=19.0).bits((0, 0, 0, 0)) == 63


# --- Lies ---


def honest(names, **parameters):
    own = robot_of((20, 18), names=names, **parameters)
    own.observe(tasks(100, 200))
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


# --- The quiet time ---


def test_feasible_is_declared_after_the_quiet_time_without_a_new_name():
    own = robot_of(quiet=30.0)
    assert declared(own, 20) == -1
    own.observe(tasks(8))
    assert declared(own, 30) == -1
    own.merge((0, 8), 1)
    assert declared(own, 1) == 1


def test_alone_the_time_runs_from_the_start():
    own = robot_of(quiet=30.0, names=0.0)
    assert declared(own, 25) == -1
    own.observe(tasks(8))
    assert declared(own, 6) == 1


def test_the_fewer_names_a_message_holds_the_longer_is_the_quiet_time():
    times = [patience_in_turn(robot_of(names=names).me.setting) for names in (-1.0, 21.0, 6.0, 3.0, 1.0)]
    assert times == sorted(times)
    assert times[0] == patience(20, 0)
    assert times[-1] == pytest.approx(1.4 * patience(20, 0))
    assert patience_in_turn(robot_of(tolerates=1.0).me.setting) == pytest.approx(1.8 * patience(20, 1))
    assert patience_in_turn(robot_of(tolerates=10.0).me.setting) == math.inf


@pytest.mark.parametrize(("n", "f"), [(1, 0), (5, 0), (20, 0), (20, 3), (200, 0)])
def test_alone_it_lasts_until_f_plus_1_robots_have_seen_all(n, f):
    """In all but 1 run of 1,000, if each sighting is as likely in every step."""
    setting = robot_of((n, n), names=0.0, tolerates=float(f)).me.setting
    visits = patience_alone(setting) - patience(n, f) / n
    sees_all = (1 - math.exp(-visits)) ** (n + 1)
    none_in_a_group = (1 - sees_all) ** ((n - f) / (f + 1))
    assert (f + 1) * none_in_a_group == pytest.approx(0.001)


def test_a_robot_that_can_not_be_sure_waits_for_ever():
    for names in (0.0, 1.0):
        own = robot_of((4, 4), tolerates=2.0, names=names)
        assert own.words[2] == NEVER
        assert declared(own, 50) == -1


# --- Second looks ---


@pytest.mark.parametrize("tolerates", [0.0, 1.0])
def test_a_name_counts_at_the_second_look(tolerates):
    own = robot_of(names=-1.0, looks=2.0, tolerates=tolerates)
    own.observe(tasks(7, 9))
    assert own.counted()[1] == [0]
    own.observe(tasks(9))
    assert own.counted()[1] == [1]
    own.observe(tasks(9, 7))
    assert own.counted()[1] == [2]


def test_sixteen_names_wait_for_a_second_look():
    own = robot_of(looks=2.0)
    own.observe(tasks(*range(1, 18)))
    own.observe(tasks(1))  # the seventeenth has taken its place, and now it takes that of 2
    assert own.counted()[1] == [0]
    own.observe(tasks(17, 3, 1, 2))
    assert own.counted()[1] == [3]


def test_names_that_count_take_no_place():
    own = robot_of(looks=2.0)
    for name in range(1, 18):
        own.merge((0, name), 3)
    own.observe(tasks(100, *range(1, 18), 100))
    assert own.counted()[1] == [18]


def test_waiting_names_do_not_reach_the_names_seen_once():
    own = robot_of((2, 2), looks=2.0, tolerates=1.0)  # five ids, so five names can wait
    own.observe(tasks(100))
    for name in range(1, 12):
        own.merge((0, name), 3)
    own.observe(tasks(100))
    assert own.counted()[1] == [1]


def test_names_heard_need_no_second_look():
    own = robot_of(looks=2.0)
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

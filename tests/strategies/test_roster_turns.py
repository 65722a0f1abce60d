"""Roster in turns: versions and their wrap-around, whose turn it is, messages to the bit, and lies."""

from __future__ import annotations

import numpy as np
import pytest
from minds import counted, knowing, right_by_step, step

from feasibee.strategies.contract import Thing

FAR = (15.0, 15.0)
TASK, ROBOT = 0, 1


def robot_of(counts=(20, 30), **changes):
    """Return the knowledge of a robot that gives up a task after one look."""
    return knowing("roster-turns", counts, **{"looks": 1.0, **changes})


def task(x=5.0, y=5.0):
    return Thing(False, 0, 0, 0, x, y)


def name_at(x, y, name_bits=20):
    """Return the name of a position, by another way than the strategy's: a grid of 2**10 by 2**10 cells."""
    columns, rows = 2 ** ((name_bits + 1) // 2), 2 ** (name_bits // 2)
    return max(int(x * columns / 20) * rows + int(y * rows / 20), 1)


def said(own, messages):
    """Return the names and versions in the next messages."""
    return [own.message()[1:] for _ in range(messages)]


# --- Versions ---


@pytest.mark.parametrize("own", range(4))
@pytest.mark.parametrize("heard", range(4))
def test_the_newer_of_two_versions_counts(own, heard):
    """The next one is newer, the one before is older; of two that differ by 2 the larger is taken."""
    robot = robot_of(place=FAR)
    name = name_at(5.0, 5.0)
    robot.merge((TASK, name, own), 1)
    robot.merge((TASK, name, heard), 1)
    newer = heard if (heard - own) % 4 == 1 else max(own, heard) if (heard - own) % 2 == 0 else own
    assert (name, newer) in said(robot, 4)
    assert counted(robot)[1] == newer % 2
    for _ in range(2):  # in the other order two robots agree
        robot.merge((TASK, name, own), 1)
    assert (name, newer) in said(robot, 4)


def test_versions_wrap_around_as_a_task_comes_and_goes():
    """Robots meet after each change, so that none misses two in a row."""
    near, far = robot_of(number=1), robot_of(number=2, place=FAR)
    versions = []
    for visit in range(9):
        step(near, *([task()] if visit % 2 == 0 else []))
        message = next(each for each in (near.message() for _ in range(4)) if each[1])
        versions.append(message[2])
        far.merge(message, 1)
        assert counted(far)[1] == counted(near)[1] == (visit + 1) % 2
    assert versions == [1, 2, 3, 0, 1, 2, 3, 0, 1]


def test_a_robot_that_missed_two_changes_is_corrected_by_its_next_look():
    """It holds version 1 of a task that came back as 3 and has vanished as 0: that seems older than 1."""
    late, name = robot_of(), name_at(5.0, 5.0)
    late.merge((TASK, name, 1), 1)
    late.merge((TASK, name, 0), 1)
    assert counted(late)[1] == 1
    step(late)
    assert counted(late)[1] == 0


@pytest.mark.parametrize("steps", [3, 300])
def test_an_outdated_version_is_answered_though_it_is_old_news(steps):
    own, name = robot_of(place=FAR), name_at(2.0, 1.0)
    for k in range(8):
        own.merge((TASK, name_at(1.0 + k, 1.0), 3), 1)
    for _ in range(steps):
        own.end_step(explores=False)
    assert [each for each, _ in said(own, 8)].count(name) <= 1
    own.merge((TASK, name, 2), 1)
    assert counted(own)[1] == 8
    assert [each for each, _ in said(own, 8)].count(name) >= 2


@pytest.mark.parametrize(
    ("name_bits", "away", "tasks"),
    [(20, 1.85, 0), (20, 1.9, 1), (10, 1.5, 1), (8, 0.7, 0), (8, 1.3, 1), (6, 0.2, 1), (4, 0.0, 1)],
)
def test_a_task_has_vanished_only_if_all_of_its_cell_is_in_sight(name_bits, away, tasks):
    """Of 8 bits cells are 1.25 wide, of 6 bits 2.5: a robot seldom sees all of such a cell."""
    for x, y in ((5.0 + away, 5.0), (5.0, 5.0 + away)):
        own = robot_of(name_bits=float(name_bits))
        step(own, task(x, y))
        step(own)
        assert counted(own)[1] == tasks


# --- Names and turns ---


@pytest.mark.parametrize("name_bits", [7, 15, 20])
def test_names_are_cells_of_a_grid_and_never_0(name_bits):
    points = np.random.default_rng(1).uniform(0, 20, (40, 2)).tolist()
    for x, y in [*points, [0.0, 0.0], [19.9999999, 19.9999999]]:
        own = robot_of(name_bits=float(name_bits))
        own.observe([task(x, y)])
        message = next(each for each in (own.message() for _ in range(4)) if each[1])
        assert message == (TASK, name_at(x, y, name_bits), 1)
        assert message[1] < 2**name_bits


def test_things_come_in_any_order():
    things = [task(1.0 + k, 5.0) for k in range(7)]
    orders = [things, things[::-1], things[3:] + things[:3]]
    for steps in (0, 5):
        robots = [robot_of() for _ in orders]
        for own, order in zip(robots, orders, strict=True):
            step(own, task(4.5, 6.0), task(1.5, 6.0), explores=False)
            own.message()
            for _ in range(steps):
                own.message()
                own.end_step(explores=True)
            own.observe(order)
        assert robots[0].words == robots[1].words == robots[2].words
        assert said(robots[0], 40) == said(robots[1], 40) == said(robots[2], 40)


def test_two_tasks_in_one_cell_are_one():
    own = robot_of(name_bits=8.0)
    step(own, task(5.1, 5.1), task(5.9, 5.9))
    assert counted(own)[1] == 1


def test_changes_have_every_other_message_and_names_their_turn():
    own = robot_of(place=FAR)
    names = [name_at(1.0 + k, 3.0) for k in range(5)]
    for name in names:
        own.merge((TASK, name, 1), 1)
    told = [name for name, _ in said(own, 20)]
    changes = {each for each in told[::2] if each in names[3:]} | {
        each for each in told[1::2] if each in names[3:]
    }
    assert changes == {*names[3:]}
    assert all(told.count(name) == 2 for name in names[:3])
    assert all(told.count(name) == 7 for name in names[3:])


def test_old_changes_are_no_news():
    own = robot_of(place=FAR)
    names = [name_at(1.0 + k, 3.0) for k in range(5)]
    for name in names:
        own.merge((TASK, name, 1), 1)
    for _ in range(201):
        own.end_step(explores=False)
    told = [name for name, _ in said(own, 20)]
    assert all(told.count(name) == 4 for name in names)


def test_vanished_tasks_are_told_for_four_quiet_times():
    own = robot_of(place=FAR)
    own.merge((TASK, 7, 2), 1)
    own.merge((TASK, 8, 1), 1)
    for _ in range(400):
        own.end_step(explores=False)
    assert {(7, 2), (8, 1)} == {*said(own, 8)}
    for _ in range(2):
        own.end_step(explores=False)
    assert {(8, 1)} == {*said(own, 8)}


def test_there_is_room_for_as_many_names_as_ids_of_tasks():
    own = robot_of((3, 4), place=FAR)
    assert own.me.setting.task_ids == 8
    for name in range(1, 20):
        own.merge((TASK, name, 1), 1)
    assert counted(own)[1] == 8


# --- Robots ---


def test_robots_are_listed_with_ages_unless_n_is_known():
    own = robot_of(knows_count=False, place=FAR, step=700, robot_timeout=30.0)
    own.merge((ROBOT, 1 + 4, 12), 3)
    own.judge()
    assert counted(own) == (3, 0)  # itself, 3 and 4
    for _ in range(5):
        step(own, explores=False)
    robots = {message[1:] for message in (own.message() for _ in range(12)) if message[0] == ROBOT}
    assert robots == {(1 + 3, 5), (1 + 4, 17)}
    for _ in range(15):
        step(own, explores=False)
    assert counted(own) == (2, 0)
    assert {message[1] for message in (own.message() for _ in range(12))} == {0, 1 + 3}
    own.merge((ROBOT, 1 + 4, 32), 3)
    own.judge()
    assert counted(own) == (2, 0)  # the report is too old
    own.merge((ROBOT, 1 + 4, 2), 3)
    own.judge()
    assert counted(own) == (3, 0)


def test_six_quiet_times_are_the_timeout_of_robots():
    assert robot_of(knows_count=True).words[6] == 6 * robot_of(knows_count=True).words[5] == 600


# --- Bits ---


@pytest.mark.parametrize(
    ("name_bits", "known", "tolerates", "length"),
    [
        (20, True, 0, 22),
        (15, True, 0, 17),
        (15, True, 1, 22),
        (20, False, 0, 5 + 1 + 22),
        (15, False, 1, 5 + 1 + 17),
        (8, False, 0, 5 + 1 + 5 + 12),
    ],
)
def test_every_message_has_the_same_length(name_bits, known, tolerates, length):
    own = robot_of(name_bits=name_bits, knows_count=known, tolerates=tolerates)
    step(own, task(), Thing(True, 4, 0, 0))
    assert {own.bits(own.message()) for _ in range(9)} == {length}


# --- Lies ---


def test_a_lie_for_feasible_makes_each_task_vanish():
    liar, own = robot_of(number=1), robot_of(place=FAR)
    step(liar, task(5.0, 5.0), task(5.0, 6.0), explores=False)
    for _ in range(8):
        own.merge(liar.message(), 1)
    assert counted(own)[1] == 2
    for _ in range(8):
        own.merge(liar.lie(liar.message(), 1, ()), 1)
        liar.end_step(explores=False)
    assert counted(own)[1] == 0


def test_a_lie_for_infeasible_brings_tasks_back_and_invents_one_more_than_robots():
    liar, own = robot_of((4, 6), number=1), robot_of((4, 6), place=FAR)
    step(liar, task(5.0, 5.0))
    step(liar, explores=False)
    own.merge(next(each for each in (liar.message() for _ in range(4)) if each[1]), 1)
    assert counted(own)[1] == 0
    for _ in range(24):
        own.merge(liar.lie(liar.message(), 0, ()), 1)
        liar.end_step(explores=False)
    assert counted(own)[1] == 1 + 5


def test_a_lie_for_feasible_invents_robots_if_n_is_learnt():
    liar, own = robot_of((4, 6), number=1, knows_count=False), robot_of((4, 6), knows_count=False)
    for _ in range(24):
        own.merge(liar.lie(liar.message(), 1, ()), 1)
        liar.end_step(explores=False)
        own.end_step(explores=False)
    assert counted(own)[0] == 2 + 6


@pytest.mark.parametrize("f", [1, 2])
def test_a_version_counts_from_f_plus_1_different_neighbours(f):
    own, name = robot_of(tolerates=float(f), place=FAR), name_at(5.0, 5.0)
    for version, present in ((1, 1), (2, 0), (3, 1), (0, 0), (1, 1)):
        for sender in [*range(1, f + 1), *range(1, f + 1)]:
            own.merge((TASK, name, version), sender)
            own.merge((TASK, name, (version + 1) % 4), 9)  # what one robot forges in between
            assert counted(own)[1] == 1 - present
        own.merge((TASK, name, version), f + 1)
        assert counted(own)[1] == present


def test_a_robot_counts_from_f_plus_1_different_neighbours():
    own = robot_of(tolerates=1.0, knows_count=False, step=50)
    for _ in range(3):
        own.merge((ROBOT, 1 + 4, 3), 7)
    assert counted(own)[0] == 2
    own.merge((ROBOT, 1 + 4, 9), 8)
    assert counted(own)[0] == 4


# --- Swarms ---


@pytest.mark.parametrize(("f", "ok"), [(0.0, 0), (1.0, 1)])
def test_one_colluding_robot_makes_most_swarms_wrong_unless_one_is_tolerated(f, ok):
    liar = {"faults.byzantine": 0.05, "faults.byzantine_says": "colluding"}
    liar["robots.know_count"] = True
    right = right_by_step("roster-turns", 20, 21, **liar, **{"decision.parameters": {"tolerates": f}})
    assert abs(right[:, 800:].mean() - ok) < 0.1

"""Rosters: ages, tombstones, messages, lies, and worlds that change."""

from __future__ import annotations

import numpy as np
import pytest
from minds import counted, knowing, right_by_step, step, task

from feasibee.strategies.contract import Thing
from feasibee.strategies.quiet_census import patience

FAR = (15.0, 15.0)

QUIET = patience(20, 0) * 10  # steps: in the paper's arena, robots find a place every 10 steps


def robot_of(counts=(20, 30), **changes):
    """Return the knowledge of a robot that gives up a task after one look."""
    return knowing("roster", counts, **{"looks": 1.0, "knows_count": False, **changes})


def robot(number):
    return Thing(True, number, 0, 77 * number)


# --- What is known, and for how long ---


NEAR, CORNER = task(0), {"place": (19.5, 0.5)}
SEEN = {  # parameters; what is in sight in each step, and what is counted after it: robots and tasks
    "itself and what it sees": (
        {},
        [
            ([], (1, 0)),
            ([robot(3), robot(4), task(0), task(1)], (3, 2)),
            ([task(0), task(1), task(2, 5.0, 5.5), task(3, 4.0, 5.0)], (3, 4)),
        ],
    ),
    "a task is absent after one look in vain, and there again": (
        *({}, [([NEAR], (1, 1)), ([], (1, 0)), ([NEAR], (1, 1))]),
    ),
    "or after three in a row": (
        {"looks": 3.0},
        [*(2 * [([NEAR], (1, 1)), ([], (1, 1)), ([], (1, 1))]), ([], (1, 0))],
    ),
    "sight goes round a torus": (CORNER, [([task(0, 0.5, 19.5)], (1, 1)), ([], (1, 0))]),
    "but not through walls": ({**CORNER, "walled": True}, [([task(0, 0.5, 19.5)], (1, 1)), ([], (1, 1))]),
    **{
        f"at {place} a robot is {'sure' if absent else 'not sure'} of absence": (
            *({"walled": walled}, [([task(0, *place)], (1, 1)), ([], (1, 1 - absent))]),
        )
        for place, walled, absent in [
            ((5.0, 6.8), False, True),
            ((5.0, 6.95), False, False),  # so near the end of its sight
            ((5.0, 7.5), False, False),
            ((19.0, 0.5), False, False),
            ((0.2, 5.0), True, False),
        ]
    },
}


@pytest.mark.parametrize("case", SEEN)
def test_a_robot_counts_what_it_has_seen_and_not_missed(case):
    parameters, steps = SEEN[case]
    own = robot_of(**parameters)
    for things, expected in steps:
        assert step(own, *things) == (expected[0] >= expected[1])
        assert counted(own) == expected


def test_what_was_given_up_stays_so_when_robots_leave_and_timeouts_grow():
    """Of 20 robots only two stay; what was last there 180 steps ago would else be there again."""
    own = robot_of()
    step(own, *map(robot, range(1, 20)), task(0), explores=False)
    assert counted(own) == (20, 1)
    ages = []
    for age in range(1, 240):
        step(own, robot(1), explores=False)
        ages.append((age, *counted(own)))
    assert [own.words[k] > 400 for k in (0, 1)] == [True, True]
    message = own.message()
    assert [message[1 + number] for number in range(own.me.setting.robot_ids)] == [1, 3] + 48 * [0]
    other = robot_of(number=1, robot_timeout=999.0, task_timeout=999.0)
    step(other, robot(0), *map(robot, range(2, 20)), task(0), explores=False)
    for _ in range(239):
        step(other, explores=False)
    assert counted(other) == (20, 1)
    own.merge(other.message(), 1)
    own.judge()
    assert counted(own) == (2, 1)  # what it had given up was not seen later than that
    assert [robots for _, robots, _ in ages] == [20] * int(1.5 * QUIET + 1) + [2] * (238 - int(1.5 * QUIET))


def test_timeouts_are_two_and_one_and_a_half_quiet_times():
    own = robot_of((20, 9), knows_count=True)
    assert own.words[:2] == [pytest.approx(2 * QUIET, abs=1), pytest.approx(1.5 * QUIET, abs=1)]
    assert robot_of((20, 9), knows_count=True, task_timeout=33.2).words[0] == 34


# --- Tombstones ---


def entry_of(own, number):
    """Return age and presence of a task in the next message; None if it isn't in it."""
    message = own.message()
    word = message[1 + (0 if own.me.setting.knows_count else own.me.setting.robot_ids) + number]
    return None if word == 0 else ((word - 1) // 2, word % 2 == 1)


def test_looks_in_vain_begin_anew_after_a_tombstone():
    own = robot_of(step=100, looks=2.0)
    step(own, task(0))
    step(own)
    step(own)
    assert counted(own)[1] == 0
    own.merge(reported(True, 1), 1)
    step(own)
    assert counted(own)[1] == 2 - 1
    step(own)
    assert counted(own)[1] == 0


def test_a_tombstone_is_no_new_report_at_each_look():
    own = robot_of(task_timeout=50.0)
    step(own, task(0))
    for age in range(1, 52):
        step(own)  # the first one finds the task absent
        assert entry_of(own, 0) == ((age, False) if age <= 50 else None)


# --- Messages ---


def test_the_younger_report_counts_and_at_the_same_age_that_it_is_there():
    for ages, there in (((3, 5), 1), ((5, 3), 0), ((4, 4), 1)):
        reports = [reported(present, age) for present, age in zip((True, False), ages, strict=True)]
        for order in (reports, reports[::-1]):
            own = robot_of(step=90, place=FAR)
            for message in order:
                own.merge(message, 1)
            assert counted(own)[1] == there


def reported(there, age, number=0):
    """Return the message of a robot on a task that it found there or absent so many steps ago."""
    other = robot_of(step=40, number=1)
    step(other, task(number), explores=not there)
    if not there:
        step(other, explores=False)
    for _ in range(age - 1):
        step(other, explores=False)
    return other.message()


def test_a_robot_looks_for_tasks_that_it_only_heard_of():
    own = robot_of(step=60)
    own.merge(reported(True, 1), 1)
    assert counted(own)[1] == 1
    step(own)
    assert counted(own)[1] == 0


@pytest.mark.parametrize("tolerates", [0.0, 1.0])
@pytest.mark.parametrize("known", [True, False])
def test_a_message_costs_what_it_takes_to_write(known, tolerates):
    timeouts = {"task_timeout": 200.0, "robot_timeout": 150.0}
    own = robot_of((20, 6), knows_count=known, tolerates=tolerates, **timeouts)
    step(own, task(1), task(2, 4.0, 4.0), task(3, 19.9, 19.9), robot(3), robot(19), explores=False)
    for _ in range(9):
        step(own, task(1), explores=False)
    names = 3 * (1 + 32 + 1 + 8) + 1 + (0 if known else 3 * (1 + 5 + 8) + 1)
    assert own.bits(own.message()) == 5 + (5 if tolerates else 0) + names


# --- Lies ---


@pytest.mark.parametrize("colluding", [False, True])
def test_a_lie_for_feasible_buries_all_tasks_and_invents_robots(colluding):
    liar, own = robot_of((3, 5), number=1, colluding=colluding), robot_of((3, 5), place=FAR)
    step(liar, *(task(number) for number in range(5)))
    own.merge(liar.message(), 1)
    assert counted(own) == (2, 5)
    own.end_step(explores=True)
    liar.end_step(explores=True)
    own.merge(liar.lie(liar.message(), 1, ()), 1)
    assert counted(own) == (2 + (2 if colluding else 5), 0)


@pytest.mark.parametrize(("colluding", "tasks"), [(False, 2 + 4), (True, 4)])
def test_a_lie_for_infeasible_wakes_the_dead_and_invents_tasks(colluding, tasks):
    """Of robots that collude, as many as make one task more than the 3 robots."""
    liar, own = robot_of((3, 5), number=1, colluding=colluding), robot_of((3, 5), place=FAR)
    step(liar, task(0), task(1))
    step(liar, task(0))
    own.merge(liar.message(), 1)
    assert counted(own)[1] == 1
    own.end_step(explores=True)
    own.merge(liar.lie(liar.message(), 0, ()), 1)
    assert counted(own)[1] == tasks


@pytest.mark.parametrize("f", [1, 2])
def test_a_report_counts_from_f_plus_1_different_neighbours_with_the_oldest_age(f):
    own = robot_of(step=100, tolerates=float(f), place=FAR)
    for _ in range(2):
        for sender in range(1, f + 1):
            own.merge(reported(True, 3 * sender), sender)
    assert counted(own) == (1 + f, 0)
    own.merge(reported(True, 1), f + 1)
    own.judge()
    assert counted(own) == (2 + f, 1)
    assert entry_of(own, 0) == (3 * f, True)


@pytest.mark.parametrize(
    "reports", [((1, 9), (2, 8), (3, 4), (4, 6), (1, 2), (3, 7)), ((1, 2), (1, 9), (3, 4)), ((3, 4), (1, 2))]
)
def test_of_many_reports_the_latest_of_f_plus_1_senders_are_kept(reports):
    own = robot_of(step=100, tolerates=1.0, place=FAR)
    for sender, age in reports:
        own.merge(reported(True, age), sender)
    own.judge()
    assert entry_of(own, 0) == (4, True)  # of 1 two steps ago, and of 3 four steps ago


def test_a_sighting_and_a_tombstone_do_not_vouch_for_each_other():
    own = robot_of(step=100, tolerates=1.0, place=FAR)
    own.merge(reported(True, 5), 1)
    own.merge(reported(False, 3), 2)
    own.judge()
    assert entry_of(own, 0) is None


# --- Swarms ---


@pytest.mark.parametrize(("before", "after", "within"), [(20, 21, 90), (21, 20, 110), (40, 10, 90)])
def test_a_change_is_noticed_and_nothing_else(before, after, within):
    right = right_by_step("roster", before, after)
    assert right[:, 300:500].all()
    assert not right[:, 500].any()
    assert right[:, 500 + within :].all()


def test_robots_that_leave_are_noticed():
    right = right_by_step("roster", 18, 18, robots=-5)
    assert right[:, 300:500].all()
    assert right[:, 500 + 180 :].all()


@pytest.mark.parametrize(("f", "ok"), [(0.0, 0), (1.0, 1)])
def test_one_colluding_robot_makes_twenty_wrong_unless_one_is_tolerated(f, ok):
    liar = {"faults.byzantine": 0.05, "faults.byzantine_says": "colluding"}
    right = right_by_step("roster", 25, 16, **liar, **{"decision.parameters": {"tolerates": f}})
    assert (np.concatenate([right[:, 400:500], right[:, 700:]], 1) == ok).all()

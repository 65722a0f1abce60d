"""Fading and fading votes: their messages, their rules against direct sums, tau, and what swarms notice."""

from __future__ import annotations

import math

import numpy as np
import pytest
from minds import knowing, right_by_step

from feasibee import Scenario
from feasibee.scenario.runs import Runs
from feasibee.scenario.setting import setting_from
from feasibee.simulation.ensemble import simulate_record
from feasibee.strategies import STRATEGIES, fading
from feasibee.strategies.contract import Me, Thing

ROBOT, TASK = Thing(True, 3, 0, 7), Thing(False, 4, 0, 7)
PAPER = setting_from((20, 20), (0, 0), False, None, tuple(fading.PARAMETERS.values()))
SHARE = math.pi * 4 / 400


def named(number=0, name="fading", counts=(20, 30), parameters=None, **changes):
    """Return the knowledge of a robot that explores."""
    return knowing(name, counts, number, mark=1, **(parameters or {}), **changes)


def live(robot, things=(), explores=True, steps=1):
    """Let a robot see the same things in some steps; return its last opinion."""
    opinion = -1
    for _ in range(steps):
        robot.me = robot.me._replace(explores=explores)
        if explores:
            robot.observe(things)
        opinion = robot.judge()
        robot.end_step(explores)
    return opinion


def told(looks, tasks, tau=100.0):
    """Return the message whose numbers are the nearest to these."""
    codes = [
        min(range(256), key=lambda code, number=number: abs(fading.value_of(code) * tau - number))
        for number in (looks, tasks)
    ]
    return (codes[0] << 8 | codes[1],)


def heard(message, tau=100.0):
    """Return the numbers of a message."""
    return fading.value_of(message[0] >> 8 & 255) * tau, fading.value_of(message[0] & 255) * tau


TAU = {"tau": 100.0}

# --- The message ---


def test_numbers_are_sent_in_steps_of_4_percent():
    values = [fading.value_of(code) for code in range(256)]
    assert values[:2] == [0.0, 1 / 2048]
    np.testing.assert_allclose(np.array(values[2:]) / values[1:-1], 1.04)
    for code in range(256):
        assert {fading.code_of(values[code] * 1.00001, chance) for chance in (0.01, 0.5, 0.99)} == {code}


@pytest.mark.parametrize("value", [1e-5, 4e-4, 0.01, 0.3, 0.777, 2.0])
def test_rounding_at_random_has_no_bias(value):
    chances = (np.arange(10_000) + 0.5) / 10_000
    sent = [fading.value_of(fading.code_of(value, chance)) for chance in chances]
    assert np.mean(sent) == pytest.approx(value, rel=1e-3)
    assert len(set(sent)) <= 2


def test_the_chances_of_robots_and_steps_are_uniform_and_unlike():
    generator = np.random.default_rng(1)
    marks = generator.integers(0, 2**32, 30).tolist()
    chances = np.array(
        [
            [fading.chance_of(Me(0, 0, mark, step, [], PAPER), which) for step in range(100)]
            for mark in marks
            for which in (0, 1)
        ]
    )
    assert np.histogram(chances, 10, (0, 1))[0] == pytest.approx(600, abs=5 * math.sqrt(600))
    assert abs(np.corrcoef(chances[::2].ravel(), chances[1::2].ravel())[0, 1]) < 5 / math.sqrt(3000)
    assert abs(np.corrcoef(chances[:, 1:].ravel(), chances[:, :-1].ravel())[0, 1]) < 5 / math.sqrt(6000)


def test_counts_too_large_for_a_message_keep_their_ratio():
    robot = named(parameters=TAU)
    robot.me.memory[fading.LOOKS], robot.me.memory[fading.TASKS] = 100.0, 50_000.0
    looks, tasks = heard(robot.message())
    assert tasks / looks == pytest.approx(500, rel=0.09)


def test_a_message_holds_the_robots_own_counts_only():
    robot = named(parameters={"tau": 1e6})
    robot.merge(told(70, 80, 1e6), 3)
    live(robot, 2 * [TASK], steps=600)
    looks, tasks = heard(robot.message(), 1e6)
    assert (looks, tasks) == pytest.approx((600, 1200), rel=0.05)


def test_pairs_of_two_time_constants_are_sent_in_turn():
    robot = named(parameters={"tau": 200.0, "fast": 20.0})
    live(robot, 2 * [TASK], steps=400)
    kinds = []
    for _ in range(4):
        message = robot.message()
        kinds.append(message[0] >> 16)
        tau = 20.0 if message[0] >> 16 else 200.0
        assert heard(message, tau)[0] == pytest.approx(tau, rel=0.2)
        live(robot, 2 * [TASK])
    assert kinds == [0, 1, 0, 1]


# --- The rule ---


def test_the_estimate_is_the_mean_of_the_tasks_in_sight_over_the_share_in_sight():
    robot = named(parameters={"tau": 1e6})
    live(robot, [TASK], steps=30)
    live(robot, steps=70)
    assert fading.tasks_of(robot.words, 0, robot.me) == pytest.approx(0.3 / SHARE, rel=1e-3)
    live(robot, 50 * [TASK], explores=False, steps=9)  # what isn't seen isn't counted, steps neither
    assert fading.tasks_of(robot.words, 0, robot.me) == pytest.approx(0.3 / SHARE, rel=1e-3)


def test_counts_are_of_about_the_last_tau_steps():
    robot = named(parameters=TAU)
    live(robot, 3 * [TASK], steps=2000)
    live(robot, steps=50)
    weight = 0.99**50
    assert robot.me.memory[fading.LOOKS] == pytest.approx(99, rel=1e-6)
    assert fading.tasks_of(robot.words, 0, robot.me) == pytest.approx(3 * weight / SHARE, rel=1e-6)


def test_sums_of_rows_are_those_of_the_latest_of_each_id_whenever_it_came():
    generator = np.random.default_rng(2)
    robot, rows = named(parameters=TAU), {}
    for step in range(300):
        for sender in generator.integers(1, 20, generator.integers(0, 4)).tolist():
            message = told(*generator.uniform(1, 80, 2))
            robot.merge(message, sender)
            rows[sender] = step, *heard(message)
        live(robot, explores=False)
    expected = np.sum([np.array(row) * 0.99 ** (300 - came) for came, *row in rows.values()], axis=0)
    sums = robot.me.memory[fading.ALL_LOOKS : fading.ALL_TASKS + 1]
    np.testing.assert_allclose(sums, expected, rtol=1e-9)
    assert robot.words[fading.HEARD] == len(rows)


@pytest.mark.parametrize(("tasks", "opinion"), [(10, 1), (20, 1), (21, 0), (40, 0)])
def test_the_tasks_are_feasible_up_to_as_many_as_robots(tasks, opinion):
    """To one task in 20: the rows of 19 others are rounded by 2 % at most."""
    robot = named(parameters={"tau": 1e4})
    live(robot, steps=1)
    for sender in range(1, 20):
        robot.merge(told(4000, 4000 * tasks * SHARE, 1e4), sender)
    assert live(robot) == opinion
    assert robot.gap() == tasks - 20


def test_a_robot_that_has_seen_nothing_keeps_its_opinion():
    robot = named()
    assert robot.judge() == 1  # it has looked once, and seen no task
    robot = named()
    robot.me = robot.me._replace(explores=False)
    assert robot.judge() == -1
    assert robot.gap() == 0
    assert robot.counted() == ([0], [0])
    assert named(parameters={"ratio": 1.0}).judge() == -1


@pytest.mark.parametrize("size", [(20.0, 20.0), (90.0, 30.0)])
@pytest.mark.parametrize("known", [True, False])
def test_with_the_ratio_the_robots_in_sight_stand_for_the_area(size, known):
    """A robot sees as many tasks as others: m = n - 1 = 9, whatever the area."""
    parameters = {**TAU, "ratio": 1.0}
    robot = named(counts=(10, 30), parameters=parameters, knows_count=known, size=size)
    for sender in range(1, 10):
        robot.merge(told(50, 50), sender)
    assert live(robot, [ROBOT, TASK]) == 1
    assert fading.tasks_of(robot.words, 0, robot.me) == pytest.approx(9, rel=1e-3)
    assert robot.gap() == -1
    assert live(robot, 3 * [TASK], steps=60) == 0


@pytest.mark.parametrize("name", ["fading", "fading-votes"])
def test_a_robot_does_not_count_itself_in_sight(name):
    robot = named(3, name, parameters={**TAU, "ratio": 1.0})
    live(robot, [ROBOT, Thing(True, 2, 0, 7)])
    assert robot.me.memory[fading.LOOKS] == pytest.approx(0.99)


def test_without_n_a_robot_counts_itself_and_the_ids_that_it_heard():
    robot = named(parameters=TAU, knows_count=False)
    for sender, tasks in ((1, 9), (2, 9), (3, 9)):
        robot.merge(told(50, 50 * tasks * SHARE), sender)
    live(robot, explores=False)
    assert robot.gap() == 9 - 4
    assert robot.judge() == 0


def test_without_n_robots_not_heard_for_long_are_forgotten():
    robot = named(parameters=TAU, knows_count=False)
    for sender in range(1, 10):
        robot.merge(told(50, 50), sender)
    live(robot, steps=580)
    assert robot.words[fading.HEARD] == 9
    robot.merge(told(50, 50), 4)
    live(robot, steps=45)
    assert robot.words[fading.HEARD] == 1
    looks = robot.me.memory[fading.ALL_LOOKS]
    assert looks == pytest.approx(heard(told(50, 50))[0] * 0.99**45, rel=1e-6)


def test_the_fast_pair_decides_if_the_estimates_differ_by_half():
    robot = named(parameters={"tau": 1000.0, "fast": 10.0})
    live(robot, [TASK, *[TASK][:0]], steps=5000)
    slow = fading.tasks_of(robot.words, 0, robot.me)
    assert fading.estimate(robot.words, robot.me) == slow == pytest.approx(1 / SHARE)
    live(robot, 2 * [TASK], steps=3)
    assert fading.estimate(robot.words, robot.me) == fading.tasks_of(robot.words, 0, robot.me)
    live(robot, 2 * [TASK], steps=30)
    assert fading.estimate(robot.words, robot.me) == fading.tasks_of(robot.words, 5, robot.me)


def test_within_walls_the_share_in_sight_is_that_of_two_random_places():
    generator = np.random.default_rng(3)
    sides = np.array([12.0, 20.0])
    one, other = (generator.uniform(0, 1, (400_000, 2)) * sides for _ in range(2))
    share = (np.hypot(*(one - other).T) <= 3.0).mean()
    setting = PAPER._replace(width=12.0, height=20.0, sight=3.0, walled=True)
    assert fading.share_in_sight(setting) == pytest.approx(share, rel=0.02)
    assert fading.share_in_sight(PAPER) == SHARE


@pytest.mark.parametrize("name", ["fading", "fading-votes"])
def test_a_sensor_that_misses_sees_a_smaller_share(name):
    half = PAPER._replace(parameters=(0.0, 0.2, 0.0, 0.5, 0.0)[: len(STRATEGIES[name].parameters)])
    assert fading.share_in_sight(half) == SHARE / 2
    assert list(STRATEGIES[name].parameters)[fading.SEES] == "sees"


def test_the_rule_for_tau_solves_its_equation():
    tau = fading.tau_of(PAPER)
    assert round(tau) == 107
    kappa, hears = 20 * 0.5 * 2 * 2 / 400, 4 / math.pi * 0.5 * 2 * 2 / 400
    pooled = 1.2 * 2.4**2 / (2 * kappa * 20 * 0.2**2)
    assert tau**2 * hears == pytest.approx(pooled * (1 + tau * hears))
    tau = fading.tau_of(PAPER._replace(parameters=(0.0, 0.2, 1.0, 1.0, 0.0)))
    assert round(tau) == 167
    assert tau == fading.tau_of(PAPER._replace(walled=True))
    assert tau**2 * hears == pytest.approx(2 * pooled * (1 + tau * hears))


@pytest.mark.parametrize(
    ("changes", "tau"),
    [
        ({"speed": 0.0}, 1e6),
        ({"parameters": (0.0, 0.0, 0.0, 1.0, 0.0)}, 1e6),
        ({"parameters": (0.3, 0.2, 0.0, 1.0, 0.0)}, 1.0),
        ({"parameters": (50.0, 0.2, 1.0, 1.0, 0.0)}, 50.0),
        ({"knows_count": False}, 120.0),
        ({"knows_count": False, "parameters": (0.0, 0.2, 1.0, 1.0, 0.0)}, 150.0),
    ],
)
def test_tau_is_bounded_and_can_be_set(changes, tau):
    assert fading.tau_of(PAPER._replace(**changes)) == tau


def test_lies_deny_tasks_or_double_them_and_collusion_is_as_large_as_can_be():
    robot = named(parameters=TAU)
    live(robot, [TASK], steps=100)
    honest = robot.message()
    looks, tasks = heard(honest)
    assert heard(robot.lie(honest, 1, [])) == (looks, 0.0)
    assert heard(robot.lie(honest, 0, [])) == pytest.approx((looks, 2.03 * tasks), rel=0.01)
    colluder = named(parameters=TAU, colluding=True)
    most = 100 * fading.value_of(255)
    assert heard(colluder.lie(honest, 1, [])) == (most, 0.0)
    seen, tasks = heard(colluder.lie(honest, 0, []))
    assert (seen, tasks) == (pytest.approx(60, rel=0.04), most)  # 1.2 times the mean of 50


@pytest.mark.parametrize("ratio", [0.0, 1.0])
def test_bounded_robots_believe_nothing_far_from_what_an_honest_one_sends(ratio):
    """Up to 1.2 times the mean of the looks, and from half to twice the tasks at the threshold."""
    robot = named(parameters={**TAU, "ratio": ratio, "bounded": 1.0}, colluding=True)
    looks = 60 * (20 * SHARE if ratio else 1)
    neutral = 20.5 / 19 if ratio else 20.5 * SHARE
    honest = told(0.8 * looks, 0.8 * looks * neutral)
    for message, times in ((robot.lie(honest, 1, []), 0.5), (robot.lie(honest, 0, []), 2.0)):
        row = (fading.believed(message[0], robot.me),)
        assert heard(row) == pytest.approx((looks, times * looks * neutral), rel=0.08)
    assert fading.believed(honest[0], robot.me) == honest[0]
    much = told(3 * looks, 3 * looks * neutral)
    seen, tasks = heard((fading.believed(much[0], robot.me),))
    assert tasks / seen == pytest.approx(neutral, rel=0.05)
    for trusting in (named(parameters=TAU), named(parameters={"bounded": 1.0}, knows_count=False)):
        assert fading.believed(much[0], trusting.me) == much[0]


# --- Votes ---


@pytest.mark.parametrize(("tasks", "vote"), [(20, 1), (21, 0)])
def test_a_vote_says_whether_the_robots_own_counts_are_feasible(tasks, vote):
    robot = named(name="fading-votes", parameters={"tau": 1e6}, size=(10.0, 10.0))
    live(robot, tasks * [TASK], steps=1257)  # 4 pi / 100 of the steps
    live(robot, steps=10_000 - 1257)
    assert robot.message() == (vote,)


@pytest.mark.parametrize(("sightings", "vote"), [(63, 1), (64, 0)])
def test_half_a_sighting_is_added(sightings, vote):
    """In 100 steps 20.5 tasks are in sight 64.4 times on average."""
    robot = named(name="fading-votes", parameters={"tau": 1e6})
    live(robot, sightings * [TASK])
    live(robot, steps=99)
    assert robot.message() == (vote,)


def test_most_of_the_weight_decides_and_a_tie_keeps_the_opinion():
    for votes, opinion in (([1], -1), ([1, 1], 1), ([0], 0), ([], 0), ([1, 0, 1], -1)):
        robot = named(name="fading-votes")  # its own vote, before it has seen anything, is against
        for sender, vote in enumerate(votes):
            robot.merge((vote,), sender + 1)
        robot.me = robot.me._replace(explores=False)
        assert robot.judge() == opinion, votes


def test_votes_lose_weight_and_are_replaced_by_id():
    robot = named(name="fading-votes", parameters=TAU)
    for vote in (1, 0, 1, 1):
        robot.merge((vote,), 5)
        live(robot, 2 * [TASK], steps=10)
    robot.merge((0,), 6)
    assert robot.me.memory[3:] == pytest.approx([1.0, 0.99**10])
    robots, tasks = robot.counted()
    assert (robots[0], tasks[0]) == (int(65536 * robot.me.memory[4]), 65536 * 2)


def test_a_false_vote_is_the_lie():
    robot = named(name="fading-votes")
    assert [robot.lie(robot.message(), feasible, []) for feasible in (0, 1)] == [(0,), (1,)]


# --- What swarms notice ---


def held_after(name, before, after, runs, **changes):
    """Return delays until a swarm holds the new truth, of swarms that held the old one."""
    right = right_by_step(name, before, after, runs, **{"robots.know_count": True, **changes})
    assert right[:, 499].mean() > 0.97
    hits = right[right[:, 499], 500:]
    return np.where(hits.any(axis=1), hits.argmax(axis=1), 10**6)


CHANGES = [(10, 40), (16, 25), (40, 10), (25, 16)]


@pytest.mark.parametrize("name", ["fading", "fading-votes"])
def test_swarms_notice_a_large_change(name):
    assert (held_after(name, 10, 40, 40) <= 200).all()
    assert (held_after(name, 40, 10, 40) <= 300).all()


def test_swarms_that_do_not_know_n_notice_robots_that_leave():
    """Of 20 robots 8 leave, and 16 tasks stay. With n, which is that of the start, nobody would notice."""
    gone = {"robots": -8, "robots.know_count": False, "decision.parameters": {"ratio": 1.0}}
    assert np.median(held_after("fading", 16, 16, 40, **gone)) < 350


@pytest.mark.slow
@pytest.mark.parametrize(("before", "after"), CHANGES)
@pytest.mark.parametrize(("name", "target"), [("fading", 0.98), ("fading-votes", 0.93)])
def test_the_targets_of_what_swarms_notice_within_300_steps(name, target, before, after):
    assert (held_after(name, before, after, 1000) <= 300).mean() >= target - 2 * math.sqrt(0.02 * 0.98 / 1000)


@pytest.mark.slow
@pytest.mark.parametrize("tasks", [16, 25])
@pytest.mark.parametrize("name", ["fading", "fading-votes"])
def test_the_target_in_worlds_that_stay(name, tasks):
    changes = {"decision.strategy": name, "robots.know_count": True, "tasks.count": tasks, "run.steps": 1500}
    record = simulate_record(Scenario().replace(changes), Runs(300, 1), curves=True)
    right = record.feasible_count if tasks <= 20 else record.infeasible_count
    assert (right[:, 500:] > 18).mean() >= 0.99

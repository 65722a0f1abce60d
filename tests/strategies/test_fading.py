"""Fading and fading votes: the rule, tau, lies, and what swarms notice; single steps are compared with C."""

from __future__ import annotations

import math

import numpy as np
import pytest
from minds import knowing, right_by_step

from feasibee import Scenario
from feasibee.scenario.runs import Runs
from feasibee.scenario.setting import setting_from
from feasibee.simulation.ensemble import simulate_record
from feasibee.strategies import fading
from feasibee.strategies.contract import Thing

TASK = Thing(False, 4, 0, 7)
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


def test_counts_too_large_for_a_message_keep_their_ratio():
    robot = named(parameters=TAU)
    robot.me.memory[fading.LOOKS], robot.me.memory[fading.TASKS] = 100.0, 50_000.0
    looks, tasks = heard(robot.message())
    assert tasks / looks == pytest.approx(500, rel=0.09)


# --- The rule ---


@pytest.mark.parametrize(("tasks", "opinion"), [(10, 1), (20, 1), (21, 0), (40, 0)])
def test_the_tasks_are_feasible_up_to_as_many_as_robots(tasks, opinion):
    """To one task in 20: the rows of 19 others are rounded by 2 % at most."""
    robot = named(parameters={"tau": 1e4})
    live(robot, steps=1)
    for sender in range(1, 20):
        robot.merge(told(4000, 4000 * tasks * SHARE, 1e4), sender)
    assert live(robot) == opinion
    assert robot.gap() == tasks - 20


def test_within_walls_the_share_in_sight_is_that_of_two_random_places():
    generator = np.random.default_rng(3)
    sides = np.array([12.0, 20.0])
    one, other = (generator.uniform(0, 1, (400_000, 2)) * sides for _ in range(2))
    share = (np.hypot(*(one - other).T) <= 3.0).mean()
    setting = PAPER._replace(width=12.0, height=20.0, sight=3.0, walled=True)
    assert fading.share_in_sight(setting) == pytest.approx(share, rel=0.02)
    assert fading.share_in_sight(PAPER) == SHARE


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


# --- Votes ---


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

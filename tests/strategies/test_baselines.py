"""Baselines for worlds that change: robots that switch, and voters among majority robots."""

from __future__ import annotations

import numpy as np
import pytest

from feasibee import Scenario
from feasibee.robot.controller import Controller, Declare, Message, Settings
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.strategies import STRATEGIES, mixture
from feasibee.strategies.contract import Inbox, Mind

# --- Switching ---


def decided(name="majority", switches=True, robots=3, tasks=1, **changes):
    """Return the opinion of a robot that held 1, explored, and heard three votes against it."""
    robot = Controller(
        STRATEGIES[name], 1, lambda mean: 1, lambda: (0.5, 0.5), draw_switch=lambda: switches, **changes
    )
    robot.observe(robots, tasks)
    robot.end_step()
    for sender in range(3):
        robot.hear(sender, Message(opinion=0, value=65535))
    robot.end_step()
    return robot.opinion


@pytest.mark.parametrize("name", [name for name, each in STRATEGIES.items() if not each.knowledge])
def test_a_robot_that_switches_adopts_what_its_own_counts_favour(name):
    assert [decided(name, robots=robots) for robots in (2, 1, 0)] == [1, 1, 0]


def test_a_robot_that_does_not_switch_decides_by_its_inbox():
    assert decided(switches=False) == 0


def test_stubborn_and_declared_robots_do_not_switch():
    assert decided(robots=0, stubborn=True) == 1
    robot = Controller(
        STRATEGIES["majority"],
        1,
        lambda mean: 1,
        lambda: (0.5, 0.5),
        Settings(declare=Declare(0, 1, 0)),
        draw_switch=lambda: True,
    )
    for _ in range(2):
        robot.observe(0, 3)
        robot.end_step()
        robot.end_step()
    assert robot.declared != -1
    assert robot.opinion == 0
    robot.observe(3, 0)
    robot.end_step()
    robot.end_step()
    assert robot.opinion == 0


# --- First sight ---


def first_sight(*sights, name="voter", **changes):
    """Return a robot's opinions after explorations with these sights, held 1 at first, and heard nothing."""
    settings = Settings(first_sight=True, **changes.pop("settings", {}))
    robot = Controller(STRATEGIES[name], 1, lambda mean: 1, lambda: (0.5, 0.5), settings, **changes)
    opinions = [robot.opinion]
    for robots, tasks in sights:
        robot.observe(robots, tasks)
        robot.end_step()
        opinions.append(robot.opinion)
        robot.end_step()
    return opinions


def test_a_robot_begins_with_what_its_first_exploration_favours_and_keeps_the_coin_with_a_tie():
    sights = (0, 1), (3, 3), (0, 0), (2, 1)
    assert [first_sight(each)[1] for each in sights] == [0, 1, 1, 1]
    assert first_sight((1, 3), settings={"quality_floor": 3}) == [1, 1]


def test_only_the_first_exploration_does_so():
    assert first_sight((0, 1), (1, 0)) == [1, 0, 0]
    assert first_sight((1, 1), (0, 1)) == [1, 1, 1]


def test_a_stubborn_robot_keeps_its_coin():
    assert first_sight((0, 9), stubborn=True) == [1, 1]


def test_what_is_broadcast_and_for_how_long_follow_from_the_new_opinion():
    means = []
    robot = Controller(
        STRATEGIES["dmmd"],
        1,
        lambda mean: means.append(mean) or 1,
        lambda: (0.5, 0.5),
        Settings(first_sight=True),
    )
    robot.observe(1, 4)
    robot.end_step()
    assert robot.message() == Message(opinion=0)
    assert means == [10.0, 8.0]


def test_first_sight_makes_swarms_right_more_often_and_sooner():
    """docs/opinions.md has the figures of 2,000 swarms; the coins cost more than all later noise."""
    for tasks, infeasible in ((10, False), (40, True)):
        runs = [
            simulate_record(
                Scenario(tasks={"count": tasks}, decision={"start": start}, run={"stop_at_decision": True}),
                Runs(200, 1),
            )
            for start in ("coin", "first-sight")
        ]
        right = [(each.decision == int(not infeasible)).mean() for each in runs]
        assert right[0] < 0.85
        assert right[1] > 0.93
        assert np.median(runs[1].decision_step) < 0.75 * np.median(runs[0].decision_step)


def curves(tasks=40, **changes):
    scenario = Scenario().replace({"decision.strategy": "voter", "tasks.count": tasks, **changes})
    return simulate_record(scenario, Runs(40, 1), curves=True).infeasible_count


def test_robots_that_never_switch_give_the_same_results_as_without_the_field():
    np.testing.assert_array_equal(curves(), curves(**{"decision.switching": 0.0}))


@pytest.mark.parametrize(("tasks", "most"), [(40, True), (10, False)])
def test_voters_that_always_switch_hold_the_evidence_of_their_last_exploration(tasks, most):
    """Voters alone drift: at step 1,000 a swarm holds either opinion, whatever the number of tasks."""
    late = curves(tasks, **{"decision.switching": 1.0})[:, 500:].mean() / 20
    assert (late > 0.7) if most else (late < 0.3)
    assert 0.3 < curves(tasks)[:, 500:].mean() / 20 < 0.7


def test_the_share_of_decisions_that_switch_is_the_probability():
    """A lone robot that sees nothing has quality 1/2, and switches to feasible for good at each decision.

    Phases last one step, so that each second step ends with a decision.
    """
    scenario = Scenario().replace(
        {
            "robots.count": 1,
            "tasks.count": 1,
            "decision.strategy": "voter",
            "decision.switching": 0.05,
            "decision.exploration": 0.1,
            "decision.gain": 0.1,
            "sensing.range": 1e-3,
            "run.steps": 40,
        }
    )
    record = simulate_record(scenario, Runs(20_000, 1), curves=True)
    began = record.infeasible_count[:, 0] == 1
    left = record.infeasible_count[began][:, 2::2].mean(axis=0)
    expected = 0.95 ** np.arange(1, len(left) + 1)
    np.testing.assert_allclose(left, expected, atol=5 * np.sqrt(0.25 / began.sum()))


# --- Mixture ---


def mind(memory, voters=0.25, opinion=1):
    return Mind(opinion, 0.5, 0.5, 1, memory, [voters])


def test_a_robot_draws_its_rule_at_its_first_decision_and_keeps_it():
    lone = Inbox(1, 3, 1, 0.0, 0.0, 0.24)  # the message drawn says feasible, the majority infeasible
    for chance, opinion in ((0.24, 1), (0.25, 0), (0.9, 0)):
        memory = [0.0]
        for later in (chance, 0.0, 0.99):
            assert mixture.decide(mind(memory), lone._replace(chance=later)) == opinion


@pytest.mark.parametrize(("voters", "pure"), [(0.0, "dmmd"), (1.0, "dmvd")])
def test_a_mixture_of_one_rule_is_that_rule(voters, pure):
    changes = {"decision.strategy": "mixture", "decision.parameters": {"voters": voters}}
    records = [
        simulate_record(Scenario().replace(each), Runs(20, 1), curves=True)
        for each in (changes, {"decision.strategy": pure})
    ]
    np.testing.assert_array_equal(records[0].feasible_count, records[1].feasible_count)

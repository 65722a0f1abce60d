"""Robots that begin with what they saw first."""

from __future__ import annotations

import numpy as np

from feasibee import Scenario
from feasibee.robot.controller import Controller, Message, Settings
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.strategies import STRATEGIES

# --- First sight ---


def first_sight(*sights, name="voter", coin=1, **changes):
    """Return a robot's opinions, at first a coin, after explorations with these sights; it hears nothing."""
    settings = Settings(first_sight=True, **changes.pop("settings", {}))
    robot = Controller(STRATEGIES[name], coin, lambda mean: 1, lambda: (0.5, 0.5), settings, **changes)
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
    assert first_sight((3, 3), coin=0) == [0, 0]
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
        Settings(first_sight=True, exploration=4.0),
    )
    robot.observe(1, 4)
    robot.end_step()
    assert robot.message() == Message(opinion=0)
    assert means == [4.0, 8.0]


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

"""Bounds: no robot declares a proof before its own run's limit, whatever its strategy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from feasibee import Scenario, Swarm
from feasibee.strategies import STRATEGIES, census
from feasibee.studies import limits, oracle

EAGER = '''

def declare(known, me):
    """Declare infeasible by more names of tasks than robots."""
    first = words_of(me.setting.robot_ids)
    return 0 if members(known, first, len(known) - first) > me.setting.robots else -1


STARTS_NEUTRAL = False


def quality(robots_known, tasks_known):
    """Return that of the robot's opinion: sure of either once 6 names of tasks are known."""
    return 1.0 if tasks_known >= 6 else 0.5


def dissemination(quality, gain):
    """Broadcast for 1 step until 6 names are known, then for 30 steps."""
    return 0.01 if quality == 0.5 else 30.0


def decide(mind, inbox):
    """Keep the opinion."""
    return mind.opinion
'''
WORLDS = [
    {"tasks.count": 21},
    {"tasks.count": 30, "arena.side": [26.0, 11.0], "radio.range": 3.5, "sensing.range": 1.7},
    {"tasks.count": 21, "radio.loss": 0.4, "sensing.miss": 0.3, "walk.mean_run": 2.0},
    {"tasks.count": 24, "arena.boundary": "walls", "arena.side": 15.0, "robots.avoid_collisions": True},
    {"tasks.count": 21, "faults.stopped": 0.3, "faults.stop_step": 40, "decision.listen": "dissemination"},
    {"robots.count": 40, "tasks.count": 45, "arena.side": 24.0, "decision.exploration": 3.0},
    {"tasks.count": 18, "arena.side": 14.0, "decision.gain": 40.0},
]
"""More tasks than robots, but in the last world."""
STEPS = 400


@pytest.fixture(scope="module")
def eager(tmp_path_factory):
    """A user's file: a census that broadcasts briefly at first, and declares infeasible by names."""
    path = tmp_path_factory.mktemp("eager") / "eager.py"
    path.write_text(Path(census.__file__).read_text(encoding="utf-8") + EAGER, encoding="utf-8")
    return str(path)


def declared_steps(scenario, run):
    """Return the step at which each robot declared infeasible, and feasible; a late one if it did not."""
    swarm = Swarm(scenario, 5, run)
    found = np.full((2, scenario.robots.count), 10**6)
    for _ in range(scenario.run.steps):
        swarm.advance()
        for verdict, steps in enumerate(found):
            steps[(swarm.declared == verdict) & (steps == 10**6)] = swarm.step
    return found


def knowing_steps(scenario, run):
    """Return the step at which each robot could know enough names, and a whole map; a late one if never."""
    swarm = limits.Tireless(limits.oracle_world(scenario, 4), 5, run)
    swarm.advance(scenario.run.steps)
    known, setting = swarm.knowledge, swarm.scenario.setting
    names = limits.naming_steps(known, setting, setting.tasks)
    found = np.array([names, known[:, oracle.MAP_STEP]])
    return np.where(found > 0, found, 10**5)


@pytest.mark.quick(2)
@pytest.mark.parametrize("changes", WORLDS, ids=str)
@pytest.mark.parametrize("name", [*(name for name in STRATEGIES if STRATEGIES[name].declares), "eager"])
def test_no_robot_proves_its_answer_before_its_own_limit(name, changes, eager):
    """In `map` both answers are proofs; in others *infeasible* is, and *feasible* a guess after a time."""
    own = {"decision.strategy": eager if name == "eager" else name, "robots.know_count": True}
    scenario = Scenario().replace({"run.steps": STEPS, **changes, **own})
    infeasible, feasible = declared_steps(scenario, 0)
    names, whole = knowing_steps(scenario, 0)
    if scenario.tasks.count > scenario.robots.count:
        assert (infeasible < 10**6).any()
        assert (infeasible >= names).all()
    if name == "map":
        assert (feasible >= whole).all()

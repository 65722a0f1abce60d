"""What robots that know the plan of their place know to be hidden, and how much they see of it."""

from __future__ import annotations

import numpy as np
import pytest

from feasibee import Scenario, ScenarioError, simulate
from feasibee.reference.place import ground_of
from feasibee.strategies.contract import Me
from feasibee.strategies.sight import TASKS, WALL, hidden, sees
from tests.places import bitmap, random_cells, rectangle, rooms


def world(name, walls, side=12.0, **changes):
    """Return robots with a strategy that know their number, in a place."""
    robots = {"robots.count": 20, "robots.know_count": True, "robots.diameter": 0.5, "tasks.count": 21}
    place = {"arena.boundary": "walls", "arena.side": side, "place.walls": walls}
    return Scenario().replace({**robots, **place, "decision.strategy": name, **changes})


def test_robots_know_what_walls_hide():
    random, answers = np.random.default_rng(5), []
    closed = random_cells(random, 24, 30, 7)
    scenario = Scenario(
        place={"map": bitmap(closed, 0.5)}, robots={"diameter": 0.2}, decision={"strategy": "roster"}
    )
    ground, setting = ground_of(scenario), scenario.setting
    for _ in range(400):
        a, b = (
            (int(x), int(y))
            for x, y in zip(random.integers(30, size=2), random.integers(24, size=2), strict=True)
        )
        if setting.plan[a[1] * 30 + a[0]] & WALL or abs(a[0] - b[0]) + abs(a[1] - b[1]) > 12:
            continue
        first, second = ((x << ground.bits, y << ground.bits) for x, y in (a, b))
        answers.append(hidden(*a, *b, setting))
        assert answers[-1] == (ground.walls_between(first, second) > 0)
        me = Me(0, 0, 0, 0, [], setting, x=0.5 * a[0] + 0.1, y=0.5 * a[1] + 0.4)
        x, y = 0.5 * b[0] + 0.2, 0.5 * b[1] + 0.2
        holds = setting.plan[b[1] * 30 + b[0]] & TASKS > 0
        assert sees(x, y, x + 0.1, y + 0.1, me) == (not (holds and answers[-1]))
    assert 20 < sum(answers) < len(answers) - 20


def test_the_plan_says_where_tasks_may_be():
    zones = {"place.zones": {"all": rectangle(0.0, 0.0, 6.0, 12.0)}, "tasks.zone": "all"}
    scenario = world("map", rooms(2.0, 12.0), **zones, **{"place.cell": 0.25})
    cells = np.frombuffer(scenario.setting.plan, np.uint8).reshape(-1, scenario.setting.columns)
    ground = ground_of(scenario)
    found = {(int(column), int(row)) for row, column in np.argwhere(cells & TASKS)}
    assert found == {each for each in ground.passable if each[0] < 24}
    point = {"tasks.placement": "points", "tasks.points": [[9.1, 0.05]], "tasks.count": 1, "tasks.zone": None}
    given = scenario.replace(point).setting
    assert (given.plan[36], given.plan[37], given.plan[23]) == (TASKS, 0, WALL)
    assert world("census", rooms(2.0, 12.0)).setting.plan == b""


WALLS = rooms(1.0, 12.0)


def test_map_never_declares_what_walls_hide():
    scenario = world("map", WALLS, **{"run.steps": 3000, "run.stop_at_declarations": True})
    said = simulate(scenario, runs=30, seed=1)
    assert not said.declared_feasible.values.any()
    assert (said.declared_infeasible.values == 20).all()
    enough = simulate(scenario.replace({"tasks.count": 20}), runs=10, seed=2)
    assert (enough.declared_feasible.values == 20).all()


def test_a_roster_keeps_the_tasks_behind_walls():
    more, fewer = {"tasks.count": 22}, {"events": [{"step": 300, "tasks": -6}]}
    first, other = (world("roster", WALLS, **{"run.steps": 1500}, **changes) for changes in (more, fewer))
    said = simulate(first.with_flooding(400), runs=20, seed=3)
    assert (said.infeasible_at_end.values == 20).all()
    gone = simulate(other.with_flooding(400), runs=20, seed=4)
    assert (gone.feasible_at_end.values == 20).mean() > 0.8


def test_a_users_strategy_must_say_that_it_reads_the_plan(tmp_path):
    text = "ALL_ROUND = True\n{}def decide(mind, inbox):\n    return mind.opinion\n"
    file = tmp_path / "mine.py"
    file.write_text(text.format(""))
    with pytest.raises(ScenarioError, match="concludes from what it doesn't see in range, but walls hide"):
        world(str(file), WALLS)
    file.write_text(text.format("READS_PLAN = True\n"))
    assert world(str(file), WALLS).setting.columns == 120

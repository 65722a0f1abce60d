"""Time of flooding in a place, and strategies that wait by it (model.md 6.20)."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from commands import invoke

from feasibee import Scenario, simulate
from feasibee.results.measures import declarations
from feasibee.strategies import certified, quiet_census, turns
from feasibee.strategies.certified import NEVER
from feasibee.studies import flooding as module
from feasibee.studies.assess import assess
from feasibee.studies.comparison import design_points, outcomes_of
from feasibee.studies.flooding import Repeated, flooded, flooding
from feasibee.studies.needs import quiet_times_in_words
from feasibee.studies.report import sections
from feasibee.sweeps import sweep as rounds
from feasibee.sweeps.executors import threads
from feasibee.sweeps.sweep import Enough, Execution, Rounds
from tests.places import rectangle

DECLARING = {"decision.strategy": "quiet-census", "robots.know_count": True}
BODIES = {"robots.diameter": 0.5, "robots.avoid_collisions": True, "robots.contact": "deflect"}
RUNS = 40
"""Fewer than in use, to save time."""


@pytest.fixture(autouse=True)
def few_runs(monkeypatch):
    monkeypatch.setattr(module, "RUNS", RUNS)


def place(door=1.0, side=12.0, **changes):
    """Return two rooms with a door in the wall between them; 0: no door."""
    half = side / 2
    ends = [(0.0, half - door / 2), (half + door / 2, side)] if door else [(0.0, side)]
    walls = [rectangle(half - 0.1, low, half + 0.1, high) for low, high in ends]
    world = {"arena.side": side, "arena.boundary": "walls", "place.walls": walls, "run.steps": 3000}
    return Scenario().replace({**world, **BODIES, "robots.count": 8, "tasks.count": 9, **changes})


@pytest.mark.slow
def test_robots_that_see_and_hear_all_know_all_names_at_once():
    world = place(**{"sensing.range": 30.0, "arena.side": 4.0, "place.walls": [], "robots.count": 2})
    world = world.replace({"place.zones": {"all": [rectangle(0.0, 0.0, 4.0, 4.0)]}})
    assert flooding(world) == (1, 1, 1)


def test_rooms_and_doors_delay_names_and_dead_radio_stops_them(monkeypatch):
    wide, narrow = flooding(place(6.0)), flooding(place(0.8))
    assert wide.slowest < narrow.p95 < narrow.slowest
    monkeypatch.setattr(module, "LONGEST", 100)
    assert flooding(place(**{"sensing.miss": 1.0})) == (None, None, None)


def test_robots_of_a_closed_room_need_its_names_only():
    closed = flooding(place(0.0))
    assert closed.slowest < flooding(place(0.8)).slowest


@pytest.mark.parametrize("changes", [{}, {"tasks.count": 3}, DECLARING, {"run.steps": 7}], ids=str)
def test_strategy_tasks_and_length_of_a_run_change_no_flooding(changes):
    assert flooding(place(**changes)) == flooding(place())


@pytest.mark.slow
def test_the_times_are_those_by_which_all_robots_know_all_names():
    world, last = module._world_of(place()), []
    for run in range(RUNS):
        swarm = Repeated(world, module.SEED, run)
        share = 0.0
        while share < 1:
            swarm.advance(1)
            start = module.oracle.names_start(swarm.scenario.setting)
            known = [int(row[start]).bit_count() for row in swarm.knowledge]
            share = np.mean([each == 9 for each in known])
        last.append(swarm.step)
    assert flooding(place()).slowest == max(last)
    assert flooding(place()).median == sorted(last)[RUNS // 2 - 1]


def setting_in(place_too=True, know_count=True, **changes):
    """Return the setting of a scenario with 300 steps of flooding, or none."""
    world = place(**{**DECLARING, "robots.know_count": know_count, **changes})
    return world.replace({"place.flooding": 300 if place_too else None}).setting


def test_quiet_times_in_a_place_are_in_proportion_to_flooding():
    own = setting_in()
    assert quiet_census.quiet_steps(8, own) == 450
    unknown = setting_in(know_count=False)
    assert [quiet_census.quiet_steps(k, unknown) for k in (1, 4, 8)] == [450] * 3
    bearing = setting_in(**{"decision.parameters": {"tolerates": 2.0}})
    ratio = quiet_census.patience(8, 2) / quiet_census.patience(8, 0)
    assert quiet_census.quiet_steps(8, bearing) == pytest.approx(450 * ratio, rel=0.03)
    one = setting_in(**{"decision.strategy": "turns", "decision.parameters": {"names": 1.0}})
    assert turns.quiet_steps(one) == pytest.approx(450 * (1 + 8 / 50), rel=0.03)
    alone = setting_in(**{"decision.strategy": "turns", "decision.parameters": {"names": 0.0}})
    assert turns.quiet_steps(alone) > 3 * 450
    given = setting_in(**{"decision.parameters": {"quiet": 70.0}})
    assert quiet_census.quiet_steps(8, given) == 70


def test_without_a_time_of_flooding_robots_wait_for_ever():
    assert setting_in(place_too=False).flooding == NEVER
    assert quiet_census.quiet_steps(8, setting_in(place_too=False)) == NEVER
    hall = Scenario().replace({**DECLARING, "arena.boundary": "walls"}).setting
    assert hall.flooding == 0.0
    patience = quiet_census.patience(20, 0)
    assert quiet_census.quiet_steps(20, hall) == certified.open_steps(0.5, patience, 20, hall)
    assert certified.steps_with(1.0, 5.0, 8, setting_in()) == NEVER  # robots that never broadcast
    assert not math.isnan(certified.sightings_to_flood(0))


def test_robots_declare_feasible_only_with_a_time_of_flooding():
    world = place(**DECLARING, **{"tasks.count": 4, "run.steps": 1000})
    assert declarations(simulate(world, 20, seed=1), world).feasible == 0
    assert flooded(world).place.flooding == flooding(world).slowest
    timed = world.replace({"place.flooding": 300})
    assert flooded(timed) == timed
    assert declarations(simulate(timed, 20, seed=1), timed).feasible > 0.9
    assert "Set place.flooding" in quiet_times_in_words(world)[0]
    assert quiet_times_in_words(timed) == []
    assert flooded(place()) == place()  # it has no strategy by names


@pytest.mark.parametrize("start", ["search", "safe"])
def test_robots_that_act_in_a_place_wait_for_its_flooding(start):
    """So do robots whose strategy counts no names."""
    world = place(**{"acting.start": start, "tasks.count": 4, "acting.reach": 1.0})
    assert (simulate(world, 5, seed=1).all_taken_step.values == -1).all()
    assert quiet_times_in_words(world)[0].endswith("Without it, robots never act in other runs.")
    timed = flooded(world)
    assert timed.place.flooding == flooding(world).slowest
    assert (simulate(timed, 5, seed=1).first_taken_step.values > timed.acts_from).all()
    assert quiet_times_in_words(timed) == []
    assert flooded(place(**{"acting.start": 40})).place.flooding is None


def test_studies_add_the_time_of_flooding():
    with Rounds(None) as rounds:
        (found,) = outcomes_of(
            rounds, design_points({"a": place(**DECLARING, **{"tasks.count": 4})}, (), 5, 1), 5, 1
        )
    assert found.declared.feasible == 1.0


def test_an_assessment_has_a_verdict_before_the_flooding_and_a_budget_ends_both(monkeypatch):
    told, known, clock = [], [], [0.0]

    def flood(world, progress, check):
        known.append(told[-1].so_far)
        clock[0] = 30.0
        check()
        raise AssertionError("the budget is over")

    monkeypatch.setattr(module, "_known", {})
    monkeypatch.setattr(module, "_flooding", flood)
    world = place(**DECLARING, **{"tasks.count": 4, "run.steps": 60})
    monkeypatch.setattr(rounds, "time", SimpleNamespace(monotonic=lambda: clock[0]))
    found = assess(world, 20, 1, Execution(pool=threads(1), progress=told.append, budget=20.0))
    assert found.outcome.runs == 10
    assert [each.partition(":")[0] for each in known] == ["not ready so far, without place.flooding"]
    assert {"running the swarm", "searching sizes"} <= set(found.missing)
    assert any(line.startswith("place.flooding is missing") for line in sections(found)["What to expect"])
    assert found.recommendation.tested == []


def test_flooding_can_end_within_a_run(monkeypatch):
    """With walls that no name passes, a run has 200 strides."""
    monkeypatch.setattr(module, "RUNS", 1)
    monkeypatch.setattr(module, "_known", {})
    world, strides = place(**DECLARING, **{"sensing.miss": 1.0}), []

    def check():
        strides.append(1)
        if len(strides) == 3:
            raise Enough

    with pytest.raises(Enough):
        flooded(world, check)
    assert (len(strides), module._known) == (3, {})


@pytest.mark.parametrize(
    ("changes", "never"),
    [
        (DECLARING, ["robots that wait for a quiet time never declare feasible"]),
        ({"acting.start": "safe", "acting.reach": 1.0}, ["robots never act"]),
        ({**DECLARING, "place.flooding": 9}, []),
        ({**DECLARING, "decision.parameters": {"quiet": 70.0}}, []),
        ({}, []),
    ],
    ids=str,
)
def test_commands_that_simulate_say_at_once_that_robots_wait_in_vain(tmp_path, monkeypatch, changes, never):
    monkeypatch.setattr(module, "_known", {})
    monkeypatch.setattr(module, "_flooding", None)  # too slow for a line of text
    world = place(**changes, **{"run.steps": 5})
    (tmp_path / "mine.toml").write_text(world.to_toml(), encoding="utf-8")
    wanted = [f"feasibee: place.flooding is missing: {each}. Set it to the step by" for each in never]
    for command in (["run", "--runs", 1], ["animate", "--frames", 1, "--out", tmp_path / "one.png"]):
        done = invoke(command[0], tmp_path / "mine.toml", *command[1:])
        assert done.exit_code == 0, done.output
        found = [line for line in done.stderr.splitlines() if "place.flooding" in line]
        assert [line[: len(want)] for line, want in zip(found, wanted, strict=True)] == wanted

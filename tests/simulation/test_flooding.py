"""Time in which names flood a place, and strategies and robots that wait by it (model.md 6.20, 6.25)."""

from __future__ import annotations

import json
import math
import pickle

import numpy as np
import pytest
from commands import invoke

from feasibee import Scenario, Swarm, simulate
from feasibee.results.measures import declarations
from feasibee.scenario.ground import ground_of
from feasibee.scenario.plugins import manifest_of, reads_flooding
from feasibee.simulation import flooding as module
from feasibee.simulation.flooding import flooded, flooding
from feasibee.strategies import certified, quiet_census, turns
from feasibee.strategies.certified import NEVER
from tests.places import rectangle

DECLARING = {"decision.strategy": "quiet-census", "robots.know_count": True}
BODIES = {"robots.diameter": 0.5, "robots.avoid_collisions": True, "robots.contact": "deflect"}
RUNS = 40
"""Fewer than in use, to save time."""


@pytest.fixture(autouse=True)
def fresh(monkeypatch, tmp_path):
    monkeypatch.setattr(module, "runs_of", lambda scenario: RUNS)
    monkeypatch.setattr(module, "cache_root", lambda: tmp_path / "cache")
    monkeypatch.setattr(module, "_known", {})


def place(door=1.0, side=12.0, **changes):
    """Return two rooms with a door in the wall between them; 0: no door."""
    half = side / 2
    ends = [(0.0, half - door / 2), (half + door / 2, side)] if door else [(0.0, side)]
    walls = [rectangle(half - 0.1, low, half + 0.1, high) for low, high in ends]
    world = {"arena.side": side, "arena.boundary": "walls", "place.walls": walls, "run.steps": 3000}
    return Scenario().replace({**world, **BODIES, "robots.count": 8, "tasks.count": 9, **changes})


def test_rooms_and_doors_delay_names_and_dead_radio_stops_them(monkeypatch):
    """Robots of a closed room need its names only."""
    wide, narrow, closed = (flooding(place(door)) for door in (6.0, 0.8, 0.0))
    assert wide.slowest < narrow.p95 < narrow.slowest
    assert not ground_of(place(0.0)).is_one
    assert closed.slowest < narrow.slowest
    monkeypatch.setattr(module, "LONGEST", narrow.slowest - 1)  # too short for the slowest run
    assert flooding(place(0.8)).slowest == NEVER
    monkeypatch.setattr(module, "LONGEST", 100)
    assert flooding(place(**{"sensing.miss": 1.0})) == (None, None, NEVER)


SAME = [
    {"tasks.count": 3, "tasks.lifetime": 9.0, "tasks.arrival_rate": 0.1},
    DECLARING,
    {"run.steps": 7, "units.metres": 0.5, "acting.start": "safe", "tasks.work": 5},
    {"radio.id_bits": 2},
    {"events": [{"step": 3, "tasks": 2}], "robots.arrival_rate": 0.1, "robots.work": 9, "robots.charge": 3},
    {"sensing.false_tasks": 0.1},
    {"decision.strategy": "census", "sensing.misname": 0.1},
]
OTHER = [{"radio.range": 3.0}, {"robots.count": 9}, {"radio.loss": 0.1}]
CASES = [*((each, True) for each in SAME), *((each, False) for each in OTHER)]


@pytest.mark.parametrize(("changes", "same"), CASES)
def test_robots_and_radio_change_flooding_and_what_comes_later_does_not(changes, same):
    assert (module._world_of(place(**changes)) == module._world_of(place())) == same


def test_there_is_one_task_more_than_robots():
    assert module._world_of(place()).tasks.count == 8 + 1


def test_classes_change_no_flooding():
    tables = place().to_dict()
    tables["robots"] |= {"classes": [{"name": "arm", "count": tables["robots"].pop("count")}]}
    assert module._world_of(Scenario.from_tables(tables)) == module._world_of(place())


@pytest.mark.slow
@pytest.mark.parametrize("door", [1.0, 0.0])
def test_the_times_are_those_by_which_all_robots_know_all_names_of_their_piece(door):
    world, last = module._world_of(place(door)), []
    ground = ground_of(world)
    wanted = (ground.robots.piece[:, None] == ground.tasks.piece[None, :]).sum(axis=1)
    for run in range(RUNS):
        swarm, known = Swarm(world, module.SEED, run), np.zeros(8)
        while (known < wanted).any():
            swarm.advance(1)
            known = np.array([int(row[0]).bit_count() for row in swarm.knowledge])
        last.append(swarm.step)
    assert flooding(place(door)).slowest == max(last)
    assert flooding(place(door)).median == sorted(last)[RUNS // 2 - 1]


def test_a_time_is_simulated_once_and_kept_also_for_other_processes(monkeypatch, tmp_path):
    world = place(**DECLARING)
    steps = flooded(world).flooding
    (file,) = (tmp_path / "cache" / "flooding").iterdir()
    monkeypatch.setattr(module, "flooding", None)
    assert flooded(place(**DECLARING, **{"tasks.count": 2})).flooding == steps
    module._known.clear()
    assert flooded(place(**DECLARING)).flooding == steps
    assert pickle.loads(pickle.dumps(world)).flooding == steps
    assert flooded(world.with_flooding(3)).flooding == 3
    assert world.replace({"robots.count": 9}).flooding is None
    key = file.name.removesuffix(f"-{steps}")
    assert module._kept(file.parent, key) == steps
    file.rename(file.with_name(f"{key}-many"))
    assert module._kept(file.parent, key) is None


def test_a_cache_that_cant_be_written_costs_a_simulation_and_no_error(monkeypatch, tmp_path):
    (tmp_path / "cache").write_text("a file where the folder should be")
    assert flooded(place(6.0, **DECLARING)).flooding > 0


def setting_in(steps=300, know_count=True, **changes):
    """Return the setting of a scenario with 300 steps of flooding."""
    return place(**{**DECLARING, "robots.know_count": know_count, **changes}).with_flooding(steps).setting


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


def test_names_that_take_too_long_let_robots_wait_for_ever():
    assert setting_in(NEVER).flooding == NEVER
    assert quiet_census.quiet_steps(8, setting_in(NEVER)) == NEVER
    hall = Scenario().replace({**DECLARING, "arena.boundary": "walls"}).setting
    assert hall.flooding == 0.0
    patience = quiet_census.patience(20, 0)
    assert quiet_census.quiet_steps(20, hall) == certified.open_steps(0.5, patience, 20, hall)
    assert certified.steps_with(1.0, 5.0, 8, setting_in()) == NEVER  # robots that never broadcast
    assert not math.isnan(certified.sightings_to_flood(0))


def test_robots_in_a_place_declare_feasible_by_themselves():
    def world():
        return place(6.0, **DECLARING, **{"tasks.count": 4, "run.steps": 1000})

    runs, swarm, steps = simulate(world(), 20, seed=1), Swarm(world(), seed=1), flooding(world()).slowest
    assert declarations(runs, world()).feasible > 0.9
    assert simulate(world().with_flooding(steps), 20, seed=1).equals(runs)
    swarm.advance(1000)
    assert swarm.declared_counts[0] == runs.declared_feasible.values[0]


@pytest.mark.parametrize("start", ["search", "safe"])
def test_robots_that_act_in_a_place_wait_for_its_flooding(start):
    """So do robots whose strategy counts no names."""
    world = place(6.0, **{"acting.start": start, "tasks.count": 4, "acting.reach": 1.0})
    runs = simulate(world, 5, seed=1)
    assert world.flooding == flooding(world).slowest
    assert (runs.first_taken_step.values > world.acts_from).all()
    assert flooded(place(**{"acting.start": 40})).flooding is None


OWN = """
def decide(mind, inbox):
    return mind.opinion
def probability(mind, known, setting):
    return 1.0 if setting.{} > 100 else 0.0
"""


def test_who_waits_for_names_is_told_by_what_its_strategy_reads(tmp_path):
    file = tmp_path / "mine.py"
    for name, waits in (("flooding", True), ("robots", False)):
        file.write_text(OWN.format(name))
        assert reads_flooding(manifest_of(str(file))) == waits
        assert place(**{"decision.strategy": str(file)}).waits_for_names == waits
    reading = {"quiet-census", "turns", "roster"}
    assert {
        name for name in (*reading, "census", "map", "dmmd") if reads_flooding(manifest_of(name))
    } == reading
    assert place(**DECLARING).waits_for_names
    assert not place(**DECLARING, **{"decision.parameters": {"quiet": 70.0}}).waits_for_names
    assert not Scenario().replace(DECLARING).waits_for_names
    assert not place().waits_for_names


def shown(folder, world):
    """Return what commands show of a world: words of a run and of the scenario, and numbers of a run."""
    (folder / "mine.toml").write_text(world.to_toml(), encoding="utf-8")
    runs = ("run", folder / "mine.toml", "--runs", 1)
    words, numbers = invoke(*runs, "--details").output, json.loads(invoke(*runs, "--json").output)
    return words, invoke("show", "scenario", folder / "mine.toml").output, numbers["flooding"]


def test_commands_say_the_time_of_flooding(tmp_path):
    world = place(6.0, **DECLARING, **{"tasks.count": 4, "run.steps": 60})
    steps = flooding(world).slowest
    line = f"Names flood this place by step {steps:,}, the latest of {RUNS} runs; robots wait by it."
    words, text, number = shown(tmp_path, world)
    assert f"flooding                        {steps}\n" in words
    assert f"# {line}" in text
    assert Scenario.from_toml(text) == world
    assert number == steps


def test_names_that_take_too_long_are_told(monkeypatch, tmp_path):
    monkeypatch.setattr(module, "LONGEST", 100)
    world = place(**DECLARING, **{"sensing.miss": 1.0, "run.steps": 5})
    said = "Names take more than 100 steps to flood this place: robots {}."
    never = said.format("that wait for a quiet time never declare feasible")
    assert module.flooding_in_words(world) == [never]
    assert shown(tmp_path, world)[2] is None
    acting = place(**{"acting.start": "safe", "sensing.miss": 1.0})
    assert module.flooding_in_words(acting) == [said.format("never act")]

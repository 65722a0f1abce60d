"""Metres and seconds: what a scenario's units and steps are outside."""

from __future__ import annotations

import pytest

from feasibee import (
    Scenario,
    ScenarioError,
    Swarm,
    plot_arena,
    plot_decision_steps,
    plot_opinions,
    simulate,
)
from feasibee.scenario import units
from feasibee.scenario.fields import unit_of
from feasibee.scenario.runs import Runs
from feasibee.scenario.supported import takes_fast_path
from feasibee.simulation.ensemble import simulate_record

HALL = Scenario(units={"metres": 0.5, "seconds": 2.0}, run={"steps": 50})


def test_units_change_neither_the_hash_nor_a_run():
    plain = Scenario(run={"steps": 50})
    assert HALL.hash == plain.hash
    assert takes_fast_path(HALL)
    records = [simulate_record(each, Runs(3, 1)) for each in (HALL, plain)]
    assert records[0].bits_sent.tolist() == records[1].bits_sent.tolist()


def test_units_are_part_of_the_text():
    assert Scenario().to_dict()["units"] == {}
    assert Scenario.from_toml(HALL.to_toml()) == HALL
    assert HALL.to_dict()["units"] == {"metres": 0.5, "seconds": 2.0}
    assert HALL.replace({"tasks.count": 3}).units == HALL.units


@pytest.mark.parametrize(("field", "value"), [("metres", 0.0), ("seconds", -1.0), ("metres", "1 m")])
def test_impossible_units_are_errors(field, value):
    with pytest.raises(ScenarioError, match=f"units.{field}"):
        Scenario(units={field: value})


def test_fields_have_the_unit_of_their_type_also_if_they_may_be_off():
    with_units = {"robots.spread": "units", "robots.speed": "units per step", "tasks.lifetime": "steps"}
    with_units |= {"arena.side": "units", "response.patience": "steps", "run.steps": "steps"}
    without = dict.fromkeys(("tasks.count", "robots.classes.0.count", "events.0.step", "preset"), "")
    assert {path: unit_of(path) for path in with_units | without} == with_units | without


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (0.25, "0.25 s"),
        (59.96, "1 min"),
        (60, "1 min"),
        (89.6, "1 min 30 s"),
        (3599.9, "1 h"),
        (3600, "1 h"),
        (7322, "2 h 2 min"),
    ],
)
def test_durations_in_words(seconds, words):
    assert units.duration(seconds) == words


def test_values_in_words():
    assert units.value_in_words(HALL, "robots.speed", 1.0) == "robots.speed = 1 unit per step (0.25 m/s)"
    assert units.value_in_words(HALL, "run.steps", 100) == "run.steps = 100 steps (3 min 20 s)"
    assert units.value_in_words(Scenario(), "tasks.count", 7) == "tasks.count = 7"
    assert units.step_in_words(Scenario(), 7) == "step 7"


def test_figures_have_axes_in_metres_and_seconds():
    results = simulate(HALL, 3, curves=True)
    for draw in (plot_opinions, plot_decision_steps):
        axes = draw(results)
        axes.figure.draw_without_rendering()
        (above,) = axes.child_axes
        assert above.get_xlabel() == "time (s)"
        assert above.get_xlim()[1] == pytest.approx(2.0 * axes.get_xlim()[1])
    axes = plot_arena(Swarm(HALL))
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x (m)", "y (m)")
    assert [label.get_text() for label in axes.get_xticklabels()] == ["0", "2.5", "5", "7.5", "10"]
    assert plot_arena(Swarm(Scenario())).get_xlabel() == "x (units)"

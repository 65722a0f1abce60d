"""Metres and seconds: what a scenario's units and steps are outside."""

from __future__ import annotations

import pickle
import re
from pathlib import Path

import pytest
from commands import json_of, output_of
from jsonschema import Draft202012Validator
from remedies import problems_of

from feasibee import Scenario, ScenarioError, Swarm, plot_arena, plot_decision_steps, plot_opinions, simulate
from feasibee.scenario import units
from feasibee.scenario.runs import Runs
from feasibee.scenario.supported import takes_fast_path
from feasibee.scenario.units import with_numbers
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.plan import study_of
from feasibee.studies.size import Axis, dimension

HALL = Scenario(units={"metres": 0.5, "seconds": 2.0}, run={"steps": 50})


def test_units_are_part_of_the_text_and_change_neither_the_hash_nor_a_run():
    plain = Scenario(run={"steps": 50})
    assert HALL.to_dict()["units"] == {"metres": 0.5, "seconds": 2.0}
    assert HALL.replace({"tasks.count": 3}).units == HALL.units
    assert HALL.hash == plain.hash
    assert takes_fast_path(HALL)
    records = [simulate_record(each, Runs(3, 1)) for each in (HALL, plain)]
    assert records[0].bits_sent.tolist() == records[1].bits_sent.tolist()


def test_durations_in_words():
    words = {0.25: "0.25 s", 59.96: "1 min", 89.6: "1 min 30 s", 3599.9: "1 h", 7359: "2 h 3 min"}
    assert {seconds: units.duration(seconds) for seconds in words} == words


def test_values_in_words():
    assert units.value_in_words(HALL, "robots.speed", 1.0) == "robots.speed = 1 unit per step (0.25 m/s)"
    assert units.value_in_words(HALL, "run.steps", 100) == "run.steps = 100 steps (3 min 20 s)"
    assert units.value_in_words(Scenario(), "tasks.count", 7) == "tasks.count = 7"
    assert units.steps_in_words(HALL, 3) == "3 steps (6 s)"
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


# --- Quantities: values as texts with units ---

SIZES = {"metres": 0.3, "seconds": 0.7}
QUANTITIES = {
    "arena.side": ("12 m", 40.0),
    "robots.speed": ("0.3 m/s", 0.7),
    "robots.diameter": ("20 cm", 2 / 3),
    "sensing.range": ("6m", 20.0),
    "sensing.position_error": ("30 mm", 0.1),
    "radio.delay": ("1750 ms", 3),
    "walk.mean_run": ("10.5 s", 15.0),
    "decision.dissemination_floor": ("0 s", 0),
    "tasks.lifetime": ("1e-3 h", 3.6 / 0.7),
    "run.steps": ("10 min", 857),
    "acting.start": (".1 min", 9),
    "tasks.arrival_rate": ("6 per min", 0.07),
    "robots.failure_rate": ("3.6/h", 0.0007),
    "sensing.false_tasks": ("1e-3 per ms", 0.7),
}


def given(path, value, **others):
    section, key = path.split(".")
    return {**others, section: {key: value}}


@pytest.mark.parametrize("path", QUANTITIES)
def test_a_quantity_is_the_number_that_it_is_in_units_and_steps(path):
    text, number = QUANTITIES[path]
    found, _, _ = with_numbers(given(path, text, units=SIZES))
    section, key = path.split(".")
    assert found[section][key] == pytest.approx(number, rel=1e-15)
    assert type(found[section][key]) is type(number)


def test_quantities_leave_numbers_in_the_complete_form_and_the_hash():
    texts = {"arena.side": ["20 m", "10 m"], "sensing.range": "1 m", "robots.speed": "25 cm/s"}
    found = HALL.replace({**texts, "run.steps": "1 min", "events": [{"step": "20 s", "tasks": 1}]})
    numbers = {"arena.side": [40.0, 20.0], "sensing.range": 2.0, "robots.speed": 1.0}
    plain = HALL.replace({**numbers, "run.steps": 30, "events": [{"step": 10, "tasks": 1}]})
    assert (found, found.to_toml(), found.hash) == (plain, plain.to_toml(), plain.hash)
    assert Scenario.from_toml(found.to_toml()).hash == found.hash
    swept = {"scenario": {"units": SIZES}, "sweep": {"sensing.range": ["1.5 m"]}}
    assert study_of({"runs": 1, **swept}, Path()).points[0].values == {"sensing.range": 5.0}
    for size in (1e-9, 1e9):  # the least and the largest one
        assert Scenario(units={"metres": size}, sensing={"range": f"{size} m"}).sensing.range == 1.0


def test_positions_and_polygons_may_have_units():
    hall = Scenario(
        units=SIZES,
        arena={"side": 20.0, "boundary": "walls"},
        events=[{"step": 5, "tasks": 1, "at": ["1.5 m", 4.0]}],
        tasks={"placement": "points", "count": 2, "points": [["3 m", 2.5], [1, "60 cm"]]},
        place={
            "zones": {"dock": [["0 m", 0], ["3 m", 0], [10, 9]]},
            "walls": [[[15, 1], ["4.8 m", 1], [16, 2]]],
        },
    )
    assert hall.tasks.points == ((10.0, 2.5), (1.0, 2.0))
    assert hall.place.zones == {"dock": (((0.0, 0.0), (10.0, 0.0), (10.0, 9.0)),)}
    assert hall.place.walls == (((15.0, 1.0), (16.0, 1.0), (16.0, 2.0)),)
    assert hall.events[0].at == (5.0, 4.0)
    assert Scenario.from_toml(hall.to_toml()) == hall
    assert Draft202012Validator(Scenario.model_json_schema()).is_valid({"tasks": {"points": [["3 m", 2.5]]}})
    with pytest.raises(ScenarioError, match="'3 s': must be a length, not a time") as error:
        hall.replace({"tasks.points": [["3 s", 1], ["3 h", 1]]})
    assert [each.path for each in error.value.problems] == ["tasks.points"]
    with pytest.raises(ScenarioError, match=r"'3\.csv': can't be read"):
        hall.replace({"tasks.points": "3.csv"})
    deep = ["3 m"]
    for _ in range(3000):
        deep = [deep]
    for path in ("arena.side", "tasks.points", "place.walls"):
        with pytest.raises(ScenarioError, match="must be"):
            Scenario(**given(path, deep))


def test_new_sizes_of_units_convert_the_texts_of_a_scenario_anew():
    hall = HALL.replace({"arena.side": ["20 m", 30], "sensing.range": "1 m", "run.steps": "1 min"})
    hall = hall.replace({"run.steps": 70, "events": [{"step": "20 s", "tasks": 1}]})
    for each in (hall, pickle.loads(pickle.dumps(hall))):
        scaled = each.replace({"units.metres": 1.0, "units.seconds": 1.0})
        assert (scaled.arena.side, scaled.sensing.range, scaled.run.steps) == ((20.0, 30.0), 1.0, 70)
        assert (hall.events[0].step, scaled.events[0].step) == (10, 20)
    numbers = Scenario.from_toml(hall.to_toml()).replace({"units.metres": 1.0})
    assert (numbers, numbers.sensing.range) == (
        hall.replace({"sensing.range": 2.0, "arena.side": [40, 30]}).replace({"units.metres": 1.0}),
        2.0,
    )


def test_options_that_mean_a_field_take_its_units(tmp_path):
    (file := tmp_path / "hall.toml").write_text("units = {metres = 0.5, seconds = 2.0}")
    sizes = ("--arena", "10 m", "--range", "2 m", "--steps", "1 min")
    found = json_of("assess", file, *sizes, "--runs", 3, "--robots", 4, "--tasks", 4)["scenario"]
    assert (found["arena"]["side"], found["sensing"]["range"], found["run"]["steps"]) == (20.0, 4.0, 30)
    assert dimension(HALL, "radio.range=1 m:2 m") == Axis("radio.range", 2.0, 4.0)
    assert dimension(HALL, "run.steps=1 min|.5 h") == Axis("run.steps", choices=(30, 900))
    with pytest.raises(ScenarioError, match="must be a length, not a time"):
        dimension(HALL, "radio.range=1 s:2 s")


@pytest.mark.parametrize(
    ("path", "text", "message"),
    [
        ("sensing.range", "6 feet", "has the unknown unit feet; write a length in m, cm, mm or km"),
        ("sensing.range", "6 s", "must be a length, not a time; write a length in m"),
        ("robots.speed", "6 m", "must be a speed, not a length; write a speed such as"),
        ("run.steps", "6 m/s", "must be a time, not a speed; write a time in s"),
        ("tasks.arrival_rate", "6 per day", "has the unknown unit /day; write a rate such as"),
        ("run.steps", "0.3 s", "is shorter than half a step; write a longer time"),
        ("run.steps", "0 s", "is 0 steps, and must be ≥ 1; the paper uses 1000"),
        ("robots.diameter", "1e99 m", "is 3.33333e+99 units, and must be ≤ 1000000; the paper uses 1.0"),
        ("sensing.range", "6 m", "is 20 units, and must be at most half the side of the torus"),
        ("sensing.range", "٦ m", "must be a number"),
        ("sensing.range", "6 m" + " " * 90, "must be a number"),
        ("acting.start", "6 m", "must be a time, not a length"),
    ],
)
def test_a_wrong_quantity_is_one_problem_with_the_text(path, text, message):
    (problem,) = problems_of(given(path, text, units=SIZES))
    assert (problem.path, problem.value) == (path, text)
    assert message in str(problem)


@pytest.mark.parametrize("metres", [None, 0, float("nan"), True, "1 m", 10**400])
def test_a_quantity_needs_the_size_of_a_unit_and_all_problems_are_told_at_once(metres):
    sizes = {} if metres is None else {"metres": metres}
    with pytest.raises(ScenarioError) as error:
        Scenario(units=sizes, robots={"speed": "1 m/s"}, sensing={"range": "1 m"}, run={"steps": 0})
    told = {problem.path: str(problem) for problem in error.value.problems}
    assert told.keys() == {"robots.speed", "sensing.range", "run.steps", *(["units.metres"] * bool(sizes))}
    assert "needs units.metres and units.seconds; set units.metres = 0.5" in told["robots.speed"]
    assert "needs units.metres; set units.metres = 0.5" in told["sensing.range"]


def test_the_schema_accepts_quantities_of_the_dimension():
    checker = Draft202012Validator(Scenario.model_json_schema())
    assert all(checker.is_valid(given(path, text)) for path, (text, _) in QUANTITIES.items())
    for path, text in {"run.steps": "6 m", "robots.speed": "6", "sensing.range": "6 feet"}.items():
        assert not checker.is_valid(given(path, text)), path


def test_commands_print_times_and_distances_in_units_but_not_in_json(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    swarm = 'acting.start = 20\ndecision.strategy = "census"\nrun.steps = 300\n'
    Path("plain.toml").write_text(swarm)
    Path("hall.toml").write_text(f"units = {{metres = 0.5, seconds = 2.0}}\n{swarm}")
    plain, hall = (
        output_of("run", file, "--runs", "20", "--details") for file in ("plain.toml", "hall.toml")
    )
    for shown in (r"\([0-9.]+ m\)", r"[ (][0-9]+ min( [0-9]+ s)?(\)| to )"):
        assert re.search(shown, hall)
        assert not re.search(shown, plain)
    plain, hall = (json_of("run", file, "--runs", "20") for file in ("plain.toml", "hall.toml"))
    assert hall["scenario"].pop("units") == {"metres": 0.5, "seconds": 2.0}
    plain["scenario"].pop("units")
    assert plain == hall

"""A scenario as an experiment of ARGoS3 (examples/argos): what it says, and what can't be exported."""

from __future__ import annotations

import math
import re
import runpy
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from feasibee import Scenario
from feasibee.robot.firmware import header
from feasibee.strategies import STRATEGIES
from tests.other_values import NEEDS, OTHER_VALUES
from tests.places import rooms

EXAMPLE = Path(__file__).parents[2] / "examples" / "argos"
EXPORT = runpy.run_path(str(EXAMPLE / "export.py"))
argos_text, EXPORTED, FOOTBOT_DIAMETER = (
    EXPORT[name] for name in ("argos_text", "EXPORTED", "FOOTBOT_DIAMETER")
)
ARGOS = {f"{section}.{key}" for section, keys in EXPORTED.items() for key in keys}
BODIES = {"arena": {"boundary": "walls"}, "robots": {"avoid_collisions": True}}
PLACED = {"arena.boundary": "walls", "place.walls": rooms(2.0)}
UNTIL_60 = {"steps": 60, "stop_at_decision": False}
ROOMS = Scenario(**BODIES, place={"walls": rooms(0)}, sensing={"range": 9.0}, run=UNTIL_60)


def exported(**sections):
    return ElementTree.fromstring(argos_text(Scenario(**sections)))


def numbers(text):
    return [float(part) for part in text.split(",")]


def problems(scenario):
    """Return the lines that say why a scenario can't be exported, by path."""
    with pytest.raises(ValueError, match="; ") as caught:
        argos_text(scenario)
    return {line.partition(" = ")[0]: line for line in str(caught.value).split("\n")}


def test_the_committed_experiments_are_those_of_the_scenarios_beside_them():
    files = sorted(EXAMPLE.glob("*.toml"))
    assert [file.stem for file in files] == ["bodies", "torus", "walls"]
    for file in files:
        assert file.with_suffix(".argos").read_text() == argos_text(Scenario.read(file))


def test_lengths_are_metres_and_a_unit_is_a_foot_bot():
    found = exported(
        arena={"side": [30.0, 20.0]},
        robots={"speed": 0.5, "diameter": 2.0},
        sensing={"range": 3.0},
        radio={"range": 5.0},
        walk={"mean_run": 12.5},
    )
    unit = FOOTBOT_DIAMETER / 2
    assert numbers(found.find(".//world").get("size")) == pytest.approx([30 * unit, 20 * unit], abs=1e-9)
    assert numbers(found.find(".//sensing").get("range")) == pytest.approx([3 * unit], abs=1e-9)
    assert numbers(found.find("loop_functions/radio").get("range")) == pytest.approx([5 * unit], abs=1e-9)
    assert numbers(found.find(".//walk").get("metres_per_step")) == pytest.approx([0.5 * unit], abs=1e-9)
    assert found.find(".//walk").get("mean_run") == "12.5"


def test_a_decision_has_all_its_fields():
    found = exported(
        decision={
            "strategy": "k-unanimity",
            "parameters": {"k": 4.0},
            "exploration": 7.5,
            "gain": 20.0,
            "dissemination_floor": 3,
            "quality_floor": 1,
            "listen": {"last": 5},
            "inbox_size": 9,
            "own_vote": False,
            "ties": "random-message",
            "start": "first-sight",
            "declare": {"quorum": 0.875, "rounds": 2, "heard": 4},
            "threshold": 0.8,
        },
        sensing={"miss": 0.125, "count_self": True},
        radio={"loss": 0.25},
        run={"steps": 300},
    )
    assert found.find(".//decision").attrib == {
        "strategy": "k-unanimity",
        "exploration": "7.5",
        "gain": "20",
        "id_bits": "5",
        "dissemination_floor": "3",
        "quality_floor": "1",
        "listens_for": "5",
        "inbox_size": "9",
        "every_message": "false",
        "own_vote": "false",
        "random_ties": "true",
        "first_sight": "true",
        "declare_rounds": "2",
        "declare_heard": "4",
        "declare_quorum": "0.875",
        "k": "4",
    }
    assert found.find("controllers//radio").get("loss") == "0.25"
    assert found.find(".//sensing").get("miss") == "0.125"
    assert found.find(".//sensing").get("count_self") == "true"
    run = found.find("loop_functions/run")
    assert (run.get("steps"), run.get("threshold"), run.get("stop_at_decision")) == ("300", "0.8", "false")


@pytest.mark.parametrize(
    ("strategy", "name", "value", "text"),
    [
        ("k-unanimity", "k", 2.5, "3"),
        ("k-unanimity", "k", 0.0, "1"),
        ("k-unanimity", "k", 1e6, "65535"),
        ("bayes", "positive_feedback", 1.0, "true"),
        ("bayes", "positive_feedback", 0.0, "false"),
        ("bayes", "credence", 0.8, "0.8"),
    ],
)
def test_parameters_have_the_types_of_c(strategy, name, value, text):
    found = exported(decision={"strategy": strategy, "parameters": {name: value}})
    assert found.find(".//decision").get(name) == text


def test_bodies_have_walls_physics_and_proximity_and_points_have_none():
    bodies = exported(**BODIES)
    walls = {box.get("id"): numbers(box.find("body").get("position"))[:2] for box in bodies.iter("box")}
    middle = 10 * FOOTBOT_DIAMETER + 0.05  # walls are 0.1 m thick, around the arena
    assert walls == {
        "wall_north": pytest.approx([0, middle], abs=1e-8),
        "wall_south": pytest.approx([0, -middle], abs=1e-8),
        "wall_east": pytest.approx([middle, 0], abs=1e-8),
        "wall_west": pytest.approx([-middle, 0], abs=1e-8),
    }
    assert bodies.find("physics_engines/dynamics2d") is not None
    assert bodies.find(".//footbot_proximity") is not None
    points = exported(arena={"boundary": "walls"})
    assert list(points.iter("box")) == []
    assert points.find("physics_engines/pointmass3d").get("iterations") == "1"
    assert points.find(".//footbot_proximity") is None


def test_a_places_walls_are_boxes():
    scenario = ROOMS.replace(
        {"place.walls": [*rooms(2.0), [[3.0, 3.0], [5.0, 4.0], [4.0, 6.0]]], "place.cell": 0.5}
    )
    metres, drawn = FOOTBOT_DIAMETER / 2, np.zeros((40, 40), int)  # a cell
    boxes = [
        each for each in ElementTree.fromstring(argos_text(scenario)).iter("box") if "place" in each.get("id")
    ]
    for box in boxes:
        middle = np.array(numbers(box.find("body").get("position"))[:2]) / metres + 20
        half = np.array(numbers(box.get("size"))[:2]) / metres / 2
        (left, low), (right, top) = np.rint([middle - half, middle + half]).astype(int)
        drawn[low:top, left:right] += 1
    assert np.array_equal(drawn, scenario.plan.walls)
    assert len(boxes) < scenario.plan.walls.any(axis=1).sum()  # equal runs of rows are one


def test_points_have_no_boxes():
    found = problems(ROOMS.replace({"robots.avoid_collisions": False}))
    assert found.keys() == {"robots.avoid_collisions"}


def test_each_field_that_must_have_its_default_is_named_with_a_remedy_that_works():
    """Deflecting robots were exported as standing ones: a field that nobody lists must be an error."""
    for path in OTHER_VALUES.keys() - ARGOS:
        changed = Scenario().replace({**NEEDS.get(path, {}), path: OTHER_VALUES[path]})
        assert problems(changed)[path].partition("; ")[2].startswith(("set it to ", f"leave out {path}"))


def test_each_field_that_can_be_exported_changes_the_experiment():
    for path in ARGOS:
        needs = {"robots.avoid_collisions": {"arena.boundary": "walls"}, "place.cell": PLACED}
        base = {"robots.avoid_collisions": path.startswith("place"), **needs.get(path, NEEDS.get(path, {}))}
        scenario = Scenario().replace(base)
        assert argos_text(scenario.replace({path: OTHER_VALUES[path]})) != argos_text(scenario), path


def test_all_problems_are_raised_at_once():
    scenario = Scenario().replace(
        {
            "arena.side": 100.0,
            "robots.count": 2000,
            "robots.avoid_collisions": True,
            "decision.dissemination_floor": 70_000,
            "decision.quality_floor": 70_000,
            "decision.listen": {"last": 70_000},
            "decision.declare": {"quorum": 0.12345, "rounds": 70_000, "heard": 70_000},
            "radio.id_bits": 8,
        }
    )
    assert problems(scenario).keys() == {
        "arena.boundary",
        "robots.count",
        "radio.id_bits",
        "decision.dissemination_floor",
        "decision.quality_floor",
        "decision.listen",
        "decision.declare.quorum",
        "decision.declare.rounds",
        "decision.declare.heard",
    }


@pytest.mark.parametrize(
    ("tables", "path"),
    [
        *(
            ({"decision": {"strategy": each}}, "decision.strategy")
            for each in ("census", str(EXAMPLE.parent / "strategies" / "witness.py"))
        ),
        ({"events": [{"step": 5, "tasks": 3}]}, "events"),
    ],
)
def test_knowledge_files_of_users_and_events_cannot_be_exported(tables, path):
    assert problems(Scenario(**tables)).keys() == {path}


def test_the_script_prints_the_experiment_or_only_errors(tmp_path):
    def printed(toml):
        (tmp_path / "mine.toml").write_text(toml)
        script = [sys.executable, EXAMPLE / "export.py", tmp_path / "mine.toml"]
        return subprocess.run(script, capture_output=True, text=True, check=False)

    assert printed("tasks.count = 7").stdout == argos_text(Scenario(tasks={"count": 7}))
    failed = printed("radio.id_bits = 8\nfaults.stubborn = 0.5")
    assert (failed.returncode, failed.stdout) == (1, "")
    assert failed.stderr.count("can't be exported to ARGoS") == 2


def test_the_example_knows_every_strategy_that_can_be_exported():
    table = re.findall(r'\{"([\w-]+)", &feasibee_', (EXAMPLE / "mind.c").read_text())
    assert table == [name for name in STRATEGIES if name in table]
    assert set(table) == {name for name, strategy in STRATEGIES.items() if not strategy.knowledge}


@pytest.mark.slow
def test_the_example_builds_and_a_swarm_decides(tmp_path):
    if shutil.which("argos3") is None or shutil.which("cmake") is None:
        pytest.skip("needs ARGoS3, built from source as docs/argos.md says, and Debian's package cmake")
    folder = tmp_path / "argos"
    shutil.copytree(EXAMPLE, folder, ignore=shutil.ignore_patterns("build", "*.csv"))
    (folder / "feasibee.h").write_text(header())
    prefix = Path(shutil.which("argos3")).parent.parent
    short = {"run": {"steps": 50}}
    for name in (name for name, each in STRATEGIES.items() if not each.knowledge):
        (folder / f"{name}.argos").write_text(argos_text(Scenario(decision={"strategy": name}, **short)))
    (folder / "rooms.argos").write_text(argos_text(ROOMS))
    for command in (
        ["cmake", "-B", "build", f"-DCMAKE_PREFIX_PATH={prefix}"],
        ["cmake", "--build", "build"],
        *(["argos3", "-z", "-c", file] for file in sorted(folder.glob("*.argos"))),
    ):
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
    rows = [line.split(",") for line in (folder / "runs.csv").read_text().splitlines()]
    names = [file.stem for file in sorted(folder.glob("*.argos"))]
    ends = dict(zip(names, rows, strict=True))
    assert [ends[world][1] in ("feasible", "infeasible") for world in ("bodies", "torus", "walls")] == [
        True
    ] * 3
    assert {row[3] for name, row in ends.items() if name in STRATEGIES} == {"50"}
    *_, way, meetings, robots, tasks = map(float, ends["torus"][2:])
    assert way == pytest.approx(FOOTBOT_DIAMETER, rel=1e-3)
    assert meetings < robots
    in_range = math.pi * 2**2 / 20**2  # of a place on the torus, sight covers this share
    assert (robots, tasks) == pytest.approx((19 * in_range, 20 * in_range), rel=0.4)
    assert float(ends["rooms"][7]) == pytest.approx(
        6.57, rel=0.1
    )  # 8.9 tasks are in range, 6.57 in the same room
    step, feasible, infeasible, _ = (folder / "steps.csv").read_text().splitlines()[-1].split(",")
    assert step == ends["walls"][2]  # the last in order of names
    assert max(int(feasible), int(infeasible)) > 18

"""A scenario as an experiment of ARGoS3 (examples/argos): what it says, and what can't be exported."""

from __future__ import annotations

import re
import runpy
import shutil
import subprocess
import sys
from pathlib import Path

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
PLACED = {"arena.boundary": "walls", "place.walls": rooms(2.0)}
OWN = [Path(__file__).with_name(name) for name in ("points.toml", "rooms.toml")]


def problems(scenario):
    """Return the lines that say why a scenario can't be exported, by path."""
    with pytest.raises(ValueError, match="; ") as caught:
        argos_text(scenario)
    return {line.partition(" = ")[0]: line for line in str(caught.value).split("\n")}


def test_the_committed_experiments_are_those_of_the_scenarios_beside_them():
    """Beside this file is one with another value in each field, and one with walls in the arena."""
    files = sorted(EXAMPLE.glob("*.toml"))
    assert [file.stem for file in files] == ["bodies", "torus", "walls"]
    for file in (*files, *OWN):
        assert file.with_suffix(".argos").read_text() == argos_text(Scenario.read(file))


@pytest.mark.parametrize(("value", "text"), [(0.0, "1"), (1e6, "65535")])
def test_a_parameter_has_the_type_of_c(value, text):
    scenario = Scenario(decision={"strategy": "k-unanimity", "parameters": {"k": value}})
    assert f' k="{text}"' in argos_text(scenario)


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


@pytest.mark.parametrize(
    ("changes", "paths"),
    [
        (
            {
                "arena.side": 100.0,
                "robots.count": 2000,
                "robots.avoid_collisions": True,
                "decision.dissemination_floor": 70_000,
                "decision.quality_floor": 70_000,
                "decision.listen": {"last": 70_000},
                "decision.declare": {"quorum": 0.12345, "rounds": 70_000, "heard": 70_000},
                "radio.id_bits": 8,
            },
            "arena.boundary robots.count radio.id_bits decision.dissemination_floor decision.quality_floor "
            "decision.listen decision.declare.quorum decision.declare.rounds decision.declare.heard",
        ),
        ({**PLACED, "robots.avoid_collisions": False}, "robots.avoid_collisions"),
        ({"decision.strategy": "census"}, "decision.strategy"),
        ({"decision.strategy": str(EXAMPLE.parent / "strategies" / "witness.py")}, "decision.strategy"),
        ({"events": [{"step": 5, "tasks": 3}]}, "events"),
    ],
)
def test_all_that_cannot_be_exported_is_told_at_once(changes, paths):
    assert problems(Scenario().replace(changes)).keys() == set(paths.split())


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
        pytest.skip("needs ARGoS3, built as examples/argos/README.md says, and Debian's package cmake")
    folder = tmp_path / "argos"
    shutil.copytree(EXAMPLE, folder, ignore=shutil.ignore_patterns("build", "*.csv"))
    (folder / "feasibee.h").write_text(header())
    prefix = Path(shutil.which("argos3")).parent.parent
    short = {"run": {"steps": 50}}
    for name in (name for name, each in STRATEGIES.items() if not each.knowledge):
        (folder / f"{name}.argos").write_text(argos_text(Scenario(decision={"strategy": name}, **short)))
    closed = Scenario.read(OWN[1]).replace({"place.walls": rooms(0), "place.cell": 0.1})
    (folder / "rooms.argos").write_text(argos_text(closed))
    for command in (
        ["cmake", "-B", "build", f"-DCMAKE_PREFIX_PATH={prefix}"],
        ["cmake", "--build", "build"],
        *(["argos3", "-z", "-c", file] for file in sorted(folder.glob("*.argos"))),
    ):
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
    rows = [line.split(",") for line in (folder / "runs.csv").read_text().splitlines()]
    names = [file.stem for file in sorted(folder.glob("*.argos"))]
    ends = dict(zip(names, rows, strict=True))
    assert {ends[world][1] for world in ("bodies", "torus", "walls")} <= {"feasible", "infeasible"}
    assert {row[3] for name, row in ends.items() if name in STRATEGIES} == {"50"}
    assert float(ends["torus"][4]) == pytest.approx(FOOTBOT_DIAMETER, rel=1e-3)  # the way of a step
    assert float(ends["rooms"][7]) == pytest.approx(6.57, rel=0.1)  # of 8.9 tasks in range

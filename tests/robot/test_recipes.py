"""The recipes of docs/recipes.md run against stand-ins for their robots, or against a simulator of theirs."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from importlib.util import find_spec
from pathlib import Path

import pytest

from benchmarks.sizes import PROCESSORS
from feasibee.robot.firmware import header
from tests.robot import boards, crazyflies
from tests.robot.driving import needs
from tests.robot.driving import run as run_command

ROOT = Path(__file__).parents[2]
RECIPES = ROOT / "examples" / "recipes"
RECIPES_PAGE = ROOT / "docs" / "recipes.md"
FIRMWARE = (
    *("ch.h", "hal.h", "leds.h", "main.h", "memory_protection.h", "motors.h", "selector.h"),
    *(f"ircom/ircom{part}.h" for part in ("", "Messages", "Receive", "Send")),
)
"""Headers of the e-puck2's firmware."""
OLD_NAMES = """
from rps import robotarium
from rps.utilities import barrier_certificates as certificates
certificates.create_uni_barrier_certificate_with_boundary = (
    certificates.create_unicycle_barrier_certificate_with_boundary
)
robotarium.Robotarium.debug = robotarium.Robotarium.call_at_scripts_end
"""
"""What version 0.0.0 of the Robotarium's simulator calls otherwise than 2.1.0, which no registry has."""


def run(source, folder, *arguments, path=(), options=()):
    """Run a recipe in a folder, with folders in front of its modules; return the lines that it prints."""
    script = folder / "recipe.py"
    script.write_text(source)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, path)), "MPLBACKEND": "agg"}
    command = [sys.executable, *options, str(script), *map(str, arguments)]
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@pytest.mark.skipif(find_spec("cflib") is None, reason="no cflib")
def test_crazyflies_fly_within_their_arena_until_they_agree(tmp_path):
    source = (RECIPES / "crazyflie.py").read_text()
    assert "\nSTEP = 1.0 " in source
    drones = [crazyflies.Crazyflie((0.7 * x, -0.4)) for x in (-1, 0, 1)]
    try:
        lines = run(
            "import random\nrandom.seed(1)\n" + source.replace("\nSTEP = 1.0 ", "\nSTEP = 0.02 "),
            tmp_path,
            *(drone.uri for drone in drones),
            path=[ROOT / "src"],
        )
    finally:
        for drone in drones:
            drone.stop()
    assert lines[-1] in ("feasible", "infeasible")
    for drone in drones:
        assert [drone.flights[0].command, drone.flights[-1].command] == [crazyflies.TAKE_OFF, crazyflies.LAND]
        on_the_way = drone.flights[1:-1]
        assert {(each.command, each.height) for each in on_the_way} == {(crazyflies.GO_TO, 0.5)}
        assert all(max(abs(each.x), abs(each.y)) <= 1.4 for each in on_the_way)


@pytest.mark.parametrize(("flags", "printed"), [([], "01 29 11"), (["-DTASK=1"], "00 19 10")])
def test_an_epuck2_decides_with_its_neighbours(flags, printed, tmp_path):
    needs("cc", "gcc")
    program = tmp_path / "program"
    run_command(["cc", *built(tmp_path), *flags, str(boards.SOURCES / "epuck2s.c"), "-o", str(program)])
    assert run_command([str(program)]).strip() == printed


def test_an_epuck2_compiles_for_its_processor(tmp_path):
    compiler = PROCESSORS["Cortex-M4"].compiler
    needs(compiler[0], PROCESSORS["Cortex-M4"].packages)
    run_command(
        [*compiler, *built(tmp_path), "-Os", "-c", str(RECIPES / "epuck2.c"), "-o", str(tmp_path / "robot.o")]
    )


def built(folder):
    """Write the headers of an e-puck2's program to a folder, and return the options of the compiler."""
    for name in FIRMWARE:
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text('#pragma once\n#include "epuck2.h"\n')
    (folder / "feasibee.h").write_text(header("dmmd"))
    include = [f"-I{each}" for each in (folder, RECIPES, boards.SOURCES / "vendor")]
    return ["-std=gnu99", "-Wall", "-Wextra", "-Werror", *include]


@pytest.mark.skipif(find_spec("rps") is None, reason="no simulator of the Robotarium")
def test_robots_of_the_robotarium_decide_without_errors(tmp_path):
    source = (RECIPES / "robotarium.py").read_text()
    assert " 10, 600, 40, " in source  # fewer iterations per step are quicker
    lines = run(
        OLD_NAMES + source.replace(" 10, 600, 40, ", " 10, 600, 4, "), tmp_path, 3, 1, path=[ROOT / "src"]
    )
    decision, steps = next(line.split() for line in lines if line.startswith(("feasible", "infeasible")))
    opinions = [int(each) for each in (tmp_path / "opinions.csv").read_text().split()]
    assert len(opinions) == int(steps) + 1
    assert opinions[-1] == {"feasible": 10, "infeasible": 0}[decision]
    assert not [line for line in lines if "boundaries" in line or "collided" in line]


def test_the_controller_runs_from_the_archive_that_is_uploaded(tmp_path):
    """It needs only the standard library: neither site-packages nor the rest of the package."""
    command = next(line for line in RECIPES_PAGE.read_text().splitlines() if line.startswith("git archive"))
    named = command.partition("HEAD:src ")[2].split()
    with zipfile.ZipFile(tmp_path / "feasibee.zip", "w") as archive:
        for path in (ROOT / "src" / each for each in named):
            for file in [path] if path.is_file() else path.glob("*.py"):
                archive.write(file, file.relative_to(ROOT / "src"))
    source = (RECIPES / "robotarium.py").read_text()
    lines = [line for line in source.splitlines() if line.startswith(("sys.path", "from feasibee"))]
    assert len(lines) == 3
    print_it = ["import sys", *lines, "print(sorted(STRATEGIES)[0], Controller.__module__)"]
    assert run("\n".join(print_it), tmp_path, options=["-S"]) == ["bayes feasibee.robot.controller"]

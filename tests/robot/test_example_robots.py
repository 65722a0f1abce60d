"""The examples for boards compile, and run on stand-ins for their libraries."""

from __future__ import annotations

import pytest

from feasibee.robot.firmware import header
from feasibee.robot.sizes import PROCESSORS, SHARED
from tests.robot import boards
from tests.robot.driving import needs, run

EXAMPLES = boards.SOURCES.parents[2] / "examples"
INFEASIBLE_FOR_GOOD = "301"
"""The LED bright red, the robot silent, a right checksum."""
TASK = "@11"
"""The LED blue, a message that says so, a right checksum."""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "feasibee.h").write_text(header("dmmd"))
    return tmp_path


def compiled(folder, compiler, *sources):
    """Compile an example with the stand-ins, warnings as errors, and return the program."""
    include = [f"-I{each}" for each in (folder, boards.SOURCES, boards.SOURCES / "vendor")]
    program = folder / "program"
    run([*compiler, "-Wall", "-Wextra", "-Werror", *include, *map(str, sources), "-o", str(program)])
    return program


@pytest.mark.parametrize(("flags", "printed"), [([], INFEASIBLE_FOR_GOOD), (["-DTASK=1"], TASK)])
def test_a_kilobot_declares_with_its_neighbours_and_fits(flags, printed, folder):
    processor = PROCESSORS["ATmega328P"]
    needs(processor.compiler[0], processor.packages)
    compiler = [*processor.compiler, *SHARED, *flags]
    program = compiled(folder, compiler, EXAMPLES / "kilobot" / "robot.c", boards.SOURCES / "kilobots.c")
    flash, ram = processor.bytes_of(program)
    assert flash <= 8 * 1024
    assert ram <= 512
    board = boards.BOARDS["ATmega328P"]
    needs(board.simulator[0], board.package)
    assert printed in run([*board.simulator, str(program)])


def test_an_esp32_declares_with_its_neighbours(folder):
    needs("c++", "g++")
    sketch = EXAMPLES / "arduino" / "feasibee_robot"
    program = compiled(
        folder, ["c++", "-std=gnu++17", "-include", "Arduino.h", f"-I{sketch}"], boards.SOURCES / "esp32.cpp"
    )
    assert run([str(program)]).split() == ["infeasible", "2"]

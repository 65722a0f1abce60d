"""feasibee.h: what it is made of, and that it compiles without warnings."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import feasibee.robot.firmware
from feasibee.base.errors import FeasibeeError
from feasibee.robot.firmware import acting_header, header, needs_double
from feasibee.robot.sizes import PROCESSORS, SOURCE
from feasibee.scenario.plugins import load
from feasibee.strategies import STRATEGIES
from tests.commands import invoke, refused_in_a_line
from tests.robot.driving import built

FOLDER = Path(feasibee.robot.firmware.__file__).parent / "c"
PROGRAM = '#include "feasibee.h"\nint main(void) { return 0; }\n'


def constants(text):
    """Return the strategies that a text defines."""
    return re.findall(r"^static const struct feasibee_strategy feasibee_(\w+) =", text, re.MULTILINE)


def test_the_header_has_all_strategies():
    assert sorted(constants(header())) == sorted(name.replace("-", "_") for name in STRATEGIES)


@pytest.mark.parametrize("name", STRATEGIES)
def test_a_trimmed_header_has_its_strategy_and_compiles(name, tmp_path):
    text = header(name, inbox=32)
    assert name.replace("-", "_") in constants(text)
    assert len(constants(text)) < len(constants(header()))
    built(tmp_path, PROGRAM, text, "-fsyntax-only")


@pytest.mark.parametrize("compiler", [["cc", "-std=c99"], ["g++", "-x", "c++", "-std=c++11"]])
@pytest.mark.parametrize(
    "options",
    [
        [],
        ["-DFEASIBEE_DOUBLE"],
        ["-DFEASIBEE_WORDS=4", "-DFEASIBEE_VALUES=0"],
        ["-DFEASIBEE_WORDS=4", "-DFEASIBEE_DOUBLE", "-DFEASIBEE_CLASSES=3"],
        ["-DFEASIBEE_WORDS=4", "-DFEASIBEE_DOUBLE", "-DFEASIBEE_INT32", "-DFEASIBEE_BOUNDS"],
    ],
)
def test_the_header_compiles_without_warnings(compiler, options, tmp_path):
    options = [*options, "-fsyntax-only", "-Wno-shadow"]  # C++ calls a function of a struct's name a shadow
    built(tmp_path, PROGRAM, header(), *options, command=compiler, packages="g++")


IN_WHOLE_NUMBERS = ("dmmd", "dmvd", "voter", "majority", "cross-inhibition")


@pytest.mark.parametrize(
    "name", [*IN_WHOLE_NUMBERS, pytest.param("dc", marks=pytest.mark.xfail(strict=True))]
)
def test_strategies_in_whole_numbers_use_no_register_for_floats(name, tmp_path):
    """And memory, setting and parameters neither; `dc` shows that the compiler finds floats."""
    if not PROCESSORS["x86-64"].found:
        pytest.skip("needs gcc on x86-64")
    text = header(name, inbox=32)
    options = ["-Os", "-S", "-mgeneral-regs-only", f"-DSTRATEGY=feasibee_{name.replace('-', '_')}"]
    built(
        tmp_path, SOURCE.read_text(), text, *options, "-Wno-conversion", "-Wno-sign-conversion", "-Wno-undef"
    )


def test_a_constant_modulates_without_double(tmp_path):
    text = "MODULATES = True\n\n\ndef decide(mind, inbox):\n    return mind.opinion\n"
    (tmp_path / "mine.py").write_text(text)
    mine = load(str(tmp_path / "mine.py"))
    assert not needs_double(mine)
    assert "feasibee_strategy feasibee_mine = {\n    true, false, 0, true,\n" in header(mine)


def test_each_part_is_in_the_header_once():
    text = header()
    assert text.count("#ifndef FEASIBEE_H\n") == 1
    assert '#include "' not in text
    for path in {*FOLDER.glob("*.h")} - {FOLDER / "given.h", FOLDER / "acting.h"}:  # files of their own
        assert text.count(path.read_text().partition("\n")[0]) == 1, path.name


def test_parts_are_short():
    assert all(len(path.read_text().splitlines()) <= 400 for path in FOLDER.glob("*.h"))
    assert all(len(line) <= 120 for path in FOLDER.glob("*.h") for line in path.read_text().splitlines())


def test_the_command_prints_the_header():
    assert invoke("robot", "header").stdout == header()
    trimmed = invoke("robot", "header", "dmmd", "dc", "--inbox", 32).stdout
    assert trimmed == header(["dmmd", "dc"], inbox=32)
    assert "#define FEASIBEE_INBOX 32\n" in trimmed


@pytest.mark.parametrize("compiler", [["cc", "-std=c99"], ["g++", "-x", "c++", "-std=c++11"]])
def test_the_header_of_robots_that_act_stands_alone_and_compiles(compiler, tmp_path):
    text = invoke("robot", "header", "--acting").stdout
    assert text == acting_header()
    assert '#include "' not in text
    built(tmp_path, PROGRAM, text, "-fsyntax-only", "-Wno-shadow", command=compiler, packages="g++")
    assert "leave out STRATEGY" in refused_in_a_line("robot", "header", "dmmd", "--acting")


def test_values_are_left_out_where_no_strategy_sends_any():
    assert "#define FEASIBEE_VALUES 0\n" in header(["dmmd", "voter"])
    assert "#define FEASIBEE_VALUES 0\n" not in header(["dmmd", "dc"])


def test_an_unknown_strategy_is_an_error():
    line = refused_in_a_line("robot", "header", "dmdm")
    assert line.startswith("feasibee: strategy = 'dmdm': must be one of dmmd, dmvd,")


@pytest.mark.parametrize("inbox", [0, -1, 65_536])
def test_an_impossible_inbox_is_an_error(inbox):
    with pytest.raises(FeasibeeError, match=f"inbox = {inbox}: must be from 1 to 65535 senders; use 32"):
        header(inbox=inbox)

"""The C header on an ATmega328P, the processor of a Kilobot, in simavr: 8 bits, and doubles of 32."""

from __future__ import annotations

import pytest

from benchmarks.sizes import names_in_c
from tests.robot import boards

FLOATING = ["average", "bayes"]
"""The strategies that compute with floating point."""
WHOLE = [name for name in names_in_c(knowledge=False) if name not in FLOATING]


def both(strategy, folder, steps):
    """Return what the processor prints, and Python's."""
    lines, _ = boards.outputs(boards.build("ATmega328P", strategy, folder, steps))
    return lines, boards.expected(strategy, steps)


@pytest.mark.quick(1)
@pytest.mark.parametrize("frames", [False, True])
def test_dmmd_equals_python_and_fits_a_kilobot(frames, tmp_path):
    """Flash and RAM include the test's own generator and printing, and with frames those that it makes."""
    flags = ['-DFRAMES="dmmd"'] if frames else []
    program = boards.build("ATmega328P", "dmmd", tmp_path, 300, *flags)
    lines, stack = boards.outputs(program)
    assert lines == boards.expected("dmmd", 300, frames)
    assert program.flash <= 8 * 1024
    assert program.ram + stack <= 512


@pytest.mark.slow
@pytest.mark.parametrize("strategy", WHOLE)
def test_strategies_of_whole_numbers_equal_python(strategy, tmp_path):
    lines, python = both(strategy, tmp_path, 5000)
    assert lines == python


@pytest.mark.slow
def test_bayes_equals_python(tmp_path):
    lines, python = both("bayes", tmp_path, 2000)
    assert lines == python


@pytest.mark.slow
def test_average_differs_by_one_in_the_last_of_16_bits(tmp_path):
    """No opinion or phase differs, and few of the values do: docs/targets.md says how many."""
    lines, python = both("average", tmp_path, 20_000)
    assert [line[:4] for line in lines] == [line[:4] for line in python]
    distances = [
        abs(int(line[4:], 16) - int(other[4:], 16)) for line, other in zip(lines, python, strict=True)
    ]
    assert max(distances) == 1
    assert sum(distances) < 0.003 * len(distances)

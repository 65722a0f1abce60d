"""Functions of knowledge in C whose limits no run of a test reaches: large totals and counts."""

from __future__ import annotations

import ctypes
import random
import shutil
import subprocess
from fractions import Fraction

import pytest

from feasibee.firmware import header
from feasibee.strategies import totals
from tests.firmware.swarms import STRICT

SOURCE = """
#define FEASIBEE_WORDS 16
#include "feasibee.h"
uint32_t row_of(uint32_t robots, uint32_t tasks);
void write_counts(uint64_t robots_found, uint64_t tasks_found, uint32_t *counts);
uint32_t row_of(uint32_t robots, uint32_t tasks)
{
    return feasibee_totals_row_of(robots, tasks);
}
void write_counts(uint64_t robots_found, uint64_t tasks_found, uint32_t *counts)
{
    feasibee_write_counts(robots_found, tasks_found, &counts[0], &counts[1]);
}
"""
GENERATOR_SEED = 17


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """Return the functions of SOURCE."""
    if shutil.which("cc") is None:
        pytest.skip("needs a C compiler: Debian's package gcc")
    folder = tmp_path_factory.mktemp("numbers")
    (folder / "feasibee.h").write_text(header("totals"))
    (folder / "numbers.c").write_text(SOURCE)
    out = folder / "numbers.so"
    subprocess.run(["cc", *STRICT, "-shared", "-fPIC", folder / "numbers.c", "-o", out], check=True)
    return ctypes.CDLL(str(out))


def number_of(draw, bits):
    """Return a random number of a random length, often just below a power of two."""
    length = draw.randrange(bits + 1)
    return max(0, draw.choice([draw.getrandbits(bits) >> (bits - length), 2**length - draw.randrange(4)]))


def test_large_totals_are_rounded_as_in_python(compiled):
    draw = random.Random(GENERATOR_SEED)
    for _ in range(20_000):
        robots, tasks = number_of(draw, 30), number_of(draw, 30)
        assert compiled.row_of(robots, tasks) == totals.row_of(robots, tasks)


def test_large_counts_keep_their_ratio(compiled):
    draw = random.Random(GENERATOR_SEED)
    counts = (ctypes.c_uint32 * 2)()
    for _ in range(20_000):
        robots, tasks = number_of(draw, 60), number_of(draw, 60)
        compiled.write_counts(ctypes.c_uint64(robots), ctypes.c_uint64(tasks), counts)
        assert sum(counts) < 2**32
        if robots + tasks < 2**32:
            assert [*counts] == [robots, tasks]
        else:
            exact = Fraction(robots, robots + tasks)
            assert abs(Fraction(counts[0], sum(counts)) - exact) < Fraction(1, 2**30)

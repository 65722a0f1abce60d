"""The C header on ARM Cortex-M0 and Cortex-M4, in QEMU: every strategy equals Python in each step."""

from __future__ import annotations

import pytest

from benchmarks.sizes import names_in_c
from tests.robot import boards

BUILDS = [("Cortex-M0", ()), ("Cortex-M4", ()), ("Cortex-M4", ("-DFEASIBEE_DOUBLE",))]


@pytest.mark.parametrize(("board", "flags"), BUILDS)
@pytest.mark.parametrize("strategy", ["dmmd", "average"])
def test_a_strategy_equals_python(board, flags, strategy, tmp_path):
    lines, _ = boards.outputs(boards.build(board, strategy, tmp_path, 300, *flags))
    assert lines == boards.expected(strategy, 300)


@pytest.mark.slow
@pytest.mark.parametrize(("board", "flags"), BUILDS)
@pytest.mark.parametrize("strategy", names_in_c(knowledge=False))
def test_each_strategy_equals_python(board, flags, strategy, tmp_path):
    lines, _ = boards.outputs(boards.build(board, strategy, tmp_path, 3000, *flags))
    assert lines == boards.expected(strategy, 3000)

"""Robots that exchange frames on processors of 8 and 32 bits know and send what they do in Python."""

from __future__ import annotations

import pytest

from feasibee.robot.firmware import strategies_in_c
from tests.robot import boards, frames

SMALL = ["dmmd", "dc", "census", "tally", "estimate", "quiet-census", "turns", "totals"]
"""Strategies tried on 8 bits, where ``int`` has 16."""


def same(board, strategy, steps, folder, *flags):
    """Compare robots on a board with those in Python, step by step."""
    swarm = frames.Swarm(strategy, quiet=0.0 if "-DFEASIBEE_DOUBLE" in flags else 20.0)
    python = swarm.run(steps)
    lines, _ = boards.outputs(frames.build(board, swarm, folder, steps, *flags))
    assert lines == python


@pytest.mark.quick(2)
@pytest.mark.parametrize("strategy", SMALL)
def test_robots_on_8_bits_know_and_send_the_same(strategy, tmp_path):
    same("ATmega328P", strategy, 100, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("strategy", strategies_in_c())
def test_robots_on_32_bits_know_and_send_the_same(strategy, tmp_path):
    same("Cortex-M4", strategy, 1000, tmp_path, "-DFEASIBEE_DOUBLE")

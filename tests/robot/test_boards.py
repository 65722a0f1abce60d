"""The C header on boards equals Python: an ATmega328P of 8 bits in simavr, and ARM Cortex in QEMU."""

from __future__ import annotations

import pytest

from benchmarks.sizes import names_in_c
from feasibee.robot.firmware import needs_double
from feasibee.strategies import STRATEGIES as KINDS
from tests.robot import boards, frames

DOUBLE = "-DFEASIBEE_DOUBLE"
ARM = [("Cortex-M0", ()), ("Cortex-M4", ()), ("Cortex-M4", (DOUBLE,))]
OPINIONS = names_in_c(knowledge=False)
SMALL = ["dmmd", "dc", *(name for name, kind in KINDS.items() if kind.knowledge and not needs_double(kind))]
"""Strategies whose frames are tried on 8 bits, where ``int`` has 16; doubles have 32 bits there."""
WHOLE = [name for name in OPINIONS if not needs_double(KINDS[name])]
BUILDS = [
    *((*build, name) for build in ARM for name in (OPINIONS if build[1] else WHOLE)),
    *(
        (board, (DOUBLE,), name)
        for board in ("ATmega328P", "Cortex-M0")
        for name in OPINIONS
        if name not in WHOLE
    ),
    *(("ATmega328P", (), name) for name in WHOLE),
]
STRATEGIES = [
    *((*build, name, 200) for build in ARM for name in ("dmmd", "dc")),
    *(
        pytest.param(*build, 1000 if build[2] == "bayes" else 1500, marks=pytest.mark.slow)
        for build in BUILDS
    ),
]
FRAMES = [
    *(("ATmega328P", (), name, 60) for name in SMALL),
    *(pytest.param("Cortex-M4", (DOUBLE,), name, 400, marks=pytest.mark.slow) for name in KINDS),
]


@pytest.mark.parametrize(("board", "flags", "strategy", "steps"), STRATEGIES)
def test_a_strategy_equals_python(board, flags, strategy, steps, tmp_path):
    lines, _ = boards.outputs(boards.build(board, strategy, tmp_path, steps, *flags))
    assert lines == boards.expected(strategy, steps)


@pytest.mark.parametrize(("board", "flags", "strategy", "steps"), FRAMES)
def test_robots_that_exchange_frames_know_and_send_the_same(board, flags, strategy, steps, tmp_path):
    swarm = frames.Swarm(strategy, quiet=0.0 if DOUBLE in flags else 20.0, has_places=DOUBLE in flags)
    python = swarm.run(steps)
    lines, _ = boards.outputs(frames.build(board, swarm, tmp_path, steps, *flags))
    assert lines == python


@pytest.mark.parametrize("frames", [False, True])
def test_dmmd_equals_python_and_fits_a_kilobot(frames, tmp_path):
    """Flash and RAM include the test's own generator and printing, and with frames those that it makes."""
    flags = ['-DFRAMES="dmmd"'] if frames else []
    program = boards.build("ATmega328P", "dmmd", tmp_path, 300, *flags)
    lines, stack = boards.outputs(program)
    assert lines == boards.expected("dmmd", 300, frames)
    assert program.flash <= 8 * 1024
    assert program.ram + stack <= 512

"""The controller in C does what the controller in Python does, step by step, to the last bit."""

from __future__ import annotations

import math
import random
import struct

import pytest

from feasibee.robot.firmware import needs_double
from feasibee.strategies import STRATEGIES
from tests.robot.driving import (
    NAMES,
    SANITIZED,
    Episode,
    answers,
    assert_same,
    compiled,
    in_node,
    program,
    zig,
)

DOUBLE = "-DFEASIBEE_DOUBLE"
NEED_DOUBLE = {name for name in NAMES if needs_double(STRATEGIES[name])}


@pytest.fixture(scope="module", params=["double", "whole"])
def build(request, tmp_path_factory):
    """Return a program with sanitizers, and whether it computes in whole numbers."""
    whole = request.param == "whole"
    options = [*SANITIZED, "-DFEASIBEE_ID=uint8_t" if whole else DOUBLE]
    without = NEED_DOUBLE if whole else ()
    return [program(tmp_path_factory.mktemp("drive"), "drive.c", NAMES, *options, without=without)], whole


def test_all_strategies_without_knowledge_are_driven():
    assert {name for name, each in STRATEGIES.items() if not each.knowledge} == set(NAMES)


@pytest.mark.quick(8)
@pytest.mark.parametrize("steps", [5_000, pytest.param(50_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("strategy", NAMES)
def test_c_and_python_agree(strategy, steps, build):
    command, whole = build
    if whole and strategy in NEED_DOUBLE:
        pytest.skip("needs FEASIBEE_DOUBLE")
    assert_same(command, strategy, steps, whole)


def test_what_is_driven_is_varied():
    """Robots change their opinions, declare, are silent, and end phases."""
    states = [
        struct.unpack_from("<BB", each) for seed in range(20) for each in Episode("dmmd", seed, 500).states()
    ]
    assert {opinion for opinion, _ in states} == {1, 2}
    assert {flags & 15 for _, flags in states} >= {0, 1, 4, 6, 7, 9, 15}


@pytest.mark.slow
@pytest.mark.parametrize("options", [[DOUBLE], []], ids=["double", "whole"])
def test_webassembly_does_the_same(options, tmp_path):
    without = () if DOUBLE in options else NEED_DOUBLE
    native = program(tmp_path, "drive.c", NAMES, "-O2", *options, without=without)
    wasm = program(tmp_path, "drive.c", NAMES, *options, command=zig(), name="drive.wasm", without=without)
    for strategy in [name for name in NAMES if name not in without]:
        stream = b"".join(Episode(strategy, seed, 1_000).stream() for seed in range(20))
        assert answers(in_node(wasm), stream) == answers([native], stream)


MEANS = [
    (10, 1, 1, 0),
    (10, 3, 7, 0),
    (10, 3, 7, 1),
    (10, 1, 20, 0),
    (2.5, 1, 1, 0),
    (100, 1, 1, 0),
    (10, 0, 5, 0),
]


def test_whole_numbers_draw_the_durations_of_real_numbers(tmp_path):
    """At most one draw in 20,000 differs, and then by a step."""
    program = compiled(tmp_path, "durations.c", "-O2")
    draw = random.Random(1)
    words = [0, 1, 2**31 - 1, 2**31, 2**32 - 2, 2**32 - 1, *(draw.getrandbits(32) for _ in range(20_000))]
    for steps, part, whole, complement in MEANS:
        given = [struct.pack("<5I", int(steps * 65_536), part, whole, complement, word) for word in words]
        got = struct.unpack(f"<{len(words)}I", answers([program], b"".join(given)))
        mean = steps * (1 - part / whole if complement else part / whole)
        expected = [max(1, math.ceil(-mean * math.log((word + 1) / 2**32))) for word in words]
        errors = [abs(one - other) for one, other in zip(got, expected, strict=True)]
        assert sum(errors) <= 1, (steps, part, whole)

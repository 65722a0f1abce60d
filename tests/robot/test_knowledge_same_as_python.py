"""Strategies that pass on knowledge, in C: the same decisions, knowledge and frames as in Python."""

from __future__ import annotations

import pytest

from feasibee.robot.firmware import needs_double
from feasibee.strategies import STRATEGIES
from tests.robot.driving import SANITIZED, in_node, program, zig
from tests.robot.swarms import IN_DOUBLE, KNOWLEDGE, NAMES, assert_same, extras

NEED_DOUBLE = {name for name in NAMES if needs_double(STRATEGIES[name])}
IN_WHOLE_NUMBERS = sorted(set(KNOWLEDGE) - NEED_DOUBLE)
MANY = pytest.param(6_000, marks=pytest.mark.slow)
STEPS = pytest.mark.parametrize("steps", [1_500, MANY])


@pytest.fixture(scope="module")
def swarm(tmp_path_factory):
    return program(tmp_path_factory.mktemp("swarm"), "swarm.c", NAMES, extras(), *IN_DOUBLE, *SANITIZED)


@pytest.fixture(scope="module")
def in_whole_numbers(tmp_path_factory):
    options = extras(whole_numbers=True), "-DFEASIBEE_BOUNDS", *SANITIZED
    return program(tmp_path_factory.mktemp("whole"), "swarm.c", NAMES, *options, without=NEED_DOUBLE)


FIRST_STEPS = [edge - before for edge in (2**15, 2**16, 2**30, 2**31, 2**32) for before in (1, 20, 45)]
"""First steps of robots whose clocks soon pass a power of two, at which a word may overflow."""
RARE = [
    ("turns", {"names": [-1.0], "name_bits": [4.0, 5.0]}),  # the largest names
    ("turns", {"names": [0.0, 1.0], "quiet": [0.0]}),  # computed quiet times
    *((name, {"first_steps": FIRST_STEPS}) for name in KNOWLEDGE),
]
"""Settings whose limits random ones seldom reach."""


@STEPS
@pytest.mark.parametrize(("name", "fixed"), RARE)
def test_swarms_at_limits_do_what_they_do_in_python(name, fixed, steps, swarm):
    assert_same([swarm], name, steps, fixed=fixed)


@STEPS
@pytest.mark.parametrize("name", KNOWLEDGE)
def test_swarms_in_c_do_what_they_do_in_python(name, steps, swarm):
    assert_same([swarm], name, steps)


@pytest.mark.quick(2)
@STEPS
@pytest.mark.parametrize("name", IN_WHOLE_NUMBERS)
def test_swarms_in_whole_numbers_do_what_they_do_in_python(name, steps, in_whole_numbers):
    assert_same([in_whole_numbers], name, steps, whole_numbers=True)


@pytest.fixture(scope="module")
def in_webassembly(tmp_path_factory):
    options = extras(), *IN_DOUBLE, "-Wl,-z,stack-size=1048576"
    folder = tmp_path_factory.mktemp("wasm")
    return program(folder, "swarm.c", NAMES, *options, command=zig(), name="swarm.wasm")


@pytest.mark.slow
@pytest.mark.parametrize("name", KNOWLEDGE)
def test_swarms_in_webassembly_do_what_they_do_in_python(name, in_webassembly):
    assert_same(in_node(in_webassembly), name, 1_500)


@pytest.mark.slow
@pytest.mark.parametrize("name", IN_WHOLE_NUMBERS)
def test_clocks_that_pass_a_power_of_two_in_whole_numbers(name, in_whole_numbers):
    fixed = {"first_steps": FIRST_STEPS}
    assert_same([in_whole_numbers], name, 2_000, whole_numbers=True, fixed=fixed)

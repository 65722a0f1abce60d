"""Strategies that pass on knowledge, in C: the same decisions, knowledge and frames as in Python."""

from __future__ import annotations

import pytest

from tests.firmware.swarms import KNOWLEDGE, SANITIZED, assert_same, program

VARIANTS = {
    "turns": {
        "names": [-1.0, 0.0, 1.0, 1.0, 3.0],
        "name_bits": [4.0, 9.0, 20.0, 31.0],
        "quiet": [0.0, 20.0, 33.5],
        "tolerates": [0.0, 0.0, 1.0, 2.0],
        "looks": [1.0, 2.0],
    },
    "quiet-census": {"quiet": [0.0, 20.0, 33.5], "tolerates": [0.0, 0.0, 1.0, 2.0]},
    "totals": {"arrivals": [0.0, 1.0], "kappa": [1.19, 0.0, 1.5], "tolerates": [0.0, 0.0, 1.0, 2.0]},
    "fading": {
        "tau": [0.0, 0.0, 7.0, 60.0],
        "margin": [0.2, 0.1],
        "ratio": [0.0, 1.0],
        "sees": [1.0, 0.9],
        "fast": [0.0, 5.0],
        "bounded": [0.0, 1.0],
    },
    "fading-votes": {"tau": [0.0, 7.0], "margin": [0.2, 0.1], "ratio": [0.0, 1.0], "sees": [1.0, 0.9]},
}


@pytest.fixture(scope="module")
def swarm(tmp_path_factory):
    return program(tmp_path_factory.mktemp("swarm"), "swarm.c", "-DFEASIBEE_DOUBLE", *SANITIZED)


@pytest.mark.parametrize("name", KNOWLEDGE)
def test_swarms_in_c_do_what_they_do_in_python(name, swarm):
    assert_same([swarm], name, 4_000, VARIANTS.get(name, {}))


@pytest.mark.slow
@pytest.mark.parametrize("name", KNOWLEDGE)
def test_a_million_steps_in_c_are_those_in_python(name, swarm):
    assert_same([swarm], name, 1_000_000, VARIANTS.get(name, {}))

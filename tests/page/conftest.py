"""The compiled world, played by node."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from feasibee.page.build import WASM
from feasibee.page.lowering import numbers_of

PLAYER = Path(__file__).parent / "play.mjs"


@pytest.fixture(scope="session")
def node():
    """The JavaScript engine that runs the compiled world."""
    program = shutil.which("node")
    if program is None:
        pytest.skip("no node in PATH: install the Debian package nodejs")
    return program


@pytest.fixture
def play(node):
    """Give a function that plays runs; each gives flags by step and robot, and positions at the end."""

    def played(runs):
        cases = [
            {"numbers": numbers_of(scenario), "seed": str(seed), "run": run, "steps": scenario.run.steps}
            for scenario, seed, run in runs
        ]
        said = subprocess.run(
            [node, str(PLAYER), str(WASM)], input=json.dumps(cases).encode(), capture_output=True, check=True
        ).stdout
        at = 0
        for scenario, _, _ in runs:
            robots, steps = scenario.robots.count, scenario.run.steps + 1
            flags = np.frombuffer(said, "<u2", robots * steps, at).reshape(steps, robots)
            at += flags.nbytes
            places = np.frombuffer(said, "<u4", 2 * robots, at).reshape(2, robots).T
            at += places.nbytes
            yield flags, places
        assert at == len(said)

    return played

"""Runs by the engine in WebAssembly, in node: those that pages show."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from feasibee.base.outcomes import ACCOUNT
from feasibee.engine.compilers import zig
from feasibee.live.packet import wasm_of
from feasibee.live.scene import simulated_of
from feasibee.scenario.runs import Runs

HARNESS = Path(__file__).with_name("wasm.mjs")
NUMBERS = (
    *("robots", "there", "tasks", "counted", "feasible", "infeasible", "needed", "decision", "missing"),
    "bits",
)
"""Of a step, as in world.js."""


def given_in_node(scenario):
    """Return what a page is given of a scenario; skip the test without ziglang or node."""
    if shutil.which("node") is None:
        pytest.skip("no node in PATH")
    if zig() is None:
        pytest.skip("ziglang isn't installed: it compiles WebAssembly")
    given = simulated_of(scenario, Runs.single(0, 0), [scenario])
    given["strategies"][0] |= {"quality": "how it rates", "decide": "how it decides"}
    fields, seconds = {"units.metres": scenario.units.metres}, scenario.units.seconds or 0
    return given | {"fields": fields, "seconds": seconds, "wasm": wasm_of(scenario)}


def shown_in_node(scenario, seed, run=0, given=None):
    """Return what a page shows at each step of a run; ``given`` may be that of other numbers of robots."""
    given = given or given_in_node(scenario)
    said = _played(given, [{"settings": _settings(scenario, seed, run), "steps": scenario.run.steps}])
    return list(_read(said, scenario.run.steps + 1))


def told_in_node(scenario, seed, steps, **moment):
    """Return the words of a page for each robot at each of these steps: lists of reasons and a sentence.

    ``moment`` says what the page knows of all: what comes next, and since when they hold their opinions.
    """
    job = {"settings": _settings(scenario, seed, 0), "tellAt": list(steps), "moment": moment}
    return json.loads(_played(given_in_node(scenario), [job]))


def ended_in_node(scenario, seed, runs, chunk, given=None):
    """Return decision, step, missing robots, account and curve of runs that stop, ``chunk`` steps a call."""
    jobs = [
        {
            "settings": _settings(scenario, seed, run),
            "steps": scenario.run.steps,
            "stops": True,
            "chunk": chunk,
        }
        for run in range(runs)
    ]
    said = _played(given or given_in_node(scenario), jobs)
    steps = scenario.run.steps + 1
    kind = np.dtype([("head", "<i4", 4), ("account", "<i8", len(ACCOUNT)), ("course", "<i4", steps)])
    found = np.frombuffer(said, kind)
    return *found["head"].T[:3], found["account"], found["course"]


def _settings(scenario, seed, run):
    events = [each.model_dump(exclude_defaults=True) for each in scenario.events]
    counts = {"robots": scenario.robots.count, "tasks": scenario.tasks.count}
    counts |= {"sight": scenario.sensing.range, "radio": scenario.radio.range, "speed": scenario.robots.speed}
    return {**counts, "strategy": 0, "seed": str(seed), "run": run, "events": events}


def _played(given, runs):
    job = {"given": given, "runs": runs, "numbers": NUMBERS}
    command = ["node", str(HARNESS)]
    done = subprocess.run(command, input=json.dumps(job).encode(), capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()
    return done.stdout


def _read(said, steps):
    """Yield the numbers and arrays of each step."""
    at = 0

    def taken(kind, count):
        nonlocal at
        found = np.frombuffer(said, kind, count, at)
        at += found.nbytes
        return found

    for _ in range(steps):
        *values, acts = taken("<i4", len(NUMBERS) + 1).tolist()
        now = dict(zip(NUMBERS, values, strict=True))
        robots, tasks = now["robots"], now["tasks"]
        for names, count in (("x y flags", robots), ("task_x task_y task_numbers", tasks)):
            now |= {name: taken("<u2", count) for name in names.split()}
        now["aims"], now["looks"] = taken("<u2", robots * acts), taken("<u2", tasks * acts)
        now["heading"], now["kinds"] = taken("u1", robots), taken("<i4", robots)
        yield now
    assert at == len(said)

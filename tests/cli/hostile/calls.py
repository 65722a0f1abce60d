"""Calls in Python with what no argument may be."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import cache, partial
from typing import Any

import numpy as np
import xarray as xr

import feasibee
from feasibee.base.record import Record
from feasibee.figures.animation import animate, draw_frame
from feasibee.figures.decisions import plot_declare_steps
from feasibee.results import statistics
from feasibee.results.dataset import to_dataset
from feasibee.scenario.feasibility import explain

SCENARIO = feasibee.Scenario(robots={"count": 3}, run={"steps": 2})
RECORD = Record.empty(0, 2, 3)
for column, value in (("decision", 1), ("decision_step", 0), ("feasible_count", 1), ("infeasible_count", 1)):
    getattr(RECORD, column)[:] = value
RESULTS = to_dataset(RECORD, SCENARIO, 0)

THINGS: dict[str, Any] = {
    "nothing": None,
    "a word": "x",
    "bytes": b"x",
    "a dict": {"a": 1},
    "a list of words": ["x"],
    "a list of nothing": [None],
    "an object": object(),
    "a class": type,
    "an imaginary number": 1j,
    "a cube": np.zeros((2, 2, 2)),
    "a data array": xr.DataArray([0.5]),
    "a dataset": xr.Dataset(),
    "a deep list": [[[[[[[[[[5]]]]]]]]]],
}
"""No number, no scenario, no results."""

NUMBERS: dict[str, Any] = {
    "below 0": -1,
    "a half": 0.5,
    "nan": math.nan,
    "infinity": math.inf,
    "huge": 10**400,
    "minus huge": -(10**400),
}
"""No number of anything."""


@cache
def swarm() -> feasibee.Swarm:
    """Return a swarm; made once, before any call, since it needs the engine."""
    return feasibee.Swarm(SCENARIO)


def wrong(each: Any, *fine: type) -> Any:
    """Return a thing, or a number in place of one that is right, or that is nothing."""
    return 5 if each is None or isinstance(each, fine) else each


SCENARIOS: dict[str, Callable[[Any], Any]] = {
    "truth": feasibee.truth,
    "explain": explain,
    "Swarm": lambda each: feasibee.Swarm(wrong(each)),
    "simulate": lambda each: feasibee.simulate(wrong(each)),
    "animate": lambda each: animate(wrong(each), "a.gif"),
    "plot_arena": feasibee.plot_arena,
    "draw_frame": draw_frame,
    "plot_decision_steps": feasibee.plot_decision_steps,
    "plot_declare_steps": plot_declare_steps,
    "plot_opinions": feasibee.plot_opinions,
    "save_results": lambda each: feasibee.save_results(each, "a.nc"),
    "scenario_of": feasibee.scenario_of,
    "axes": lambda each: feasibee.plot_opinions(RESULTS, wrong(each)),
    "replace": lambda each: feasibee.Scenario().replace(wrong(each, xr.Dataset)),
    "model_validate": lambda each: feasibee.Scenario.model_validate(wrong(each, xr.Dataset)),
    "from_tables": lambda each: feasibee.Scenario.from_tables(wrong(each, xr.Dataset)),
    "from_toml": feasibee.Scenario.from_toml,
    "read": feasibee.Scenario.read,
    "open_results": feasibee.open_results,
    "a section": lambda each: feasibee.Scenario(tasks=wrong(each, xr.Dataset)),
    "points": lambda each: feasibee.Scenario(tasks={"points": each, "placement": "points"}),
    "a strategy": lambda each: feasibee.Scenario(decision={"strategy": each}),
    "classes": lambda each: feasibee.Scenario(robots={"classes": wrong(each, xr.Dataset)}),
    "a preset": lambda each: feasibee.Scenario(preset=each or 5),
    "a side": lambda each: feasibee.Scenario(arena={"side": "x" if isinstance(each, xr.DataArray) else each}),
    "curves": lambda each: feasibee.simulate(SCENARIO, curves=each),
    "backend": lambda each: feasibee.simulate(SCENARIO, backend=each),
    "progress": lambda each: feasibee.simulate(SCENARIO, progress=wrong(each, type)),
    "span": lambda each: draw_frame(swarm(), span=wrong(each)),
    "the steps of an animation": lambda each: animate(SCENARIO, "a.gif", steps=wrong(each)),
}
"""What takes scenarios, swarms, results, tables and functions."""

WHOLE: dict[str, Callable[[Any], Any]] = {
    "a seed": lambda each: feasibee.simulate(SCENARIO, seed=each),
    "runs": lambda each: feasibee.simulate(SCENARIO, runs=each),
    "threads": lambda each: feasibee.simulate(SCENARIO, threads=0 if each is None else each),
    "the seed of a swarm": lambda each: feasibee.Swarm(SCENARIO, each),
    "the room of a swarm": lambda each: feasibee.Swarm(SCENARIO, room=-1 if each is None else each),
    "steps to advance": lambda each: swarm().advance(each),
    "until": lambda each: feasibee.plot_opinions(RESULTS, until=0 if each is None else each),
    "every": lambda each: animate(SCENARIO, "a.gif", every=each),
    "frames a second": lambda each: animate(SCENARIO, "a.gif", fps=each),
    "a size": lambda each: animate(SCENARIO, "a.gif", size=each),
    "the size of a frame": lambda each: draw_frame(swarm(), size=each),
    "a count": lambda each: feasibee.Scenario(tasks={"count": each}),
    "successes": lambda each: feasibee.wilson(each, 10),
    "successes so far": lambda each: statistics.confidence_sequence(each, 10),
    "robots": lambda each: statistics.opinion_quartiles([[1, 2]], each),
    "robots that send": lambda each: statistics.bits_per_robot_and_step([1], [1], each, 10, False),
    "steps to send": lambda each: statistics.bits_per_robot_and_step([1], [1], 10, each, False),
    "a confidence": lambda each: feasibee.wilson(1, 10, 2 if isinstance(each, float) else each),
    "the confidence of rates": lambda each: feasibee.decision_rates(
        [1], 2 if isinstance(each, float) else each
    ),
}
"""What takes a whole number from 1 on, or a confidence."""

ARRAYS: dict[str, Callable[[Any], Any]] = {
    "decision_counts": feasibee.decision_counts,
    "decision_rates": feasibee.decision_rates,
    "decision_times": feasibee.decision_times,
    "accuracy": partial(statistics.accuracy, feasible=True),
    "opinion_quartiles": partial(statistics.opinion_quartiles, robots=10),
    "bits": lambda each: statistics.bits_per_robot_and_step(each, [1, 1, 1], 10, 10, False),
    "the first of a pair": lambda each: statistics.paired_difference(each, [True, False, True]),
    "the second of a pair": lambda each: statistics.paired_difference([True, False, True], each),
    "costs": lambda each: statistics.pareto(each, [1.0, 2.0, 3.0, 4.0]),
}
"""What takes an array of numbers."""


def cases() -> Iterator[tuple[str, Callable[[], Any]]]:
    """Yield names and calls."""
    for name, call in SCENARIOS.items():
        for kind, thing in {**THINGS, "a number": 5, "nan": math.nan}.items():
            if (name, kind) not in FINE:
                yield f"{name}: {kind}", partial(call, thing)
    for name, call in WHOLE.items():
        for kind, thing in {**THINGS, **NUMBERS}.items():
            yield f"{name}: {kind}", partial(call, thing)
    for name, call in ARRAYS.items():
        for kind, thing in {**THINGS, **NUMBERS}.items():
            yield f"{name}: {kind}", partial(call, thing)


FINE = {("from_toml", "a word"), ("points", "a data array"), ("a side", "a number")}
"""Calls that are right, or that fail elsewhere."""

"""A scenario as bytes for the engine in WebAssembly, or all reasons why a page can't show it."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Iterable, Iterator
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from feasibee.base.errors import Problem, ScenarioError
from feasibee.engine.given import Given, struct_of
from feasibee.engine.library import ffi
from feasibee.engine.own import module
from feasibee.engine.params import packed
from feasibee.engine.state import Room, size_of
from feasibee.engine.tables import Lowered
from feasibee.scenario.ground import ground_of, stands_in
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.sections import surely_above
from feasibee.scenario.supported import takes_fast_path
from feasibee.simulation.flooding import flooded
from feasibee.simulation.lowering import lower

MOST: Final = {"robots.count": 20_000, "tasks.count": 20_000, "run.steps": 10_000}
"""Largest values of fields in a page."""
MEBIBYTES: Final = 1024
"""Most memory of a swarm in a page; pages.c has it, too."""


def check_scenario(scenario: Scenario) -> None:
    """Raise a `ScenarioError` with all reasons why a page can't simulate a scenario."""
    if problems := list(_problems(scenario)):
        raise ScenarioError(problems)


def _problems(scenario: Scenario) -> Iterator[Problem]:
    """Yield a problem for each value that a page can't simulate."""
    robots, tasks = scenario.most
    values = (robots, tasks, scenario.run.steps)
    above = [(path, value) for path, value in zip(MOST, values, strict=True) if value > MOST[path]]
    for path, value in above:
        yield Problem(path, value, f"must be at most {MOST[path]:,} in a page", f"use {MOST[path]:,} or less")
    if above or scenario.strategy.source:  # of which the page itself says so
        return
    lowered = lower(flooded(scenario), 0, fast=False)
    if (needed := size_of(Given(lowered), Room.first(lowered.params)) >> 20) >= MEBIBYTES:
        rule = f"needs {needed:,} MiB of memory in a page, which has {MEBIBYTES:,}"
        yield Problem("robots.count", robots, rule, "use fewer robots or tasks, or use feasibee watch")


def wasm_of(scenario: Scenario) -> str:
    """Return the module that a page loads: the engine with all strategies, also a user's own."""
    return shrunk(module(scenario.strategy))


def packets_of(variants: Iterable[Scenario]) -> dict[str, Any]:
    """Return the bytes of scenarios that differ in their strategies, and where each part of them begins.

    The first packet has what they have in common, and each strategy has one of its own: see pages.c.
    """
    scenarios = list(variants)
    lowered = [lower(each, 0, fast=False) for each in scenarios]
    packets = [_common(scenarios[0], lowered[0])]
    packets += [_own(each, numbers) for each, numbers in zip(scenarios, lowered, strict=True)]
    starts = np.cumsum([0, *map(len, packets)])
    return {"bytes": shrunk(b"".join(packets)), "starts": starts[:-1].tolist()}


def reached_of(scenario: Scenario) -> dict[str, Any] | None:
    """Return in which cells of its place robots can be, a bit for each; None if it has none."""
    ground = ground_of(scenario)
    if ground is None:
        return None
    cells = np.packbits(ground.pieces == ground.robots.piece[0], bitorder="little")
    return {"columns": ground.pieces.shape[1], "bits": ground.plan.bits, "cells": shrunk(cells.tobytes())}


def shrunk(data: bytes) -> str:
    """Return bytes as a page inflates them: compressed, in base64."""
    return base64.b64encode(zlib.compress(data, 9)).decode()


def _common(scenario: Scenario, lowered: Lowered) -> bytes:
    tables = lowered.tables
    ground, surface = tables.ground, ground_of(scenario)
    pieces, first, cells = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)], ground.stands
    if surface is not None:  # with pieces that have no robots, which they may get
        robots, every = surface.robots, np.ones(int(surface.pieces.max()) + 1, bool)
        tasks = stands_in(surface.pieces, surface.plan.zones.get(scenario.tasks.zone or ""), every)
        alike = np.array_equal(robots.cells, tasks.cells)
        cells = robots.cells if alike else np.concatenate([robots.cells, tasks.cells])
        pieces = [robots.piece, surface.tasks.piece]
        first = [robots.first, tasks.first + (0 if alike else len(robots.cells))]
    arrays = (tables.class_of, tables.adds, tables.points, tables.ranks, tables.able)
    boxes, stands = map(_differences, (ground.boxes, cells))
    of_place = (ground.passable, boxes, ground.tiles, stands)
    where = (np.concatenate(pieces), np.concatenate(first).astype(np.int64), ground.lattice)
    return _packet(*(each.tobytes() for each in (*arrays, *of_place, *where)))


def _differences(numbers: NDArray[np.integer[Any]]) -> NDArray[np.int32]:
    """Return how much each number differs from the one before: compressed, these take fewer bytes."""
    return np.diff(numbers.astype(np.int32).ravel(), prepend=np.int32(0))


def _own(scenario: Scenario, lowered: Lowered) -> bytes:
    strategy, tables = lowered.strategy, lowered.tables
    setting, (_, parameters) = struct_of(ffi(), lowered.setting)
    setting.plan = setting.parameters = ffi().NULL  # which the page sets, so that a file is the same again
    surface = ground_of(scenario)
    shape = [
        strategy.memory,
        *tables.adds.shape,
        tables.able.shape[1],
        takes_fast_path(scenario),
        scenario.robots.most or 0,
        surely_above((scenario.tasks.arrival_rate or 0.0) * scenario.run.steps),
        0 if surface is None else len(surface.robots.first) - 1,
    ]
    return _packet(
        packed(lowered.params).tobytes(),
        bytes(ffi().buffer(setting)),
        bytes(ffi().buffer(parameters)),
        b"\0" if strategy.source else strategy.name.encode() + b"\0",
        tables.ground.limits.tobytes(),
        np.array(shape, np.int64).tobytes(),
    )


def _packet(*parts: bytes) -> bytes:
    head = np.array([len(parts), *map(len, parts)], np.int64).tobytes()
    return head + b"".join(each + bytes(-len(each) % 8) for each in parts)

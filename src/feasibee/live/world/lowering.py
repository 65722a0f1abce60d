"""From a scenario to the numbers that the page's world takes, or to all reasons why it can't."""

from __future__ import annotations

import base64
import math
import zlib
from collections.abc import Iterator
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from feasibee.errors import Problem, ScenarioError
from feasibee.model.codes import MOST_WALLS, exact
from feasibee.reference.robot import settings_of
from feasibee.robot.firmware import constant
from feasibee.robot.given import numbers_of as given_numbers
from feasibee.scenario.ground import Ground, ground_of
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.supported import PAGE, unsupported
from feasibee.simulation.lowering import TURN, fixed, probability, squared, unit_of
from feasibee.strategies import STRATEGIES
from feasibee.strategies.contract import Strategy

ROBOTS_LIMIT: Final = 200
TASKS_LIMIT: Final = 400
EVENTS_LIMIT: Final = 1000
STEPS_LIMIT: Final = 10_000
"""Most robots, tasks, events and steps of a run in a page."""
WORDS_LIMIT: Final = 10_000
"""Most words that a robot knows in a page, and most words of a message."""
CELLS_LIMIT: Final = 512 * 512
PIECES_LIMIT: Final = 255
"""Most cells of a place in a page, and most pieces in which robots can be placed."""
CELL_BITS: Final = ("wall", "passable", "robots_zone", "tasks_zone")
"""Bits of a cell in place.h, from the lowest on."""
MOST: Final = {
    "robots.count": ROBOTS_LIMIT,
    "tasks.count": TASKS_LIMIT,
    "run.steps": STEPS_LIMIT,
    "decision.dissemination_floor": 65_535,
    "decision.quality_floor": 65_535,
    "decision.declare.rounds": 65_535,
    "decision.declare.heard": 65_535,
}
"""Largest values of fields in a page."""
EVERY_MESSAGE_LIMIT: Final = 20.0
"""Most steps of both phases together, on average, with which an inbox of every message can't overflow."""


def check_scenario(scenario: Scenario) -> None:
    """Raise a `ScenarioError` with all reasons why a page can't simulate a scenario."""
    if problems := list(_problems(scenario)):
        raise ScenarioError(problems)


def strategies_of(scenario: Scenario) -> list[Strategy]:
    """Return the strategies that a scenario's page is compiled with, by their numbers there.

    These are the built-in ones and the scenario's own, which replaces one of the same name in C.
    """
    return list({constant(each): each for each in (*STRATEGIES.values(), scenario.strategy)}.values())


def variants_of(scenario: Scenario) -> Iterator[Scenario]:
    """Yield a scenario with each strategy with which a page can simulate it, and its robots' number known."""
    for each in strategies_of(scenario):
        if each == scenario.strategy:
            yield scenario
            continue
        known = scenario.robots.know_count or each.needs_count
        changes = {"decision.strategy": each.name, "decision.parameters": {}, "robots.know_count": known}
        try:
            changed = scenario.replace(changes)
            check_scenario(changed)
        except ScenarioError:
            continue
        yield changed


def numbers_of(scenario: Scenario) -> dict[str, float]:
    """Return the numbers of a scenario, in the order in which world.c takes them."""
    decision, sensing, radio = scenario.decision, scenario.sensing, scenario.radio
    unit, walled, (width, height) = unit_of(scenario), scenario.setting.walled, scenario.arena.size
    threshold = exact(decision.threshold)
    given = given_numbers(scenario.strategy, settings_of(scenario), scenario.setting, ROBOTS_LIMIT)
    return {
        "robots": scenario.robots.count,
        "tasks": scenario.tasks.count,
        "span_x": fixed(width, unit),
        "span_y": fixed(height, unit),
        "unit": float(unit),
        "walled": int(walled),
        "radius": math.ceil(exact(scenario.robots.diameter) / unit / 2) if walled else 0,
        "reach": float(exact(scenario.robots.speed) / unit),
        "mean_run": scenario.walk.mean_run,
        **_halves("sight", min(squared(sensing.range, unit), 2**63)),  # no squared distance is larger
        **_halves("radio", min(squared(radio.range, unit), 2**63)),
        "miss": int(probability(sensing.miss)),
        "lost": int(probability(radio.loss)),
        "count_self": int(sensing.count_self),
        "strategy": strategies_of(scenario).index(scenario.strategy),
        "id_bits": radio.id_bits or 0,
        **_halves("share", threshold.numerator),
        **_halves("whole", threshold.denominator),
        "events": len(scenario.events),
        **{f"given_{name}": value for name, value in given.items()},
    }


def place_of(scenario: Scenario) -> dict[str, Any] | None:
    """Return a scenario's place as world.c takes it; None if it has none.

    These are its numbers, and its cells, compressed by zlib, in base64: for each of `CELL_BITS` a bit of each
    cell, then a byte for the piece of each, from 1 on; a piece in which no robots are placed is 0.
    """
    ground = ground_of(scenario)
    if ground is None:
        return None
    rows, columns = ground.passable.shape
    radio, walls, unit = exact(scenario.radio.range), exact(scenario.radio.walls), ground.plan.unit
    reaches = [
        math.floor((radio * walls**k / unit) ** 2) + 1 if walls else 0 for k in range(1, MOST_WALLS + 1)
    ]
    halves = [half for reach in reaches for half in divmod(min(reach, 2**63 + 1), TURN)]
    cells = zlib.compress(_cells(scenario, ground), 9)
    return {
        "numbers": [columns, rows, ground.plan.bits, *halves],
        "cells": base64.b64encode(cells).decode(),
    }


def _cells(scenario: Scenario, ground: Ground) -> bytes:
    """Return what is in each cell, and its piece; a cell that isn't passable has that of the one before it.

    So zones and pieces take few bytes.
    """
    plan, places = ground.plan, _places_robots(ground)
    everywhere = np.ones(plan.walls.shape, bool)
    zones = (plan.zones.get(each.zone or "", everywhere) for each in (scenario.robots, scenario.tasks))
    planes = [np.packbits(each, bitorder="little") for each in (plan.walls, ground.passable, *zones)]
    before = np.maximum.accumulate(np.where(ground.passable.ravel(), np.arange(everywhere.size), 0))
    pieces = (np.cumsum(places) * places).astype(np.uint8)[ground.pieces.ravel()[before]]
    return b"".join(each.tobytes() for each in (*planes, pieces))


def _places_robots(ground: Ground) -> NDArray[np.bool_]:
    """Return whether robots may be placed in each piece, from number 0 on, no piece."""
    return np.diff(ground.robots.first) > 0


def _halves(name: str, number: int) -> dict[str, float]:
    """Return both halves of a number of 64 bits."""
    high, low = divmod(number, TURN)
    return {f"{name}_high": high, f"{name}_low": low}


def _problems(scenario: Scenario) -> Iterator[Problem]:
    """Yield a problem for each value that a page can't simulate."""
    rule = "isn't simulated by a page"
    yield from unsupported(scenario, PAGE, rule, ", or use feasibee watch")
    values = {path: scenario.get(path) for path in MOST if scenario.decision.declare or "declare" not in path}
    values |= {"robots.count": scenario.most.robots, "tasks.count": scenario.most.tasks}
    for path, value in values.items():
        if value > (most := MOST[path]):
            yield Problem(path, value, f"must be at most {most:,} in a page", f"use {most:,} or less")
    yield from _place(scenario)
    yield from _combinations(scenario)


def _place(scenario: Scenario) -> Iterator[Problem]:
    """Yield the problems of a place that is too large for a page."""
    ground = ground_of(scenario)
    if ground is None:
        return
    rows, columns = ground.passable.shape
    if rows * columns > CELLS_LIMIT:
        kind, remedy = ("map", "a coarser one") if scenario.place.map else ("cell", "larger cells")
        value, rule = f"{columns} x {rows} cells", f"a page has at most {CELLS_LIMIT:,}"
        yield Problem(f"place.{kind}", value, rule, f"use {remedy}, or use feasibee watch")
    if (pieces := _places_robots(ground).sum()) > PIECES_LIMIT:
        rule = f"is in {pieces:,} pieces, above the limit of {PIECES_LIMIT} in a page"
        remedy = "choose a zone in fewer pieces, or use feasibee watch"
        yield Problem("robots.zone", scenario.robots.zone, rule, remedy)


def _combinations(scenario: Scenario) -> Iterator[Problem]:
    """Yield the problems of knowledge, inbox and declaration."""
    decision = scenario.decision
    if scenario.manifest.knowledge:
        yield from _knowledge(scenario)
    if decision.inbox == "every-message":
        yield from _every_message(scenario)
    if decision.declare and exact(decision.declare.quorum).denominator > 65_535:
        rule = "must have at most 4 decimals in a page"
        yield Problem(
            "decision.declare.quorum", decision.declare.quorum, rule, f"use {decision.declare.quorum:.4f}"
        )


def _knowledge(scenario: Scenario) -> Iterator[Problem]:
    """Yield a problem if what a robot knows, or a message, takes too many words for most robots and tasks."""
    most = {"robots.count": ROBOTS_LIMIT, "tasks.count": TASKS_LIMIT, "events": []}
    setting = scenario.replace(most).setting
    if (words := max(scenario.strategy.row_lengths(setting))) > WORDS_LIMIT:
        rule = (
            f"takes {words:,} words with {ROBOTS_LIMIT} robots and {TASKS_LIMIT} tasks, above the limit of "
            f"{WORDS_LIMIT:,} in a page"
        )
        remedy = "choose another strategy or other parameters, or use feasibee watch"
        yield Problem("decision.strategy", scenario.decision.strategy, rule, remedy)


def _every_message(scenario: Scenario) -> Iterator[Problem]:
    """Yield the problems of an inbox that keeps every message: it counts votes, in 16 bits."""
    decision = scenario.decision
    remedy = "use 'latest-per-robot', or use feasibee watch"
    if scenario.manifest.value_bits:
        rule = f"can't be combined with {decision.strategy} in a page, since its messages have values"
        yield Problem("decision.inbox", decision.inbox, rule, remedy)
    if decision.exploration + decision.gain + decision.dissemination_floor > EVERY_MESSAGE_LIMIT:
        rule = f"needs phases of at most {EVERY_MESSAGE_LIMIT:g} steps together on average in a page"
        yield Problem("decision.inbox", decision.inbox, rule, remedy)

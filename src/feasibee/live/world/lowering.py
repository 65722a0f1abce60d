"""From a scenario to the numbers that the page's world takes, or to all reasons why it can't."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from typing import Any, Final

from feasibee.errors import Problem, ScenarioError
from feasibee.model.codes import exact
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.supported import PAGE, unsupported
from feasibee.strategies import STRATEGIES

TURN: Final = 2**32
ROBOTS_LIMIT: Final = 200
"""Most robots in a page."""
TASKS_LIMIT: Final = 400
"""Most tasks in a page."""
STEPS_LIMIT: Final = 10_000
"""Most steps of a run in a page."""
PAGE_STRATEGIES: Final = tuple(name for name, each in STRATEGIES.items() if not each.knowledge)
"""The strategies in a page, by their numbers there: those that pass on opinions only."""
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


def numbers_of(scenario: Scenario) -> dict[str, float]:
    """Return the numbers of a scenario, in the order in which world.c takes them."""
    decision, rule = scenario.decision, scenario.decision.declare
    unit = max(map(exact, scenario.arena.size)) / TURN
    quorum = exact(rule.quorum) if rule else Fraction(1)
    switching = decision.switching
    return {
        "robots": scenario.robots.count,
        "tasks": scenario.tasks.count,
        "reach": float(exact(scenario.robots.speed) / unit),
        "mean_run": scenario.walk.mean_run,
        **_squared("sight", scenario.sensing.range, unit),
        **_squared("radio", scenario.radio.range, unit),
        "count_self": int(scenario.sensing.count_self),
        "strategy": PAGE_STRATEGIES.index(decision.strategy),
        "exploration": decision.exploration,
        "gain": decision.gain,
        "dissemination_floor": decision.dissemination_floor,
        "quality_floor": decision.quality_floor,
        "listens_for": _listens_for(decision.listen),
        "inbox_size": min(decision.inbox_size or ROBOTS_LIMIT, ROBOTS_LIMIT),
        "own_vote": int(decision.own_vote),
        "every_message": int(decision.inbox == "every-message"),
        "switching": -1 if switching is None else math.ceil(exact(switching) * TURN),
        "rounds": rule.rounds if rule else 0,
        "heard": rule.heard if rule else 0,
        "quorum": quorum.numerator,
        "quorum_of": quorum.denominator,
        **_parameters(scenario),
        "id_bits": scenario.radio.id_bits or 0,
        "needed": math.floor(exact(decision.threshold) * scenario.robots.count) + 1,
    }


def _squared(name: str, length: float, unit: Fraction) -> dict[str, float]:
    """Return both halves of a range's square; no squared distance is larger than 2**63."""
    high, low = divmod(min(math.floor((exact(length) / unit) ** 2), 2**63), TURN)
    return {f"{name}_high": high, f"{name}_low": low}


def _listens_for(listen: Any) -> int:
    """Return the number of last steps of dissemination in which a robot hears; 0: all, -1: always."""
    if isinstance(listen, str):
        return {"always": -1, "dissemination": 0}[listen]
    return min(int(listen["last"]), 65_535)


def _parameters(scenario: Scenario) -> dict[str, float]:
    """Return the parameters of all strategies in the page; those of the scenario's are its own."""
    given = {key: value for name in PAGE_STRATEGIES for key, value in STRATEGIES[name].parameters.items()}
    given |= scenario.decision.parameters
    return {
        "k": min(max(1, math.ceil(given["k"])), 65_535),
        "voters": min(max(0, math.ceil(exact(given["voters"]) * TURN)), TURN - 1),
        "credence": given["credence"],
        "positive_feedback": int(given["positive_feedback"] > 0),
    }


def _problems(scenario: Scenario) -> Iterator[Problem]:
    """Yield a problem for each value that a page can't simulate."""
    rule = "isn't simulated by a page, which has the paper's world only"
    yield from unsupported(scenario, PAGE, rule, ", or use feasibee watch")
    for path, most in MOST.items():
        if path.startswith("decision.declare.") and scenario.decision.declare is None:
            continue
        if (value := scenario.get(path)) > most:
            yield Problem(path, value, f"must be at most {most:,} in a page", f"use {most:,} or less")
    yield from _combinations(scenario)


def _combinations(scenario: Scenario) -> Iterator[Problem]:
    """Yield the problems of shape, strategy, inbox and declaration."""
    decision, (width, height) = scenario.decision, scenario.arena.size
    if width != height:
        rule = "must be a square in a page"
        yield Problem("arena.side", [width, height], rule, f"use {max(width, height)}, or use feasibee watch")
    if decision.strategy not in PAGE_STRATEGIES:
        rule = "isn't in a page, which has the strategies that pass on opinions only"
        remedy = f"use {', '.join(PAGE_STRATEGIES)}, or use feasibee watch"
        yield Problem("decision.strategy", decision.strategy, rule, remedy)
    if decision.inbox == "every-message":
        yield from _every_message(scenario)
    if decision.declare and exact(decision.declare.quorum).denominator > 65_535:
        rule = "must have at most 4 decimals in a page"
        yield Problem(
            "decision.declare.quorum", decision.declare.quorum, rule, f"use {decision.declare.quorum:.4f}"
        )


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

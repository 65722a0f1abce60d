"""Before a deployment: whether a swarm would decide rightly, how soon, and what would help."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Any

from feasibee.errors import ScenarioError
from feasibee.results.statistics import paired_difference, wilson
from feasibee.scenario.feasibility import explain
from feasibee.scenario.scenario import Scenario
from feasibee.strategies import STRATEGIES
from feasibee.studies.assessment import Assessment, Trial, wait_for
from feasibee.studies.comparison import Outcome, compare

FIRST = 0.7
"""The share of the work that isn't at the opposite truth, about."""


def assess(
    scenario: Scenario,
    runs: int = 400,
    seed: int = 0,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Assessment:
    """Simulate a swarm, changes to it, and other strategies, all on the same worlds.

    A swarm that always gave one answer would be right in all worlds of one truth. So the swarm, and the
    strategies that do better, are also simulated at the reciprocal ratio of robots to tasks.

    Parameters
    ----------
    scenario : Scenario
        What to assess.
    runs : int
        Swarms of each kind.
    seed : int
        64 bits.
    threads : int, optional
        By default one for each processor.
    progress : callable, optional
        Called with the share of the work done.
    """
    scenario = scenario.replace({"run.stop_at_decision": False})
    others = _other_strategies(scenario)
    changed = _changes(scenario)
    kinds = {"as it is": scenario, **changed, **others}
    first, second = _parts(progress)
    outcomes = {each.contender: each for each in compare(kinds, (), runs, seed, threads, first)}
    base = outcomes["as it is"]
    right, held = int(base.right.sum()), int(base.agreed.sum())
    strategies = _ranked(others, outcomes, base)
    better = {trial.name: others[trial.name] for trial in strategies if trial.difference.low > 0}
    turned = _turned({"as it is": scenario, **better})
    opposite = {each.contender: each for each in compare(turned, (), runs, seed, threads, second)}
    return Assessment(
        scenario,
        explain(scenario),
        base,
        wilson(right, runs),
        wilson(held - right, runs),
        wilson(runs - held, runs),
        wait_for(base),
        _ranked(changed, outcomes, base),
        [replace(trial, opposite=opposite.get(trial.name)) for trial in strategies],
        opposite.get("as it is"),
    )


def _parts(progress: Callable[[float], None] | None) -> tuple[Callable[[float], None] | None, ...]:
    """Split the progress in two."""
    if progress is None:
        return None, None
    return lambda share: progress(FIRST * share), lambda share: progress(FIRST + (1 - FIRST) * share)


def _turned(kinds: Mapping[str, Scenario]) -> dict[str, Scenario]:
    """Return the scenarios that can be had at the reciprocal ratio, where the truth is the other."""
    turned = {}
    for name, scenario in kinds.items():
        robots, tasks = scenario.robots.count, scenario.tasks.count
        others = robots + 1 if tasks == robots else max(1, round(robots * robots / max(1, tasks)))
        if scenario.robots.classes or scenario.tasks.classes or scenario.tasks.points:
            continue
        with suppress(ScenarioError):  # such as more tasks than a census has room for
            turned[name] = scenario.replace({"tasks.count": others})
    return turned


def _ranked(names: Mapping[str, Any], outcomes: Mapping[str, Outcome], base: Outcome) -> list[Trial]:
    trials = [
        Trial(name, outcomes[name], paired_difference(outcomes[name].right, base.right)) for name in names
    ]
    return sorted(trials, key=lambda trial: (-trial.difference.estimate, trial.outcome.bits.mean()))


def _other_strategies(scenario: Scenario) -> dict[str, Scenario]:
    """Return the scenario under each other strategy that has a meaning in it."""
    others = {}
    for name in STRATEGIES:
        if name == scenario.decision.strategy:
            continue
        try:
            others[name] = scenario.replace({"decision.strategy": name, "decision.parameters": {}})
        except ScenarioError:
            continue
    return others


def _changes(scenario: Scenario) -> dict[str, Scenario]:
    """Return what to try in order to see what limits the swarm."""
    sensing, radio, decision = scenario.sensing, scenario.radio, scenario.decision
    tried: dict[str, dict[str, Any]] = {
        "sight 1.5 times as far": {"sensing.range": 1.5 * sensing.range, "radio.range": radio.range},
        "radio 1.5 times as far": {"radio.range": 1.5 * radio.range},
        "explorations 3 times as long": {"decision.exploration": 3 * decision.exploration},
        "3 times as many steps": {"run.steps": 3 * scenario.run.steps},
    }
    if sensing.miss or sensing.false_robots or sensing.false_tasks:
        tried["a perfect sensor"] = {
            f"sensing.{name}": 0.0 for name in ("miss", "false_robots", "false_tasks")
        }
    if radio.loss:
        tried["no message lost"] = {"radio.loss": 0.0}
    if scenario.faults.stopped or scenario.faults.byzantine or scenario.faults.stubborn:
        tried["no faulty robot"] = {f"faults.{name}": 0.0 for name in ("stopped", "byzantine", "stubborn")}
    changed = {}
    for name, values in tried.items():
        try:
            changed[name] = scenario.replace(values)
        except ScenarioError:  # such as a range that would reach round the torus
            continue
    return changed

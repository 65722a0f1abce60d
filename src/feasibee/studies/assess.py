"""Assess a swarm before deployment: how often it would be right, how soon, and what would help."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Any

from feasibee.errors import ScenarioError
from feasibee.results.statistics import paired_difference, wilson
from feasibee.scenario.feasibility import explain
from feasibee.scenario.scenario import Scenario
from feasibee.studies.assessment import Assessment, Trial, wait_for
from feasibee.studies.comparison import Outcome, design_points, outcomes_of
from feasibee.studies.suitable import suitable
from feasibee.sweeps.sweep import Execution, Rounds

OPPOSITE_SHARE = 0.3
"""Share of the runs that are at the opposite truth, about: for the progress only."""
AS_IT_IS = "as it is"


def assess(
    scenario: Scenario, runs: int = 400, seed: int = 0, execution: Execution | None = None
) -> Assessment:
    """Simulate a swarm, changes to it, and other strategies, all on the same worlds.

    A swarm that always gave one answer would be right in all worlds of one truth. So the swarm, and the
    strategies that do better, are also simulated at the reciprocal ratio of robots to tasks.

    Parameters
    ----------
    scenario : Scenario
        What to assess.
    runs : int
        Number of runs of each variant.
    seed : int
        64 bits.
    execution : Execution, optional
        Where to compute and keep the runs; by default on threads, and in memory.
    """
    scenario = scenario.replace({"run.stop_at_decision": False})
    others, changed = _other_strategies(scenario), _changes(scenario)
    kinds = {AS_IT_IS: scenario, **changed, **others}
    with Rounds(execution, round(len(kinds) * runs / (1 - OPPOSITE_SHARE))) as rounds:
        outcomes = _outcomes(rounds, kinds, runs, seed)
        base = outcomes[AS_IT_IS]
        strategies = _ranked(others, outcomes, base)
        better = {trial.name: others[trial.name] for trial in strategies if trial.difference.low > 0}
        opposite = _outcomes(rounds, _turned({AS_IT_IS: scenario, **better}), runs, seed)
    right, held = int(base.right.sum()), int(base.agreed.sum())
    return Assessment(
        scenario=scenario,
        verdict=explain(scenario),
        outcome=base,
        right=wilson(right, runs),
        wrong=wilson(held - right, runs),
        split=wilson(runs - held, runs),
        wait=wait_for(base),
        limits=_ranked(changed, outcomes, base),
        strategies=[replace(trial, opposite=opposite.get(trial.name)) for trial in strategies],
        opposite=opposite.get(AS_IT_IS),
    )


def _outcomes(rounds: Rounds, kinds: Mapping[str, Scenario], runs: int, seed: int) -> dict[str, Outcome]:
    found = outcomes_of(rounds, design_points(kinds, (), runs, seed), runs, seed)
    return {each.contender: each for each in found}


def _turned(kinds: Mapping[str, Scenario]) -> dict[str, Scenario]:
    """Return the scenarios at the reciprocal ratio, where the truth is the opposite, as far as possible."""
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
    """Return the scenario with each other strategy that it supports."""
    others, _ = suitable(scenario)
    others.pop(scenario.decision.strategy, None)
    return others


def _changes(scenario: Scenario) -> dict[str, Scenario]:
    """Return the scenario with each change that may show what limits the swarm."""
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

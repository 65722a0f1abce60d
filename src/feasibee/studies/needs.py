"""What strategies ask of robots, and which of them a scenario supports."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

from feasibee.base.errors import ScenarioError
from feasibee.scenario.messages import bare_bits, knowledge_bits
from feasibee.scenario.plugins import registered
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.swarm import Swarm
from feasibee.strategies import STRATEGIES
from feasibee.strategies.certified import TESTED, untested
from feasibee.strategies.contract import Me
from feasibee.strategies.words import Words

IDS: Final = "ids that are never misread"
NAMES: Final = "names of tasks"
COUNT: Final = "the number of robots"
IN_WORDS: Final = {"ids": IDS, "names": NAMES, "count": COUNT}
WORD_BITS: Final = 32
FLOAT_BITS: Final = 64
LOOKS: Final = 20
"""Number of steps of a run, evenly spaced, at which messages are measured."""
FEW_PAIRS: Final = 0.02
RARELY: Final = 1e-6
"""Expected pairs of tasks under one name, and probability of a wrong name, that need no warning."""


def suitable(scenario: Scenario) -> tuple[dict[str, Scenario], dict[str, ScenarioError]]:
    """Return the scenario with each built-in strategy that it supports, and the problems with the others.

    Both are by the name of the strategy. The scenario's own one keeps its parameters.
    """
    scenarios, problems = {}, {}
    for name in STRATEGIES:
        try:
            scenarios[name] = scenario.replace(strategy_change(scenario, name))
        except ScenarioError as error:
            problems[name] = error
    return scenarios, problems


def possible(scenario: Scenario, changes: Mapping[str, Any]) -> Scenario | None:
    """Return the scenario with some changes; None if it doesn't support them."""
    with suppress(ScenarioError):  # such as a range that would reach round the torus
        return scenario.replace(changes)
    return None


def strategy_change(scenario: Scenario, name: str) -> dict[str, Any]:
    """Return the changes that give a scenario another strategy; its own one keeps its parameters."""
    own = name == scenario.decision.strategy
    return {} if own else {"decision.strategy": name, "decision.parameters": {}}


def all_strategies(scenario: Scenario) -> list[str]:
    """Return the names of the built-in strategies, of those of installed packages, and the scenario's own."""
    return list(dict.fromkeys([*STRATEGIES, *registered(), scenario.decision.strategy]))


@dataclass(frozen=True)
class Asked:
    """What a scenario asks of its robots. Messages are measured when their length is first needed."""

    scenario: Scenario
    seed: int = 0

    @property
    def needs(self) -> tuple[str, ...]:
        """What they must know or recognise, in words."""
        return tuple(needs_of(self.scenario))

    @property
    def message_bits(self) -> int:
        """Length of the longest message, in bits."""
        return sum(self._longest_parts)

    @property
    def memory_bits(self) -> int:
        """Memory of a robot: for what it knows, for what its strategy keeps, for a message of each other."""
        scenario, (plain, longest) = self.scenario, self._longest_parts
        strategy, others = scenario.strategy, scenario.robots.count - 1
        words = strategy.row_lengths(scenario.setting)[0] if strategy.knowledge else 0
        known = max(WORD_BITS * words, longest)  # names of tasks take more room in a message than here
        senders = min(scenario.decision.inbox_size or others, others)
        return known + FLOAT_BITS * strategy.memory + senders * plain

    def to_dict(self) -> dict[str, Any]:
        """Return all of this, and the ranges of sight and radio in units, as a plain table, for programs."""
        found = {name: getattr(self, name) for name in ("needs", "message_bits", "memory_bits")}
        return {**found, "sight": self.scenario.sensing.range, "radio": self.scenario.radio.range}

    @cached_property
    def _longest_parts(self) -> tuple[int, int]:
        """Lengths in bits of a message without its knowledge, and of the longest knowledge in one.

        Knowledge is measured in one run, at 20 steps, of all robots.
        """
        scenario, strategy, setting = self.scenario, self.scenario.strategy, self.scenario.setting
        plain, longest = bare_bits(scenario, setting.id_bits), 0
        if not strategy.knowledge:
            return plain, longest
        swarm, memory, steps = Swarm(scenario, self.seed), [0.0] * strategy.memory, scenario.run.steps
        for look in range(1, LOOKS + 1):
            swarm.advance(steps * look // LOOKS - swarm.step)
            me = Me(0, 0, 0, swarm.step, memory, setting)
            lengths = (knowledge_bits(strategy, Words(row.tolist()), me) for row in swarm.knowledge)
            longest = max(longest, *lengths)
        return plain, longest


def needs_of(scenario: Scenario) -> list[str]:
    """Return what a scenario's strategy needs, in words, with the scenario's values of its parameters."""
    return [IN_WORDS[need] for need in scenario.manifest.needs(scenario.decision.parameters)]


def untested_in_words(scenario: Scenario) -> list[str]:
    """Return a warning if robots compute quiet times that weren't tested in such a world."""
    if scenario.place.exists or scenario.decision.parameters.get("quiet") != 0:
        return []
    outside = untested(scenario.robots.count, scenario.setting)
    if not outside:
        return []
    ranges = [
        f"{name} {value:.4g}, tested {' to '.join(map(str, TESTED[name]))}" for name, value in outside.items()
    ]
    return [
        f"The quiet times that robots compute were not tested here ({'; '.join(ranges)}): they may declare "
        "feasible too soon. Set the parameter quiet of their strategy, or rely on rates simulated here."
    ]


def noisy_names_in_words(scenario: Scenario) -> list[str]:
    """Return a warning if names of tasks are expected to be merged or wrong at noisy positions."""
    sensing, tasks, (width, height) = scenario.sensing, scenario.tasks.count, scenario.arena.size
    if not (sensing.position_error and scenario.manifest.sends_positions):
        return []
    pairs = tasks * (tasks - 1) / 2 * math.pi * max(sensing.merged, 0.0) ** 2 / (width * height)
    found = []
    if pairs > FEW_PAIRS:
        found.append(
            f"At uniform positions, {pairs:.2g} pairs of tasks on average are at most {sensing.merged:.3g} "
            "units apart. That is too near for two names, so robots count them as one."
        )
    if sensing.wrong > RARELY:
        found.append(
            f"One look in {1 / sensing.wrong:,.0f} gives a task a wrong name. One may make a robot declare "
            f"infeasible: raise sensing.gate, now {sensing.gated:.3g}, or choose a strategy without names."
        )
    return found

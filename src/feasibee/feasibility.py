"""Whether the tasks are feasible, known from outside."""

from __future__ import annotations

from feasibee.scenario import Scenario


def truth(scenario: Scenario) -> bool:
    """Return whether the swarm can do its tasks: one robot a task, so n >= m (paper, section II)."""
    return scenario.robots.count >= scenario.tasks.count

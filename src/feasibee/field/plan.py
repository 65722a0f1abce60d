"""What a field does: the scenario, the clocks of its robots, and the faults."""

from __future__ import annotations

from typing import NamedTuple

from feasibee.field.faults import Fault
from feasibee.scenario.scenario import Scenario


class Plan(NamedTuple):
    """What a field does: the scenario, the clock of its robots, and the faults."""

    scenario: Scenario
    seed: int
    run: int
    lockstep: bool
    hz: float
    """Steps per second of a robot's clock; in lockstep only the unit of times in faults."""
    drift: float
    """Largest error of a robot's clock, as a share."""
    jitter: float
    """Largest deviation of a step's duration, as a share."""
    delay: float
    """Delay of messages, in steps."""
    faults: tuple[Fault, ...]
    patience: float
    """Seconds of silence after which a robot is lost."""
    wait: float
    """Seconds that the robots have to join."""

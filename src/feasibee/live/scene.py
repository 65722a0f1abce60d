"""A shown world: what stays as it is in a run, and what changes with each step.

Steps come from a simulation, or from the log of a field (`Logged`).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.field.recording import Recording
from feasibee.reference.mind import BYZANTINE, STUBBORN
from feasibee.scenario.feasibility import truth
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.snapshot import FLAGS, Snapshot
from feasibee.simulation.swarm import Swarm


class Step(NamedTuple):
    """One step of a shown world."""

    step: int
    shown: Snapshot
    counts: tuple[int, int, int]
    """Robots that hold feasible, that hold infeasible, and that count."""
    declared: tuple[int, int]
    """Counted robots that have declared feasible, and infeasible."""
    decision: tuple[int, int, int]
    """The opinion of the swarm at this step, its first decision and the step of that; -1 for none."""
    tasks: int
    places: NDArray[np.uint16]
    """Positions of the tasks in a world that changes, shape (tasks, 2); none in another one."""
    truth: bool
    """Whether the tasks of this step are feasible."""
    bits: int
    """Bits sent so far."""
    robot_steps: int
    """Number of robots, summed over the steps so far."""


class Logged(Recording):
    """A field as pages draw it."""

    def snapshot(self) -> Snapshot:
        """Return the robots of this step. A silent robot has no opinion and doesn't work."""
        there, lost = self.present, self.lost
        having = {
            "feasible": (self.opinions == 1) & ~lost,
            "neutral": there & ((self.opinions == -1) | lost),
            "disseminating": self.disseminating,
            "declared": self.declared >= 0,
            "working": self.working,
            "byzantine": self.has_fault(BYZANTINE),
            "stubborn": self.has_fault(STUBBORN),
            "there": there,
        }
        flags = np.zeros(there.size, np.uint16)
        for bit, name in enumerate(FLAGS):
            flags |= having[name].astype(np.uint16) << np.uint16(bit)
        turns = np.round(self.headings * (128 / np.pi)).astype(np.int16).astype(np.uint8)
        return Snapshot(*self.coarse_places(), flags, turns)


def step_of(swarm: Swarm | Logged) -> Step:
    """Return the current step of a swarm or field."""
    places = np.stack(swarm.task_places(), axis=1)
    return Step(
        swarm.step,
        swarm.snapshot(),
        (swarm.feasible_count, swarm.infeasible_count, int(swarm.counted.sum())),
        swarm.declared_counts,
        (swarm.decision, *swarm.first_decision),
        len(places),
        places if swarm.scenario.dynamic else places[:0],
        swarm.truth,
        swarm.bits_sent,
        int(swarm.robot_counts[1:].sum()),
    )


def curves_of(swarm: Swarm | Logged, first: int) -> NDArray[np.int32]:
    """Return the three counts and the truth of each step from one on: int32, shape (steps, 4)."""
    known = (swarm.feasible_counts, swarm.infeasible_counts, swarm.counted_counts, swarm.truths)
    return np.stack([each[first:] for each in known], axis=1).astype(np.int32)


def scene_of(scenario: Scenario) -> dict[str, Any]:
    """Return what stays as it is in a run, with the names that the pages use."""
    return {
        "size": list(scenario.arena.size),
        "walls": scenario.arena.boundary == "walls",
        "diameter": scenario.robots.diameter,
        "sight": scenario.sensing.range,
        "radio": scenario.radio.range,
        "robots": scenario.robots.count,
        "numbers": scenario.most.robots,
        "tasks": scenario.tasks.count,
        "changes": scenario.dynamic,
        "truth": truth(scenario),
        "declares": scenario.declares,
    }

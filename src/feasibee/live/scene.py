"""A shown world: what stays as it is in a run, and the steps of a field's log as a simulation has them."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from feasibee.field.recording import Recording
from feasibee.reference.mind import BYZANTINE, STUBBORN
from feasibee.scenario.feasibility import truth
from feasibee.scenario.picture import extent_of, outlines_of, picture_of
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.snapshot import FLAGS, Snapshot


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
            "standing": self.standing,
        }
        flags = np.zeros(there.size, np.uint16)
        for bit, name in enumerate(FLAGS):
            flags |= having[name].astype(np.uint16) << np.uint16(bit)
        turns = np.round(self.headings * (128 / np.pi)).astype(np.int16).astype(np.uint8)
        return Snapshot(*self.coarse_places(), flags, turns)


def scene_of(scenario: Scenario) -> dict[str, Any]:
    """Return what stays as it is in a run, with the names that the pages use."""
    return {
        "size": list(scenario.arena.size),
        "walls": scenario.arena.boundary == "walls",
        "plan": plan_for_pages(scenario),
        "diameter": scenario.robots.diameter,
        "sight": scenario.sensing.range,
        "view": scenario.sensing.view,
        "radio": scenario.radio.range,
        "robots": scenario.robots.count,
        "numbers": scenario.most.robots,
        "tasks": scenario.tasks.count,
        "changes": scenario.dynamic,
        "truth": truth(scenario),
        "declares": scenario.declares,
        "acts": scenario.acts,
    }


def plan_for_pages(scenario: Scenario) -> dict[str, Any] | None:
    """Return the plan of a scenario with the names that pages use: an image in base64, and zones; or None."""
    if scenario.plan is None:
        return None
    image = base64.b64encode(picture_of(scenario.plan)).decode()
    zones = [each._asdict() for each in outlines_of(scenario)]
    return {"image": image, "size": extent_of(scenario.plan), "zones": zones}

"""Runs that tests compare with what pages show."""

from __future__ import annotations

from feasibee import Swarm
from feasibee.simulation import executors
from feasibee.simulation.plan import study_of
from feasibee.simulation.sweep import complete


def swarm_at(step, *run, **seed):
    """Return the swarm of a run, given as to `Swarm`, at a step."""
    swarm = Swarm(*run, **seed)
    swarm.advance(step)
    return swarm


def swept(tables, folder):
    """Run a sweep, given as the tables of its study; return the folder of its results."""
    complete(study_of(tables, folder), folder / "results", executors.threads(1))
    return folder / "results"

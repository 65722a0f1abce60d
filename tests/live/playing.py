"""Runs that tests compare with what the live arena shows."""

from __future__ import annotations

from feasibee import Swarm
from feasibee.sweeps import executors
from feasibee.sweeps.plan import study_of
from feasibee.sweeps.sweep import sweep


def swarm_at(step, *run, **seed):
    """Return the swarm of a run, given as to `Swarm`, at a step."""
    swarm = Swarm(*run, **seed)
    swarm.advance(step)
    return swarm


def looked(outlook, robot=None):
    """Look to the end of a run, at a robot if one is given; return what is found as a message."""
    outlook.follow(robot)
    while not outlook.look(1.0):
        pass
    return outlook.to_dict(0)


def swept(tables, folder):
    """Run a sweep, given as the tables of its study; return the folder of its results."""
    sweep(study_of(tables, folder), folder / "results", executors.threads(1))
    return folder / "results"

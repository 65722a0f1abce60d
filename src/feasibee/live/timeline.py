"""Time of one run in both directions: copies of its state at intervals, and replay from the nearest one.

A run is deterministic, so that a step is always reached by simulating from an earlier copy. Small swarms are
replayed from the start faster than a page can show it; large ones keep copies, within a limit of memory.
"""

from __future__ import annotations

import time
from bisect import bisect_right
from typing import Final

from feasibee.simulation.snapshot import Saved
from feasibee.simulation.swarm import Swarm

WORK: Final = 2**20
"""Robots times steps between two copies: tens of milliseconds of simulation."""
LEAST: Final = 16
"""Fewest steps between two copies."""
ROOM: Final = 32 * 2**20
"""Most bytes that the copies of a run take, apart from that of step 0."""


class Timeline:
    """A swarm that can go to any step of its run.

    Parameters
    ----------
    swarm : Swarm
        The run, at step 0.
    room : int
        Most bytes of all copies, apart from that of step 0.
    """

    def __init__(self, swarm: Swarm, room: int = ROOM) -> None:
        self.swarm = swarm
        self.spacing = max(LEAST, WORK // swarm.present.size)
        self._room = room
        self._saved = [swarm.save()]

    @property
    def saved(self) -> list[int]:
        """Steps of which there are copies, in ascending order."""
        return [each.step for each in self._saved]

    def rewind(self, step: int) -> None:
        """Go to the last copy at or before a step, unless the swarm is between that copy and the step."""
        nearest = self._saved[bisect_right(self.saved, step) - 1]
        if not nearest.step <= self.swarm.step <= step:
            self.swarm.restore(nearest)

    def advance(self, until: int) -> None:
        """Simulate to a step, and copy the state at multiples of the spacing on the way."""
        while self.swarm.step < until:
            goal = (self.swarm.step // self.spacing + 1) * self.spacing
            self.swarm.advance(min(goal, until) - self.swarm.step)
            if self.swarm.step == goal > self._saved[-1].step:
                self._keep(self.swarm.save())

    def _keep(self, saved: Saved) -> None:
        """Keep a copy; while all copies take too much memory, double the spacing and drop every other one."""
        self._saved.append(saved)
        while sum(each.nbytes for each in self._saved[1:]) > self._room:
            self.spacing *= 2
            self._saved = [each for each in self._saved if each.step % self.spacing == 0]


def advance_together(timelines: list[Timeline], until: int, seconds: float) -> bool:
    """Advance runs of one step to another one, in step, for a limited time; return whether it is reached.

    They advance by one step at least, however busy the machine is.
    """
    before, chunk = time.monotonic(), 1
    end = before + seconds
    while (step := timelines[0].swarm.step) < until:
        for each in timelines:
            each.advance(min(step + chunk, until))
        now = time.monotonic()
        if now >= end:
            break
        chunk = 2 * chunk if now - before < seconds / 8 else chunk
        before = now
    return timelines[0].swarm.step >= until

"""Time of one run in both directions: copies of its state, replay from the nearest one, and what lies ahead.

A run is deterministic, so that a step is always reached by simulating from an earlier copy. Small swarms are
replayed from the start faster than a page can show it; large ones keep copies, within a limit of memory.

A second swarm of the same run goes ahead of the one that the page shows, a little at a time (`Outlook`). What
it finds is what the page will show.
"""

from __future__ import annotations

import time
from bisect import bisect_right
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from feasibee.simulation.snapshot import FLAGS, Saved
from feasibee.simulation.swarm import Swarm

WORK: Final = 2**20
"""Robots times steps between two copies: tens of milliseconds of simulation."""
LEAST: Final = 16
"""Fewest steps between two copies."""
ROOM: Final = 32 * 2**20
"""Most bytes that the copies of a run take, apart from that of step 0."""
CHANGES_LIMIT: Final = 5000
"""Most changes of a robot, or of the world, that are sent: more than a seek bar has pixels."""
BACK: Final = 400
"""Most steps that are simulated one by one to find since when robots hold their opinions: 0.2 s."""
SHOWN: Final = sum(
    1 << FLAGS.index(name)
    for name in ("feasible", "neutral", "disseminating", "declared", "working", "there", "standing")
)
"""Flags whose change is a change of the robot."""


class Timeline:
    """A swarm, at first at step 0, that can go to any step of its run.

    ``room`` is the most bytes of all copies, apart from that of step 0.
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


class History:
    """Since which step each robot of a timeline holds its opinion, and last decided, from `first` on."""

    def __init__(self, timeline: Timeline) -> None:
        self._timeline = timeline
        self._step = -1 - BACK
        self.first = 0

    def follow(self) -> None:
        """Look at each step up to the present one that was not looked at before, but at most `BACK`."""
        timeline, swarm = self._timeline, self._timeline.swarm
        until = swarm.step
        known, self._step = self._step, until
        is_new = not known <= until <= known + BACK
        start = max(0, until - BACK) if is_new else known
        timeline.rewind(start)
        timeline.advance(start)
        if is_new:
            self.first = start
            self.held, self.decided = np.full((2, swarm.present.size), start)
            self._before = swarm.opinions, swarm.disseminating
        while swarm.step < until:
            swarm.advance()
            now = swarm.opinions, swarm.disseminating
            self.held[now[0] != self._before[0]] = swarm.step
            self.decided[self._before[1] & ~now[1]] = swarm.step
            self._before = now


def advance_together(timelines: list[Timeline], until: int, seconds: float) -> bool:
    """Advance runs of one step to another one, in step, for a limited time; return whether it is reached.

    They advance by one step at least, however busy the machine is.
    """
    for chunk in _chunks(seconds):
        if (step := timelines[0].swarm.step) >= until:
            return True
        for each in timelines:
            each.advance(min(step + chunk, until))
    return timelines[0].swarm.step >= until


def _chunks(seconds: float) -> Iterator[int]:
    """Yield how many steps to simulate next, at least once, until a time is over; more while quick."""
    now, chunk = time.monotonic(), 1
    end = now + seconds
    while True:
        yield chunk
        past, now = now, time.monotonic()
        if now >= end:
            return
        chunk = 2 * chunk if now - past < seconds / 8 else chunk


class Outlook:
    """The outlook of a run, of which one robot is followed, if any.

    Parameters
    ----------
    swarm : Swarm
        The run, at step 0; another one than that of the page.
    last : int
        Last step to look at.

    Attributes
    ----------
    decision_step : int
        Step of the first decision; -1 if it isn't found yet, or there is none.
    """

    def __init__(self, swarm: Swarm, last: int) -> None:
        self._swarm = swarm
        self._start = swarm.save()
        self._last = last
        self._robot: int | None = None
        self._changes: list[tuple[int, int]] = []
        self._seen = self._noted = -1
        self._world: list[tuple[int, int, int, int]] = []
        self._declaration = self._all_taken = -1
        self.decision_step = -1

    @property
    def done(self) -> bool:
        """Whether the run has been looked at to its last step."""
        return self._seen >= self._last

    def follow(self, robot: int | None) -> None:
        """Look for the changes of a robot from the start of the run on; for None, of no robot."""
        if robot != self._robot:
            self._robot = robot
            if robot is not None:
                self._swarm.restore(self._start)
                self._seen = -1
                self._changes = []
                self._note()

    def look(self, seconds: float) -> bool:
        """Go ahead for a limited time; return whether all is found."""
        for chunk in _chunks(seconds):
            if self.done:
                break
            is_followed = self._robot is not None and len(self._changes) < CHANGES_LIMIT
            self._swarm.advance(min(1 if is_followed else chunk, self._last - self._swarm.step))
            self._note()
        return self.done

    def to_dict(self, first: int, seen: int = 0) -> dict[str, Any]:
        """Return what is found as a message.

        ``first`` changes of the robot and ``seen`` changes of the world are left out.
        """
        return {
            "type": "outlook",
            "robot": self._robot,
            "first": first,
            "changes": self._changes[first:],
            "seen": seen,
            "world": self._world[seen:],
            "decision": self.decision_step,
            "declaration": self._declaration,
            "allTaken": self._all_taken,
            "until": self._seen,
            "done": self.done,
        }

    def _note(self) -> None:
        """Add what has changed at this step."""
        swarm = self._swarm
        self._seen = swarm.step
        self.decision_step = max(self.decision_step, swarm.first_decision[1])
        self._declaration = max(self._declaration, swarm.declaration_step)
        self._all_taken = max(self._all_taken, swarm.all_taken_step)
        if swarm.scenario.dynamic:
            self._note_world()
        if self._robot is not None and len(self._changes) < CHANGES_LIMIT:
            flags = swarm.robot(self._robot).flags & SHOWN if swarm.present[self._robot] else 0
            if not self._changes or self._changes[-1][1] != flags:
                self._changes.append((swarm.step, flags))

    def _note_world(self) -> None:
        """Add the steps at which the numbers of robots or tasks, or the truth, change: with the new ones."""
        swarm, start = self._swarm, max(self._noted, 0)
        if swarm.step <= self._noted:
            return
        curves = (each[start:] for each in (swarm.robot_counts, swarm.task_counts, swarm.truths))
        rows = np.stack([each.astype(np.int64) for each in curves], axis=1)
        differs = np.flatnonzero((rows[1:] != rows[:-1]).any(axis=1)) + 1
        if self._noted < 0:
            differs = np.concatenate([[0], differs])
        found = [(start + each, *rows[each].tolist()) for each in differs.tolist()]
        self._world += found[: max(0, CHANGES_LIMIT - len(self._world))]
        self._noted = swarm.step

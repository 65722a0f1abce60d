"""The steps of one field, as far as a viewer has received them."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.field.checks import MARKS
from feasibee.simulation.snapshot import FLAGS, Snapshot

ROOM: Final = 64 * 2**20
"""Most bytes of the steps that are kept; the oldest ones go first."""
FIXED: Final = 2000
"""Bytes of a step in addition to those per robot, about."""
CURVE_LIMIT: Final = 200_000
"""Most steps of the curves of counts."""


class View(NamedTuple):
    """One step of a field."""

    step: int
    shown: Snapshot
    counts: tuple[int, int, int]
    """Robots that hold feasible, that hold infeasible, and that count."""
    declared: tuple[int, int]
    decision: tuple[int, int, int]
    """The opinion at this step, the first decision and its step."""
    lost: tuple[int, ...]
    """Numbers of the robots whose processes are silent."""
    is_cut: bool
    """Whether the radio is cut between the two halves of the robots."""
    tasks: NDArray[np.uint16]
    """Positions of the tasks in a world that changes, shape (tasks, 2); none in another one."""
    truth: bool
    """Whether the tasks of this step are feasible."""


class FieldSteps:
    """The steps of one field that have been received.

    Parameters
    ----------
    scene : mapping
        What stays as it is in the field; see `feasibee.field.viewers.scene_of`.
    """

    def __init__(self, scene: Mapping[str, Any]) -> None:
        self.scene = scene
        self.views: list[View] = []
        self.first = 0
        self.has_ended = False
        self._curves: list[tuple[int, ...]] = []

    @property
    def latest(self) -> int:
        """The newest step that was received; -1 before the first one."""
        return self.views[-1].step if self.views else -1

    def at(self, step: int) -> View:
        """Return a step that was received, or the last one before it that is kept."""
        place = bisect_right(self.views, step, key=lambda each: each.step)
        return self.views[max(0, place - 1)]

    def counts(self, first: int, until: int) -> NDArray[np.int32]:
        """Return counts and truth of steps from one to before another: int32, shape (steps, 4)."""
        found = self._curves[max(0, first - self.first) : max(0, until - self.first)]
        return np.array(found, np.int32).reshape(-1, 4)

    def fits(self, body: Mapping[str, Any]) -> bool:
        """Return whether a step is of robots that this field may have."""
        numbers = {*body["numbers"], *body["lost"]}
        return max(numbers, default=0) < len(self.scene["faults"])

    def keep(self, body: Mapping[str, Any]) -> None:
        """Keep a step; while all steps take too much memory, drop the oldest ones."""
        view = view_of(body, len(self.scene["faults"]))
        known = *view.counts, int(view.truth)
        if not self.views:
            self.first = view.step
        missing = view.step - self.latest if self.views else 1
        if missing > 0 and view.step - self.first < CURVE_LIMIT:
            before = self._curves[-1:] or [known]
            self._curves += [*before * (missing - 1), known]  # packets that were lost
        if missing > 0:
            self.views.append(view)
        elif view.step == self.latest:  # a robot may have fallen silent meanwhile
            self.views[-1] = view
        most = max(2, ROOM // (FIXED + 7 * len(self.scene["faults"])))
        del self.views[: max(0, len(self.views) - most)]
        self.has_ended = body["end"]


def view_of(body: Mapping[str, Any], robots: int) -> View:
    """Return a step as pages draw it, with a row for each of so many numbers that robots may have.

    A silent robot has no opinion and doesn't work.
    """
    there = body["numbers"]

    def rows(values: Any, dtype: type[np.generic]) -> NDArray[Any]:
        found = np.zeros(robots, dtype)
        found[there] = values
        return found

    lost = np.zeros(robots, np.bool_)
    lost[body["lost"]] = True
    opinions, marks = rows(body["opinions"], np.int8), rows(body["marks"], np.uint16)
    having = {name: (marks >> bit & 1).astype(np.bool_) for bit, name in enumerate(MARKS)}
    having |= {
        "feasible": (opinions == 1) & ~lost,
        "neutral": (opinions == -1) | lost,
        "there": rows(True, np.bool_),
    }
    for name in ("disseminating", "working"):
        having[name] = having[name] & ~lost
    flags = np.zeros(robots, np.uint16)
    for bit, name in enumerate(FLAGS):
        flags |= having[name].astype(np.uint16) << np.uint16(bit)
    x, y = np.array(body["places"], np.uint16).reshape(-1, 2).T
    headings = rows(body["headings"], np.uint8)
    shown = Snapshot(rows(x, np.uint16), rows(y, np.uint16), flags, headings)
    tasks = np.array(body["tasks"], np.uint16).reshape(-1, 2)
    numbers: dict[str, Any] = {name: tuple(body[name]) for name in ("counts", "declared", "decision", "lost")}
    return View(body["t"], shown, is_cut=body["cut"], tasks=tasks, truth=body["truth"], **numbers)

"""A field's log as pages take it: its steps as columns of numbers, and how it is now."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from feasibee.base.codes import FLAGS
from feasibee.base.files import named
from feasibee.field.plan import numbers_in_words
from feasibee.field.recording import Recording
from feasibee.reference.mind import BYZANTINE, STUBBORN
from feasibee.results.measures import least_quorum

SILENCE: Final = 5.0
"""Seconds without a line in the log after which a field is silent."""
AT_ONCE: Final = 250
"""Most steps at once."""
NO_TASK: Final = 2**16 - 1
"""Aim of a robot that has none."""


def columns_of(field: Recording, start: int) -> dict[str, Any]:
    """Return the steps of a field from one on, some at most, as history.js takes them: see its Steps.

    ``lost`` has the silent robots of each step.
    """
    steps = range(start, min(field.last + 1, start + AT_ONCE))
    robots: dict[str, list[int]] = {}
    numbers: list[int] = []
    there: list[dict[str, Any]] = []
    lost: list[list[int]] = []
    for step in steps:
        field.step = step
        for name, column in _robots(field).items():
            robots.setdefault(name, []).extend(column.tolist())
        numbers += _numbers(field)
        lost.append(np.flatnonzero(field.lost).tolist())
        now = _there(field)
        if not there or {**there[-1], "step": step} != now:
            there.append(now)
    done, most = field.has_ended and start + len(steps) > field.last, field.scenario.most.robots
    about = {"from": start, "count": len(steps), "every": 1, "kept": len(steps), "robots": most}
    found = {"numbers": numbers, "there": there, "lost": lost, "done": done, "problem": ""}
    return {**about, **robots, **found}


def _robots(field: Recording) -> dict[str, NDArray[Any]]:
    """Return the columns of the robots of a step. A silent one has no opinion and doesn't work."""
    there, lost = field.present, field.lost
    having = {
        "feasible": (field.opinions == 1) & ~lost,
        "neutral": there & ((field.opinions == -1) | lost),
        "disseminating": field.disseminating,
        "declared": field.declared >= 0,
        "working": field.working,
        "byzantine": field.fault_of == BYZANTINE,
        "stubborn": field.fault_of == STUBBORN,
        "there": there,
        "standing": field.standing,
    }
    flags = np.sum([having[name].astype(int) << bit for bit, name in enumerate(FLAGS)], axis=0)
    turns = np.round(field.headings * (128 / np.pi)).astype(int) & 255
    x, y = field.coarse_places()
    found = {"x": x, "y": y, "flags": flags, "heading": turns}
    if field.scenario.acts:
        found["aims"] = np.where(field.acting.aims < 0, NO_TASK, field.acting.aims)
    return found


def _numbers(field: Recording) -> list[int]:
    """Return what history.js calls NUMBERS of a step; a log doesn't have the last three."""
    robots, tasks = int(field.present.sum()), len(field.task_numbers)
    counts = (field.counted_counts, field.feasible_counts, field.infeasible_counts)
    counted, feasible, infeasible = (int(each[-1]) for each in counts)
    needed = least_quorum(field.scenario, counted)
    missing = 0 if field.truth else max(1, tasks - robots)
    return [robots, tasks, counted, feasible, infeasible, needed, field.decision, missing, 0, -1, -1]


def _there(field: Recording) -> dict[str, Any]:
    """Return the tasks of a step, and the classes of robots."""
    x, y = (each.tolist() for each in field.task_places())
    taken = {"taken": field.acting.looks.tolist()} if field.scenario.acts else {}
    tasks = {"taskX": x, "taskY": y, "taskNumbers": field.task_numbers.tolist(), **taken}
    return {"step": field.step, **tasks, "kinds": field.robot_kinds}


def state_of(field: Recording) -> dict[str, Any]:
    """Return how a field is now: who is silent, and whether it goes on."""
    field.step, problems = field.last, []
    if lost := np.flatnonzero(field.lost).tolist() if field.last >= 0 else []:
        one, verb = ("robot", "is") if len(lost) == 1 else ("robots", "are")
        problems.append(f"{one} {numbers_in_words(lost)} {verb} silent")
    if field.cuts_at(field.step):
        problems.append("the radio is cut between the two halves of the robots")
    if silent := not field.has_ended and field.silence > SILENCE:
        problems.append(
            f"the field in {named(field.folder)} has logged nothing for more than {SILENCE:g} s; "
            "this page shows the next one that writes there"
        )
    return {"problems": problems, "silent": silent, "ended": field.has_ended, "last": field.last}

"""A recording of a field: its world's log, step by step, as far as it is written, with what pictures need."""

from __future__ import annotations

import json
import time
from functools import cached_property
from hashlib import sha256
from math import inf
from os import SEEK_END
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from feasibee.base.codes import FEASIBLE, FLAGS, INFEASIBLE
from feasibee.base.files import named
from feasibee.field.bodies import Bodies
from feasibee.field.logs import LOG_LIMIT, VERSION, read_log, reading
from feasibee.field.plan import PARTITION, PROCESS, Fault, fault_in_words, numbers_in_words
from feasibee.reference.mind import BYZANTINE, HONEST, STOPPED, STUBBORN
from feasibee.results.measures import held_decision, least_quorum
from feasibee.scenario.paths import toml_tables
from feasibee.scenario.picture import Deeds
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario

LOG: Final = "world.jsonl"
"""Name of the world's log in a field's folder."""


class Recording:
    """A field, step by step as its world logs it: the part of ``Swarm`` that pages and painters need.

    Who is there, positions of robots, opinions, decisions and the truth are those of the log. Positions of
    tasks and faulty robots follow from its scenario, seed and run. No strategy is run.

    ``folder`` is what ``feasibee robot launch --out`` has written. Raise a FeasibeeError if it has no world's
    log, or a damaged one.
    """

    bits_sent: Final = 0
    """A log has no bits, and so no steps of robots to divide them by."""
    robot_counts: Final = np.zeros(1, np.int64)
    first_decision: tuple[int, int]  # as all that `_step` returns

    def __init__(self, folder: Path) -> None:
        self.folder, self._path = folder, folder / LOG
        lines, _ = read_log(
            self._path,
            "the folder that `feasibee robot launch --out FOLDER` has written",
            {"feasibee": "field", "version": VERSION},
            f"isn't the world's log of a field, version {VERSION}; run the field again with --out",
        )
        self._head, self._read = lines[0], sum(len(line.encode()) + 1 for line in lines)
        with reading(self._path, 1):
            head = json.loads(self._head)
            tables = toml_tables(head["scenario"], "scenario")
            self.scenario = Scenario.from_tables(tables, source=head["source"], trusted=False)
            self.which = Runs.single(head["seed"], head["run"])
        self.hz: float | None = None if head.get("lockstep") else head.get("hz")
        """Steps per second of the robots' clocks; None in lockstep."""
        self.faults: list[Fault] = []
        self.has_ended = False
        """Whether the world has ended the field; false, too, if it was killed."""
        self._steps: list[dict[str, Any]] = []
        self._lines, self.step = 1, 0
        self._counts = np.zeros((0, 4), np.int64)
        """At each step: counted robots that hold feasible and infeasible, all counted ones, and the truth."""
        self._take(lines[1:])

    def grow(self) -> bool:
        """Take what the world has logged since; return whether the log is still that of the same field.

        Raise a FeasibeeError if the log is damaged.
        """
        try:
            with self._path.open("rb") as file:
                head = file.read(len(self._head.encode()))
                if head.decode(errors="replace") != self._head or file.seek(0, SEEK_END) < self._read:
                    return False
                file.seek(self._read)
                data = file.read(LOG_LIMIT)
        except OSError:  # it is gone: the field is silent
            return True
        end = data.rfind(b"\n") + 1
        self._read += end
        self._take(data[:end].decode(errors="replace").splitlines())
        return True

    def _take(self, lines: list[str]) -> None:
        """Take further lines of the log."""
        counts = []
        for text in lines:
            self._lines += 1
            with reading(self._path, self._lines):
                line = json.loads(text)
                if "event" not in line:
                    step = self._step(line)
                    self._steps.append(step)
                    held = step["opinions"][step["counted"]]
                    of_opinions = ((held == each).sum() for each in (1, 0))
                    counts.append([*of_opinions, step["counted"].sum(), step["truth"]])
                elif line["event"] == "fault":
                    fault = Fault(*(line[name] for name in Fault._fields))
                    self.faults.append(fault._replace(robots=tuple(fault.robots)))
                self.has_ended |= line.get("event") == "end"
        self.faults.sort(key=lambda fault: fault.step)
        self._counts = np.append(self._counts, np.array(counts, np.int64).reshape(-1, 4), axis=0)

    def _step(self, line: dict[str, Any]) -> dict[str, Any]:
        """Return a step's line, as far as it is drawn.

        An array has a value for each number that a robot may have: -1 for no task, opinion or declaration.
        """
        now, robots, processes = len(self._steps), line["robots"], line["processes"]
        if line["step"] != now:
            raise ValueError(f"step {now} is missing")
        bodies, goals = (self._columns(line, *each) for each in (("bodies", [0] * 4), ("goes", [-1] * 3)))
        opinions, declared, disseminating = self._columns(line, "minds", [-1, -1, 0])
        first, numbers = self._first_faults, np.arange(len(opinions))
        faults = np.full(len(numbers), "", "U16")
        faults[robots] = [first[each] if each < len(first) else HONEST for each in processes]
        lost, stops = np.isin(numbers, [*line["lost"]]), now >= self.scenario.faults.stop_step
        works = (faults != "") & ~lost & ~(stops & (faults == STOPPED))
        decision, since = line["decision"]
        return {
            "robots": robots,
            "processes": processes,  # those of the robots of the start are the lowest
            "numbers_of_tasks": [*line["tasks"]],
            "done": line.get("done", []),
            "placed": {i: (x, y) for i, x, y in line.get("placed", ())},  # tasks, if events put some
            "truth": bool(line["truth"]),
            "first_decision": (decision, since),
            "places": bodies[:2].T,  # in fixed point
            "headings": np.where(works, np.arctan2(bodies[3], bodies[2]), 0.0),
            "present": faults != "",
            "opinions": opinions,
            "declared": declared,
            "disseminating": works & (disseminating > 0),
            "lost": lost,
            "fault_of": faults,
            "working": works,
            "counted": works & (faults != BYZANTINE),
            "targets": goals[0],
            "standing": goals[1] >= 0,
            "holds": goals[1:].max(axis=0),  # at which a robot stands, or which it has marked
        }

    def _columns(self, line: dict[str, Any], name: str, nobody: list[int]) -> NDArray[np.int64]:
        """Return the columns of a table with a row per robot; ``nobody`` is the row of other numbers."""
        found = np.tile(np.array(nobody, np.int64), (self.scenario.most.robots, 1))
        rows = line.get(name, [nobody] * len(line["robots"]))
        cells = [row[: len(nobody)] for row in rows]
        found[line["robots"]] = np.reshape(cells, (len(line["robots"]), len(nobody)))
        return found.T

    @cached_property
    def _bodies(self) -> Bodies:
        """The bodies at the start; there are as many as the log's first step has."""
        return Bodies(self.scenario, self.which.seed, self.which.first)

    @cached_property
    def _first_faults(self) -> list[str]:
        """The faults of the robots of the start."""
        return [body.fault for body in self._bodies.everyone[: self.scenario.robots.count]]

    def __getattr__(self, name: str) -> Any:
        """Return what this step's line has by a name."""
        steps = vars(self).get("_steps") or [{}]
        if name not in steps[0]:
            raise AttributeError(f"a recording has no {name!r}")
        return steps[self.step][name]

    @property
    def last(self) -> int:
        """The last step that was logged; -1 before the first one."""
        return len(self._steps) - 1

    @property
    def silence(self) -> float:
        """Seconds since the log was written to; infinite if it is gone."""
        try:
            return time.time() - self._path.stat().st_mtime
        except OSError:
            return inf

    @property
    def mark(self) -> str:
        """What differs for each field that logs into the folder."""
        return sha256(self._head.encode()).hexdigest()[:16]

    def advance(self, steps: int = 1) -> None:
        """Go on by a number of steps."""
        self.step += steps

    @property
    def tasks(self) -> NDArray[np.float64]:
        """Positions of the tasks at this step in units: float64, shape (tasks, 2)."""
        return self._in_units(self._task_places())

    @property
    def task_numbers(self) -> NDArray[np.int64]:
        """Numbers of the tasks at this step, in ascending order: int64, shape (tasks,)."""
        return np.array(self.numbers_of_tasks, np.int64)

    @property
    def robot_kinds(self) -> list[int]:
        """The class of each number that a robot may have."""
        return self._bodies.robot_kinds

    def coarse_places(self) -> tuple[NDArray[np.uint16], NDArray[np.uint16]]:
        """Return x and y of the robots, in 65,536ths of the arena's longer side: uint16, shape (robots,)."""
        return self._coarse(self.places)

    def task_places(self) -> tuple[NDArray[np.uint16], NDArray[np.uint16]]:
        """Return x and y of the tasks of this step, in the same unit: uint16, shape (tasks,)."""
        return self._coarse(self._task_places())

    def _task_places(self) -> NDArray[np.int64]:
        placed, world = self.placed, self._bodies.world
        places = [placed.get(number) or world.task_place(number) for number in self.numbers_of_tasks]
        return np.array(places, np.int64).reshape(-1, 2)

    def _coarse(self, places: NDArray[np.int64]) -> tuple[NDArray[np.uint16], NDArray[np.uint16]]:
        parts = (places << 16) // max(self._bodies.world.size)
        x, y = np.minimum(parts, 65_535).astype(np.uint16).T
        return x, y

    @property
    def positions(self) -> NDArray[np.float64]:
        """Positions of the robots in units: float64, shape (robots, 2)."""
        return self._in_units(self.places)

    all_taken_step: Final = -1
    """A log doesn't have it."""

    @property
    def acting(self) -> Deeds:
        """Targets of robots, tasks at which robots stand or which they have marked, and done tasks."""
        holders = np.full(self.scenario.most.tasks, -1, np.int32)
        holding = self.holds >= 0
        holders[self.holds[holding]] = np.flatnonzero(holding)
        holders[self.done] = -2
        return Deeds.of(self.targets, self.standing, holders, self.task_numbers)

    @property
    def feasible_counts(self) -> NDArray[np.int64]:
        """Number of counted robots with opinion 1 at each step so far."""
        return self._counts[: self.step + 1, 0]

    @property
    def infeasible_counts(self) -> NDArray[np.int64]:
        """Number of counted robots with opinion 0 at each step so far."""
        return self._counts[: self.step + 1, 1]

    @property
    def counted_counts(self) -> NDArray[np.int64]:
        """Number of counted robots at each step so far."""
        return self._counts[: self.step + 1, 2]

    @property
    def declared_counts(self) -> tuple[int, int]:
        """Numbers of counted robots that have declared feasible, and infeasible."""
        declared = self.declared[self.counted]
        return int((declared == FEASIBLE).sum()), int((declared == INFEASIBLE).sum())

    @property
    def truths(self) -> NDArray[np.bool_]:
        """Whether the tasks were feasible at each step so far."""
        return self._counts[: self.step + 1, 3].astype(np.bool_)

    @property
    def decision(self) -> int:
        """Decision of the counted robots at this step: 1 feasible, 0 infeasible, -1 undecided."""
        feasible, infeasible, counted, _ = self._counts[self.step].tolist()
        return held_decision(self.scenario, feasible, infeasible, counted)

    def notes_at(self, step: int) -> list[str]:
        """Return lines on the last fault of processes, on radio that is cut, and on lost robots at a step."""
        hit = [fault for fault in self.faults if fault.step <= step and fault.kind in PROCESS]
        lines = [fault for fault in hit if fault.step == hit[-1].step] + self.cuts_at(step)
        notes = [f"step {fault.step}: {fault_in_words(fault._asdict())}" for fault in sorted(lines)]
        there = self._steps[step]
        named = zip(there["robots"], there["processes"], strict=True)
        lost = [process for number, process in named if there["lost"][number]]
        return [*notes, f"lost: {numbers_in_words(lost)}"] if lost else notes

    def cuts_at(self, step: int) -> list[Fault]:
        """Return the faults by which the radio is cut at a step."""
        cuts = [fault for fault in self.faults if fault.kind == PARTITION]
        return [fault for fault in cuts if fault.step <= step < fault.step + fault.lasts]

    def _in_units(self, places: NDArray[np.int64]) -> NDArray[np.float64]:
        return places.astype(np.float64) * float(self._bodies.world.unit)


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

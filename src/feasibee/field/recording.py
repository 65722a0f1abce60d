"""A recording of a field: its world's log, step by step, as far as it is written, with what pictures need."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cached_property
from os import SEEK_END
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.field.bodies import Bodies
from feasibee.field.logs import LOG_LIMIT, VERSION, read_log, reading
from feasibee.field.plan import PARTITION, PROCESS, Fault, fault_in_words, numbers_in_words
from feasibee.model.codes import FEASIBLE, INFEASIBLE, UNDECIDED, exact
from feasibee.reference.mind import BYZANTINE, HONEST, STOPPED
from feasibee.scenario.geometry import Acting
from feasibee.scenario.paths import toml_tables
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario

LOG: Final = "world.jsonl"
"""Name of the world's log in a field's folder."""


class _Step(NamedTuple):
    """A step's line, as far as it is drawn."""

    robots: list[int]
    """Numbers of the robots."""
    processes: list[int]
    """Numbers of their processes; those of the robots of the start are the lowest."""
    tasks: list[int]
    """Numbers of the tasks."""
    truth: int
    bodies: NDArray[np.int64]
    """Place and velocity of each robot in fixed point."""
    minds: NDArray[np.int8]
    """Opinion, declaration, and whether it disseminates, of each robot."""
    lost: list[int]
    decision: tuple[int, int]
    faults: NDArray[np.str_]
    """The fault of each robot."""
    works: NDArray[np.bool_]
    counted: NDArray[np.bool_]
    goals: NDArray[np.int32]
    """The task to which each robot goes, that at which it stands, and that which it has marked, or -1."""
    done: list[int]
    """Numbers of the tasks at which the work is done."""
    placed: dict[int, tuple[int, int]]
    """Where each task is, if events put some."""


class _OfRobots:
    """Values of a step's robots by number, with another one for numbers without robot."""

    def __init__(self, nobody: float, values: Callable[[_Step], NDArray[Any]]) -> None:
        self._nobody, self._values = nobody, values

    def __get__(self, field: Recording, _: type[Recording]) -> NDArray[Any]:
        return field._rows(self._values(field._now), self._nobody)


class Recording:
    """A field, step by step as its world logs it: the part of ``Swarm`` that pages and painters need.

    Who is there, positions of robots, opinions, decisions and the truth are those of the log. Positions of
    tasks and faulty robots follow from its scenario, seed and run. No strategy is run.

    ``folder`` is what ``feasibee launch --out`` has written. Raise a FeasibeeError if it has no world's log,
    or a damaged one.
    """

    bits_sent: Final = 0
    """A log has no bits, and so no steps of robots to divide them by."""
    robot_counts: Final = np.zeros(1, np.int64)

    def __init__(self, folder: Path) -> None:
        self._path = folder / LOG
        lines, _ = read_log(
            self._path,
            "the folder that `feasibee launch --out FOLDER` has written",
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
        self._steps: list[_Step] = []
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
                    held = step.minds[step.counted, 0]
                    counts.append(
                        [*((held == each).sum() for each in (1, 0)), step.counted.sum(), step.truth]
                    )
                elif line["event"] == "fault":
                    fault = Fault(*(line[name] for name in Fault._fields))
                    self.faults.append(fault._replace(robots=tuple(fault.robots)))
                self.has_ended |= line.get("event") == "end"
        self.faults.sort(key=lambda fault: fault.step)
        self._counts = np.append(self._counts, np.array(counts, np.int64).reshape(-1, 4), axis=0)

    def _step(self, line: dict[str, Any]) -> _Step:
        """Return a step's line."""
        now, robots, processes, lost = len(self._steps), line["robots"], line["processes"], [*line["lost"]]
        if line["step"] != now:
            raise ValueError(f"step {now} is missing")
        first, count = self._first_faults, len(robots)
        faults = np.array([first[each] if each < len(first) else HONEST for each in processes], np.str_)
        works = ~np.isin(robots, lost) & ((now < self.scenario.faults.stop_step) | (faults != STOPPED))
        decision, step = line["decision"]
        found = _Step(
            robots,
            processes,
            [*line["tasks"]],
            line["truth"],
            np.array(line["bodies"], np.int64).reshape(count, 4),
            np.array([mind[:3] for mind in line["minds"]], np.int8).reshape(count, 3),
            lost,
            (decision, step),
            faults.reshape(count),
            works,
            works & (faults != BYZANTINE),
            np.array(line.get("goes", [[-1] * 3] * count), np.int32).reshape(count, 3),
            line.get("done", []),
            {i: (x, y) for i, x, y in line.get("placed", ())},
        )
        np.zeros(self.scenario.most.robots)[robots]  # none has a number beyond these
        return found

    @cached_property
    def _bodies(self) -> Bodies:
        """The bodies at the start; there are as many as the log's first step has."""
        return Bodies(self.scenario, self.which.seed, self.which.first)

    @cached_property
    def _first_faults(self) -> NDArray[np.str_]:
        """The faults of the robots of the start."""
        return np.array([body.fault for body in self._bodies.everyone[: self.scenario.robots.count]])

    @property
    def _now(self) -> _Step:
        return self._steps[self.step]

    @property
    def last(self) -> int:
        """The last step that was logged; -1 before the first one."""
        return len(self._steps) - 1

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
        return np.array(self._now.tasks, np.int64)

    @property
    def robot_kinds(self) -> list[int]:
        """The class of each number that a robot may have."""
        return self._bodies.robot_kinds

    def coarse_places(self) -> tuple[NDArray[np.uint16], NDArray[np.uint16]]:
        """Return x and y of the robots, in 65,536ths of the arena's longer side: uint16, shape (robots,)."""
        x, y = self._coarse(self._now.bodies[:, :2])
        return self._rows(x, 0), self._rows(y, 0)

    def task_places(self) -> tuple[NDArray[np.uint16], NDArray[np.uint16]]:
        """Return x and y of the tasks of this step, in the same unit: uint16, shape (tasks,)."""
        return self._coarse(self._task_places())

    def _task_places(self) -> NDArray[np.int64]:
        placed, world = self._now.placed, self._bodies.world
        places = [placed.get(number) or world.task_place(number) for number in self._now.tasks]
        return np.array(places, np.int64).reshape(-1, 2)

    def _coarse(self, places: NDArray[np.int64]) -> tuple[NDArray[np.uint16], NDArray[np.uint16]]:
        parts = (places << 16) // max(self._bodies.world.size)
        x, y = np.minimum(parts, 65_535).astype(np.uint16).T
        return x, y

    @property
    def positions(self) -> NDArray[np.float64]:
        """Positions of the robots in units: float64, shape (robots, 2)."""
        return self._rows(self._in_units(self._now.bodies[:, :2]), 0.0)

    headings = _OfRobots(0.0, lambda step: np.where(step.works, np.arctan2(*step.bodies[:, :1:-1].T), 0.0))
    """Directions of robots in radians: float64, shape (robots,); 0 if a robot stopped or is lost."""
    present = _OfRobots(False, lambda step: np.ones(len(step.robots), np.bool_))
    """Whether a robot, lost or not, has each number at this step: bool, shape (robots,)."""
    opinions = _OfRobots(-1, lambda step: step.minds[:, 0])
    """Opinions that the robots last reported: int8, shape (robots,)."""
    declared = _OfRobots(-1, lambda step: step.minds[:, 1])
    """What each robot has declared: int8, shape (robots,), -1 for nothing."""
    disseminating = _OfRobots(False, lambda step: step.minds[:, 2].astype(np.bool_) & step.works)
    """Whether each robot is disseminating: bool, shape (robots,)."""
    working = _OfRobots(False, lambda step: step.works)
    """Whether each robot works, and its process answers: bool, shape (robots,)."""
    counted = _OfRobots(False, lambda step: step.counted)
    """Whether each robot counts in the decision: bool, shape (robots,)."""
    lost = _OfRobots(False, lambda step: np.isin(step.robots, step.lost))
    """Whether each robot's process is silent: bool, shape (robots,)."""

    all_taken_step: Final = -1
    """A log doesn't have it."""
    targets = _OfRobots(-1, lambda step: step.goals[:, 0])
    """The task to which each robot goes: int32, shape (robots,), -1 for none."""
    standing = _OfRobots(False, lambda step: step.goals[:, 1] >= 0)
    """Whether each robot stands at a task: bool, shape (robots,)."""

    @property
    def acting(self) -> Acting:
        """Targets of robots, tasks at which robots stand or which they have marked, and done tasks."""
        holders = np.full(self.scenario.most.tasks, -1, np.int32)
        has = self._now.goals[:, 1:].max(axis=1, initial=-1)
        holders[has[has >= 0]] = np.array(self._now.robots, np.int32)[has >= 0]
        holders[self._now.done] = -2
        return Acting.of(self.targets, self.standing, holders, self.task_numbers)

    def has_fault(self, kind: str) -> NDArray[np.bool_]:
        """Return whether each robot has a fault of a kind: bool, shape (robots,)."""
        return self._rows(self._now.faults == kind, False)

    def _rows(self, values: NDArray[Any], nobody: float) -> NDArray[Any]:
        """Return values of the robots of this step by number, with another one for free numbers."""
        found = np.full((self.scenario.most.robots, *values.shape[1:]), nobody, values.dtype)
        found[self._now.robots] = values
        return found

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
    def truth(self) -> bool:
        """Whether the tasks of this step are feasible for the robots of this step."""
        return bool(self._now.truth)

    @property
    def decision(self) -> int:
        """Decision of the counted robots at this step: 1 feasible, 0 infeasible, -1 undecided."""
        feasible, infeasible, counted, _ = self._counts[self.step].tolist()
        needed = exact(self.scenario.decision.threshold) * counted
        return FEASIBLE if feasible > needed else INFEASIBLE if infeasible > needed else UNDECIDED

    @property
    def first_decision(self) -> tuple[int, int]:
        """First decision of the field so far and its step; -1 and -1 while undecided."""
        return self._now.decision

    def notes_at(self, step: int) -> list[str]:
        """Return lines on the last fault of processes, on radio that is cut, and on lost robots at a step."""
        hit = [fault for fault in self.faults if fault.step <= step and fault.kind in PROCESS]
        lines = [fault for fault in hit if fault.step == hit[-1].step] + self.cuts_at(step)
        notes = [f"step {fault.step}: {fault_in_words(fault._asdict())}" for fault in sorted(lines)]
        there = self._steps[step]
        named = zip(there.robots, there.processes, strict=True)
        lost = [process for number, process in named if number in there.lost]
        return [*notes, f"lost: {numbers_in_words(lost)}"] if lost else notes

    def cuts_at(self, step: int) -> list[Fault]:
        """Return the faults by which the radio is cut at a step."""
        cuts = [fault for fault in self.faults if fault.kind == PARTITION]
        return [fault for fault in cuts if fault.step <= step < fault.step + fault.lasts]

    def _in_units(self, places: NDArray[np.int64]) -> NDArray[np.float64]:
        return places.astype(np.float64) * float(self._bodies.world.unit)

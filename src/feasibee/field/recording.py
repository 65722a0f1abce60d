"""A recording of a field: its world's log, step by step, with what a painter of frames needs of a swarm."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.errors import FeasibeeError, one_line
from feasibee.field.bodies import Bodies
from feasibee.field.checks import is_status, is_whole
from feasibee.field.faults import KINDS, PARTITION, PROCESS, Fault, fault_in_words, numbers_in_words
from feasibee.field.frames import ROBOTS_LIMIT
from feasibee.field.replay import LOG_LIMIT, damaged, parsed
from feasibee.field.worldlog import VERSION
from feasibee.files.reading import named, read_text
from feasibee.model.codes import FEASIBLE, INFEASIBLE, UNDECIDED, exact
from feasibee.reference.mind import BYZANTINE, HONEST, STOPPED
from feasibee.scenario.paths import toml_tables
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario

LOG: Final = "world.jsonl"
"""Name of the world's log in a field's folder."""
FAR: Final = 2**40
"""Bound of coordinates and velocities in fixed point; the sides of an arena are at most 2**32."""


class Recording:
    """A field, step by step as its world logged it: the part of ``Swarm`` that a painter of frames needs.

    Who is there, positions of robots, opinions, decisions and the truth are those of the log. Positions of
    tasks and faulty robots follow from its scenario, seed and run. No strategy is run.

    Parameters
    ----------
    folder : Path
        The folder that ``feasibee launch --out`` has written.

    Raises
    ------
    FeasibeeError
        If the folder has no world's log, or a damaged one.
    """

    def __init__(self, folder: Path) -> None:
        path = folder / LOG
        what = "the folder that `feasibee launch --out FOLDER` has written"
        lines = read_text(path, what, LOG_LIMIT).split("\n")[:-1]  # a killed world's last one is incomplete
        if not lines:
            raise damaged(path, 1, "is incomplete")
        self.scenario, one = _head(path, lines[0])
        self.faults, self._steps = _steps(path, lines[1:], self.scenario)
        bodies = Bodies(self.scenario, one.seed, one.first)  # as many as the log's first step has
        self.step, self.last = 0, len(self._steps) - 1
        self.decided = self._steps[-1].decision
        self._world = bodies.world
        faults = np.array([body.fault for body in bodies.everyone[: self.scenario.robots.count]])
        shown = [step.shown(number, faults, self.scenario) for number, step in enumerate(self._steps)]
        self._works = [works for works, _ in shown]
        self._counted = [counted for _, counted in shown]
        self._counts: NDArray[np.int64] = np.array([each.sum() for each in self._counted])
        held = [step.minds[:, 0][counts] for step, counts in zip(self._steps, self._counted, strict=True)]
        self._holding: dict[int, NDArray[np.int64]] = {
            opinion: np.array([(each == opinion).sum() for each in held])
            for opinion in (FEASIBLE, INFEASIBLE)
        }
        self._truths: NDArray[np.bool_] = np.array([step.truth for step in self._steps], np.bool_)

    def advance(self, steps: int = 1) -> None:
        """Go on by a number of steps."""
        self.step += steps

    @property
    def tasks(self) -> NDArray[np.float64]:
        """Positions of the tasks at this step in units: float64, shape (tasks, 2)."""
        places = [self._world.task_place(number) for number in self._steps[self.step].tasks]
        return self._in_units(np.array(places, np.int64).reshape(-1, 2))

    @property
    def task_numbers(self) -> NDArray[np.int64]:
        """Numbers of the tasks at this step, in ascending order: int64, shape (tasks,)."""
        return np.array(self._steps[self.step].tasks, np.int64)

    @property
    def positions(self) -> NDArray[np.float64]:
        """Positions of the robots in units: float64, shape (robots, 2)."""
        return self._rows(self._in_units(self._steps[self.step].bodies[:, :2]), 0.0)

    @property
    def headings(self) -> NDArray[np.float64]:
        """Directions of robots in radians: float64, shape (robots,); 0 if a robot stopped or is lost."""
        dx, dy = self._steps[self.step].bodies[:, 2:].T
        return self._rows(np.where(self._works[self.step], np.arctan2(dy, dx), 0.0), 0.0)

    @property
    def present(self) -> NDArray[np.bool_]:
        """Whether a robot, lost or not, has each number at this step: bool, shape (robots,)."""
        return self._rows(np.ones(len(self._steps[self.step].robots), np.bool_), False)

    @property
    def opinions(self) -> NDArray[np.int8]:
        """Opinions that the robots last reported: int8, shape (robots,)."""
        return self._rows(self._steps[self.step].minds[:, 0], -1)

    @property
    def declared(self) -> NDArray[np.int8]:
        """What each robot has declared: int8, shape (robots,), -1 for nothing."""
        return self._rows(self._steps[self.step].minds[:, 1], -1)

    @property
    def disseminating(self) -> NDArray[np.bool_]:
        """Whether each robot is disseminating: bool, shape (robots,)."""
        tells = self._steps[self.step].minds[:, 2].astype(np.bool_)
        return self._rows(tells & self._works[self.step], False)

    @property
    def counted(self) -> NDArray[np.bool_]:
        """Whether each robot counts in the decision: bool, shape (robots,)."""
        return self._rows(self._counted[self.step], False)

    @property
    def lost(self) -> NDArray[np.bool_]:
        """Whether each robot's process is silent: bool, shape (robots,)."""
        step = self._steps[self.step]
        return self._rows(np.isin(step.robots, step.lost), False)

    def _rows(self, values: NDArray[Any], nobody: float) -> NDArray[Any]:
        """Return values of the robots of this step by number, with another one for free numbers."""
        found = np.full((self.scenario.most.robots, *values.shape[1:]), nobody, values.dtype)
        found[self._steps[self.step].robots] = values
        return found

    @property
    def feasible_counts(self) -> NDArray[np.int64]:
        """Number of counted robots with opinion 1 at each step so far."""
        return self._holding[FEASIBLE][: self.step + 1]

    @property
    def infeasible_counts(self) -> NDArray[np.int64]:
        """Number of counted robots with opinion 0 at each step so far."""
        return self._holding[INFEASIBLE][: self.step + 1]

    @property
    def counted_counts(self) -> NDArray[np.int64]:
        """Number of counted robots at each step so far."""
        return self._counts[: self.step + 1]

    @property
    def feasible_count(self) -> int:
        """Number of counted robots with opinion 1."""
        return int(self._holding[FEASIBLE][self.step])

    @property
    def infeasible_count(self) -> int:
        """Number of counted robots with opinion 0."""
        return int(self._holding[INFEASIBLE][self.step])

    @property
    def declared_counts(self) -> tuple[int, int]:
        """Numbers of counted robots that have declared feasible, and infeasible."""
        declared = self.declared[self.counted]
        return int((declared == FEASIBLE).sum()), int((declared == INFEASIBLE).sum())

    @property
    def truths(self) -> NDArray[np.bool_]:
        """Whether the tasks were feasible at each step so far."""
        return self._truths[: self.step + 1]

    @property
    def truth(self) -> bool:
        """Whether the tasks of this step are feasible for the robots of this step."""
        return bool(self._truths[self.step])

    @property
    def decision(self) -> int:
        """Decision of the counted robots at this step: 1 feasible, 0 infeasible, -1 undecided."""
        needed = exact(self.scenario.decision.threshold) * int(self.counted.sum())
        if self.feasible_count > needed:
            return FEASIBLE
        return INFEASIBLE if self.infeasible_count > needed else UNDECIDED

    @property
    def first_decision(self) -> tuple[int, int]:
        """First decision of the field so far and its step; -1 and -1 while undecided."""
        return self._steps[self.step].decision

    def notes_at(self, step: int) -> list[str]:
        """Return lines on the last fault of processes, on radio that is cut, and on lost robots at a step."""
        hit = [fault for fault in self.faults if fault.step <= step and fault.kind in PROCESS]
        lines = [fault for fault in hit if fault.step == hit[-1].step]
        lines += [
            fault
            for fault in self.faults
            if fault.kind == PARTITION and fault.step <= step < fault.step + fault.lasts
        ]
        notes = [f"step {fault.step}: {fault_in_words(fault._asdict())}" for fault in sorted(lines)]
        there = self._steps[step]
        named = zip(there.robots, there.processes, strict=True)
        lost = [process for number, process in named if number in there.lost]
        return [*notes, f"lost: {numbers_in_words(lost)}"] if lost else notes

    def _in_units(self, places: NDArray[np.int64]) -> NDArray[np.float64]:
        return places.astype(np.float64) * float(self._world.unit)


class _Step(NamedTuple):
    """A step's line, as far as it is drawn."""

    bodies: NDArray[np.int64]
    """Place and velocity of each robot in fixed point."""
    minds: NDArray[np.int8]
    """Opinion, declaration, and whether it disseminates, of each robot."""
    lost: list[int]
    decision: tuple[int, int]
    robots: list[int]
    """Numbers of the robots."""
    processes: list[int]
    """Numbers of their processes; those of the robots of the start are the lowest."""
    tasks: list[int]
    """Numbers of the tasks."""
    truth: int

    def shown(
        self, number: int, faults: NDArray[np.str_], scenario: Scenario
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Return which robots work and which ones count at this step; ``faults`` are those of the start."""
        each_has = (faults[each] if each < len(faults) else HONEST for each in self.processes)
        has = np.array(list(each_has), np.str_)
        works = ~np.isin(self.robots, self.lost)
        if number >= scenario.faults.stop_step:
            works &= has != STOPPED
        return works, works & (has != BYZANTINE)


def _head(path: Path, text: str) -> tuple[Scenario, Runs]:
    """Return the scenario of a log, and which run its field is."""
    head = parsed(path, 1, text)
    if head.get("feasibee") != "field" or head.get("version") != VERSION:
        rule = f"isn't the world's log of a field, version {VERSION}"
        raise FeasibeeError(f"{named(path)}: {rule}; run the field again with --out")
    toml, source = head.get("scenario"), head.get("source")
    if not (isinstance(toml, str) and isinstance(source, str)):
        raise damaged(path, 1, "has no scenario")
    try:
        tables = toml_tables(toml, "scenario")
        scenario = Scenario.from_tables(tables, source=source, trusted=False)
        one = Runs.single(head.get("seed"), head.get("run"))  # type: ignore[arg-type]  # it checks them
        if scenario.most.robots <= ROBOTS_LIMIT:
            return scenario, one
        why = f"more than {ROBOTS_LIMIT:,} robots"
    except FeasibeeError as error:
        why = one_line(str(error))
    raise damaged(path, 1, f"has a field that can't be: {why}")


def _steps(path: Path, lines: list[str], scenario: Scenario) -> tuple[list[Fault], list[_Step]]:
    """Return the faults and the steps of a log's lines after the first."""
    faults: list[Fault] = []
    steps: list[_Step] = []
    for at, text in enumerate(lines, 2):
        line = parsed(path, at, text)
        if "event" not in line:
            steps.append(_step(path, at, line, len(steps), scenario))
        elif line["event"] == "fault":
            faults.append(_fault(path, at, line, scenario.robots.count))
        elif line["event"] not in ("lost", "back", "comes", "leaves"):
            raise damaged(path, at, "has no valid event")
    if not steps:
        raise FeasibeeError(f"{named(path)}: has no step; run the field again, longer")
    return sorted(faults, key=lambda fault: fault.step), steps


def _step(path: Path, at: int, line: dict[str, Any], number: int, scenario: Scenario) -> _Step:
    """Return a step's line, if it can be one."""
    given: list[Any] = [line.get(name) for name in _Step._fields]
    bodies, minds, lost, decision, robots, processes, tasks, truth = given
    most = scenario.most
    there = len(robots) if isinstance(robots, list) else 0
    starts = number == 0 and not any(event.step == 0 for event in scenario.events)
    fits = {
        f"step {number}": is_whole(line.get("step"), number, number),
        "robots": _are_numbers(robots, most.robots) and (not starts or there == scenario.robots.count),
        "processes": _are_numbers(processes, ROBOTS_LIMIT) and len(processes) == there,
        "tasks": _are_numbers(tasks, most.tasks) and (not starts or len(tasks) == scenario.tasks.count),
        "truth": is_whole(truth, 0, 1),
        "bodies": _is_list(bodies, there) and all(map(_is_body, bodies)),
        "minds": _is_list(minds, there) and all(map(is_status, minds)),
        "lost": _are_numbers(lost, most.robots),
        "decision": _is_decision(decision, number),
    }
    for name, fit in fits.items():
        if not fit:
            raise damaged(path, at, f"has no valid {name}")
    shown = np.array([(mind[0], mind[2], mind[3]) for mind in minds], np.int8).reshape(-1, 3)
    places = np.array([body[:4] for body in bodies], np.int64).reshape(-1, 4)
    return _Step(places, shown, lost, (decision[0], decision[1]), robots, processes, tasks, truth)


def _fault(path: Path, at: int, line: dict[str, Any], robots: int) -> Fault:
    """Return the fault of a line, if it can be one."""
    step, kind, numbers, lasts = (line.get(name) for name in ("step", "kind", "robots", "lasts"))
    if not (
        is_whole(step, 1, FAR)
        and kind in KINDS
        and _are_numbers(numbers, robots)
        and type(lasts) in (int, float)
        and 0 <= lasts <= FAR  # type: ignore[operator]
    ):
        raise damaged(path, at, "has no valid fault")
    return Fault(step, kind, len(numbers), tuple(numbers), lasts)  # type: ignore[arg-type]


def _is_list(value: Any, length: int) -> bool:
    return isinstance(value, list) and len(value) == length


def _is_body(value: Any) -> bool:
    return _is_list(value, 6) and all(is_whole(each, -FAR, FAR) for each in value[:4])


def _is_decision(value: Any, now: int) -> bool:
    if not _is_list(value, 2):
        return False
    opinion, step = value
    least, most = (-1, -1) if opinion == UNDECIDED else (0, now)
    return is_whole(opinion, UNDECIDED, FEASIBLE) and is_whole(step, least, most)


def _are_numbers(value: Any, limit: int) -> bool:
    return isinstance(value, list) and all(is_whole(each, 0, limit - 1) for each in value)

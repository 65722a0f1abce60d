"""Run studies: what a store lacks is computed, and what it holds is read.

A study that knows all its points at the start is one round. One that chooses points by what came of earlier
ones has several rounds, with the same workers and the same store.
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import NoReturn, Self

from feasibee.base.errors import FeasibeeError
from feasibee.base.record import Record
from feasibee.engine.given import rules_of
from feasibee.simulation.ensemble import CURVES_LIMIT
from feasibee.simulation.executors import WorkerPool, Workers, counted_interrupts, threads
from feasibee.simulation.flooding import flooded
from feasibee.simulation.plan import Study
from feasibee.simulation.schedule import Schedule, Totals
from feasibee.simulation.store import Store


class Enough(Exception):  # noqa: N818 (no error: a study that has an answer ends with it)
    """The time is over, or Ctrl-C was pressed, and the study has an answer so far."""


@dataclass(frozen=True, kw_only=True)
class Progress(Totals):
    """Progress of a study. Its work is in robot-steps, to which time is about proportional."""

    is_bounded: bool = True
    """Whether ``most`` is the most work of the whole study: a search may go on without end."""
    phase: str = ""
    """What the study does at the moment, if it has phases."""
    so_far: str = ""
    """The answer so far, if any."""
    seconds: float
    stopping: bool = False
    """Whether it was interrupted, and waits for the chunks that are being computed."""

    @property
    def left(self) -> tuple[float, float | None] | None:
        """Seconds that are left at least and at most, at the mean speed so far; None before any speed."""
        if not self.work_new or self.seconds <= 0:
            return None
        pace = self.seconds / self.work_new
        most = pace * (self.most - self.work_done) if self.is_bounded else None
        return pace * (self.work - self.work_done), most


@dataclass(frozen=True)
class Execution:
    """Where a study's runs are computed and kept, and how its progress is reported. Changes no result.

    Parameters
    ----------
    folder : path, optional
        Folder of the runs; made if need be. By default they stay in memory.
    pool : WorkerPool, optional
        Workers; by default one thread per processor.
    progress : callable, optional
        Called with a `Progress` after each chunk of runs, and each second.
    budget : float, optional
        Seconds after which a study that can ends with its answer so far, once it has one.
    answers : bool
        Whether Ctrl-C ends such a study in the same way.
    """

    folder: str | Path | None = None
    pool: WorkerPool = field(default_factory=threads)
    progress: Callable[[Progress], None] | None = None
    budget: float | None = None
    answers: bool = False


class Rounds:
    """The rounds of a study, with one store and the same workers.

    Whatever ends them, the same rounds in the same folder go on: at most the chunks that were being computed
    are computed again. Ctrl-C ends a round when these are done; a second Ctrl-C ends it at once. Damaged
    files count as missing.

    Parameters
    ----------
    execution : Execution, optional
        Where to compute and keep the runs; by default on threads, and in memory.
    most : int, optional
        Largest number of runs in all rounds, for the progress only; 0 if one round is all, None if unknown.
        A study with phases sets ``phases`` instead.

    Raises
    ------
    FeasibeeError
        If the folder can't be written to, or has a file of another version.

    Examples
    --------
    >>> from feasibee import Scenario
    >>> from feasibee.simulation.plan import DesignPoint, Study
    >>> from feasibee.simulation.sweep import Rounds
    >>> points = [DesignPoint({"tasks.count": m}, Scenario(tasks={"count": m})) for m in (2, 200)]
    >>> with Rounds() as rounds:
    ...     [record.decision.tolist() for record in rounds.run(Study(points, runs=3, seed=1))]
    [[1, 1, 0], [0, 0, 0]]
    """

    so_far: str | None = None
    """The answer so far, in words, perhaps none; unless it is None, a round may raise ``Enough``."""
    stopped = ""
    """Why rounds raise ``Enough``: ``"out of time"`` or ``"interrupted"``."""
    place = ""
    """How far the phase is, such as ``"14 of 23"``; by default by the points of the round."""
    stops = 0
    """Number of rounds that raised it."""

    def __init__(self, execution: Execution | None = None, most: int | None = 0) -> None:
        self.execution = execution or Execution()
        self._most = most
        self._past = Totals()
        self._counted: Counter[tuple[str, int]] = Counter()
        self.phases: dict[str, int] = {}
        self.phase = ""
        self._started = time.monotonic()
        self._workers = Workers(self.execution.pool)
        self._interrupts: list[int] = []
        self._exits = ExitStack()
        self.store = Store(self.execution.folder, write=True)

    @property
    def phase(self) -> str:
        """What the study does at the moment, in words; for the progress only."""
        return self._phase

    @phase.setter
    def phase(self, name: str) -> None:
        self._phase, self._begun, self.place = name, self._past.work, ""

    def __enter__(self) -> Self:
        if self.execution.answers:  # between rounds; in a round, its workers count
            self._interrupts = self._exits.enter_context(counted_interrupts())
        return self

    def __exit__(self, *error: object) -> None:
        with self._exits:
            self._workers.close()

    def run(self, study: Study) -> Iterator[Record]:
        """Run a round; then read each point's runs, in the order of the points, a point at a time.

        Raises
        ------
        FeasibeeError
            If the curves of a point don't fit, or a worker keeps dying.
        KeyboardInterrupt
            At Ctrl-C; it says how many runs are kept.
        """
        for point in study.points:
            steps, what = point.scenario.run.steps, "truths" if point.scenario.dynamic else "curves"
            kept = study.curves or point.scenario.dynamic
            if kept and 4 * study.runs * (steps + 1) > CURVES_LIMIT:
                raise FeasibeeError(
                    f"{what} of {study.runs} runs x {steps} steps: must fit {CURVES_LIMIT // 2**30} GiB; use "
                    "fewer runs or fewer steps"
                )
        once = {(point.scenario.hash, point.first_run): point for point in study.points}
        schedule = self._complete(replace(study, points=list(once.values())), (0, 1))
        keys = dict(zip(once, schedule.keys, strict=True))
        for point in study.points:
            key = keys[point.scenario.hash, point.first_run]
            yield self.store.record(key, point.first_run, study.runs, study.curves)

    def complete(self, study: Study, shard: tuple[int, int] = (0, 1)) -> Progress:
        """Compute what the store lacks of a study, or of a part of it; raise as `run`."""
        self._complete(study, shard)
        return self._progress(Totals())

    def _complete(self, study: Study, shard: tuple[int, int]) -> Schedule:
        points = self.store.add(study.points, study.seed, study.until)
        if self.store.damaged:
            print(f"feasibee: {self.store.harm}", file=sys.stderr, flush=True)
            self.store.damaged.clear()
        keys = [(key, point.first_run) for key, point in zip(points, study.points, strict=True)]
        before = [self._counted[key] for key in keys]
        schedule = Schedule(study, self.store, points, shard, before)
        schedule.begin()
        if schedule.queue:
            self.check()
        if self.execution.pool.is_local:  # compute here, once, what workers on this machine need
            for place in {piece.point: None for piece in schedule.queue}:
                rules_of(flooded(study.points[place].scenario).strategy)
        self._report(schedule, False)
        interrupted = self._workers.work_off(schedule, partial(self._report, schedule))
        if interrupted:  # also in the last chunk: other rounds may follow
            kept = f"{self._progress(schedule.totals).runs_done} runs kept; the same command goes on"
            self._stop("interrupted", "" if self.execution.folder is None else kept)
        self._past = self._past.plus(schedule.totals)
        for place, key in enumerate(keys):
            self._counted[key] = max(self._counted[key], schedule.wanted[place])
        return schedule

    def check(self) -> None:
        """Raise ``Enough`` if the study ends early; long work outside of rounds calls it often."""
        budget = self.execution.budget
        late = budget is not None and time.monotonic() - self._started >= budget
        if self.stopped or self._interrupts:
            self._stop(self.stopped or "interrupted")
        if late and self.so_far is not None:
            self._stop("out of time")

    def _stop(self, why: str, kept: str = "") -> NoReturn:
        if self.so_far is None or (why == "interrupted" and not self.execution.answers):
            raise KeyboardInterrupt(kept)
        self.stopped, self.stops = why, self.stops + 1
        raise Enough

    def tell(self, answer: str) -> None:
        """Set the answer so far, and report it, since the next round may begin late."""
        self.so_far = answer
        if self.execution.progress is not None:
            self.execution.progress(self._progress(Totals()))

    def _report(self, schedule: Schedule, stopping: bool) -> None:
        if self.execution.progress is not None:
            self.execution.progress(self._progress(schedule.totals, stopping))
        if schedule.queue and not stopping:
            self.check()

    def _progress(self, now: Totals, stopping: bool = False) -> Progress:
        done = self._past.plus(now)
        later = max(0, (self._most or 0) - done.runs)  # runs, taken to be as long as those so far
        most = done.most + later * done.work // max(1, done.runs)
        names, place = list(self.phases), self.place
        if now.points > 1 and not place:
            place = f"{now.points_done} of {now.points}"
        if self.phase in names:
            most = max(most, self._begun + self.phases[self.phase])
            most += sum(self.phases[name] for name in names[names.index(self.phase) + 1 :])
        return Progress(
            **(vars(done) | {"most": most}),
            is_bounded=self._most is not None or self.phase in names,
            phase=", ".join(filter(None, (self.phase, place))) if self.phase else "",
            so_far=self.so_far or "",
            seconds=time.monotonic() - self._started,
            stopping=stopping,
        )


def complete(
    study: Study,
    folder: str | Path,
    pool: WorkerPool,
    shard: tuple[int, int] = (0, 1),
    progress: Callable[[Progress], None] | None = None,
) -> Progress:
    """Run what a folder lacks of a study, by one round of `Rounds`.

    Parameters
    ----------
    study : Study
        What to run.
    folder, pool, progress
        As in `Execution`.
    shard : pair of int
        Part number, from 0, and number of parts: run that part of each point's runs only.

    Raises
    ------
    FeasibeeError
        As `Rounds` and its method ``run``, or if a study with a stopping rule is to be run in parts.
    KeyboardInterrupt
        At Ctrl-C; it says how many runs of the study are kept.
    """
    if study.until is not None and shard[1] > 1:
        raise FeasibeeError(
            "until: needs all runs of a point in one place; leave out either until or the shard"
        )
    with Rounds(Execution(folder, pool, progress)) as rounds:
        return rounds.complete(study, shard)

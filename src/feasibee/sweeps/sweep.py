"""Run what a study's journal doesn't hold yet, on threads, processes or a Dask cluster."""

from __future__ import annotations

import math
import sys
import time
from collections import Counter, deque
from collections.abc import Callable, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    as_completed,
    wait,
)
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from feasibee.errors import FeasibeeError
from feasibee.files import make_folder
from feasibee.model.record import Record
from feasibee.results.statistics import confidence_sequence
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.ensemble import CURVES_LIMIT, simulate_record
from feasibee.sweeps.executors import Crew
from feasibee.sweeps.interrupts import Interrupts
from feasibee.sweeps.journal import Journal
from feasibee.sweeps.pace import Pace
from feasibee.sweeps.plan import Study, Until
from feasibee.sweeps.rescue import rescue

CHUNK_WORK = 40_000_000
"""Robot-steps of a chunk at most: about a second on a machine of 2020."""
ROUNDS = 8
"""A point's runs are done in at least so many rounds over all points: a half-done sweep is balanced."""
GROWTH = 1.5
"""When a study runs until it is sure, each look at a point comes after so many times the runs of the last."""
PULSE = 1.0
"""Progress is told at least so often, in seconds, however long a chunk takes."""
TRIES = 3
"""How often a chunk is tried whose worker dies; the last time alone, since others died with it."""


class Piece(NamedTuple):
    """Some runs of one point."""

    point: int
    first_run: int
    runs: int


@dataclass(frozen=True)
class Progress:
    """How far a sweep is."""

    points: int
    points_done: int
    runs: int
    """Wanted, as far as known: a study that runs until it is sure may want more."""
    runs_done: int
    runs_new: int
    """Of these, computed by this sweep."""
    seconds: float
    stopping: bool = False
    """Whether it has been interrupted, and waits for the chunks that are being computed."""


def sweep(
    study: Study,
    folder: str | Path,
    crew: Crew,
    shard: tuple[int, int] = (0, 1),
    progress: Callable[[Progress], None] | None = None,
) -> Progress:
    """Run what the journal in a folder doesn't hold yet.

    Whatever ends it, the same call goes on: at most the chunks in flight are computed again. Ctrl-C ends it
    when these are done, a second one at once. What is damaged in the journal is computed again.

    Parameters
    ----------
    study : Study
        What to run.
    folder : path
        Where the journal is; made if need be.
    crew : Crew
        Who does the work; it changes no result.
    shard : pair of int
        Part number, from 0, and number of parts: do that part of each point's runs only.
    progress : callable, optional
        Called after each chunk, and each second.

    Raises
    ------
    FeasibeeError
        If the folder can't be written to, another sweep writes to it, or a worker keeps dying.
    KeyboardInterrupt
        At Ctrl-C; it says how many runs of the study are in the journal.
    """
    if study.until is not None and shard[1] > 1:
        raise FeasibeeError("until: needs all runs of a point at one place; leave it out, or don't shard")
    with Journal(make_folder(folder), write=True, rescue=rescue) as journal:
        if journal.rescued:
            print(f"feasibee: {journal.rescued}", file=sys.stderr, flush=True)
        agenda = _Agenda(study, journal, journal.add(study.points, study.seed, study.until), shard)
        agenda.begin()
        if progress is not None:
            progress(agenda.progress())
        _work_off(agenda, crew, progress)
        return agenda.progress()


@dataclass
class _Agenda:
    """What is left to do, and what the journal holds. Points are known by their places in the study."""

    study: Study
    journal: Journal
    numbers: Sequence[int]
    shard: tuple[int, int]
    queue: deque[Piece] = field(default_factory=deque)
    wanted: dict[int, int] = field(default_factory=dict)
    there: dict[int, int] = field(default_factory=dict)
    pending: dict[int, int] = field(default_factory=dict)
    """Runs wanted so far, runs in the journal, and pieces that aren't, of each point."""
    new: int = 0
    started: float = field(default_factory=time.monotonic)

    def begin(self) -> None:
        """Queue what is missing of all points, round-robin over them."""
        plans = [self.plan(place, self.study.runs) for place in range(len(self.study.points))]
        for turn in range(max(map(len, plans), default=0)):
            self.queue.extend(pieces[turn] for pieces in plans if turn < len(pieces))
        for place in range(len(plans)):
            self.extend(place)

    def plan(self, place: int, runs: int) -> list[Piece]:
        """Return what is missing of the first runs of a point, in pieces."""
        first, last = (runs * part // self.shard[1] for part in (self.shard[0], self.shard[0] + 1))
        size = _piece_size(self.study.points[place].scenario, last - first, self.study.curves)
        pieces = [
            Piece(place, start, min(size, min(high, last) - start))
            for low, high in self.journal.missing(self.numbers[place], runs, self.study.curves)
            for start in range(max(low, first), min(high, last), size)
        ]
        self.wanted[place] = last - first
        self.there[place] = last - first - sum(piece.runs for piece in pieces)
        self.pending[place] = len(pieces)
        return pieces

    def extend(self, place: int) -> None:
        """Queue more runs of a point, if the study runs until it is sure and isn't."""
        rule = self.study.until
        while rule is not None and self.pending[place] == 0 and self.wanted[place] < rule.most:
            runs = self.wanted[place]
            if is_sure(rule, self.journal.right(self.numbers[place], runs), runs):
                return
            self.queue.extend(self.plan(place, min(rule.most, math.ceil(GROWTH * runs))))

    def chunk(self, work: float) -> list[Piece]:
        """Take pieces from the queue, so much work in robot-steps; the last may be split."""
        pieces: list[Piece] = []
        while self.queue and work > 0:
            piece = self.queue.popleft()
            each = _work(self.study.points[piece.point].scenario)
            runs = min(piece.runs, max(1, int(work / each)))
            if runs < piece.runs:
                self.queue.appendleft(Piece(piece.point, piece.first_run + runs, piece.runs - runs))
                self.pending[piece.point] += 1
            pieces.append(piece._replace(runs=runs))
            work -= runs * each
        return pieces

    def work(self, pieces: Sequence[Piece]) -> int:
        """Return how many robot-steps some pieces have."""
        return sum(piece.runs * _work(self.study.points[piece.point].scenario) for piece in pieces)

    def enter(self, pieces: Sequence[Piece], records: Sequence[Record]) -> None:
        """Write a chunk down, and look whether its points need more runs."""
        numbers = (self.numbers[piece.point] for piece in pieces)
        self.journal.write(list(zip(numbers, records, strict=True)))
        for piece in pieces:
            self.new += piece.runs
            self.there[piece.point] += piece.runs
            self.pending[piece.point] -= 1
        for place in {piece.point for piece in pieces}:
            self.extend(place)

    @property
    def is_done(self) -> bool:
        """Whether all runs that are wanted are there."""
        return not any(self.pending.values())

    def progress(self, stopping: bool = False) -> Progress:
        """Say how far it is."""
        return Progress(
            len(self.pending),
            sum(pieces == 0 for pieces in self.pending.values()),
            sum(self.wanted.values()),
            sum(self.there.values()),
            self.new,
            time.monotonic() - self.started,
            stopping,
        )


def is_sure(rule: Until, right: int, runs: int) -> bool:
    """Tell whether a rate of right decisions is known as well as a study wants."""
    _, low, high = confidence_sequence(right, runs)
    if rule.width is not None:
        return high - low <= rule.width
    return rule.decided is not None and not low <= rule.decided <= high


def _work(scenario: Scenario) -> int:
    return scenario.robots.count * scenario.run.steps


def _piece_size(scenario: Scenario, runs: int, curves: bool) -> int:
    """Return how many runs to do at a time: at most a chunk, an eighth of all, and what fits in memory."""
    room = CURVES_LIMIT // 64 // (8 * (scenario.run.steps + 1)) if curves else runs
    return max(1, min(CHUNK_WORK // _work(scenario), -(-runs // ROUNDS), room))


def play(scenarios: Sequence[Scenario], pieces: Sequence[Piece], seed: int, curves: bool) -> list[Record]:
    """Play a chunk, wherever this runs: ``scenarios`` has that of each piece, with its strategy's text."""
    return [_play(scenario, piece, seed, curves) for scenario, piece in zip(scenarios, pieces, strict=True)]


def _play(scenario: Scenario, piece: Piece, seed: int, curves: bool) -> Record:
    try:
        return simulate_record(scenario, Runs(piece.runs, seed, piece.first_run), curves=curves, threads=1)
    except MemoryError:
        raise FeasibeeError(
            f"robots.count = {scenario.robots.count}: a worker has no room for such a swarm; take fewer "
            "workers or smaller swarms, and run the same command again: nothing that was kept is lost"
        ) from None


def _work_off(agenda: _Agenda, crew: Crew, progress: Callable[[Progress], None] | None) -> None:
    """Keep the workers busy until nothing is left; few chunks wait, so that memory stays flat."""
    executor = crew.make()
    waiting: dict[Future[list[Record]], list[Piece]] = {}
    again: deque[list[Piece]] = deque()
    deaths: Counter[tuple[Piece, ...]] = Counter()
    pace = Pace(crew.workers)
    tell = progress or (lambda told: None)
    with Interrupts(lambda: _kill(executor)) as interrupts:
        try:
            while (agenda.queue or again or waiting) and not interrupts.seen:
                while _may_go(agenda, again, list(waiting.values()), deaths, crew):
                    pieces = again.popleft() if again else agenda.chunk(min(pace.budget, CHUNK_WORK))
                    waiting[_submit(executor, agenda.study, pieces)] = pieces
                done = wait(waiting, PULSE, return_when=FIRST_COMPLETED).done
                if not done:
                    tell(agenda.progress())
                for future in done:
                    if isinstance(_failure(future, agenda.study, waiting[future]), BrokenExecutor):
                        executor.shutdown(wait=False)
                        executor = crew.make()
                        again.extendleft(reversed(waiting.values()))
                        deaths.update(map(tuple, waiting.values()))
                        waiting = {}
                        _check_deaths(agenda.study, again, deaths)
                        break
                    pieces = waiting.pop(future)
                    agenda.enter(pieces, future.result())
                    pace.count(agenda.work(pieces), time.monotonic())
                    tell(agenda.progress())
            if interrupts.seen:
                tell(agenda.progress(stopping=True))
        finally:
            _stop(agenda, executor, waiting)
    if interrupts.seen and not agenda.is_done:
        raise KeyboardInterrupt(f"{agenda.progress().runs_done} runs kept; the same command goes on")


def _kill(executor: Executor) -> bool:
    """End workers with what they are computing, if they are processes; tell whether they are."""
    kill = getattr(executor, "kill_workers", None)
    if kill is not None:
        kill()
    return kill is not None


def _stop(agenda: _Agenda, executor: Executor, waiting: dict[Future[list[Record]], list[Piece]]) -> None:
    """Cancel the chunks that wait, and keep those that are being computed or have been."""
    running = [future for future in waiting if not future.cancel()]
    for future in as_completed(running):
        with suppress(Exception):  # it has ended with an error, or the sweep has: that is the one to tell
            agenda.enter(waiting[future], future.result())
    executor.shutdown(wait=True)


def _submit(executor: Executor, study: Study, pieces: list[Piece]) -> Future[list[Record]]:
    scenarios = [study.points[piece.point].scenario for piece in pieces]
    try:
        return executor.submit(play, scenarios, pieces, study.seed, study.curves)
    except BrokenExecutor as error:  # a worker has died since the last look
        failed: Future[list[Record]] = Future()
        failed.set_exception(error)
        return failed


def _failure(future: Future[list[Record]], study: Study, pieces: list[Piece]) -> BaseException | None:
    """Return why a chunk has no result, or raise what is wrong with a cluster."""
    try:
        error = future.exception()
    except CancelledError:
        raise FeasibeeError(
            "the cluster has gone; start it, and run the same command again: nothing that was kept is lost"
        ) from None
    if type(error).__name__ == "KilledWorker":  # Dask's, which has tried it on several workers by now
        raise _deadly(study, pieces) from None
    return error


def _deadly(study: Study, pieces: list[Piece]) -> FeasibeeError:
    return FeasibeeError(
        f"workers died again and again, at last with runs of {dict(study.points[pieces[0].point].values)}: "
        "they may have run out of memory; take fewer workers, or smaller swarms"
    )


def _may_go(
    agenda: _Agenda,
    again: Sequence[list[Piece]],
    waiting: Sequence[list[Piece]],
    deaths: Counter[tuple[Piece, ...]],
    crew: Crew,
) -> bool:
    """Tell whether to submit the next chunk; one that may have killed workers goes alone at its last try."""
    if not waiting:
        return bool(again or agenda.queue)
    at_last = [deaths[tuple(pieces)] >= TRIES - 1 for pieces in (*waiting, *list(again)[:1])]
    return bool(again or agenda.queue) and len(waiting) < 2 * crew.workers and not any(at_last)


def _check_deaths(study: Study, again: Sequence[list[Piece]], deaths: Counter[tuple[Piece, ...]]) -> None:
    """Give up a chunk that has killed a worker alone."""
    for pieces in again:
        if deaths[tuple(pieces)] >= TRIES:
            raise _deadly(study, pieces)

"""Which runs of a study are missing, and in which order they are computed."""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from feasibee.base.record import Record
from feasibee.results.measures import decided_right
from feasibee.results.statistics import confidence_sequence
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.ensemble import CURVES_LIMIT
from feasibee.simulation.plan import StoppingRule, Study
from feasibee.simulation.store import Store

CHUNK_WORK = 40_000_000
"""Robot-steps per chunk at most: about one second of a processor of 2020."""
CHUNK_SECONDS = 1.0
"""Intended duration of a chunk: how long an interruption waits, and how much work a kill costs."""
FIRST_WORK = 1_000_000
"""Robot-steps of the first chunks, before the workers' speed is known: about 25 ms."""
LEAST_SECONDS = 0.05
"""Intended duration down to which the last chunks shrink, so that all workers end together."""
ROUNDS = 8
"""Each point's runs are split into so many pieces, so that a half-done sweep is balanced."""
LEAST_PIECE = 4_000_000
"""Robot-steps down to which they are split: about 100 ms. To begin a piece takes 2 to 3 ms."""
GROWTH = 1.5
"""With a stopping rule, each look at a point comes after so many times the runs of the last look."""


class RunRange(NamedTuple):
    """Consecutive runs of one point, which is known by its place in the study."""

    point: int
    first_run: int
    runs: int


@dataclass(frozen=True)
class Totals:
    """Points, runs, and their work in robot-steps: wanted so far, done, and computed by this process."""

    points: int = 0
    points_done: int = 0
    runs: int = 0
    runs_done: int = 0
    runs_new: int = 0
    work: int = 0
    """The least work that there is."""
    work_done: int = 0
    work_new: int = 0
    most: int = 0
    """The most work that there may be: each stopping rule that isn't met yet asks for the most runs."""

    def plus(self, other: Totals) -> Totals:
        """Return the sums of both."""
        return Totals(*(own + vars(other)[name] for name, own in vars(self).items()))


@dataclass
class Schedule:
    """The runs of a study that its store lacks. Points are known by their places in the study."""

    study: Study
    store: Store
    keys: Sequence[str]
    """Keys of the points in the store."""
    shard: tuple[int, int] = (0, 1)
    before: Sequence[int] = ()
    """Runs of each point that an earlier round has counted."""
    queue: deque[RunRange] = field(default_factory=deque)
    left: int = 0
    """Robot-steps in the queue."""
    wanted: dict[int, int] = field(default_factory=dict)
    """Runs wanted so far of each point."""
    there: dict[int, int] = field(default_factory=dict)
    """Runs in the store, of those."""
    pending: dict[int, int] = field(default_factory=dict)
    """Pieces that aren't in the store yet."""
    met: set[int] = field(default_factory=set)
    """Points whose stopping rule is met."""
    new: Counter[int] = field(default_factory=Counter)
    """Runs of each point that were computed."""

    def begin(self) -> None:
        """Queue the missing runs of all points, taking turns between points."""
        plans = [self._plan(place, self.study.runs) for place in range(len(self.study.points))]
        for turn in range(max(map(len, plans), default=0)):
            self._queue([pieces[turn] for pieces in plans if turn < len(pieces)])
        for place in range(len(plans)):
            self._extend(place)

    def _queue(self, pieces: Sequence[RunRange]) -> None:
        self.queue.extend(pieces)
        self.left += self.work(pieces)

    def _plan(self, place: int, runs: int) -> list[RunRange]:
        """Return the missing runs among the first runs of a point, in pieces."""
        point, (part, parts) = self.study.points[place], self.shard
        first, last = (point.first_run + runs * end // parts for end in (part, part + 1))
        size = _piece_size(point.scenario, last - first, self.study.curves)
        pieces = [
            RunRange(place, start, min(size, high - start))
            for low, high in self.store.missing(self.keys[place], first, last, self.study.curves)
            for start in range(low, high, size)
        ]
        self.wanted[place] = last - first
        self.there[place] = last - first - sum(piece.runs for piece in pieces)
        self.pending[place] = len(pieces)
        return pieces

    def _extend(self, place: int) -> None:
        """Queue more runs of a point whose stopping rule isn't met yet."""
        rule, first = self.study.until, self.study.points[place].first_run
        while rule is not None and self.pending[place] == 0 and self.wanted[place] < rule.most:
            runs, results = self.wanted[place], self.store.results(self.keys[place])
            these = (first <= results.run) & (results.run < first + runs)
            right = decided_right(results, self.study.points[place].scenario)[these]
            if is_sure(rule, int(right.sum()), runs):
                self.met.add(place)
                return
            self._queue(self._plan(place, min(rule.most, math.ceil(GROWTH * runs))))

    def chunk(self, work: float) -> list[RunRange]:
        """Remove pieces of ``work`` robot-steps from the queue and return them; the last one may be split."""
        pieces: list[RunRange] = []
        while self.queue and work > 0:
            piece = self.queue.popleft()
            each = run_work(self.study.points[piece.point].scenario)
            runs = min(piece.runs, max(1, int(work / each)))
            if runs < piece.runs:
                self.queue.appendleft(RunRange(piece.point, piece.first_run + runs, piece.runs - runs))
                self.pending[piece.point] += 1
            pieces.append(piece._replace(runs=runs))
            work -= runs * each
            self.left -= runs * each
        return pieces

    def work(self, pieces: Sequence[RunRange]) -> int:
        """Return the number of robot-steps of some pieces."""
        return sum(piece.runs * run_work(self.study.points[piece.point].scenario) for piece in pieces)

    def enter(self, pieces: Sequence[RunRange], records: Sequence[Record]) -> None:
        """Write a chunk to the store; queue more runs of its points if the stopping rule wants them."""
        for piece, record in zip(pieces, records, strict=True):
            self.store.put(self.keys[piece.point], record)
            self.new[piece.point] += piece.runs
            self.there[piece.point] += piece.runs
            self.pending[piece.point] -= 1
        for place in {piece.point for piece in pieces}:
            self._extend(place)

    @property
    def totals(self) -> Totals:
        """What is wanted and done so far."""
        rule, points = self.study.until, self.study.points
        most = {p: rule.most for p in self.wanted if p not in self.met} if rule else {}
        before = self.before or [0] * len(points)
        wanted, there = (
            {p: max(0, runs - before[p]) for p, runs in each.items()} for each in (self.wanted, self.there)
        )
        counts: list[Mapping[int, int]] = [wanted, there, self.new]
        runs = (sum(each.values()) for each in counts)
        work = (
            sum(number * run_work(points[place].scenario) for place, number in each.items())
            for each in (*counts, {**wanted, **most})
        )
        done = sum(pieces == 0 for pieces in self.pending.values())
        return Totals(len(self.pending), done, *runs, *work)


def is_sure(rule: StoppingRule, right: int, runs: int) -> bool:
    """Whether the rate of right decisions is known as well as a stopping rule asks for."""
    _, low, high = confidence_sequence(right, runs)
    if rule.width is not None:
        return high - low <= rule.width
    return rule.decided is not None and not low <= rule.decided <= high


def run_work(scenario: Scenario) -> int:
    """Return the number of robot-steps of a run."""
    return scenario.robots.count * scenario.run.steps


def _piece_size(scenario: Scenario, runs: int, curves: bool) -> int:
    """Return the number of runs per piece: about an eighth of all, at most a chunk or what fits in memory."""
    by_step = 8 * curves + 10 * scenario.dynamic
    room = CURVES_LIMIT // 64 // (by_step * (scenario.run.steps + 1)) if by_step else runs
    balanced = max(-(-runs // ROUNDS), LEAST_PIECE // run_work(scenario))
    return max(1, min(CHUNK_WORK // run_work(scenario), balanced, room))


def chunk_work(budget: float, left: int, workers: int) -> float:
    """Return the robot-steps of the next chunk, when so many are left for all workers."""
    least = budget * LEAST_SECONDS / CHUNK_SECONDS
    return min(budget, CHUNK_WORK, max(least, left / (2 * workers)))


def next_budget(budget: float, work: int, seconds: float) -> float:
    """Return the robot-steps of a chunk of the intended duration, by those of one that took some seconds."""
    return max(1.0, min(CHUNK_SECONDS * work / max(seconds, 1e-9), 4 * budget))

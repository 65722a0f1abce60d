"""How much work a worker is given at a time: about a second's, on any machine."""

from __future__ import annotations

from collections import deque

CHUNK_SECONDS = 1.0
"""How long a chunk should take where that is less work: what an interruption waits for, and a kill costs."""
FIRST_WORK = 1_000_000
"""Robot-steps of the first chunks, when it isn't known yet how fast the workers are: about 25 ms."""


class Pace:
    """How much work makes a chunk of `CHUNK_SECONDS`, by what the workers have done lately."""

    def __init__(self, workers: int) -> None:
        self.workers = workers
        self.budget: float = FIRST_WORK
        self._last: float | None = None
        self._clock = 0.0
        self._done: deque[tuple[float, int]] = deque(maxlen=2 * workers + 1)

    def count(self, work: int, now: float) -> None:
        """Count a chunk that has been done."""
        gap = 0.0 if self._last is None else now - self._last
        self._last = now
        self._clock += min(gap, 4 * CHUNK_SECONDS)  # a machine that slept isn't slow
        self._done.append((self._clock, work))
        seconds = self.workers * (self._clock - self._done[0][0])
        if len(self._done) > self.workers and seconds > 0:  # each worker has done one since the first
            done = sum(work for _, work in self._done) - self._done[0][1]
            self.budget = max(1.0, min(CHUNK_SECONDS * done / seconds, 4 * self.budget))

"""How much work a worker is given at a time: about one second, on any machine."""

from __future__ import annotations

from collections import deque

CHUNK_WORK = 40_000_000
"""Robot-steps per chunk at most: about one second of a processor of 2020."""
CHUNK_SECONDS = 1.0
"""Intended duration of a chunk: how long an interruption waits, and how much work a kill costs."""
FIRST_WORK = 1_000_000
"""Robot-steps of the first chunks, before the workers' speed is known: about 25 ms."""
LEAST_WORK = 500_000
"""Robot-steps down to which the last chunks shrink, so that all workers end together: about 12 ms."""


class Pace:
    """Work per chunk, estimated from the workers' recent speed.

    Parameters
    ----------
    workers : int
        Number of chunks computed at a time.
    """

    def __init__(self, workers: int) -> None:
        self.workers = workers
        self.budget: float = FIRST_WORK
        self._last: float | None = None
        self._clock = 0.0
        self._done: deque[tuple[float, int]] = deque(maxlen=2 * workers + 1)

    def share(self, left: int) -> float:
        """Return the robot-steps of the next chunk, when so many are left for all workers."""
        return min(self.budget, CHUNK_WORK, max(LEAST_WORK, left / (2 * self.workers)))

    def count(self, work: int, now: float) -> None:
        """Count a finished chunk of so many robot-steps at a time in seconds."""
        gap = 0.0 if self._last is None else now - self._last
        self._last = now
        self._clock += min(gap, 4 * CHUNK_SECONDS)  # a machine that slept isn't slow
        self._done.append((self._clock, work))
        seconds = self.workers * (self._clock - self._done[0][0])
        if len(self._done) > self.workers and seconds > 0:  # each worker has done one since the first
            done = sum(work for _, work in self._done) - self._done[0][1]
            self.budget = max(1.0, min(CHUNK_SECONDS * done / seconds, 4 * self.budget))

    def rest(self) -> None:
        """Forget when the last chunk ended: until the next round the workers have nothing to do."""
        self._last = None

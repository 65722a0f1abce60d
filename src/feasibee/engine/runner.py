"""Runs over threads, in chunks; the outcome of a run depends on neither."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from concurrent.futures import FIRST_EXCEPTION, Future, ThreadPoolExecutor, wait

import numpy as np

from feasibee.base.record import Record
from feasibee.engine.params import Params
from feasibee.engine.players import player_of
from feasibee.engine.tables import Control, Lowered

CHUNK = 2_000_000  # robot-steps: about 20 ms, against 0.1 ms for the call
TOGETHER = 4096
"""Robots from which on the threads may simulate one swarm together."""
ROBOTS_A_THREAD = 1000
"""The fewest robots that each of those is given: with fewer, it would mostly wait for the others."""
TOGETHER_SPEED = 0.9
"""Speed of a thread of those, in units of its speed alone."""
POLL = 0.1  # seconds between two looks at the progress


def simulate(
    lowered: Lowered,
    record: Record,
    threads: int | None = None,
    chunk: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> None:
    """Simulate runs and fill in their record.

    Parameters
    ----------
    lowered : Lowered
        The scenario and the seed.
    record : Record
        Empty, with the length and first run wanted.
    threads : int, optional
        Number of chunks simulated at a time; by default one for each processor.
    chunk : int, optional
        Runs per chunk; by default about 30 ms of work.
    progress : callable, optional
        Called every 0.1 s with the share of the work done, 0 to 1.

    Raises
    ------
    RunError
        If the strategy raises an error.
    """
    threads = threads or processors()
    team = team_size(lowered.params, record.runs, threads)
    play = player_of(lowered, team)
    length = chunk or _chunk_length(lowered.params, record.runs, threads)
    parts = [record.part(k, min(k + length, record.runs)) for k in range(0, record.runs, length)]
    cancelled = np.zeros(1, np.bool_)
    controls = [Control(np.zeros(1, np.int64), cancelled) for _ in parts]
    with ThreadPoolExecutor(threads // team) as pool:
        each_part = zip(parts, controls, strict=True)
        futures = [pool.submit(play, *each) for each in each_part]
        try:
            _watch(futures, controls, parts, lowered.params, progress)
        except BaseException:
            cancelled[0] = True
            pool.shutdown(wait=True, cancel_futures=True)
            raise


def processors() -> int:
    """Return the number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def team_size(params: Params, runs: int, threads: int) -> int:
    """Return the number of threads that simulate each run.

    Runs side by side need no waiting. But the last of them may leave threads without work.
    """
    single = params.strategy.knowledge.enabled or params.changes or params.acting.acts
    if params.robots.count < TOGETHER or single:
        return 1
    most = max(1, min(threads, params.robots.count // ROBOTS_A_THREAD))

    def duration(team: int) -> float:
        speed = team if team == 1 else team * TOGETHER_SPEED
        return math.ceil(runs / (threads // team)) / speed

    return min(range(1, most + 1), key=duration)


def _watch(
    futures: list[Future[None]],
    controls: list[Control],
    parts: list[Record],
    params: Params,
    progress: Callable[[float], None] | None,
) -> None:
    """Wait for all chunks, report progress, and raise the first error of a chunk."""
    runs = sum(part.runs for part in parts)
    pending = set(futures)
    while pending:
        finished, pending = wait(pending, timeout=POLL, return_when=FIRST_EXCEPTION)
        for future in (each for each in futures if each in finished):  # raises the failure of the first run
            future.result()
        if progress is not None:
            # Runs that stop at their decision do fewer steps, so a finished chunk counts in full.
            shares = [
                part.runs if future.done() else int(control.steps_done[0]) / params.run.steps
                for part, future, control in zip(parts, futures, controls, strict=True)
            ]
            progress(min(1.0, sum(shares) / runs))


def _chunk_length(params: Params, runs: int, threads: int) -> int:
    by_work = CHUNK // (params.robots.count * params.run.steps)
    by_balance = math.ceil(runs / (4 * threads))
    return max(1, min(by_work, by_balance))

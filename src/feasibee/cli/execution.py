"""Run a study for a command: with its workers, its folder, and its progress.

The progress is a bar on a terminal, a line every ten seconds elsewhere, and JSON lines in a log. It shows
the answer so far, if any, the phase of the study, what is done in it, and the least and most time left.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

import click

from feasibee.base.errors import FeasibeeError
from feasibee.base.files import why_not
from feasibee.cli.interrupts import UNHARMED, leaving
from feasibee.cli.options import Workforce, stderr_console

if TYPE_CHECKING:
    from feasibee.simulation.sweep import Execution, Progress

PATIENCE = 10.0
"""Seconds between two lines of progress where there is no terminal."""


@contextmanager
def executing(
    what: str,
    folder: Path | None,
    workforce: Workforce,
    log: Path | None = None,
    *,
    budget: float | None = None,
    answers: bool = False,
) -> Iterator[Execution]:
    """Let a study run within: with its workers, its folder, and a display of its progress.

    If the study answers early, it does so when its budget is over, and at Ctrl-C on a terminal.

    Ctrl-C while chunks are computed waits for these; a second one, or one at another moment, ends the process
    at once. So nothing but runs may be written within.
    """
    from feasibee.simulation.sweep import Execution

    pool = workforce.pool()
    with (
        leaving(UNHARMED if folder is None else "the runs so far are kept; the same command goes on"),
        progress_display(what, log) as display,
    ):
        yield Execution(folder, pool, display, budget, answers and sys.stderr.isatty())


def leave_if_stopped(stopped: str) -> None:
    """End the process as at Ctrl-C if that is why a study ended early; its answer is printed by now."""
    if stopped == "interrupted":
        sys.exit(128 + signal.SIGINT)


@contextmanager
def progress_display(what: str, log: Path | None = None) -> Iterator[Callable[[Progress], None]]:
    """Show a bar on a terminal, a line every ten seconds elsewhere, and append to a log if one is named."""
    from rich.progress import BarColumn, TextColumn
    from rich.progress import Progress as Bar

    terminal = sys.stderr.isatty()
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[done]}"))
    last, said = time.monotonic(), ""
    if log is not None:
        _end_line(log)
    with Bar(*columns, console=stderr_console(), transient=True, disable=not terminal) as bar:
        task = bar.add_task(what, total=None, done="")

        def display(progress: Progress) -> None:
            nonlocal last, said
            words = f"{what}, {progress.phase}" if progress.phase else what
            words = f"{progress.so_far}\n{words}" if terminal and progress.so_far else words
            if progress.stopping:
                words = "stopping, Ctrl-C again ends at once"
            done = _done(progress)
            most = progress.most if progress.is_bounded else None
            bar.update(task, total=most, completed=progress.work_done, description=words, done=done)
            if log is not None:
                with _writing_log(log), log.open("a", encoding="utf-8") as file:
                    file.write(json.dumps({"time": time.time(), **vars(progress)}) + "\n")
            late = time.monotonic() - last >= PATIENCE
            if not terminal and progress.so_far != said and (late or not said):
                said = progress.so_far
                click.echo(f"feasibee: {said}", err=True)
            if not terminal and late:
                last = time.monotonic()
                click.echo(f"feasibee: {words}: {done}", err=True)

        yield display


def _end_line(log: Path) -> None:
    """End the last line of a log if a killed sweep has left it half-written."""
    with suppress(OSError):
        if log.is_file() and log.stat().st_size:
            with log.open("r+b") as file:
                file.seek(-1, os.SEEK_END)
                if file.read() != b"\n":
                    file.write(b"\n")


def check_log(log: Path) -> None:
    """Raise an error before the work if the log can't be written; don't wait for the reader of a pipe."""
    with _writing_log(log):
        os.close(os.open(log, os.O_WRONLY | os.O_APPEND | os.O_CREAT | getattr(os, "O_NONBLOCK", 0), 0o666))


@contextmanager
def _writing_log(log: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise FeasibeeError(
            f"--log {log}: can't be written: {why_not(error)}; choose a file that you may write to"
        ) from None


def _done(progress: Progress) -> str:
    """Return what is done of what, how fast, and the time that is left: never less than is sure."""
    more = "" if progress.is_bounded and progress.most == progress.work else " or more"
    done = f"{progress.runs_done:,} of {progress.runs:,}{more} runs"
    if progress.left is None:
        return done
    rate = progress.runs_new / progress.seconds
    return f"{done}, {rate:,.{int(rate < 10)}f} runs/s, {_span(*progress.left)} left"


def _span(least: float, most: float | None) -> str:
    """Return the seconds that are left in words: about as many, a range, or at least so many."""
    if most is None:
        return f"at least {_time(least)}"
    low, high = _time(least), _time(most)
    return f"about {low}" if low == high else f"{low} to {high}"


def _time(seconds: float) -> str:
    if seconds < 120:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.0f} h"

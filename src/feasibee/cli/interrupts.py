"""Ctrl-C at any moment ends a command with one line and exit status 130."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn

import click

STATUS = 130
UNHARMED = "no file was left half-written"
_CLEAR = b"\r\x1b[2K\x1b[?25h"  # what a progress bar leaves: its line, and a hidden cursor

_is_program = threading.Event()
"""Set if the command line is the whole process, not called from another program: only then handle Ctrl-C."""


def begin() -> None:
    """Install the handler of Ctrl-C, unless the parent process ignores it, as for a background job."""
    if callable(signal.getsignal(signal.SIGINT)):
        _is_program.set()
        signal.signal(signal.SIGINT, _Leave(UNHARMED))
        sys.unraisablehook = _leave_or_print


def end() -> None:
    """Ignore Ctrl-C from now on: all is done, and Python's own exit would print a traceback."""
    if _is_program.is_set():
        signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def raising() -> Iterator[None]:
    """Let Ctrl-C raise KeyboardInterrupt, so that half-written files are removed; then ignore it."""
    if _is_program.is_set():
        signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        end()


@contextmanager
def leaving(what: str) -> Iterator[None]:
    """Let Ctrl-C end the process at once, where nothing can be left half-written; then raise as before.

    Parameters
    ----------
    what : str
        What to print of the state that is left.
    """
    if _is_program.is_set():
        signal.signal(signal.SIGINT, _Leave(what))
    try:
        yield
    finally:
        if _is_program.is_set():
            signal.signal(signal.SIGINT, signal.default_int_handler)


def interrupted(what: str) -> NoReturn:
    """Print that a command was interrupted and what it kept; exit with status 130."""
    end()
    click.echo(f"feasibee: interrupted; {what or UNHARMED}", err=True)
    sys.exit(STATUS)


class _Leave:
    """A signal handler that prints one line and ends the process at once."""

    def __init__(self, what: str) -> None:
        self.what = what

    def __call__(self, *signalled: object) -> NoReturn:
        line = f"feasibee: interrupted; {self.what}\n".encode()
        os.write(2, _CLEAR + line if os.isatty(2) else line)
        os._exit(STATUS)


def _leave_or_print(what: sys.UnraisableHookArgs) -> None:
    """End at once if Ctrl-C came where Python can't raise an error, such as in a destructor."""
    if issubclass(what.exc_type, KeyboardInterrupt):
        _Leave(UNHARMED)()
    sys.__unraisablehook__(what)

"""Ctrl-C ends a command in a line and with status 130, at whatever moment it comes."""

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
USUAL = "no file was left half-written"
_CLEAR = b"\r\x1b[2K\x1b[?25h"  # what a progress bar leaves: its line, and a hidden cursor

_is_program = threading.Event()
"""Set where the command line is the process, and no guest in another: then Ctrl-C is ours to handle."""


def begin() -> None:
    """Install the handler of Ctrl-C, unless the parent process ignores it, as for a background job."""
    if callable(signal.getsignal(signal.SIGINT)):
        _is_program.set()
        signal.signal(signal.SIGINT, _Leave(USUAL))
        sys.unraisablehook = _leave_or_tell


def end() -> None:
    """Ignore Ctrl-C from now on: all is done, and Python's own end would answer with a traceback."""
    if _is_program.is_set():
        signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def raising() -> Iterator[None]:
    """Let Ctrl-C raise KeyboardInterrupt, so that what is half-written is cleared away; then `end`."""
    if _is_program.is_set():
        signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        end()


@contextmanager
def leaving(what: str) -> Iterator[None]:
    """Let Ctrl-C end the process at once, where nothing can be left half-written; then `end`."""
    if _is_program.is_set():
        signal.signal(signal.SIGINT, _Leave(what))
    try:
        yield
    finally:
        end()


def interrupted(what: str) -> NoReturn:
    """Print that a command was interrupted and what it kept, and exit with status 130."""
    end()
    click.echo(f"feasibee: interrupted; {what or USUAL}", err=True)
    sys.exit(STATUS)


class _Leave:
    """A handler that ends the process at once, in a line."""

    def __init__(self, what: str) -> None:
        self.what = what

    def __call__(self, *signalled: object) -> NoReturn:
        line = f"feasibee: interrupted; {self.what}\n".encode()
        os.write(2, _CLEAR + line if os.isatty(2) else line)
        os._exit(STATUS)


def _leave_or_tell(what: sys.UnraisableHookArgs) -> None:
    """End at once if Ctrl-C came where Python can't raise an error, as while it frees an object."""
    if issubclass(what.exc_type, KeyboardInterrupt):
        _Leave(USUAL)()
    sys.__unraisablehook__(what)

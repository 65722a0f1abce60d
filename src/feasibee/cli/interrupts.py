"""Ctrl-C, SIGTERM and SIGHUP at any moment end a command with one line, and leave nothing behind."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from types import TracebackType
from typing import Any, NoReturn

UNHARMED = "no file was left half-written"
_CLEAR = b"\r\x1b[2K\x1b[?25h"  # what a progress bar leaves: its line, and a hidden cursor
_WORDS = {"SIGINT": "interrupted", "SIGTERM": "ended by SIGTERM", "SIGHUP": "ended by SIGHUP"}
_SIGNALS = [getattr(signal, name) for name in _WORDS if hasattr(signal, name)]

_handled: list[signal.Signals] = []
"""Signals that are handled: none unless the command line is the whole process."""
_seen: list[signal.Signals] = []
"""The first signal that came and was raised as an error, if any."""


def begin() -> None:
    """Handle the signals, except those that the parent process ignores, as for a background job."""
    _handled[:] = [each for each in _SIGNALS if signal.getsignal(each) not in (signal.SIG_IGN, None)]
    _handle(partial(_leave, UNHARMED))
    sys.unraisablehook = _leave_or_print
    sys.excepthook = _leave_or_show


def end() -> None:
    """Ignore the signals from now on: all is done, and Python's own exit would print a traceback."""
    _handle(signal.SIG_IGN)


@contextmanager
def raising() -> Iterator[None]:
    """Let signals raise errors, so that what is half-written is removed; then print one line and exit."""
    try:
        try:
            _handle(_raise)
            yield
        finally:
            end()
    except BaseException as error:
        # A module whose import was interrupted may raise any other error instead.
        if _seen or isinstance(error, KeyboardInterrupt):
            number = _seen[0] if _seen else signal.SIGINT
            print(_line(number, str(error) if isinstance(error, KeyboardInterrupt) else ""), file=sys.stderr)
            sys.exit(128 + number)
        raise


@contextmanager
def leaving(what: str) -> Iterator[None]:
    """Let signals end the process at once, where nothing can be left half-written; then raise as before.

    ``what`` is printed of the state that is left.
    """
    _handle(partial(_leave, what))
    if _seen:  # a module whose import was interrupted may have gone on without it
        _leave(what, _seen[0])
    try:
        yield
    finally:
        _handle(_raise)


def _handle(handler: Callable[[int, Any], Any] | signal.Handlers) -> None:
    for each in _handled:
        signal.signal(each, handler)


def _raise(number: int, frame: Any) -> NoReturn:
    _seen.append(signal.Signals(number))
    raise KeyboardInterrupt if number == signal.SIGINT else SystemExit(128 + number)


def _line(number: int, what: str) -> str:
    """Return by which signal a command ended, and what it kept."""
    return f"feasibee: {_WORDS[signal.Signals(number).name]}; {what or UNHARMED}"


def _leave(what: str, number: int, frame: Any = None) -> NoReturn:
    """Print one line, and end the process at once."""
    line = f"{_line(number, what)}\n".encode()
    try:
        os.write(2, _CLEAR + line if os.isatty(2) else line)
    finally:  # standard error may be closed
        os._exit(128 + number)


def _leave_or_print(what: sys.UnraisableHookArgs) -> None:
    """End at once if a signal came where Python can't raise an error, such as in a destructor."""
    if _seen and issubclass(what.exc_type, KeyboardInterrupt | SystemExit):
        _leave(UNHARMED, _seen[0])
    sys.__unraisablehook__(what)


def _leave_or_show(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    """End at once if a signal came where a module written in C would print the error and go on."""
    if _seen and issubclass(kind, KeyboardInterrupt | SystemExit):
        _leave(UNHARMED, _seen[0])
    sys.__excepthook__(kind, error, trace)

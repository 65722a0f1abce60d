"""Standard output and error: closed ones, and characters that a terminal lacks or that nobody sees."""

from __future__ import annotations

import os
import sys
from io import TextIOWrapper
from typing import Any
from unicodedata import category

UNSEEN = ("Cc", "Cf", "Zl", "Zp")
"""Categories of characters that are printed as escapes, beyond ASCII: a right-to-left override would show a
file's name as another one."""


def prepare() -> None:
    """Let both streams be open, and take any text."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            _replace(number)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper) and "write" not in vars(stream):
            stream.reconfigure(errors="backslashreplace")
            vars(stream)["write"] = lambda text, write=stream.write: write(visible(text))


def visible(text: str) -> str:
    """Return a text with characters that nobody sees as escapes, as TOML and JSON write them."""
    if text.isascii():
        return text
    return "".join(each if each.isascii() or category(each) not in UNSEEN else _code(each) for each in text)


def _code(character: str) -> str:
    number = ord(character)
    return f"\\u{number:04x}" if number < 2**16 else f"\\U{number:08x}"


def _replace(number: int) -> None:
    """Open a closed stream; else a file that is opened later would take its number.

    Standard output becomes a pipe without a reader, as if the program that reads it had ended.
    """
    if number != 1:
        os.open(os.devnull, os.O_RDWR)  # takes the lowest free number, which is this one
    else:
        _, end = os.pipe()  # so does its reader, which is replaced
        os.dup2(end, number)
        os.close(end)
    stream: Any = open(number, "r" if number == 0 else "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    setattr(sys, ("stdin", "stdout", "stderr")[number], stream)

"""The controller in C99: one header for robots, made of the parts in `c/`."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from importlib.metadata import version
from pathlib import Path

from feasibee.errors import FeasibeeError, quoted
from feasibee.strategies import STRATEGIES

__all__ = ["header", "strategies_in_c"]

MOST_SENDERS = 65_535
"""Largest capacity of an inbox in C."""
_FOLDER = Path(__file__).parent / "c"
_LOCAL_INCLUDE = re.compile(r'#include "(\w+\.h)"\n+')


def strategies_in_c() -> list[str]:
    """Return the names of the strategies that exist in C, in the order of `STRATEGIES`."""
    return [name for name in STRATEGIES if (_FOLDER / _part(name)).exists()]


def header(strategy: str | Sequence[str] | None = None, inbox: int | None = None) -> str:
    """Return the text of ``feasibee.h``.

    Parameters
    ----------
    strategy : str or sequence of str, optional
        The strategies to include; by default all of `strategies_in_c`.
    inbox : int, optional
        Number of senders whose latest message a robot keeps; by default 64. A program may define
        ``FEASIBEE_INBOX`` before it includes the file.

    Raises
    ------
    FeasibeeError
        If a strategy does not exist in C, or the inbox is not from 1 to 65535.

    Examples
    --------
    >>> from feasibee.robot.firmware import header
    >>> "feasibee_dmmd" in header("dmmd", inbox=32)
    True
    """
    everything = strategies_in_c()
    names = everything if strategy is None else [strategy] if isinstance(strategy, str) else list(strategy)
    for name in names:
        if name not in everything:
            remedy = f"use {', '.join(everything)}"
            raise FeasibeeError(f"strategy = {quoted(name)}: must be a strategy that exists in C; {remedy}")
    if inbox is not None and not 1 <= inbox <= MOST_SENDERS:
        raise FeasibeeError(f"inbox = {inbox}: must be from 1 to {MOST_SENDERS} senders; use 32")
    chosen = [name for name in everything if name in names]
    return "".join([_beginning(chosen, inbox), *_parts(map(_part, chosen)), "\n#endif\n"])


def _part(name: str) -> str:
    """Return the file that holds a strategy."""
    return f"{name.replace('-', '_')}.h"


def _beginning(names: Sequence[str], inbox: int | None) -> str:
    """Return the comment at the top, and the macros that the chosen strategies need."""
    macros = {} if inbox is None else {"FEASIBEE_INBOX": inbox}
    if not any(STRATEGIES[name].value_bits for name in names):
        macros["FEASIBEE_VALUES"] = 0
    lines = [
        f"/* feasibee {version('feasibee')}: the controller of one robot of a swarm, in C99. Apache-2.0.",
        f" * Strategies: {', '.join(names)}. Written by `feasibee header`. */",
        "",
        "#ifndef FEASIBEE_H",
        "#define FEASIBEE_H",
        "",
    ]
    for macro, value in macros.items():
        lines += [f"#ifndef {macro}", f"#define {macro} {value}", "#endif"]
    return "\n".join(lines) + "\n"


def _parts(strategies: Iterable[str]) -> Iterable[str]:
    """Yield each part once, after the parts that it includes."""
    done: set[str] = set()

    def with_included(name: str) -> Iterable[str]:
        if name in done:
            return
        done.add(name)
        text = (_FOLDER / name).read_text(encoding="utf-8")
        for included in _LOCAL_INCLUDE.findall(text):
            yield from with_included(included)
        yield "\n" + _LOCAL_INCLUDE.sub("", text)

    for name in ("controller.h", *strategies, "phases.h", "wire.h"):
        yield from with_included(name)

"""What knowledge may depend on, and the memory that it takes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final

from feasibee.base.errors import FeasibeeError
from feasibee.strategies.contract import Setting, Strategy

KNOWLEDGE_LIMIT: Final = 4 * 2**30
"""Largest memory of the knowledge and messages of all robots of a swarm, in bytes."""
WORDS_LIMIT: Final = 2**24
"""Words of one robot's knowledge, and of one message."""


PAPER: Final = {
    "knows_count": True,
    "colluding": False,
    "walled": False,
    "sight": 2.0,
    "radio": 2.0,
    "speed": 1.0,
    "exploration": 10.0,
    "dissemination": 10.0,
}
"""Numbers of the paper's world, with robots that know their number."""


def setting_from(
    counts: tuple[int, int],
    classes: tuple[int, int],
    liars: bool,
    id_bits: int | None,
    parameters: Iterable[float],
    *,
    misnames: bool = False,
    size: tuple[float, float] = (20.0, 20.0),
    **others: Any,
) -> Setting:
    """Return the numbers of a scenario that a strategy's knowledge may depend on.

    ``counts`` and ``classes`` are those of robots and of tasks. With ``liars`` a Byzantine robot may invent
    names, and with ``misnames`` robots give wrong ones. By default, ids are as wide as they must be, and
    fields of `Setting` those of the paper.
    """
    robots, tasks = counts
    return Setting(
        robots=robots,
        tasks=tasks,
        robot_ids=robots + (tasks if liars else 0),
        task_ids=tasks + (robots + 1 if liars else 0) + (tasks if misnames else 0),
        robot_classes=max(1, classes[0]),
        task_classes=max(1, classes[1]),
        id_bits=id_bits or max(1, (robots - 1).bit_length()),
        parameters=tuple(float(each) for each in parameters),
        width=size[0],
        height=size[1],
        **{"count": robots, **PAPER, **others},
    )


def knowledge_words(strategy: Strategy, setting: Setting) -> tuple[int, int]:
    """Return the number of words that a robot's knowledge takes, and that of its message.

    Raise a FeasibeeError if all robots' words together don't fit the memory that they may take.
    """
    known, told = strategy.row_lengths(setting)
    problem = excess(setting, known, told)
    if problem:
        raise FeasibeeError(f"{strategy.name}: {problem}; take fewer robots or a smaller row of words")
    return known, told


def excess(setting: Setting, known: int, told: int) -> str:
    """Return what is wrong with the memory that all robots' words take; empty if they fit."""
    needed = 4 * setting.robots * (known + told + 2 * int(setting.delay) * told)
    if needed <= KNOWLEDGE_LIMIT:
        return ""
    gibibytes = f"{needed / 2**30:.0f} GiB, over {KNOWLEDGE_LIMIT // 2**30}"
    late = " and say within radio.delay" if setting.delay else ""
    return f"what {setting.robots} robots know{late} would take {gibibytes}"

"""Replay the log of a robot: from its inputs and draws, the same decisions to the bit."""

from __future__ import annotations

import json
from collections import deque
from pathlib import Path
from typing import Any, NamedTuple

from feasibee.errors import FeasibeeError, one_line, quoted
from feasibee.field.checks import is_heard, is_insight, is_place, is_sighting, is_status, is_whole
from feasibee.field.heads import problem_of
from feasibee.field.node import VERSION, Node, Words
from feasibee.files.reading import named, read_text
from feasibee.model.codes import DECISIONS
from feasibee.strategies import STRATEGIES
from feasibee.strategies.contract import Strategy

LOG_LIMIT = 2**30
"""Largest log that is read, in bytes."""
WORD_LIMIT = 2**32
UNFIT = (ArithmeticError, AttributeError, LookupError, TypeError, ValueError)
"""Errors of a strategy that is given what its own robots never see, or that isn't the robot's."""


class Replay(NamedTuple):
    """A replayed log, equal to what the robot did."""

    number: int
    """The robot's number."""
    steps: int
    """Number of steps in the log."""
    opinion: str
    """The opinion at the end: ``feasible``, ``infeasible`` or ``undecided``."""
    decisions: int
    """Number of phases that ended with a decision."""
    cut: bool
    """Whether the last line is incomplete, as of a process that was killed."""


def replay(path: Path, strategy: Strategy | None = None) -> Replay:
    """Replay a robot's log.

    Parameters
    ----------
    path : Path
        The log.
    strategy : Strategy, optional
        The robot's strategy, if it isn't built in. A log never says which file to run.

    Raises
    ------
    FeasibeeError
        If the file is no log of a robot, is damaged, or says anything else than the replay.
    """
    *lines, rest = read_text(path, "the log of a robot, such as robot-3.jsonl", LOG_LIMIT).split("\n")
    if not lines:
        raise damaged(path, 1, "is incomplete")
    head = parsed(path, 1, lines[0])
    if head.get("feasibee") != "robot" or head.get("version") != VERSION:
        raise FeasibeeError(f"{named(path)}: isn't the log of a robot, version {VERSION}; name robot-K.jsonl")
    draws = deque(_draws(path, 1, head))
    node, written = _node(path, head, draws, strategy)
    _compare(path, 1, head, written.pop(), draws)
    decisions = explores = 0
    for at, text in enumerate(lines[1:], 2):
        line = _step(path, at, text)
        draws.extend(_draws(path, at, line))
        try:
            node.speak(line["step"], tuple(line["place"]), line.get("insight"))
            node.sense(line["see"])
            node.finish(line["heard"])
        except UNFIT as error:
            raise _unfit(path, at, error, draws) from None
        _compare(path, at, line, written.pop(), draws)
        disseminating = node.status.disseminating
        decisions += bool(explores) and not disseminating
        explores = disseminating
    opinion = DECISIONS[node.status.opinion]
    return Replay(head["settings"]["coordinates"][2], len(lines) - 1, opinion, decisions, bool(rest))


def _node(
    path: Path, head: dict[str, Any], draws: deque[Words], strategy: Strategy | None
) -> tuple[Node, list[Any]]:
    """Return a robot as at the begin of its log, and the list of the lines that it writes."""
    name = head.get("strategy")
    own = strategy or STRATEGIES.get(str(name))
    if own is None:
        raise FeasibeeError(
            f"{named(path)}: the robot's strategy {quoted(name)} isn't built in; give --strategy FILE"
        )
    orders = {key: head[key] for key in head if key not in ("draws", "status", "feasibee", "version")}
    written: list[Any] = []
    try:
        problem = problem_of(orders, own)
        if problem:
            raise damaged(path, 1, problem)
        return Node(orders, written.append, lambda _, __: draws.popleft(), own), written
    except UNFIT as error:
        raise _unfit(path, 1, error, draws) from None


def _unfit(path: Path, at: int, error: Exception, draws: deque[Words]) -> FeasibeeError:
    """Return the error of a line that no robot with this head and this strategy has written."""
    if isinstance(error, IndexError) and not draws:
        return damaged(path, at, "has too few draws")
    return damaged(
        path, at, f"makes the strategy fail with {type(error).__name__}: {one_line(str(error), 100)}"
    )


def parsed(path: Path, at: int, text: str) -> dict[str, Any]:
    """Return a line of a log, which must be a JSON object."""
    try:
        line = json.loads(text)
    except (ValueError, RecursionError):
        raise damaged(path, at, "isn't JSON") from None
    if not isinstance(line, dict):
        raise damaged(path, at, "isn't a JSON object")
    return line


def _step(path: Path, at: int, text: str) -> dict[str, Any]:
    """Return a step's line, if it can be one."""
    line = parsed(path, at, text)
    see, heard = line.get("see"), line.get("heard")
    fits = {
        "step": is_whole(line.get("step"), 0, 2**62),
        "place": is_place(line.get("place")),
        "see": isinstance(see, list) and all(map(is_sighting, see)),
        "heard": isinstance(heard, list) and all(map(is_heard, heard)),
        "status": is_status(line.get("status")),
        "insight": is_insight(line.get("insight")),
    }
    for name, fit in fits.items():
        if not fit:
            raise damaged(path, at, f"has no valid {name}")
    return line


def _draws(path: Path, at: int, line: dict[str, Any]) -> list[Words]:
    draws = line.get("draws")
    if isinstance(draws, list) and all(
        isinstance(each, list) and len(each) == 4 and all(is_whole(word, 0, WORD_LIMIT - 1) for word in each)
        for each in draws
    ):
        return [(a, b, c, d) for a, b, c, d in draws]
    raise damaged(path, at, "has no valid draws")


def _compare(path: Path, at: int, line: dict[str, Any], again: Any, draws: deque[Words]) -> None:
    """Raise an error if the log says anything else than the replay."""
    if draws:
        raise damaged(path, at, "has too many draws")
    for name in ("said", "see", "heard", "status"):
        kept, found = line.get(name), again.get(name)
        if kept != found:
            raise FeasibeeError(
                f"{named(path)}: line {at}: {name} is {quoted(kept)} in the log and {quoted(found)} in the "
                "replay; the log was changed, or another version or strategy wrote it: use an intact copy"
            )


def damaged(path: Path, at: int, what: str) -> FeasibeeError:
    """Return the error of a damaged line of a log."""
    return FeasibeeError(f"{named(path)}: line {at}: {what}; the log is damaged: use an intact copy")

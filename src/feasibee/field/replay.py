"""Replay the log of a robot: from its inputs and draws, the same decisions to the bit."""

from __future__ import annotations

import json
from collections import deque
from pathlib import Path
from typing import Any, NamedTuple

from feasibee.base.codes import DECISIONS
from feasibee.base.errors import FeasibeeError, quoted
from feasibee.base.files import named
from feasibee.field.logs import read_log, reading
from feasibee.field.node import VERSION, WORK, Node
from feasibee.reference.mind import Words
from feasibee.strategies import STRATEGIES
from feasibee.strategies.contract import Strategy


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


def replay(path: str | Path, strategy: Strategy | None = None) -> Replay:
    """Replay a robot's log; ``strategy`` is that of the robot, if it isn't built in.

    A log never says which file to run. Raise a FeasibeeError if it is no log of a robot, is damaged, or says
    anything else than the replay.
    """
    path, first = Path(path), {"feasibee": "robot", "version": VERSION}
    wrong = f"isn't the log of a robot, version {VERSION}; name robot-K.jsonl"
    lines, rest = read_log(path, "the log of a robot, such as robot-3.jsonl", first, wrong)
    head = json.loads(lines[0])
    own = strategy or STRATEGIES.get(str(head.get("strategy")))
    if own is None:
        what = f"the robot's strategy {quoted(head.get('strategy'))} isn't built in"
        raise FeasibeeError(f"{named(path)}: {what}; give --strategy FILE")
    draws, written = deque[Words](), list[Any]()
    decisions = explores = 0
    for at, text in enumerate(lines, 1):
        with reading(path, at):
            line = json.loads(text)
            draws.extend((a, b, c, d) for a, b, c, d in line["draws"])
            if at == 1:
                node = Node(head, written.append, lambda _, __: draws.popleft(), own)
            else:
                node.speak(line["step"], tuple(line["place"]), line.get("insight"))
                node.sense(line)
                node.finish(line["heard"])
            if draws:
                raise ValueError("too many draws")
            _compare(path, at, line, written.pop())
        disseminating = node.status.disseminating
        decisions += bool(explores) and not disseminating
        explores = disseminating
    opinion = DECISIONS[node.status.opinion]
    return Replay(head["settings"]["coordinates"][2], len(lines) - 1, opinion, decisions, bool(rest))


def _compare(path: Path, at: int, line: dict[str, Any], again: Any) -> None:
    """Raise an error if the log says anything else than the replay."""
    for name in ("said", "see", "heard", "status", "goes", *WORK):
        kept, found = line.get(name), again.get(name)
        if kept != found:
            raise FeasibeeError(
                f"{named(path)}: line {at}: {name} is {quoted(kept)} in the log and {quoted(found)} in the "
                "replay; a line is missing or was changed, or another version or strategy wrote it: use an "
                "intact copy"
            )

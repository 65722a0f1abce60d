"""A real robot: a driver of the user writes what it senses, one object a step, and reads its messages."""

from __future__ import annotations

import json
import random
import socket
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

from feasibee.errors import FeasibeeError
from feasibee.field.checks import DEED, MESSAGE, PLACE, SIGHTING, TAKEN, anything, many, record, whole
from feasibee.field.connections import split_address
from feasibee.field.node import HEARD_LIMIT, Node
from feasibee.files import named, why_not
from feasibee.scenario.runs import Runs

if TYPE_CHECKING:
    from feasibee.scenario.scenario import Scenario

SENSES_LIMIT = 65_507
"""Largest object of a driver, in bytes: what a datagram holds."""
COUNT_LIMIT = 10_000
"""Largest number of robots or of tasks in sight."""
_SENSED = record(
    {
        "place": PLACE,
        "heard": many(anything, 0, HEARD_LIMIT),
        "see": many(SIGHTING),
        "taken": TAKEN,
        "acts": many(DEED),
        **dict.fromkeys(("robots", "tasks"), whole(0, COUNT_LIMIT)),
    }
)
"""The form of a driver's object; messages are checked one by one."""


def real_robot(
    scenario: Scenario,
    number: int,
    seed: int | None = None,
    write: Callable[[Mapping[str, Any]], None] | None = None,
) -> Node:
    """Return the robot of a number; without a seed, each start has random numbers of its own.

    Raise a FeasibeeError if the scenario has no robot of this number.
    """
    from feasibee.field.bodies import Bodies

    one = Runs.single(random.SystemRandom().getrandbits(64) if seed is None else seed, 0)
    bodies = Bodies(scenario, one.seed, one.first)
    count = scenario.robots.count
    if number >= count:
        raise FeasibeeError(f"--id {number}: must be below robots.count, {count}; use 0 or more")
    orders = bodies.orders(bodies.everyone[number], real=True)
    orders["settings"] = json.loads(json.dumps(orders["settings"]))
    return Node(orders, write, strategy=scenario.strategy)


def drive(
    node: Node, number: int, senses: Iterable[bytes], write: Callable[[Mapping[str, Any]], None]
) -> int:
    """Let a robot take one step for each object of its driver; return the number of steps.

    Parameters
    ----------
    node : Node
        The robot.
    number : int
        Its number; messages of this number are its own, which some radios return.
    senses : iterable of bytes
        The driver's objects. One that is invalid is counted in ``node.dropped`` and left out, and so is an
        invalid message in one.
    write : callable
        Takes after each step its number, the robot's message and what it holds.
    """
    step = 0
    for text in senses:
        sensed = sensed_from(text)
        if sensed is None:
            node.dropped["invalid object"] += 1
            continue
        step += 1
        said = node.speak(step, tuple(sensed["place"]))
        acts = node.goes and [node.goes[2], sensed["acts"]]
        node.sense({"see": sensed["see"], "taken": sensed["taken"], "acts": acts})
        heard = [each for each in sensed["heard"] if MESSAGE(each)]
        node.dropped["malformed message"] += len(sensed["heard"]) - len(heard)
        node.finish(each for each in heard if each[0] != number)
        write({"step": step, "said": said, **node.status._asdict(), **node.way})
    return step


def open_senses(source: str) -> Iterator[bytes]:
    """Return a driver's objects: from a named pipe or file, or ``udp:HOST:PORT``.

    Raise a FeasibeeError if the source can't be read.
    """
    kind, _, rest = source.partition(":")
    return _datagrams(rest) if kind == "udp" else _lines(Path(source))


def sensed_from(text: bytes) -> dict[str, Any] | None:
    """Return what a robot senses in a step, of a driver's object, or None if the text is invalid."""
    if len(text) > SENSES_LIMIT:
        return None
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        return None
    if not isinstance(found, dict):
        return None
    sensed = {
        "place": [0.0, 0.0],
        "heard": [],
        "see": [],
        "taken": [],
        "acts": [],
        "robots": 0,
        "tasks": 0,
        **found,
    }
    if not _SENSED(sensed):
        return None
    for is_robot, name in ((1, "robots"), (0, "tasks")):
        sensed["see"] += [[is_robot, -1, 0, 0, 0.0, 0.0, -1]] * sensed[name]
    return sensed


def _lines(path: Path) -> Iterator[bytes]:
    """Yield the lines of a named pipe or a file, until its writer closes it."""
    try:
        with path.open("rb") as file:
            while line := file.readline(SENSES_LIMIT + 1):
                yield line
    except (OSError, ValueError) as error:
        raise FeasibeeError(
            f"--senses {named(path)}: can't be read: {why_not(error)}; name a pipe that mkfifo made"
        ) from None


def _datagrams(address: str) -> Iterator[bytes]:
    """Yield the datagrams that come to an address; one that says ``{"end": true}`` is the last."""
    host, port = split_address(address)
    with closing(socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET, socket.SOCK_DGRAM)) as end:
        try:
            end.bind((host, port))
        except (OSError, UnicodeError, TypeError):
            raise FeasibeeError(
                f"--senses udp:{address}: can't listen on it; use a free port of this machine"
            ) from None
        while (text := end.recv(SENSES_LIMIT + 1)).replace(b" ", b"").strip() != b'{"end":true}':
            yield text

"""A real robot: a driver of the user writes what it senses, one object a step, and reads its messages."""

from __future__ import annotations

import json
import random
import socket
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from feasibee.base.errors import FeasibeeError
from feasibee.base.files import named, why_not
from feasibee.field.node import HEARD_LIMIT, Node, is_message
from feasibee.scenario.runs import Runs

if TYPE_CHECKING:
    from feasibee.scenario.scenario import Scenario

SENSES_LIMIT = 65_507
"""Largest object of a driver, in bytes: what a datagram holds."""
COUNT_LIMIT = 10_000
"""Largest number of robots or of tasks in sight."""
_Number = Annotated[int, Field(ge=-1, le=2**32)]
_Ordinate = Annotated[float, Field(ge=-1e300, le=1e300)]
_Kind = Annotated[int, Field(ge=0, le=2**16)]
_Count = Annotated[int, Field(ge=0, le=COUNT_LIMIT)]


class _Sensed(BaseModel):
    """What a driver's object may have; messages are checked one by one."""

    model_config = ConfigDict(strict=True, allow_inf_nan=False)

    place: tuple[_Ordinate, _Ordinate] = (0.0, 0.0)
    heard: Annotated[list[Any], Field(max_length=HEARD_LIMIT)] = []
    see: list[
        tuple[
            Annotated[int, Field(ge=0, le=1)],
            _Number,
            _Kind,
            Annotated[int, Field(ge=0, lt=2**32)],
            _Ordinate,
            _Ordinate,
            _Number,
        ]
    ] = []
    taken: list[tuple[_Number, Annotated[int, Field(ge=-1, le=2**16)]]] = []
    acts: list[tuple[Literal["reached", "lost", "joined"], Annotated[int, Field(ge=-1, le=2**20)]]] = []
    robots: _Count = 0
    tasks: _Count = 0


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

    ``senses`` are the driver's objects. An invalid one is counted in ``node.dropped`` and left out, and so is
    an invalid message in one. Messages of the robot's own ``number`` are its own, which some radios return.
    ``write`` takes after each step its number, the robot's message and what it holds.
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
        heard = [each for each in sensed["heard"] if is_message(each)]
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
        sensed = _Sensed.model_validate_json(text).model_dump()
    except ValidationError:
        return None
    for is_robot, name in ((1, "robots"), (0, "tasks")):
        sensed["see"] += [(is_robot, -1, 0, 0, 0.0, 0.0, -1)] * sensed[name]
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


def _split_address(text: str) -> tuple[str, int]:
    """Return host and port of an address; raise a FeasibeeError if it isn't HOST:PORT."""
    host, colon, port = text.rpartition(":")
    host = host.removeprefix("[").removesuffix("]")
    if not (colon and host and port.isascii() and port.isdigit() and 0 < int(port) < 65_536):
        raise FeasibeeError(f"address {text}: must be HOST:PORT, such as 127.0.0.1:7400")
    return host, int(port)


def _datagrams(address: str) -> Iterator[bytes]:
    """Yield the datagrams that come to an address; one that says ``{"end": true}`` is the last."""
    host, port = _split_address(address)
    with closing(socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET, socket.SOCK_DGRAM)) as end:
        try:
            end.bind((host, port))
        except (OSError, UnicodeError, TypeError):
            raise FeasibeeError(
                f"--senses udp:{address}: can't listen on it; use a free port of this machine"
            ) from None
        while (text := end.recv(SENSES_LIMIT + 1)).replace(b" ", b"").strip() != b'{"end":true}':
            yield text

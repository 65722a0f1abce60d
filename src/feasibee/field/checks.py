"""Checks of what packets hold: a packet whose content can't be is dropped, whoever signed it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

HELLO, WELCOME, STEP, SAID, TICK, SIGHT, HEARD, BYE, REFUSED, END, WAIT = range(11)
"""Kinds of packets: a robot joins, its settings, lockstep, free-running, the end, a reason against it. Then
the end of a step, and that a robot isn't there yet."""
ROBOTS_LIMIT: Final = 65_535
"""Numbers of robots are smaller than this."""
TEXT_LIMIT: Final = 100_000
"""Largest number of hexadecimal digits of a message."""
FARTHEST: Final = 1e300
"""Largest coordinate; a whole number beyond the range of floats would raise an error later."""


def is_whole(value: Any, least: int, most: int) -> bool:
    """Return whether a value is an int from ``least`` to ``most``, and not a bool."""
    return type(value) is int and least <= value <= most


def is_sighting(value: Any) -> bool:
    """Return whether a value has the form of `node.sighting_of`."""
    if not is_list(value, length=7):
        return False
    is_robot, name, kind, mark, x, y, number = value
    return (
        is_whole(is_robot, 0, 1)
        and is_whole(name, -1, 2**32)
        and is_whole(kind, 0, 2**16)
        and is_whole(mark, 0, 2**32 - 1)
        and is_place([x, y])
        and is_whole(number, -1, 2**32)
    )


def is_heard(value: Any) -> bool:
    """Return whether a value is a pair of a sender's number and its message."""
    return is_list(value, length=2) and is_whole(value[0], -1, 2**32) and _is_text(value[1])


def is_status(value: Any) -> bool:
    """Return whether a value has the form of `node.Status`."""
    if not is_list(value, length=6):
        return False
    opinion, declared, disseminating, left, phases, gap = value
    return (
        is_whole(opinion, -1, 1)
        and is_whole(declared, -1, 1)
        and isinstance(disseminating, bool)
        and is_whole(left, 0, 2**62)
        and is_whole(phases, 0, 2**62)
        and (gap is None or is_whole(gap, -(2**32), 2**32))
    )


def is_insight(value: Any) -> bool:
    """Return whether a value is what Byzantine robots know, in the form of `node.known_from`."""
    if value is None:
        return True
    if not (isinstance(value, dict) and is_whole(value.get("truth"), 0, 1)):
        return False
    return is_list(value.get("invented"), lambda things: is_list(things, is_sighting), 2)


def is_place(value: Any) -> bool:
    """Return whether a value is a pair of numbers that can be coordinates."""
    return is_list(value, lambda each: type(each) in (int, float) and abs(each) <= FARTHEST, 2)


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and len(value) <= TEXT_LIMIT


def is_list(value: Any, check: Callable[[Any], bool] | None = None, length: int | None = None) -> bool:
    """Return whether a value is a list, of a length and of values that pass a check."""
    fits = isinstance(value, list) and length in (None, len(value))
    return fits and (check is None or all(map(check, value)))


def _is_step(body: dict[str, Any]) -> bool:
    return is_whole(body.get("t"), 0, 2**62)


def _is_said(body: dict[str, Any]) -> bool:
    said = body.get("said")
    return (
        _is_step(body)
        and is_status(body.get("was"))
        and (said is None or _is_text(said))
        and type(body.get("ends", False)) is bool
    )


def _is_seen(body: dict[str, Any]) -> bool:
    sees = is_list(body.get("see"), is_sighting)
    return sees and is_place(body.get("place")) and is_insight(body.get("insight"))


def _is_hello(body: dict[str, Any]) -> bool:
    return is_whole(body.get("robot"), 0, 2**16 - 1) and is_whole(body.get("nonce"), 0, 2**63)


def _is_welcome(body: dict[str, Any]) -> bool:
    clock = body.get("clock")
    return isinstance(body.get("settings"), dict) and (clock is None or isinstance(clock, dict))


CHECKS: Final[dict[int, Callable[[dict[str, Any]], bool]]] = {
    HELLO: _is_hello,
    WELCOME: _is_welcome,
    STEP: lambda body: _is_step(body) and _is_seen(body),
    SAID: _is_said,
    TICK: _is_said,
    SIGHT: _is_seen,
    HEARD: lambda body: is_heard(body.get("heard")),
    BYE: lambda body: True,
    REFUSED: lambda body: _is_text(body.get("why")),
    END: lambda body: _is_step(body) and is_list(body.get("heard"), is_heard),
    WAIT: lambda body: True,
}
"""What a packet of each kind may hold."""

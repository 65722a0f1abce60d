"""Forms of what packets and logs hold: what lacks its form is dropped or rejected, whoever signed it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
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

Form = Callable[[Any], bool]
"""Returns whether a value has a form."""


def whole(least: int, most: int) -> Form:
    """Return the form of an int from ``least`` to ``most`` that is no bool."""
    return lambda value: type(value) is int and least <= value <= most


def number(least: float, most: float) -> Form:
    """Return the form of an int or float from ``least`` to ``most``."""
    return lambda value: type(value) in (int, float) and least <= value <= most


def row(*forms: Form) -> Form:
    """Return the form of a list with a value of each form."""
    return lambda value: (
        isinstance(value, list)
        and len(value) == len(forms)
        and all(form(each) for form, each in zip(forms, value, strict=True))
    )


def many(form: Form, least: int = 0, most: float = float("inf")) -> Form:
    """Return the form of a list of ``least`` to ``most`` values of a form."""
    return lambda value: isinstance(value, list) and least <= len(value) <= most and all(map(form, value))


def maybe(form: Form) -> Form:
    """Return the form of None, or of a value of a form."""
    return lambda value: value is None or form(value)


def record(forms: Mapping[str, Form]) -> Form:
    """Return the form of an object whose values have forms; a missing value is None."""
    return lambda value: (
        isinstance(value, dict) and all(form(value.get(name)) for name, form in forms.items())
    )


def anything(_: Any) -> bool:
    """Return True: any value will do."""
    return True


def is_text(value: Any) -> bool:
    """Return whether a value can be a message or a reason."""
    return isinstance(value, str) and len(value) <= TEXT_LIMIT


BIT, TIME, NAME, ORDINATE = whole(0, 1), whole(0, 2**62), whole(-1, 2**32), number(-FARTHEST, FARTHEST)
OPINION, FLAG = whole(-1, 1), lambda value: isinstance(value, bool)
PLACE: Final = row(ORDINATE, ORDINATE)
SIGHTING: Final = row(BIT, NAME, whole(0, 2**16), whole(0, 2**32 - 1), ORDINATE, ORDINATE, NAME)
"""The form of `node.sighting_of`."""
MESSAGE: Final = row(NAME, is_text)
"""A sender's number and its message."""
STATUS: Final = row(OPINION, OPINION, FLAG, TIME, TIME, maybe(whole(-(2**32), 2**32)))
"""The form of `node.Status`."""
INSIGHT: Final = maybe(record({"truth": BIT, "invented": row(many(SIGHTING), many(SIGHTING))}))
"""What Byzantine robots know: the truth, and tasks and robots to invent; None for others."""
TAKEN: Final = maybe(many(row(NAME, whole(-1, 2**16))))
"""Numbers of the tasks in sight that are taken, with the ranks of those who have them, or -1 if done."""
DEED: Final = row(("reached", "lost", "joined").__contains__, whole(-1, 2**20))
"""What a body did, with the status of the task, -1 for none; or that there are so many robots."""
ACTS: Final = maybe(row(TIME, many(DEED)))
"""Number of the first deed, and the deeds from it on."""
WAYS: Final = maybe(many(row(NAME, TIME)))
"""Numbers of the tasks that a robot in a place can do and get to, with the lengths of its ways there."""
WORK: Final = {"taken": TAKEN, "acts": ACTS, "ways": WAYS}
"""What an acting robot senses in addition."""
GOES: Final = maybe(row(NAME, whole(-1, 2**62), TIME))
"""The form of `errands.Errands.goes`."""
_SEEN: Final = {"place": PLACE, "see": many(SIGHTING), "insight": INSIGHT, **WORK}
_TICK: Final = {"t": TIME, "said": maybe(is_text), "was": STATUS, "goes": GOES}
_OBJECT: Final = record({})

CHECKS: Final[Mapping[int, Form]] = {
    HELLO: record({"robot": whole(0, 2**16 - 1), "nonce": whole(0, 2**63)}),
    WELCOME: record({"settings": _OBJECT, "clock": maybe(_OBJECT)}),
    STEP: record({"t": TIME, **_SEEN}),
    SAID: record({**_TICK, "ends": FLAG}),
    TICK: record(_TICK),
    SIGHT: record(_SEEN),
    HEARD: record({"heard": MESSAGE}),
    BYE: _OBJECT,
    REFUSED: record({"why": is_text}),
    END: record({"t": TIME, "heard": many(MESSAGE)}),
    WAIT: _OBJECT,
}
"""The form of the packets of each kind."""

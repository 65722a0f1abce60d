"""The settings of a robot as numbers, for programs in C that simulate its body: those of ``c/given.h``."""

from __future__ import annotations

from typing import Final

from feasibee.robot.controller import Settings
from feasibee.strategies.contract import Setting, Strategy

LARGEST: Final = 65_535
"""Largest number of 16 bits."""
OF_SETTING: Final = [
    each for each in Setting._fields if each not in ("parameters", "colluding", "exploration", "plan")
]
"""The numbers of a setting, in its order."""


def numbers_of(strategy: Strategy, settings: Settings, setting: Setting, inbox: int) -> dict[str, float]:
    """Return the numbers of a robot, in the order in which C takes them.

    ``inbox`` is the most senders whose message the program can keep.
    """
    rule, listens = settings.declare, settings.listens_for
    return {
        "exploration": settings.exploration,
        "gain": settings.gain,
        "dissemination_floor": settings.dissemination_floor,
        "quality_floor": settings.quality_floor,
        "listens_for": -1 if listens is None else min(listens, LARGEST),
        "inbox_size": min(settings.inbox_size or inbox, inbox),
        "own_vote": float(settings.own_vote),
        "random_ties": float(settings.random_ties),
        "first_sight": float(settings.first_sight),
        "every_message": float(settings.every_message),
        "rounds": rule.rounds if rule else 0,
        "heard": rule.heard if rule else 0,
        "quorum": rule.quorum.numerator if rule else 1,
        "quorum_of": rule.quorum.denominator if rule else 1,
        **{name: float(getattr(setting, name)) for name in OF_SETTING},
        **{f"parameter_{k}": value for k, value in enumerate(setting.parameters)},
    }

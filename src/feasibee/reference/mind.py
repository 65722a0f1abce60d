"""The mind of a simulated robot: its controller, with draws that are coordinates, its memory and its lies.

It needs no scenario, only plain settings, so that a swarm's minds can live in processes of their own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Any

from feasibee.base.purposes import FIRST_OPINION, LIE, PHASE
from feasibee.reference.draws import TURN, duration, philox
from feasibee.robot import controller
from feasibee.robot.controller import Controller, Declare, Message
from feasibee.strategies.contract import Setting, Strategy, Thing

Words = tuple[int, int, int, int]
Draw = Callable[[int, int], Words]
HONEST, STOPPED, BYZANTINE, STUBBORN = "honest", "stopped", "byzantine", "stubborn"


@dataclass(frozen=True, kw_only=True)
class MindSettings(controller.Settings):
    """The settings of one simulated mind: plain values, those of the scenario and those of the robot."""

    setting: Setting
    coordinates: tuple[int, int, int]
    """Seed, run and number of the robot, the coordinates of its draws."""
    joined: int
    """Number of robots that have had this number before it."""
    phases: int
    """Number of phases that these have begun."""
    fault: str
    """The robot's fault (model.md 6.6)."""
    byzantine_says: str
    """What it says if it is Byzantine."""
    repeated: bool
    """Whether a robot or task counts each time it is seen."""


class Mind(Controller):
    """The mind of one simulated robot.

    ``words`` returns the random words of a counter and a purpose; by default those of the robot's
    coordinates.
    """

    def __init__(self, strategy: Strategy, settings: MindSettings, words: Draw | None = None) -> None:
        self.settings: MindSettings = settings
        self.phases = settings.phases
        self._words = words or partial(philox, *settings.coordinates)
        self._remembered: set[tuple[bool, int]] = set()
        self._remembers_since = 0
        super().__init__(
            strategy,
            opinion=self._words(settings.joined, FIRST_OPINION)[0] >> 31,
            draw_duration=self._duration,
            draw_choice=self._choice,
            settings=settings,
            stubborn=settings.fault == STUBBORN,
        )

    def says(self, step: int, truth: int, inventions: Callable[[int], Iterable[Thing]]) -> Message | None:
        """Return the message that the robot broadcasts in a step, if any; a Byzantine robot lies.

        It knows the truth, and invents robots (for 1, feasible) or tasks (model.md 6.12, 6.16).
        """
        message = self.message()
        if self.settings.fault != BYZANTINE:
            return message
        says = self.settings.byzantine_says
        if message is None:
            if says != "colluding":
                return None
            message = self.compose(0, 0)  # opinion and value are replaced below
        lies = {
            "opposite": 1 - message.opinion,
            "feasible": 1,
            "infeasible": 0,
            "random": self._words(step, LIE)[0] >> 31,
            "colluding": 1 - truth,
        }
        told = lies[says]
        value = 2**self.strategy.value_bits - 1 if told else 0
        knowledge: tuple[int, ...] = ()
        if self.knowledge:
            knowledge = self.knowledge.lie(message.knowledge, told, inventions(told))
        return message._replace(opinion=told, value=value, knowledge=knowledge)

    def see(self, sightings: Iterable[tuple[Thing, int]]) -> None:
        """Count and recognise the robots and tasks in sight, while exploring (model.md 4.2, 6.3).

        Each comes with its number, which tells it from others; -1 for a false sighting.
        """
        if self.disseminating:
            return
        robots, tasks = [0] * len(self.robots_seen), [0] * len(self.tasks_seen)
        things = [thing for thing, number in sightings if self._counts(thing, number)]
        for thing in things:
            (robots if thing.is_robot else tasks)[thing.kind] += 1
        self.observe(robots, tasks)
        self.recognise(things)

    def _counts(self, thing: Thing, number: int) -> bool:
        """Return whether a robot or task in sight counts: always, or only when new (model.md 6.3)."""
        if self.settings.repeated or number == -1:
            return True
        if self._remembers_since != self.explorations:
            self._remembers_since = self.explorations
            self._remembered.clear()
        is_new = (thing.is_robot, number) not in self._remembered
        self._remembered.add((thing.is_robot, number))
        return is_new

    def _choice(self) -> tuple[float, float]:
        """Return a chance and a drawn message; the next phase's duration has the same coordinate."""
        _, chance, message, _ = self._words(self.phases, PHASE)
        return chance / TURN, message / TURN

    def _duration(self, mean: float) -> int:
        word = self._words(self.phases, PHASE)[0]
        self.phases += 1
        return duration(word, mean)


def plain_settings(settings: MindSettings) -> dict[str, Any]:
    """Return settings as plain values, which JSON keeps exactly."""
    rule = settings.declare
    return vars(settings) | {
        "setting": settings.setting._asdict() | {"plan": settings.setting.plan.hex()},
        "declare": None if rule is None else rule._asdict() | {"quorum": str(rule.quorum)},
    }


def setting_from(plain: Mapping[str, Any]) -> Setting:
    """Return a setting from its form in `plain_settings`; logs of earlier versions have no plan."""
    return Setting(**{**plain, "plan": bytes.fromhex(plain.get("plan", ""))})


def settings_from(plain: Mapping[str, Any]) -> MindSettings:
    """Return settings from the form of `plain_settings`."""
    rule = plain["declare"]
    if rule is not None:
        rule = Declare(**{**rule, "quorum": Fraction(rule["quorum"])})
    return MindSettings(
        **{
            **plain,
            "coordinates": tuple(plain["coordinates"]),
            "me": tuple(plain["me"]),
            "place": tuple(plain["place"]),
            "declare": rule,
            "setting": setting_from(plain["setting"]),
        }
    )

"""Robots whose controllers in Python and in C live the same lives: where both differ is an error."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from feasibee.base.errors import FeasibeeError
from feasibee.field.brain import CompiledMind
from feasibee.reference.mind import BYZANTINE, Mind, Settings
from feasibee.reference.robot import Robot
from feasibee.reference.swarm import Swarm
from feasibee.robot.controller import Message
from feasibee.robot.wire import Wire, WireError
from feasibee.scenario.scenario import Scenario
from feasibee.strategies.contract import Strategy, Thing


class Twin(Mind):
    """A mind in Python with one in C, which senses the same and must say, hold and declare the same.

    Robots hear what was sent as bytes, as real ones do. ``library`` is the program in C that
    `feasibee.field.brain.compiled` made.
    """

    def __init__(self, library: Path, strategy: Strategy, settings: Settings) -> None:
        setting = settings.setting
        id_bits = max(setting.id_bits, (max(setting.robots, setting.robot_ids) - 1).bit_length())
        settings = replace(settings, setting=setting._replace(id_bits=id_bits))
        self._wire = Wire(strategy, id_bits, declares=settings.declare is not None, setting=settings.setting)
        super().__init__(strategy, settings)
        self._other = CompiledMind(library, strategy, settings, self._words)
        self._compare()

    def move_to(self, x: float, y: float) -> None:
        """Store the robot's position."""
        super().move_to(x, y)
        self._other.move_to(x, y)

    def observe(self, robots: int | Sequence[int], tasks: int | Sequence[int]) -> None:
        """Count robots and tasks in sight."""
        super().observe(robots, tasks)
        self._other.observe(robots, tasks)

    def recognise(self, things: Iterable[Thing]) -> None:
        """Add robots and tasks in sight to the knowledge."""
        things = list(things)
        super().recognise(things)
        self._other.recognise(things)

    def message(self) -> Message | None:
        """Return the message of this step, if any, as it is heard."""
        said, other = super().message(), self._other.message()
        frame = None if said is None else self._bytes(self.settings.me[0], said)
        if frame != other:
            shown = ("nothing" if each is None else each.hex() for each in (frame, other))
            raise FeasibeeError("Python sends {}, and C {}".format(*shown))
        return said

    def hear(self, sender: int, message: Message) -> None:
        """Hear a message as the bytes that were sent; a lie may not fit its bits, and isn't heard."""
        frame = self._bytes(sender, message)
        if not frame:
            return
        try:
            heard = self._wire.decode(frame).message
            self._other.decode(frame)
        except WireError as error:
            raise FeasibeeError(f"{frame.hex()}, which Python sends, isn't read: it {error}") from None
        super().hear(sender, heard)
        self._other.hear(sender, None)

    def _bytes(self, sender: int, message: Message) -> bytes:
        """Return a message as bytes, none if it doesn't fit its bits."""
        try:
            return self._wire.encode(sender, message)
        except WireError:
            return b""

    def end_step(self) -> None:
        """End a step."""
        super().end_step()
        self._other.end_step()
        self._compare()

    def _compare(self) -> None:
        """Raise an error if both minds differ."""
        held = [
            (each.opinion, each.declared, each.disseminating, each.phase_left) for each in (self, self._other)
        ]
        if held[0] != held[1]:
            names = "opinion, declaration, whether it disseminates and for how long"
            raise FeasibeeError(f"{names} are {held[0]} in Python, and {held[1]} in C")


def live(scenario: Scenario, library: Path, seed: int, run: int) -> None:
    """Simulate a run of robots without classes; raise an error that names the first step and difference."""

    class TwinRobot(Robot):
        """A robot with two minds, unless it is Byzantine."""

        def mind_of(self, settings: Settings) -> Mind:
            if settings.fault == BYZANTINE:
                return Mind(scenario.strategy, settings)
            return Twin(library, scenario.strategy, settings)

    class Twins(Swarm):
        """A swarm of them."""

        robot_type = TwinRobot

    swarm = Twins(scenario, seed, run)
    for step in range(scenario.run.steps):
        try:
            swarm.step()
        except FeasibeeError as error:
            raise FeasibeeError(f"step {step + 1}: {error}") from None

"""The bodies of a field: a swarm of the reference whose minds are in other processes."""

from __future__ import annotations

from typing import Any, cast

from feasibee.errors import FeasibeeError
from feasibee.field.node import Status, sighting_of
from feasibee.reference.mind import BYZANTINE, HONEST, Mind, Settings, plain_settings
from feasibee.reference.robot import Robot
from feasibee.reference.swarm import Swarm
from feasibee.reference.world import Place
from feasibee.scenario.scenario import Scenario


class RemoteMind:
    """What is known here of a mind in another process: its settings, and what it last reported.

    Parameters
    ----------
    settings : Settings
        What the robot is sent when it joins.
    """

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.phases = 0
        self.report(Status(-1, False, -1, False, 1))

    def report(self, status: Status) -> None:
        """Keep what the robot reports."""
        self.opinion, self.committed, self.declared, self.disseminating, self.phase_left = status

    @property
    def status(self) -> Status:
        """What the robot last reported."""
        return Status(self.opinion, self.committed, self.declared, self.disseminating, self.phase_left)

    def move_to(self, x: float, y: float) -> None:
        """Do nothing: the robot learns its place with the next packet."""

    def end_step(self) -> None:
        """Do nothing: the robot ends its own steps."""


class Body(Robot):
    """The body of a robot: place, walk and faults, without its mind."""

    lost = False
    """Whether its process is silent."""

    def mind_of(self, settings: Settings) -> Mind:
        """Return the place for what the robot reports."""
        return cast(Mind, RemoteMind(settings))

    @property
    def remote(self) -> RemoteMind:
        """What its mind last reported, and its settings."""
        return cast(RemoteMind, self.mind)

    def works(self, step: int) -> bool:
        """Return whether the robot still works at a step, and its process answers."""
        return not self.lost and super().works(step)

    def state(self) -> list[int]:
        """Return the state of the body, for the world's log."""
        return [*self.place, *self.velocity, self._walk_left, self._walks]

    def restore(self, state: list[int]) -> None:
        """Put the body into a state of the log."""
        x, y, dx, dy, self._walk_left, self._walks = state
        self.place, self.velocity = (x, y), (dx, dy)


class Bodies(Swarm):
    """The robots' bodies and the tasks of one field.

    Parameters
    ----------
    scenario : Scenario
        What is simulated; its world doesn't change.
    seed, run : int
        Seed and number of the run.
    """

    def __init__(self, scenario: Scenario, seed: int, run: int) -> None:
        if scenario.dynamic:
            raise FeasibeeError(
                "scenario: its world changes, and that of a field can't; use feasibee run, or remove events, "
                "arrival rates, lifetimes, failures and the response"
            )
        super().__init__(scenario, seed, run)
        self.bodies = cast("list[Body]", self.robots)

    def new_robot(self, number: int, place: Place, fault: str = HONEST, before: Robot | None = None) -> Robot:
        """Return the body of a robot that begins at this step."""
        kind = self.robot_kinds[number]
        return Body(
            self.scenario, *self._run, number, self.world, place, kind, fault, self.names, before, self.time
        )

    def orders(self, body: Body) -> dict[str, Any]:
        """Return what a robot is sent when it joins."""
        insight = None
        if body.fault == BYZANTINE:
            invented = [
                [sighting_of(thing, -1) for thing in self.names.inventions(opinion)] for opinion in (0, 1)
            ]
            insight = {"truth": self.names.truth, "invented": invented}
        return {
            "strategy": self.scenario.manifest.name,
            "settings": plain_settings(body.remote.settings),
            "insight": insight,
        }

    def place_of(self, body: Body) -> list[float]:
        """Return where a robot is, in units."""
        return list(self.world.in_units(body.place))

    def seen_by(self, body: Body) -> list[list[Any]]:
        """Return all that a robot sees, as plain lists."""
        return [sighting_of(thing, number) for thing, number in self.sightings(body)]

    def advance(self, working: list[Body]) -> None:
        """Move some robots at once; the others stand. What they meet turns them."""
        blocked = self.move(cast("list[Robot]", working))
        for body in working:
            body.end_step(body in blocked)

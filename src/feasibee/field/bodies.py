"""The bodies of a field: a swarm of the reference whose minds are in other processes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any, cast

from feasibee.field.errands import RemoteErrand, check_tasks
from feasibee.field.node import Status, sighting_of
from feasibee.reference.mind import BYZANTINE, HONEST, Mind, MindSettings, plain_settings
from feasibee.reference.robot import Robot
from feasibee.reference.swarm import Swarm
from feasibee.reference.world import Place
from feasibee.robot.acting import FREE, NONE
from feasibee.scenario.scenario import Scenario


class RemoteMind:
    """What is known here of a mind in another process: its settings, and what it last reported."""

    def __init__(self, settings: MindSettings) -> None:
        self.settings = settings
        # As that of a fresh mind, whose first phase has begun.
        self.report([-1, -1, False, 1, settings.phases + 1])

    def report(self, status: Sequence[Any]) -> None:
        """Keep what the robot reports, in the form of `Status`."""
        self.status = Status(*status)
        self.opinion, self.declared, self.disseminating, _, self.phases = self.status

    def move_to(self, x: float, y: float) -> None:
        """Do nothing: the robot learns its place with the next message."""

    def end_step(self) -> None:
        """Do nothing: the robot ends its own steps."""


class Body(Robot):
    """The body of a robot: place, walk and faults, without its mind."""

    errand_type = RemoteErrand
    errand: RemoteErrand
    """What its robot last reported of its target, and what this body did."""
    process = 0
    """Number of its process: robots are counted as they come, and no number is used again."""
    lost = False
    """Whether its process is silent."""
    has_left = False
    """Whether it isn't in the world any more."""
    knows: Mapping[str, Any] | None = None
    """The insight of a Byzantine robot that its process last got."""

    def mind_of(self, settings: MindSettings) -> Mind:
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
        """Return place and velocity of the body, for the world's log."""
        return [*self.place, *self.velocity]


class Bodies(Swarm):
    """The robots' bodies and the tasks of one field, by scenario, seed and number of the run."""

    robot_type = Body

    def __init__(self, scenario: Scenario, seed: int, run: int) -> None:
        self.everyone: list[Body] = []
        """All robots that have ever come, by the numbers of their processes."""
        self._insight: dict[str, Any] = {}
        check_tasks(scenario)
        super().__init__(scenario, seed, run)
        self.bodies = cast("list[Body]", self.robots)
        for body in self.everyone:
            body.has_left = body not in self.bodies
            body.knows = self._insight_of(body)

    def change(self, step: int) -> tuple[list[Body], list[Body]]:
        """Begin a step: let the world change as that of a run does (model.md 6.17.2).

        Return the bodies that leave, and those that join.
        """
        self.time = step
        if self._dynamics is None:
            return [], []
        before = dict.fromkeys(self.bodies)
        if self._dynamics.change():
            self._look_up_truth()
        now = dict.fromkeys(self.bodies)
        left = [body for body in before if body not in now]
        for body in left:
            body.has_left = True
        return left, [body for body in now if body not in before]

    def _look_up_truth(self) -> None:
        super()._look_up_truth()
        self._insight = {}

    def new_robot(self, number: int, place: Place, fault: str = HONEST, before: Robot | None = None) -> Robot:
        """Return the body of a robot that begins at this step."""
        body = cast(Body, super().new_robot(number, place, fault, before))
        body.process = len(self.everyone)
        self.everyone.append(body)
        return body

    def orders(self, body: Body, *, real: bool = False) -> dict[str, Any]:
        """Return what a robot is sent when it joins; a real one, without a world, finds tasks itself."""
        orders = {
            "strategy": self.scenario.manifest.name,
            "settings": plain_settings(body.remote.settings),
            "insight": self._insight_of(body),
        }
        return orders | ({"acting": self._errand_of(body, real)} if self.work else {})

    def _errand_of(self, body: Body, real: bool) -> dict[str, Any]:
        """Return what a robot is sent of its errand."""
        assert self.work is not None
        world, kinds = self.world, self.task_kinds
        return {
            "rules": asdict(body.errand.rules),
            "able": list(self.work.can_do[body.kind]),
            "frame": [float(world.unit), *world.size, world.is_torus],
            "tasks": None if real else [[*world.task_place(i), kind] for i, kind in enumerate(kinds)],
        }

    def report(self, body: Body, told: Mapping[str, Any]) -> None:
        """Keep what a robot reports."""
        body.remote.report(told["was"])
        if self.work and told.get("goes") is not None:
            body.errand.report(told["goes"], self.work.places)

    def _insight_of(self, body: Body) -> Mapping[str, Any] | None:
        """Return what only Byzantine robots know; None for the other ones."""
        if body.fault != BYZANTINE:
            return None
        if not self._insight:
            invented = [
                [sighting_of(thing, -1) for thing in self.names.inventions(opinion)] for opinion in (0, 1)
            ]
            self._insight = {"truth": self.names.truth, "invented": invented}
        return self._insight

    def sight_of(self, body: Body) -> dict[str, Any]:
        """Return what a robot senses: its place, all in sight, and new insight of a Byzantine robot."""
        seen = [sighting_of(thing, number) for thing, number in self.sightings(body)]
        sight = {"place": list(self.world.in_units(body.place)), "see": seen}
        insight = self._insight_of(body)
        if insight is not body.knows:
            body.knows = sight["insight"] = insight
        if self.work:
            tasks = [number for is_robot, *_, number in seen if not is_robot and number >= 0]
            statuses = [(each, self.work.status(each)) for each in tasks]
            sight["taken"] = [[each, NONE if how is None else how] for each, how in statuses if how != FREE]
            sight["acts"] = [body.errand.heeded, body.errand.deeds[body.errand.heeded :]]
            if self.world.ground:
                ways = ((task, self.work.way(body, task)) for task in self.work.places)
                sight["ways"] = [[task, length] for task, length in ways if length is not None]
        return sight

    def advance(self, working: list[Body]) -> None:
        """Move some robots at once; the others stand. What they meet turns them."""
        blocked = self.move(cast("list[Robot]", working))
        if self.work:
            self.work.arrive(cast("list[Robot]", working))
        for body in working:
            body.end_step(body in blocked)

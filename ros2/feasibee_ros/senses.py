"""What a robot senses: odometry and detections, in the form that `feasibee.field.node.Node` takes."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from functools import partial
from typing import Any

from geometry_msgs.msg import Pose, PoseArray
from nav_msgs.msg import Odometry
from std_msgs.msg import String

from feasibee.field.senses import COUNT_LIMIT, sensed_from
from feasibee_ros.messages import step_of

POSES, OBJECTS = "poses", "objects"
"""Detections as two arrays of poses, or as one object of docs/field.md in JSON."""


class Senses:
    """The newest odometry and detections of a robot.

    Parameters
    ----------
    metres : float
        Metres in a unit of the scenario.
    detections : str
        `POSES` or `OBJECTS`.
    simulated : bool
        Whether the objects come from the world of `feasibee robot launch --ros`.
    """

    def __init__(self, metres: float, detections: str, *, simulated: bool = False) -> None:
        self.place: tuple[float, float] = (0.0, 0.0)
        self.frame = "map"
        self.dropped = 0
        self.foreign = ""
        """The frame of the newest poses, if it is neither the odometry's nor the robot's own."""
        self.metres, self._detections, self._simulated = metres, detections, simulated
        self._heading = 0.0
        self._base = ""
        self._seen: dict[str, list[list[Any]]] = {}
        self._told: dict[str, Any] = {}
        self._acts: list[list[Any]] = []
        self._steps: dict[str, int] = {}

    @property
    def takers(self) -> dict[str, Callable[[Any], None]]:
        """What takes the messages of each topic that is needed."""
        if self._detections == OBJECTS:
            return {"odom": self.take_odometry, OBJECTS: self.take_object}
        arrays = {name: partial(self.take_poses, name) for name in ("robots", "tasks")}
        return {"odom": self.take_odometry, **arrays}

    @property
    def step(self) -> int:
        """The step of the simulated world of which all is there; -1 for none."""
        needed = ("odom", "robots", "tasks") if self._detections == POSES else (OBJECTS,)
        steps = {self._steps.get(name, -1) for name in needed}
        return steps.pop() if len(steps) == 1 else -1

    def take_odometry(self, message: Odometry) -> None:
        """Keep where the robot is."""
        pose = message.pose.pose
        place = pose.position.x / self.metres, pose.position.y / self.metres
        if not all(map(math.isfinite, place)):
            self.dropped += 1
            return
        self.place, self.frame, self._base = place, message.header.frame_id, message.child_frame_id
        self._heading = _heading(pose)
        self._steps["odom"] = step_of(message.header.stamp)

    def take_poses(self, name: str, message: PoseArray) -> None:
        """Keep the poses of ``robots`` or ``tasks``, in the robot's frame or that of its odometry."""
        frame = message.header.frame_id
        own = bool(self._base) and frame == self._base
        self.foreign = frame if self._base and frame not in (self._base, self.frame) else ""
        is_robot = int(name == "robots")
        places = [self._place_of(pose, own) for pose in message.poses]
        finite = all(math.isfinite(each) for place in places for each in place)
        if self.foreign or not finite or len(places) > COUNT_LIMIT:
            self.dropped += 1
            return
        self._seen[name] = [[is_robot, -1, 0, 0, *place, k] for k, place in enumerate(places)]
        self._steps[name] = step_of(message.header.stamp)

    def _place_of(self, pose: Pose, own: bool) -> tuple[float, float]:
        """Return a place in units; of a pose in the robot's own frame, with its own place and heading."""
        x, y = pose.position.x / self.metres, pose.position.y / self.metres
        if not own:
            return x, y
        across, along = math.cos(self._heading), math.sin(self._heading)
        return self.place[0] + across * x - along * y, self.place[1] + along * x + across * y

    def take_object(self, message: String) -> None:
        """Keep a driver's object, or what the simulated world shows."""
        found = self._ordered(message.data) if self._simulated else sensed_from(message.data.encode())
        if found is None:
            self.dropped += 1
            return
        if self._simulated or "odom" not in self._steps:
            self.place = (found["place"][0], found["place"][1])
        if not self._simulated:
            self._acts += found["acts"]
        self._seen = {OBJECTS: found["see"]}
        self._told = found
        self._steps[OBJECTS] = found.get("t", -1)

    def _ordered(self, text: str) -> dict[str, Any] | None:
        """Return what the simulated world shows in a step; None if it has no such form."""
        try:
            found: dict[str, Any] = json.loads(text)
        except ValueError:
            return None
        return found if {"t", "place", "see"} <= found.keys() else None

    def insight(self) -> Any:
        """Return what a simulated Byzantine robot newly knows."""
        return self._told.pop("insight", None)

    def forget(self, name: str) -> None:
        """See nothing of a topic any more: its newest detections are too old."""
        self._seen.pop(name, None)

    def sensed(self, goes: list[int] | None, arrival: list[list[Any]]) -> dict[str, Any]:
        """Return what the robot has sensed; ``arrival`` is what its body did, unless a driver says it."""
        see = [each for seen in self._seen.values() for each in seen]
        if self._simulated:
            return {**self._told, "see": see}
        acts, self._acts = self._acts or arrival, []
        return {"see": see, "taken": self._told.get("taken"), "acts": goes and [goes[2], acts]}

    def arrived(self, go: list[float], reach: float) -> list[list[Any]]:
        """Return that it has reached its goal, if it has, with the status of the task that it sees there."""
        if math.dist(self.place, go) > reach:
            return []
        tasks = [each for seen in self._seen.values() for each in seen if not each[0]]
        near = [each for each in tasks if math.dist(each[4:6], go) <= reach]
        if not near:
            return [["reached", -1]]
        nearest = min(near, key=lambda each: math.dist(each[4:6], go))
        return [["reached", dict(self._told.get("taken") or ()).get(nearest[6], 0)]]


def _heading(pose: Pose) -> float:
    """Return the yaw of a pose, in radians."""
    q = pose.orientation
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))

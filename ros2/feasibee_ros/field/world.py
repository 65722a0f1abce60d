"""The process of a field's world, as a node: it shows robots what they see, and is their radio."""

from __future__ import annotations

import json
import os
import time
from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseArray
from nav_msgs.msg import Odometry
from rclpy.executors import SingleThreadedExecutor
from std_msgs.msg import Header, String, UInt8MultiArray, UInt16

from feasibee.field.connections import (
    BYE,
    END,
    HEARD,
    HELLO,
    REFUSED,
    SAID,
    SIGHT,
    STEP,
    TICK,
    WELCOME,
    Frame,
)
from feasibee.field.node import Status
from feasibee.field.plan import ROBOTS_LIMIT, FieldPlan, plan_from
from feasibee.field.world import main
from feasibee.scenario.scenario import Scenario
from feasibee_ros.messages import (
    frame_from,
    frame_message,
    odometry_at,
    poses_at,
    reported,
    stamp_of,
    step_of,
)
from feasibee_ros.robot import KEPT, LATEST
from feasibee_ros.senses import OBJECTS, POSES

RESEND = 0.1
"""Seconds after which an order of lockstep without an answer is sent again."""


class Endpoint:
    """The topics of one robot, on the world's side."""

    def __init__(self, world: Topics, number: int) -> None:
        node, name = world.node, f"/robot_{number}"
        self.robot = -1
        """Its number, once it has joined."""
        self.status: dict[str, Any] = {}
        """What it last told."""
        self.order: tuple[str, dict[str, Any]] | None = None
        """Kind and content of the order of lockstep that it hasn't answered."""
        self.sent_at = self.until = 0.0
        """When it was sent last, and until when it is sent again."""
        self.orders = node.create_publisher(String, f"{name}/orders", LATEST)
        kinds = {"odom": Odometry, "heard": UInt8MultiArray}
        kinds |= (
            {OBJECTS: String}
            if world.detections == OBJECTS
            else dict.fromkeys(("robots", "tasks"), PoseArray)
        )
        self.shows = {
            topic: node.create_publisher(kind, f"{name}/{topic}", KEPT) for topic, kind in kinds.items()
        }
        node.create_subscription(
            UInt8MultiArray, f"{name}/said", lambda said: world.take_said(number, said), KEPT
        )
        node.create_subscription(
            DiagnosticArray, f"{name}/status", lambda status: world.take_status(number, status), KEPT
        )

    @property
    def is_there(self) -> bool:
        """Whether the robot listens to all that the world shows."""
        return all(shown.get_subscription_count() for shown in self.shows.values())


class Topics:
    """The world's side of a field's topics; it does what `feasibee.field.connections.Server` does."""

    def __init__(self, plan: FieldPlan) -> None:
        scenario = plan.scenario
        self.node = rclpy.create_node("feasibee_world")
        # Where robots of DDS find each other: the port that RTPS gives a domain.
        self.address = f"localhost:{7400 + 250 * int(os.environ.get('ROS_DOMAIN_ID') or 0)}"
        self.detections = POSES if _are_nameless(scenario) else OBJECTS
        self._metres = scenario.units.metres or 1.0
        self._lockstep, self._patience = plan.lockstep, plan.patience
        self._frames: deque[Frame] = deque()
        self._robots: dict[int, Endpoint] = {}
        self._shown = 0
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self.node.create_subscription(UInt16, "/hello", self._greet, KEPT)

    def receive(self, timeout: float) -> Frame | None:
        """Return what a robot sent next, or None if nothing comes in so many seconds."""
        if not self._frames:
            self._executor.spin_once(min(timeout, RESEND) if self._lockstep else timeout)
        now = time.monotonic()
        for endpoint in self._robots.values():
            if endpoint.order and now - endpoint.sent_at > RESEND and now < endpoint.until:
                endpoint.sent_at = now
                self._publish(endpoint, *endpoint.order)
        return self._frames.popleft() if self._frames else None

    def _take(self, kind: str, number: int, body: dict[str, Any]) -> None:
        """Queue what a robot says."""
        endpoint = self._robots[number]
        if endpoint.order:
            ordered, content = endpoint.order
            if (content["t"], ordered == END) == (body.get("t"), body.get("ends")):
                endpoint.order = None
        self._frames.append(Frame(kind, body, endpoint))

    def _greet(self, message: UInt16) -> None:
        """Queue the greeting of a robot that asks for its orders."""
        number = message.data
        if number >= ROBOTS_LIMIT:
            return
        if number not in self._robots:
            self._robots[number] = Endpoint(self, number)
        self._take(HELLO, number, {"robot": number})

    def take_said(self, number: int, message: UInt8MultiArray) -> None:
        """Queue the message of a robot, with the state that the robot last reported."""
        found, endpoint = frame_from(message), self._robots[number]
        if found is not None and endpoint.status:
            _, step, text = found
            body = {**endpoint.status, "t": step, "said": text or None, "ends": False}
            self._take(SAID if self._lockstep else TICK, number, body)

    def take_status(self, number: int, message: DiagnosticArray) -> None:
        """Queue the state of a robot, at the end of a step or before the first one."""
        told, endpoint = reported(message), self._robots[number]
        if told is None or not {*Status._fields, "ends"} <= told.keys():
            return
        step, ends = step_of(message.header.stamp), told["ends"]
        endpoint.status = {"was": [told[name] for name in Status._fields], "goes": told.get("goes")}
        if (ends and not self._lockstep) or not (ends or endpoint.is_there):
            return
        self._take(SAID, number, {**endpoint.status, "t": step if ends else 0, "said": None, "ends": ends})

    def send(self, endpoint: Endpoint, kind: str, content: dict[str, Any]) -> None:
        """Send a robot what the world tells or shows it."""
        if kind in (STEP, END):
            endpoint.order = kind, content
            endpoint.sent_at = time.monotonic()
            endpoint.until = endpoint.sent_at + self._patience
        self._publish(endpoint, kind, content)

    def _publish(self, endpoint: Endpoint, kind: str, content: dict[str, Any]) -> None:
        if kind in (WELCOME, REFUSED):
            orders = {**content, "metres": self._metres, "detections": self.detections}
            endpoint.orders.publish(String(data=json.dumps(orders)))
        elif kind == BYE:
            endpoint.orders.publish(String())
        elif kind in (STEP, SIGHT):
            self._show(endpoint, content)
        elif kind == HEARD:
            sender, text = content["heard"]
            endpoint.shows["heard"].publish(frame_message(sender, 0, text))
        elif kind == END:
            for sender, text in content["heard"]:
                endpoint.shows["heard"].publish(frame_message(sender, content["t"], text))
            endpoint.shows["heard"].publish(frame_message(-1, content["t"], ""))

    def _show(self, endpoint: Endpoint, content: dict[str, Any]) -> None:
        """Publish where a robot is and what it sees; in lockstep, this begins a step."""
        self._shown += 1
        step = content.get("t", self._shown)
        header = Header(stamp=stamp_of(step), frame_id="map")
        endpoint.shows["odom"].publish(odometry_at(content["place"], header, self._metres))
        if self.detections == OBJECTS:
            endpoint.shows[OBJECTS].publish(String(data=json.dumps({"t": step, **content})))
            return
        for name, is_robot in (("robots", 1), ("tasks", 0)):
            places = [each[4:6] for each in content["see"] if each[0] == is_robot]
            endpoint.shows[name].publish(poses_at(places, header, self._metres))


def _are_nameless(scenario: Scenario) -> bool:
    """Return whether robots need nothing of what they see but where it is."""
    named = scenario.manifest.knowledge or scenario.acts or scenario.robots.classes or scenario.tasks.classes
    return not (named or scenario.sensing.observation == "unique" or scenario.faults.byzantine)


@contextmanager
def _serve(order: Mapping[str, Any]) -> Iterator[Any]:
    """Make the topics of a field, which do what a server does."""
    plan = plan_from(order["plan"])
    with rclpy.init():
        topics = Topics(plan)
        yield topics
        while topics.receive(0.2) is not None:  # what was sent last is on its way
            pass


if __name__ == "__main__":
    main(_serve)

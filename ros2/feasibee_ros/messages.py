"""What travels: standard messages of ROS 2, and the forms of feasibee that they stand for."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Point, Pose, PoseArray, PoseStamped
from nav_msgs.msg import Odometry
from std_msgs.msg import Header, MultiArrayDimension, UInt8MultiArray

from feasibee.field.node import is_message

STEP = 10**8
"""Nanoseconds of a step in stamps of a simulated world."""
SECOND = 10**9


def stamp_of(step: int) -> Time:
    """Return the stamp of a step of the simulated world."""
    seconds, rest = divmod(step * STEP, SECOND)
    return Time(sec=seconds, nanosec=rest)


def step_of(stamp: Time) -> int:
    """Return the step of a stamp of the simulated world."""
    return int(stamp.sec * SECOND + stamp.nanosec) // STEP


def frame_message(sender: int, step: int, text: str) -> UInt8MultiArray:
    """Return a robot's message, in hexadecimal digits, as bytes; its label is ``SENDER STEP``."""
    data = bytes.fromhex(text)
    message = UInt8MultiArray()
    message.data = data
    message.layout.dim = [MultiArrayDimension(label=f"{sender} {step}", size=len(data), stride=len(data))]
    return message


def frame_from(message: UInt8MultiArray) -> tuple[int, int, str] | None:
    """Return sender, step and hexadecimal digits of a message; None if it can't be one."""
    try:
        (dimension,) = message.layout.dim
        sender, step = map(int, dimension.label.split(" "))
    except ValueError:
        return None
    text = bytes(message.data).hex()
    return (sender, step, text) if is_message([sender, text]) else None


def pose_at(place: Iterable[float], metres: float) -> Pose:
    """Return a pose at a place in units."""
    x, y = (each * metres for each in place)
    return Pose(position=Point(x=x, y=y))


def poses_at(places: Iterable[Iterable[float]], header: Header, metres: float) -> PoseArray:
    """Return poses at places in units."""
    return PoseArray(header=header, poses=[pose_at(place, metres) for place in places])


def odometry_at(place: Iterable[float], header: Header, metres: float) -> Odometry:
    """Return the odometry of a robot at a place in units."""
    message = Odometry(header=header, child_frame_id="base_link")
    message.pose.pose = pose_at(place, metres)
    return message


def goal_at(place: Iterable[float], header: Header, metres: float) -> PoseStamped:
    """Return the goal of a robot that shall go to a place in units."""
    return PoseStamped(header=header, pose=pose_at(place, metres))


def report(
    header: Header, robot: int, summary: str, values: Mapping[str, Any], warning: str = ""
) -> DiagnosticArray:
    """Return what a robot holds, each value as JSON; with a warning, its level is WARN."""
    status = DiagnosticStatus(
        level=DiagnosticStatus.WARN if warning else DiagnosticStatus.OK,
        name=f"robot {robot}: feasibee",
        message=warning or summary,
        hardware_id=str(robot),
        values=[KeyValue(key=key, value=json.dumps(value)) for key, value in values.items()],
    )
    return DiagnosticArray(header=header, status=[status])


def reported(message: DiagnosticArray) -> dict[str, Any] | None:
    """Return the values of a report; None if it is none."""
    try:
        (status,) = message.status
        return {each.key: json.loads(each.value) for each in status.values}
    except (ValueError, RecursionError):
        return None

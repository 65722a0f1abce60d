"""The process of a field's robot that is a node: that of `feasibee.field.robot`, with another network."""

from __future__ import annotations

import gc
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import rclpy

from feasibee.field.logs import LineLog
from feasibee.field.robot import main
from feasibee.strategies.contract import Strategy
from feasibee_ros.robot import spin
from feasibee_ros.simulated import SimulatedRobot


def take_part(
    order: Mapping[str, Any], log: LineLog | None = None, strategy: Strategy | None = None
) -> tuple[int, str]:
    """Run the robot of an order as `feasibee.field.robot.take_part` does; ROS 2 finds the world."""
    try:
        return _live(order, log, strategy)
    finally:
        gc.collect()  # lifecycle nodes are in cycles, and would leave shared memory


def _live(order: Mapping[str, Any], log: LineLog | None, strategy: Strategy | None) -> tuple[int, str]:
    """Run the node until it ends; nothing holds it afterwards."""
    brain = Path(order["brain"]) if order["brain"] else None
    about: dict[str, Any] = {"log": log, "strategy": strategy, "brain": brain, "patience": order["patience"]}
    with rclpy.init():
        robot = SimulatedRobot(namespace=f"/robot_{order['number']}", **about)
        spin(robot)
        return robot.status, robot.problem


if __name__ == "__main__":
    main(take_part)

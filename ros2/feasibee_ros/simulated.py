"""A robot of a simulated field: a node whose mind, clock and senses come from the world of the field."""

from __future__ import annotations

import json
import math
import random
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

from std_msgs.msg import String, UInt16

from feasibee.field.logs import LineLog
from feasibee.field.node import Node
from feasibee.field.robot import GONE
from feasibee.strategies.contract import Strategy
from feasibee_ros.messages import frame_message, stamp_of
from feasibee_ros.robot import LATEST, Robot, main
from feasibee_ros.senses import Senses

RETRY = 0.2
"""Seconds after which a robot that has no answer asks again."""
IDLE = 1.0
"""Seconds after which a robot without orders lets the world know that it is there."""


class SimulatedRobot(Robot):
    """A robot of a field. In lockstep the world says when a step begins and ends.

    ``log``, ``strategy`` and ``brain`` are those of `feasibee.field.robot.Robot`. After ``patience``
    seconds of silence, its world is gone.
    """

    defaults: ClassVar = {"id": -1, "stale": math.inf}

    def __init__(
        self,
        *,
        log: LineLog | None = None,
        strategy: Strategy | None = None,
        brain: Path | None = None,
        patience: float = 20.0,
        **options: Any,
    ) -> None:
        super().__init__(**options)
        self._file, self._strategy, self._brain, self._patience = log, strategy, brain, patience
        self._orders: dict[str, Any] = {}
        self._is_under_way = False

    def configure(self) -> None:
        """Make the topics of a robot whose mind comes with the world's orders."""
        self._make_publishers()
        self._hello = self.publisher(UInt16, "/hello")
        self.listen(String, "orders", self._take_orders, LATEST)

    def set_out(self) -> None:
        """Ask the world for orders, until it begins."""
        self._heard_at = self._answered_at = self._now
        self.each(RETRY, self._ask)

    def _ask(self) -> None:
        """Ask the world for orders, or repeat the last answer; end if the world is silent for too long."""
        if self._now - self._heard_at > self._patience:
            self.problem = f"the world was silent for {self._patience:g} s; start feasibee robot launch --ros"
            self.status, self.has_ended = GONE, True
        elif self.mind is None:
            self._hello.publish(UInt16(data=self.number))
        elif not self._is_under_way:
            if self._is_heard:
                self.tell_status()
        elif self._is_in_lockstep and self._now - self._answered_at > IDLE:
            self._answered_at = self._now
            self._hello.publish(UInt16(data=self.number))
            (self.say if self._is_in_step else self.tell_status)()

    def _take_orders(self, message: String) -> None:
        """Begin with the mind that the world gives it; end if it says so."""
        self._heard_at = self._now
        if not message.data or self.mind is not None:
            self.has_ended = not message.data
            return
        orders = json.loads(message.data)
        if "why" in orders:
            self.problem, self.status, self.has_ended = orders["why"], 2, True
            self.get_logger().error(self.problem)
            return
        self._period = orders["clock"]
        self.step = orders["settings"]["step"]
        self.mind = Node(orders, self.keep, strategy=self._strategy, brain=self._brain)
        self.reach = 0.0
        self.sense_with(Senses(orders["metres"], orders["detections"], simulated=True))

    @property
    def _is_heard(self) -> bool:
        """Whether it and the world have found each other; what is sent before comes seconds later."""
        says = self.topics["said"], self.topics["status"]
        return all(ear.get_publisher_count() for ear in self.ears) and all(
            each.get_subscription_count() for each in says
        )

    @property
    def _is_in_lockstep(self) -> bool:
        return self._period is None

    def has_sensed(self) -> None:
        """Begin the step of the world, or start the clock."""
        self._heard_at = self._now
        step = self.senses.step
        if not self._is_in_lockstep:
            if step >= 0 and not self._is_under_way:
                self._start_clock(self._period)
        elif step > self.step:
            if self._is_in_step:  # a robot that was silent hasn't heard anything
                self._heard = []
                self.end()
            self._answered_at = self._now
            self.begin(step)
        elif step == self.step and self._is_in_step:
            self.say()
        self._is_under_way |= step >= 0

    def _start_clock(self, clock: Mapping[str, float]) -> None:
        """Step by a clock that drifts, with steps of unequal length."""
        period, noise = clock["period"] * (1.0 + clock["drift"]), random.Random()

        def step() -> None:
            ticking.timer_period_ns = round(
                1e9 * period * (1.0 + clock["jitter"] * (2.0 * noise.random() - 1.0))
            )
            self.tick()

        ticking = self.each(period * max(noise.random(), 1e-3), step)

    def say(self) -> None:
        """Publish the message of this step; an empty one says that it is silent."""
        self.topics["said"].publish(frame_message(self.number, self.step, self._said or ""))

    def take(self, sender: int, step: int, text: str) -> None:
        """Keep a message; in lockstep, an empty one ends the step."""
        self._heard_at = self._now
        if text:
            self._heard.append([sender, text])
        elif step == self.step and self._is_in_step:
            self._answered_at = self._now
            self.end()
        else:
            self._heard = []
            if step == self.step:
                self.tell_status()

    def tell_status(self) -> None:
        """Publish all that it holds, with the step that has ended as the stamp."""
        assert self.mind is not None
        has_ended = self._is_under_way and not self._is_in_step
        self.topics["status"].publish(self.held(stamp_of(self.step), ends=has_ended))

    def keep(self, line: Any) -> None:
        """Write a line of its log, and publish it."""
        if self._file is not None:
            self._file.write(line)
        super().keep(line)


USAGE = """One robot of a field; feasibee robot launch --ros --no-robots is its world and waits for it.

Example:
  {program} --ros-args -r __ns:=/robot_3
"""


def join() -> None:
    """Run one robot of a field."""
    main(SimulatedRobot, USAGE)

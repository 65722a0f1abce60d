"""What robots' processes take, on Linux: docs/field.md.

With ``--ros``, robots are nodes of ROS 2, which the environment must have: docs/ros.md. The latency of a
topic is measured while they run, too.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time
from collections.abc import Mapping
from multiprocessing import get_context
from pathlib import Path
from statistics import median
from threading import Thread
from typing import Any

from feasibee import Scenario
from feasibee.field.plan import FieldPlan
from feasibee.field.supervisor import Field

QUICK = "--quick" in sys.argv
"""Whether only to try the code, with small numbers."""
ROS = "--ros" in sys.argv
ROBOTS, HZ = (4, 50.0) if QUICK else (20 if ROS else 50, 10.0)
FIRST, LAST = 20, 120
"""Steps between which the robots' use of processors is measured."""
MESSAGES = 5 if QUICK else 200
SIZE = 100
"""Bytes of a message for the latency."""
TICKS = os.sysconf("SC_CLK_TCK")


def answer() -> None:
    """Publish each message of the topic of questions on that of answers."""
    import rclpy
    from std_msgs.msg import UInt8MultiArray

    with rclpy.init():
        node = rclpy.create_node("answers")
        answers = node.create_publisher(UInt8MultiArray, "answers", 10)
        node.create_subscription(UInt8MultiArray, "questions", answers.publish, 10)
        rclpy.spin(node)


def topic_latency() -> float:
    """Return the median time of a message between two nodes in ms: half of that there and back."""
    import rclpy
    from std_msgs.msg import UInt8MultiArray

    other = get_context("spawn").Process(target=answer, daemon=True)
    other.start()
    times: list[float] = []
    with rclpy.init():
        node = rclpy.create_node("questions")
        questions = node.create_publisher(UInt8MultiArray, "questions", 10)
        heard: list[Any] = []
        answers = node.create_subscription(UInt8MultiArray, "answers", heard.append, 10)
        while not (questions.get_subscription_count() and answers.get_publisher_count()):
            rclpy.spin_once(node, timeout_sec=0.1)
        while len(times) < MESSAGES:
            time.sleep(0.1 / HZ)
            began, before = time.perf_counter(), len(heard)
            questions.publish(UInt8MultiArray(data=bytes(SIZE)))
            rclpy.spin_once(node, timeout_sec=1.0)
            if len(heard) == before + 1:  # an answer that comes later than a second doesn't count
                times.append(time.perf_counter() - began)
    other.kill()
    return 1000.0 * median(times) / 2.0


class Watch:
    """What the robots of a field take, by its events."""

    def __init__(self) -> None:
        self.began, self._before = time.monotonic(), loopback()
        self.joined = self.finding = 0.0
        self._seen: dict[int, tuple[float, float]] = {}
        self.megabytes: list[float] = []
        self._probe = Thread(target=self._measure)
        self.milliseconds = 0.0

    def _measure(self) -> None:
        self.milliseconds = topic_latency()

    def wait(self) -> None:
        """Wait until the latency is measured."""
        if ROS:
            self._probe.join()

    def tell(self, event: Mapping[str, Any]) -> None:
        """Keep when all robots have joined, and what their processes take at two steps."""
        if event["event"] == "joined":
            self.joined = time.monotonic() - self.began
            self.finding = (loopback() - self._before) / 1e6
        elif event["event"] == "step" and event["step"] in (FIRST, LAST):
            robots = [each for each in children(os.getpid()) if "field.robot" in command_of(each)]
            if event["step"] == FIRST and ROS:
                self._probe.start()
            self._seen[event["step"]] = time.monotonic(), sum(map(processor_seconds, robots))
            self.megabytes = [resident(each) for each in robots]

    @property
    def percent(self) -> float:
        """Share of a processor that one robot uses, in percent."""
        (began, before), (ended, after) = self._seen[FIRST], self._seen[LAST]
        return 100.0 * (after - before) / (ended - began) / ROBOTS


def loopback() -> int:
    """Return the bytes that the loopback has carried."""
    lines = Path("/proc/net/dev").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.lstrip().startswith("lo:"))


def children(process: int) -> list[int]:
    """Return the processes that a process has started."""
    return [int(each) for each in Path(f"/proc/{process}/task/{process}/children").read_text().split()]


def command_of(process: int) -> str:
    """Return the command line of a process."""
    return Path(f"/proc/{process}/cmdline").read_text()


def processor_seconds(process: int) -> float:
    """Return the time that a process has used processors."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def resident(process: int) -> float:
    """Return the memory of a process in megabytes, with its share of that which processes have in common."""
    lines = Path(f"/proc/{process}/smaps_rollup").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("Pss:")) * 1024 / 1e6


def figures() -> dict[str, Any]:
    """Return what is measured."""
    scenario = Scenario().replace(
        {"robots.count": ROBOTS, "run.steps": LAST + 20, "run.stop_at_decision": False}
    )
    plan = FieldPlan(scenario, 1, 0, False, HZ, 0.0, 0.0, 0.0, (), 20.0, 120.0)
    watch = Watch()
    package = "feasibee_ros.field" if ROS else "feasibee.field"
    with tempfile.TemporaryDirectory() as folder:
        result = Field(plan, Path(folder), watch.tell, package=package).run()
    watch.wait()
    return {
        "milliseconds": watch.milliseconds,
        "joined": watch.joined,
        "finding": watch.finding,
        "percent": watch.percent,
        "megabytes": median(watch.megabytes),
        "achieved_hz": result["achieved_hz"],
        "load": os.getloadavg()[0],
    }


if __name__ == "__main__":
    print(json.dumps({"robots": ROBOTS, **figures()}))

"""Latency of packets, and what robots' processes take over it, on Linux: docs/field.md."""

from __future__ import annotations

import json
import os
import socket
import sys
import tempfile
import time
from collections.abc import Mapping
from multiprocessing import get_context
from pathlib import Path
from statistics import median
from typing import Any

from feasibee import Scenario
from feasibee.field.connections import DEFAULT_HOST, Link, split_address
from feasibee.field.plan import Plan
from feasibee.field.supervisor import Field

QUICK = "--quick" in sys.argv
"""Whether only to try the code, with small numbers."""
ROBOTS, HZ = (4, 50.0) if QUICK else (50, 10.0)
FIRST, LAST = 20, 120
"""Steps between which the robots' use of processors is measured."""
PACKETS = 50 if QUICK else 2_000
SIZE = 100
"""Bytes of a packet for the latency."""
TICKS = os.sysconf("SC_CLK_TCK")


def echo(address: str) -> None:
    """Send each packet of the world back to it, until an empty one comes."""
    link = Link(*split_address(address), listens=False)
    received = None
    while received is None:  # until the world answers
        link.send(b"here")
        received = link.receive(0.05)
    while received is None or received[0]:
        if received is not None:
            link.send(received[0])
        received = link.receive(1.0)
    link.close()


def latency() -> float:
    """Return the median time of a packet between two processes in ms: half of that there and back."""
    with socket.socket() as probe:
        probe.bind((DEFAULT_HOST, 0))
        port = probe.getsockname()[1]
    world = Link(DEFAULT_HOST, port, listens=True)
    other = get_context("spawn").Process(target=echo, args=(world.address,))
    other.start()
    while (received := world.receive(1.0)) is None:
        pass
    peer = received[1]
    times: list[float] = []
    while len(times) < PACKETS:
        began = time.perf_counter()
        packet = f"{len(times)}".encode().ljust(SIZE)
        world.send(packet, peer)
        while (received := world.receive(1.0)) is not None and received[0] != packet:
            pass  # one of those before the first answer
        if received is not None:
            times.append(time.perf_counter() - began)
    while other.is_alive():
        world.send(b"", peer)
        other.join(0.1)
    world.close()
    return 1000.0 * median(times) / 2.0


class Watch:
    """What the robots of a field take, by its events."""

    def __init__(self) -> None:
        self.began = time.monotonic()
        self.joined = 0.0
        self._seen: dict[int, tuple[float, float]] = {}
        self.megabytes: list[float] = []

    def tell(self, event: Mapping[str, Any]) -> None:
        """Keep when all robots have joined, and what their processes take at two steps."""
        if event["event"] == "joined":
            self.joined = time.monotonic() - self.began
        elif event["event"] == "step" and event["step"] in (FIRST, LAST):
            (nursery,) = (each for each in children(os.getpid()) if "field.robot" in command_of(each))
            robots = children(nursery)
            self._seen[event["step"]] = time.monotonic(), sum(map(processor_seconds, robots))
            self.megabytes = [resident(each) for each in robots]

    @property
    def percent(self) -> float:
        """Share of a processor that one robot uses, in percent."""
        (began, before), (ended, after) = self._seen[FIRST], self._seen[LAST]
        return 100.0 * (after - before) / (ended - began) / ROBOTS


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
        {"robots.count": ROBOTS, "run.steps": LAST + 1, "run.stop_at_decision": False}
    )
    plan = Plan(scenario, 1, 0, False, HZ, 0.0, 0.0, 0.0, (), 20.0, 120.0)
    watch = Watch()
    with tempfile.TemporaryDirectory() as folder:
        result = Field(plan, Path(folder), watch.tell).run()
    return {
        "milliseconds": latency(),
        "joined": watch.joined,
        "percent": watch.percent,
        "megabytes": median(watch.megabytes),
        "achieved_hz": result["achieved_hz"],
        "load": os.getloadavg()[0],
    }


if __name__ == "__main__":
    print(json.dumps({"robots": ROBOTS, **figures()}))

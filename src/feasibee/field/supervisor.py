"""The field itself: it starts the processes, causes their faults, and ends them all."""

from __future__ import annotations

import json
import os
import secrets
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from feasibee.errors import FeasibeeError
from feasibee.field.connections import DEFAULT_HOST, join_address, split_address
from feasibee.field.errands import check_tasks
from feasibee.field.logs import log_folder, remove_older
from feasibee.field.plan import RESTART, Plan, plain_plan
from feasibee.field.robot import KEY_VARIABLE, SIGNALS

GRACE = 2.0
"""Seconds that processes have to end by themselves."""

Process = subprocess.Popen[str]


class Field:
    """The processes of one field.

    Parameters
    ----------
    plan : Plan
        The scenario, the clock of its robots, and the faults.
    folder : Path, optional
        Where the logs of the world and of the robots that are started here go. Without it, the world's log is
        temporary, and robots write none.
    tell : callable
        Takes each event, for people.
    host, port : str and int
        Where the world listens; port 0 takes a free one.
    key : str
        The shared key; empty for none.
    starts_robots : bool
        Whether the robots are started here; otherwise they join from elsewhere.
    brain : Path, optional
        The program in C of the robots that are started here: what `brain.compiled` made.
    package : str
        Where the programs ``world`` and ``robot`` are, which may talk in another way than by UDP.
    """

    def __init__(
        self,
        plan: Plan,
        folder: Path | None,
        tell: Callable[[Mapping[str, Any]], None],
        *,
        host: str = DEFAULT_HOST,
        port: int = 0,
        key: str = "",
        starts_robots: bool = True,
        brain: Path | None = None,
        package: str = "feasibee.field",
    ) -> None:
        if plan.scenario.robots.work is not None:
            rule = "robots of a field don't charge; leave out robots.work and robots.charge"
            raise FeasibeeError(f"robots.work = {plan.scenario.robots.work}: {rule}")
        check_tasks(plan.scenario)
        if plan.scenario.acts and any(fault.kind == RESTART for fault in plan.faults):
            rule = "a world that starts again doesn't know who has which task; leave out acting.start"
            raise FeasibeeError(f"--restart-world with [acting]: {rule}")
        self._plan, self._named, self._tell = plan, folder, tell
        self._host, self._port, self._starts_robots, self._brain = host, port, starts_robots, brain
        self._package = package
        self._session = secrets.randbits(63) + 1
        self._environment = {**os.environ, KEY_VARIABLE: key}
        self._world: Process | None = None
        self._nursery: Process | None = None
        self._started: set[int] = set()
        self._joined_at = time.monotonic()

    def run(self) -> dict[str, Any]:
        """Run the field to its end; return its result.

        Raise a FeasibeeError if the world or the robots can't start or go on, or don't join, or another
        process writes logs to the same folder.
        """
        with log_folder(self._named) as self._folder:
            with self._ending():
                result = self._play()
            if self._starts_robots:
                remove_older(self._folder, self._started)
        return result

    def _play(self) -> dict[str, Any]:
        """Start the world, and follow it to its result; return that with the time that the field took."""
        self._start_world(resumes=False)
        for event in self._events():
            self._follow(event)
            if event["event"] == "result":
                self._tell_robots("end", [])
                seconds = time.monotonic() - self._joined_at
                took = {"seconds": round(seconds, 3), "achieved_hz": round(event["steps"] / seconds, 3)}
                return {name: value for name, value in event.items() if name != "event"} | took
            if event["event"] == "error":
                raise FeasibeeError(str(event["why"]))
        raise FeasibeeError("the world's process ended without a result; run the field again")

    def _follow(self, event: Mapping[str, Any]) -> None:
        """Act on an event of the world."""
        self._tell(event)
        if event["event"] == "listening":
            host, self._port = split_address(event["address"])  # a world that starts again keeps the port
            if self._starts_robots and self._nursery is None:
                self._started.update(event["robots"])
                self._start_robots(host, event["robots"])
        elif event["event"] == "comes" and event["robot"] not in self._started:
            self._started.add(event["robot"])  # a world that starts again says it once more
            self._tell_robots("start", [event["robot"]])
        elif event["event"] == "joined":
            self._joined_at = time.monotonic()
        elif event["event"] == "fault":
            self._cause(event)

    def _cause(self, fault: Mapping[str, Any]) -> None:
        """Cause a fault of processes, and let the world go on."""
        if fault["kind"] in SIGNALS:
            self._tell_robots(fault["kind"], fault["robots"])
            _write(self._world, "go\n")
        elif fault["kind"] == RESTART and self._world is not None:
            self._world.kill()
            self._world.wait()
            _close(self._world)
            self._start_world(resumes=True)

    def _tell_robots(self, command: str, numbers: Iterable[int]) -> None:
        """Have robots started, killed, stopped or continued; wait until it has happened."""
        if self._nursery is not None:
            _write(self._nursery, " ".join([command, *map(str, numbers)]) + "\n")
            self._hear_nursery("done")

    def _hear_nursery(self, expected: str = "") -> None:
        """Read a line of the nursery, which only answers, or else says why it ends."""
        assert self._nursery is not None
        assert self._nursery.stdout is not None
        line = self._nursery.stdout.readline().strip()
        if line != expected or not line:
            raise FeasibeeError(line or "the process that starts robots has ended; run the field again")

    def _start_world(self, *, resumes: bool) -> None:
        order = {
            "plan": plain_plan(self._plan),
            "host": self._host,
            "port": self._port,
            "session": self._session,
            "log": str(self._folder / "world.jsonl"),
            "temporary": self._named is None,
            "resumes": resumes,
        }
        self._world = self._begun("world", order)

    def _start_robots(self, host: str, numbers: list[int]) -> None:
        manifest = self._plan.scenario.manifest
        host = DEFAULT_HOST if host in ("0.0.0.0", "::") else host
        order = {
            "connect": join_address(host, self._port),
            "numbers": numbers,
            "patience": max(20.0, 4 * self._plan.patience),
            "strategy_file": manifest.name if manifest.source else None,
            "logs": str(self._named or ""),
            "brain": str(self._brain or ""),
        }
        self._nursery = self._begun("robot", order)

    def _begun(self, module: str, order: Mapping[str, Any]) -> Process:
        """Start a process of the field, and write its order to its standard input."""
        process = subprocess.Popen(
            [sys.executable, "-m", f"{self._package}.{module}"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=self._environment,
            process_group=0,  # Ctrl-C reaches the field, which ends its processes
        )
        _write(process, json.dumps(order) + "\n")
        return process

    def _events(self) -> Iterator[dict[str, Any]]:
        """Yield the world's events; after a restart those of the new process."""
        unread = b""
        while True:
            world, nursery = self._world, self._nursery
            assert world is not None
            assert world.stdout is not None
            pipes = [world.stdout, *([nursery.stdout] if nursery is not None and nursery.stdout else [])]
            ready = select.select(pipes, [], [])[0]
            if nursery is not None and nursery.stdout in ready:
                self._hear_nursery()
            if world.stdout in ready:
                read = os.read(world.stdout.fileno(), 65_536)
                if not read:
                    return
                *lines, unread = (unread + read).split(b"\n")
                yield from map(json.loads, lines)

    @contextmanager
    def _ending(self) -> Iterator[None]:
        """End all processes, whatever happens."""
        grace = 0.0
        try:
            yield
            grace = GRACE
        finally:
            for process in (self._world, self._nursery):
                if process is not None:
                    _end(process, grace)


def _write(process: Process | None, text: str) -> None:
    """Write to a process; one that has ended needs nothing."""
    if process is not None and process.stdin is not None:
        with suppress(BrokenPipeError):
            process.stdin.write(text)
            process.stdin.flush()


def _end(process: Process, grace: float) -> None:
    """Wait for a process so many seconds; then close its input, and kill its group if it doesn't end."""
    with suppress(subprocess.TimeoutExpired):
        process.wait(grace)
    _close(process)
    with suppress(subprocess.TimeoutExpired):
        process.wait(GRACE)
    if process.returncode is None or process.returncode < 0:
        with suppress(ProcessLookupError):  # robots that are stopped don't notice that the nursery has ended
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def _close(process: Process) -> None:
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            with suppress(OSError):
                pipe.close()

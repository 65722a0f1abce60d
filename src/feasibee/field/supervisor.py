"""The field itself: it starts the processes, causes their faults, and ends them all."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from selectors import EVENT_READ, DefaultSelector
from tempfile import TemporaryDirectory
from typing import Any, Final

from feasibee.base.errors import FeasibeeError
from feasibee.field.errands import check_tasks
from feasibee.field.logs import locked, remove_older
from feasibee.field.plan import KILL, PAUSE, RESUME, FieldPlan, plain_plan

GRACE: Final = 2.0
"""Seconds that processes have to end by themselves."""
SIGNALS: Final = {KILL: "SIGKILL", PAUSE: "SIGSTOP", RESUME: "SIGCONT"}
"""Faults of robots' processes, and how they are caused."""
WORLD: Final = -1
"""Stands for the world where robots have their numbers."""

Process = subprocess.Popen[str]


class Field:
    """The processes of one field, all in the group of the world's process, which ends them if this one dies.

    ``folder`` is where the logs of the world and of the robots that are started here go. Without it, the
    world's log is temporary, and robots write none. ``tell`` takes each event, for people.

    Unless ``starts_robots``, robots join by themselves; else their program in C is ``brain``, if any.
    ``package`` has the programs ``world`` and ``robot``, which may talk by another network.
    """

    def __init__(
        self,
        plan: FieldPlan,
        folder: Path | None,
        tell: Callable[[Mapping[str, Any]], None],
        *,
        starts_robots: bool = True,
        brain: Path | None = None,
        package: str = "feasibee.field",
    ) -> None:
        if plan.scenario.robots.work is not None:
            rule = "robots of a field don't charge; leave out robots.work and robots.charge"
            raise FeasibeeError(f"robots.work = {plan.scenario.robots.work}: {rule}")
        check_tasks(plan.scenario)
        self._plan, self._folder, self._tell = plan, folder, tell
        self._starts_robots, self._brain, self._package = starts_robots, brain, package
        self._processes: dict[int, Process] = {}
        self._selector = DefaultSelector()
        self._address = ""
        self._joined_at = time.monotonic()

    def run(self) -> dict[str, Any]:
        """Run the field to its end; return its result.

        Raise a FeasibeeError if the world or the robots can't start or go on, or don't join, or another
        process writes logs to the same folder.
        """
        about: Any = {"prefix": "feasibee-field-", "ignore_cleanup_errors": True}
        with locked(self._folder), TemporaryDirectory(**about) as temporary:
            with self._ending():
                result = self._play(Path(temporary))
            if self._folder is not None and self._starts_robots:
                remove_older(self._folder, self._processes.keys())
        return result

    def _play(self, temporary: Path) -> dict[str, Any]:
        """Start the world, and follow it to its result; return that with the time that the field took."""
        log = str((self._folder or temporary) / "world.jsonl")
        order = {"plan": plain_plan(self._plan), "log": log, "temporary": str(temporary)}
        self._start(WORLD, "world")
        self._write(order)
        for event in self._events():
            self._follow(event)
            if event["event"] == "result":
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
            self._address = event["address"]
            for number in event["robots"]:
                self._start_robot(number)
        elif event["event"] == "comes":
            self._start_robot(event["robot"])
        elif event["event"] == "joined":
            self._joined_at = time.monotonic()
        elif event["event"] == "fault" and event["kind"] in SIGNALS:
            for number in event["robots"]:
                self._processes[number].send_signal(getattr(signal, SIGNALS[event["kind"]]))
                if event["kind"] == KILL:
                    self._processes[number].wait()
            self._write("go")

    def _start_robot(self, number: int) -> None:
        if not self._starts_robots:
            return
        manifest = self._plan.scenario.manifest
        order = {
            "connect": self._address,
            "number": number,
            "patience": max(20.0, 4 * self._plan.patience),  # of robots that don't notice the world's end
            "strategy_file": manifest.name if manifest.source else None,
            "logs": str(self._folder or ""),
            "brain": str(self._brain or ""),
        }
        self._start(number, "robot", json.dumps(order))

    def _start(self, number: int, module: str, *arguments: str) -> None:
        """Start a process of the field."""
        group = self._processes[WORLD].pid if self._processes else 0
        try:
            process = subprocess.Popen(
                [sys.executable, "-m", f"{self._package}.{module}", *arguments],
                stdin=subprocess.DEVNULL if self._processes else subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
                process_group=group,  # Ctrl-C reaches the field, which ends its processes
            )
        except OSError as error:
            raise FeasibeeError(f"feasibee robot launch: can't start a process: {error.strerror}") from None
        self._processes[number] = process
        assert process.stdout is not None
        self._selector.register(process.stdout, EVENT_READ, number)

    def _write(self, line: Any) -> None:
        """Write a line to the world, unless it has ended."""
        pipe = self._processes[WORLD].stdin
        assert pipe is not None
        with suppress(BrokenPipeError):
            pipe.write(json.dumps(line) + "\n")
            pipe.flush()

    def _events(self) -> Iterator[dict[str, Any]]:
        """Yield the world's events, until it ends; heed what robots say meanwhile."""
        unread = b""
        while True:
            for key, _ in self._selector.select():
                read = os.read(key.fd, 65_536)
                if key.data != WORLD:
                    self._hear(key.data, read)
                elif not read:
                    return
                else:
                    *lines, unread = (unread + read).split(b"\n")
                    yield from map(json.loads, lines)

    def _hear(self, number: int, read: bytes) -> None:
        """Raise what a robot says, which is why the field can't go on; name the signal that has ended it."""
        if read:
            raise FeasibeeError(read.decode().partition("\n")[0])
        process = self._processes[number]
        self._selector.unregister(process.stdout)  # type: ignore[arg-type]
        status = process.wait()
        if status < 0 and status != -signal.SIGKILL:  # not by a fault
            print(f"feasibee: robot {number}: ended by {signal.Signals(-status).name}", file=sys.stderr)

    @contextmanager
    def _ending(self) -> Iterator[None]:
        """End all processes, whatever happens; after a result, they may end by themselves."""
        until = 0.0
        try:
            yield
            until = time.monotonic() + GRACE
        finally:
            for process in self._processes.values():
                with suppress(subprocess.TimeoutExpired):
                    process.wait(max(0.0, until - time.monotonic()))
            for process in self._processes.values():
                process.kill()
                process.wait()
                for pipe in (process.stdin, process.stdout):
                    if pipe is not None:
                        with suppress(OSError):
                            pipe.close()
            self._selector.close()

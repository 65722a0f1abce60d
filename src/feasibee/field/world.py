"""The process of a field's world: bodies, sight, radio, and the robots that joined.

It is in lockstep, or robots step by their own clocks. Its plan comes on standard input, its events go to
standard output.
"""

from __future__ import annotations

import heapq
import itertools
import json
import os
import random
import secrets
import shutil
import signal
import sys
import time
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, closing
from pathlib import Path
from statistics import median
from threading import Semaphore, Thread
from typing import Any

import numpy as np

from feasibee.base.codes import DECISIONS, UNDECIDED
from feasibee.base.errors import FeasibeeError
from feasibee.base.record import Record
from feasibee.field.bodies import Bodies, Body
from feasibee.field.connections import (
    BYE,
    DIED,
    END,
    HEARD,
    HELLO,
    REFUSED,
    SAID,
    SIGHT,
    STEP,
    TICK,
    WELCOME,
    Connections,
    Frame,
)
from feasibee.field.logs import VERSION, LineLog
from feasibee.field.plan import PARTITION, PROCESS, ROBOTS_LIMIT, FieldPlan, plan_from
from feasibee.field.robot import own_output
from feasibee.reference.swarm import WORKED
from feasibee.results.measures import tracked


class World:
    """The world's side of a field, without its clock.

    ``report`` takes events, as mappings, for whoever watches. ``wait_for_go`` returns once a fault of
    processes has happened.
    """

    def __init__(
        self,
        plan: FieldPlan,
        server: Connections,
        report: Callable[[Mapping[str, Any]], None],
        log: Path,
        wait_for_go: Callable[[], object] = lambda: None,
    ) -> None:
        if plan.scenario.most.robots > ROBOTS_LIMIT:
            raise FeasibeeError(f"robots: a field has at most {ROBOTS_LIMIT:,}; use fewer")
        self.plan, self.server, self.report = plan, server, report
        self.bodies = Bodies(plan.scenario, plan.seed, plan.run)
        self.step = 0
        self.decision, self.decision_step = UNDECIDED, -1
        self._tracked: list[tuple[int, int]] = []
        """The truth and the opinion held, at each step."""
        self._channels: dict[int, Any] = {}
        self._waiting: dict[int, Any] = {}
        """Channels of robots from elsewhere that come later."""
        self._is_complete = False
        """Whether all robots have joined."""
        self._wait_for_go = wait_for_go
        self._cut_until = -1.0
        """The step until which the two halves of the swarm don't hear each other."""
        self._faults = list(plan.faults)
        self.said: dict[int, str | None] = {}
        self.session = secrets.token_hex(8)
        """Random digits, which distinguish two fields in one folder."""
        self.log = LineLog(log)
        self._write_head()

    def _write_head(self) -> None:
        """Write which field this is."""
        plan, scenario = self.plan, self.plan.scenario
        recipe = {"scenario": scenario.to_toml(), "source": scenario.manifest.source}
        which = {"seed": plan.seed, "run": plan.run, "lockstep": plan.lockstep, "hz": plan.hz}
        session = {"session": self.session}
        self.log.write({"feasibee": "field", "version": VERSION, **recipe, **which, **session})

    def gather(self) -> None:
        """Wait until all robots have joined and are ready.

        Raise a FeasibeeError if some don't come in time.
        """
        missing = [body.process for body in self._wait_for(self.bodies.bodies)]
        if missing:
            shown = ", ".join(map(str, missing[:10])) + (" and more" if len(missing) > 10 else "")
            raise FeasibeeError(
                f"robots {shown}: did not join within {self.plan.wait:g} s; start them, or raise --wait"
            )
        self._is_complete = True
        self.report({"event": "joined", "robots": len(self.bodies.bodies)})

    def _wait_for(self, bodies: list[Body]) -> list[Body]:
        """Wait until robots have joined and are ready; return those that don't come in time."""
        missing = {body.process for body in bodies}
        until = time.monotonic() + self.plan.wait
        while missing and time.monotonic() < until:
            frame = self.receive(0.2)
            if frame is not None and frame.kind == SAID:
                body = self.body(frame)
                if body.process in missing:
                    self.bodies.report(body, frame.body)
                    missing.discard(body.process)
                self.answer(body)
            elif frame is not None and frame.kind == DIED:
                missing.discard(frame.channel.robot)
        return [body for body in bodies if body.process in missing]

    def change(self, *, waits: bool) -> list[Body]:
        """Let the world change at the beginning of a step; return the bodies that join.

        The processes of robots that leave end. ``waits`` is whether to wait for those that begin.
        """
        left, joined = self.bodies.change(self.step)
        for body in left:
            self._tell("leaves", body)
            self.send(body, BYE, {})
        for body in joined:
            if body.process >= ROBOTS_LIMIT:
                raise FeasibeeError(
                    f"robots: more than {ROBOTS_LIMIT:,} have come to this field; use fewer steps"
                )
            self._tell("comes", body)
            if body.process in self._waiting:
                self._join(body.process, self._waiting.pop(body.process))
        for body in self._wait_for(joined) if waits else ():
            self.lose(body)
        return joined

    def receive(self, timeout: float) -> Frame | None:
        """Return the next message of a robot that has joined; answer those that join."""
        frame = self.server.receive(timeout)
        if frame is None:
            return None
        if frame.kind == HELLO:
            self._join(frame.body["robot"], frame.channel)
        elif frame.channel.robot < 0:
            self._waiting = {each: who for each, who in self._waiting.items() if who is not frame.channel}
        elif self.body(frame).has_left:
            self.send(self.body(frame), BYE, {})  # again, to who hasn't heard it
        elif frame.kind != DIED:
            return frame
        elif not self._is_complete:
            rule = "ended before the first step; read above what it said, and run the field again"
            raise FeasibeeError(f"robot {frame.channel.robot}: {rule}")
        elif not self.body(frame).lost:
            self.lose(self.body(frame), "died")
            return frame
        return None

    def _join(self, number: int, channel: Any) -> None:
        """Welcome a robot with its settings, let it wait until it comes, or say why it can't join."""
        count, why = len(self.bodies.everyone), ""
        if number >= count and self.plan.scenario.dynamic:
            self._waiting[number] = channel
            return
        if number >= count:
            why = f"this field has robots 0 to {count - 1}; use one of these as --id"
        elif self.bodies.everyone[number].has_left:
            why = "the robot of this number has left; use another --id"
        elif self._channels.get(number, channel) is not channel:
            why = "a robot of this number has joined already; use another --id"
        if why:
            self.server.send(channel, REFUSED, {"why": why})
            return
        channel.robot, self._channels[number] = number, channel
        body = self.bodies.everyone[number]
        self.send(body, WELCOME, self._welcome(body))

    def _welcome(self, body: Body) -> dict[str, Any]:
        plan = self.plan
        clock = None
        if not plan.lockstep:
            # Not a draw of the model: clocks differ between fields of the same seed.
            drift = random.Random(f"{self.session} {body.process}").uniform(-plan.drift, plan.drift)
            clock = {"period": 1.0 / plan.hz, "drift": drift, "jitter": plan.jitter}
        orders = self.bodies.orders(body)
        orders["settings"]["step"] = max(0, self.step - 1)  # in free running, starting has taken some steps
        return {"clock": clock, **orders}

    def send(self, body: Body, kind: str, content: dict[str, Any]) -> None:
        """Send a message to a robot, if it has joined."""
        if body.process in self._channels:
            self.server.send(self._channels[body.process], kind, content)

    def body(self, frame: Frame) -> Body:
        """Return the body of the robot that sent a message."""
        body: Body = self.bodies.everyone[frame.channel.robot]
        return body

    def answer(self, body: Body) -> None:
        """Let a robot know that the world is there; one that was silent takes part again."""
        if body.lost:
            self.find(body)
        self.send(body, WELCOME, self._welcome(body))

    def reaches(self, sender: Body, receiver: Body) -> bool:
        """Return whether a message arrives: within range, not lost, and not cut off."""
        if sender is receiver:
            return False
        half = self.plan.scenario.robots.count // 2
        if self.step < self._cut_until and (sender.number < half) != (receiver.number < half):
            return False
        return self.bodies.hears(receiver, sender)

    def cause_faults(self) -> None:
        """Let the faults of this step happen."""
        while self._faults and self._faults[0].step <= self.step:
            fault = self._faults.pop(0)
            if fault.kind == PARTITION:
                self._cut_until = max(self._cut_until, fault.step + fault.lasts)
            event = {"event": "fault", **fault._asdict()}
            self.log.write(event)
            self.report(event)
            if fault.kind in PROCESS:
                self._wait_for_go()

    def lose(self, body: Body, why: str = "lost") -> None:
        """Count a robot no longer that is silent, or has ``died``."""
        body.lost, body.knows = True, None
        self._tell(why, body)

    def find(self, body: Body) -> None:
        """Count a robot again that was silent."""
        body.lost = False
        self._tell("back", body)

    def _tell(self, what: str, body: Body) -> None:
        event = {"event": what, "robot": body.process, "step": self.step}
        self.report(event)
        self.log.write(event)

    def look(self, step: int) -> None:
        """Record a step: states of the bodies, opinions, messages, and the decision if it is new."""
        self.bodies.time = step
        decision = self.bodies.decision
        if self.decision == UNDECIDED != decision:
            self.decision, self.decision_step = decision, step
        self._tracked.append((self.bodies.truth, decision))
        counts = {"feasible": self.bodies.feasible_count, "infeasible": self.bodies.infeasible_count}
        self.report({"event": "step", "step": step, **counts})
        there, work = self.bodies.bodies, self.bodies.work
        puts = self.plan.scenario.puts
        has = [(each.errand.target, each.errand.task, each.errand.mark) for each in there]
        self.log.write(
            {
                "step": step,
                "bodies": [body.state() for body in there],
                "minds": [body.remote.status for body in there],
                "said": [self.said.get(body.process) for body in there],
                "lost": [body.number for body in there if body.lost],
                "decision": [self.decision, self.decision_step],
                "robots": [body.number for body in there],
                "processes": [body.process for body in there],
                "tasks": list(self.bodies.tasks),
                "truth": self.bodies.truth,
                **({"goes": has, "done": sorted(work.done)} if work else {}),
                **({"placed": [[i, *place] for i, place in self.bodies.tasks.items()]} if puts else {}),
            }
        )

    @property
    def is_over(self) -> bool:
        """Whether the run ends, as that of a simulated swarm does."""
        return self.bodies.is_over(self.decision != UNDECIDED)

    def end(self) -> dict[str, Any]:
        """Let the robots go; return the result."""
        for body in self.bodies.bodies:
            self.send(body, BYE, {})
        for channel in self._waiting.values():
            self.server.send(channel, BYE, {})
        self.log.write({"event": "end"})
        self.log.close()
        measures: dict[str, Any] = {}
        if self.plan.scenario.dynamic:
            record = Record.empty(0, 1, 0, len(self._tracked))
            record.truth[0], record.held[0] = np.array(self._tracked).T
            measures = tracked(record, self.plan.scenario)
        if work := self.bodies.work:
            measures["acting"] = {name: getattr(work, name) for name in WORKED}
        return {
            "decision": DECISIONS[self.decision],
            "decision_step": self.decision_step if self.decision != UNDECIDED else None,
            "steps": self.step,
            "robots": len(self.bodies.bodies),
            "feasible": self.bodies.feasible_count,
            "infeasible": self.bodies.infeasible_count,
            "lost": [body.process for body in self.bodies.bodies if body.lost],
            **measures,
        }


class Lockstep(World):
    """A field in lockstep, with two exchanges per step.

    A robot begins the step with what it sees, and says its message. It ends the step with the messages that
    it heard, and reports its opinion.
    """

    def play(self) -> None:
        """Play all steps."""
        self._air: dict[int, list[tuple[Body, str]]] = {}
        self.look(0)
        while not (self.is_over or self.step == self.plan.scenario.run.steps):
            self._begin()
            self._end()
            self.look(self.step)

    def _begin(self) -> None:
        """Begin the next step: let the world change, move the bodies, and let each robot see and speak."""
        self.step += 1
        self.cause_faults()
        self.change(waits=True)
        self._begun = [body for body in self.bodies.bodies if body.works(self.step)]
        self.bodies.advance(self._begun)
        self.said = self._ask(STEP, {body.process: self.bodies.sight_of(body) for body in self._begun})

    def _end(self) -> None:
        """End the step with its messages, or delayed ones; the robots report their opinions."""
        delayed = self._air.setdefault(self.step + round(self.plan.message_delay), [])
        everyone = self.bodies.everyone
        delayed.extend((everyone[each], text) for each, text in sorted(self.said.items()) if text is not None)
        arriving = [
            (each, text)
            for each, text in self._air.pop(self.step, [])
            if each.works(self.step) and not each.has_left
        ]
        orders = {}
        for receiver in self._begun:
            if not receiver.lost:
                heard = [[each.number, text] for each, text in arriving if self.reaches(each, receiver)]
                orders[receiver.process] = {"heard": heard}
        self._ask(END, orders)

    def _ask(self, kind: str, orders: Mapping[int, dict[str, Any]]) -> dict[int, str | None]:
        """Send each robot its order, and wait until it answers or is lost; return the messages."""
        everyone = self.bodies.everyone
        said: dict[int, str | None] = {}
        waiting = set(orders)
        for number in sorted(waiting):
            self.send(everyone[number], kind, {"t": self.step, **orders[number]})
        until = time.monotonic() + self.plan.patience
        while waiting and (left := until - time.monotonic()) > 0:
            frame = self.receive(left)
            if frame is None:
                continue
            number = frame.channel.robot
            if frame.kind == DIED:
                waiting.discard(number)
            elif number not in orders:
                self.answer(everyone[number])
            elif (frame.body["t"], frame.body["ends"]) == (self.step, kind == END) and number in waiting:
                self.bodies.report(everyone[number], frame.body)
                said[number] = frame.body["said"]
                waiting.discard(number)
        for number in sorted(waiting):
            self.lose(everyone[number])
        return said


AIR_LIMIT = 100_000
"""Largest number of messages under way; more are left out."""


class FreeRunning(World):
    """A field whose robots have clocks of their own.

    A robot's tick moves its body by one step; the other bodies stand meanwhile. Its message reaches the
    robots in range at this moment, after the delay.
    """

    def play(self) -> None:
        """Play until the robots have done all steps, by the median of their clocks."""
        now = self._passed_at = time.monotonic()
        self._ticks = {body.process: self.step for body in self.bodies.bodies}
        self._seen_at = {body.process: now for body in self.bodies.bodies}
        self._air: list[tuple[float, int, int, list[object]]] = []
        self._order = itertools.count()
        self.look(0)
        for body in self.bodies.bodies:
            self._show(body)
        while self.step < self.plan.scenario.run.steps and not self.is_over:
            frame = self.receive(self._time_to_wait())
            if frame is not None:
                self._take(frame)
            self._deliver()
            self._lose_silent()
            self._pass_steps()

    def _time_to_wait(self) -> float:
        """Return the seconds until a message arrives, at most a step."""
        longest = 1.0 / self.plan.hz
        if not self._air:
            return longest
        return min(longest, max(0.0, self._air[0][0] - time.monotonic()))

    def _take(self, frame: Frame) -> None:
        """Simulate a robot's step: move its body, pass its message on, send it what it sees."""
        if frame.kind == DIED:
            return
        body, step = self.body(frame), frame.body["t"]
        self._seen_at[body.process] = time.monotonic()
        if body.lost:
            self.find(body)
        if frame.kind == SAID:  # it waits for the start
            self._show(body)
            return
        if frame.kind != TICK or step <= self._ticks.get(body.process, 0):
            return
        self._ticks[body.process] = self.bodies.time = step
        self.bodies.report(body, frame.body)
        if body.works(step):
            self.bodies.advance([body])
            self._send_around(body, frame.body["said"])
        self._show(body)

    def _send_around(self, sender: Body, text: str | None) -> None:
        """Send a message on its way to all robots in range."""
        self.said[sender.process] = text
        if text is None:
            return
        arrives = time.monotonic() + self.plan.message_delay / self.plan.hz
        for receiver in self.bodies.bodies:
            if receiver.works(self.bodies.time) and self.reaches(sender, receiver):
                if len(self._air) >= AIR_LIMIT:
                    return
                heard: list[object] = [sender.number, text]
                heapq.heappush(self._air, (arrives, next(self._order), receiver.process, heard))

    def _deliver(self) -> None:
        """Deliver the messages whose time has come."""
        now = time.monotonic()
        while self._air and self._air[0][0] <= now:
            _, _, number, heard = heapq.heappop(self._air)
            receiver = self.bodies.everyone[number]
            if not receiver.has_left:
                self.send(receiver, HEARD, {"heard": heard})

    def _show(self, body: Body) -> None:
        """Send a robot its place and what it sees."""
        self.send(body, SIGHT, self.bodies.sight_of(body))

    def _lose_silent(self) -> None:
        """Count the robots no longer that have been silent for too long."""
        now = time.monotonic()
        for body in self.bodies.bodies:
            if not body.lost and now - self._seen_at[body.process] > self.plan.patience:
                self.lose(body)

    def _pass_steps(self) -> None:
        """Advance to the median of the robots' clocks."""
        now = self._median_step()
        while self.step < now and not self.is_over:
            self._passed_at = time.monotonic()
            self.step += 1
            self.cause_faults()
            for body in self.change(waits=False):
                self._seen_at[body.process] = self._passed_at
            self.look(self.step)

    def _median_step(self) -> int:
        """Return the median of the robots' clocks; without any, that of the world until a robot comes."""
        numbers = [body.process for body in self.bodies.bodies if not body.lost]
        ticks = [self._ticks[number] for number in numbers if number in self._ticks]
        last = self.plan.scenario.run.steps
        if ticks:
            return min(int(median(ticks)), last)
        if not self.plan.scenario.dynamic:
            return last
        return self.step + (time.monotonic() - self._passed_at >= 1.0 / self.plan.hz)


def _serve(order: Mapping[str, Any]) -> AbstractContextManager[Connections]:
    """Listen for robots in the temporary folder of an order."""
    return closing(Connections(Path(order["temporary"])))


Serve = Callable[[Mapping[str, Any]], AbstractContextManager[Any]]
"""Gives the world's side of the connections with the robots, such as a `Connections`, for an order."""


def main(serve: Serve = _serve) -> None:
    """Run the world of the order on standard input; report its result or its error as an event."""
    signal.signal(signal.SIGHUP, signal.SIG_IGN)  # comes as the field is killed while a robot is stopped
    parent, line = own_output(), sys.stdin.buffer.readline()
    order = json.loads(line) if line.endswith(b"\n") else sys.exit(1)
    ready = Semaphore(0)

    def report(event: Mapping[str, Any]) -> None:
        parent.write(f"{json.dumps(event)}\n")

    follower = Thread(target=_follow_parent, args=(order["temporary"], ready), daemon=True)
    follower.start()
    try:
        try:
            _run(order, serve, ready, report)
        except FeasibeeError as error:
            report({"event": "error", "why": str(error)})
            sys.exit(2)
    except BrokenPipeError:  # the field has ended
        follower.join()


def _follow_parent(temporary: str, ready: Semaphore) -> None:
    """Release ``ready`` for each line of the field; when the field has ended, end all its processes.

    These are the group of this process. A robot that is stopped ends in no other way.
    """
    while read := os.read(sys.stdin.fileno(), 4096):  # not a file object: the exit would wait for its lock
        ready.release(read.count(b"\n"))
    shutil.rmtree(temporary, ignore_errors=True)
    if os.getpgid(0) == os.getpid():
        os.killpg(0, signal.SIGKILL)
    os._exit(1)


def _run(
    order: Mapping[str, Any], serve: Serve, ready: Semaphore, report: Callable[[Mapping[str, Any]], None]
) -> None:
    """Play the field of an order; report its result. ``ready`` is released after each fault of processes."""
    plan = plan_from(order["plan"])
    with serve(order) as server:
        kind = Lockstep if plan.lockstep else FreeRunning
        world = kind(plan, server, report, Path(order["log"]), ready.acquire)
        robots = [body.process for body in world.bodies.bodies]
        report({"event": "listening", "address": server.address, "robots": robots})
        world.gather()
        world.play()
        report({"event": "result", **world.end()})


if __name__ == "__main__":
    main()

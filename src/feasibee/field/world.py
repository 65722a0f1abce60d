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
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, closing, contextmanager
from pathlib import Path
from statistics import median
from threading import Semaphore
from typing import Any

import numpy as np

from feasibee.errors import FeasibeeError
from feasibee.field.bodies import Bodies, Body
from feasibee.field.checks import (
    BYE,
    END,
    HEARD,
    HELLO,
    REFUSED,
    ROBOTS_LIMIT,
    SAID,
    SIGHT,
    STEP,
    TICK,
    WAIT,
    WELCOME,
)
from feasibee.field.connections import Channel, Frame, Link, Server
from feasibee.field.logs import VERSION, LineLog, read_lines
from feasibee.field.plan import PARTITION, PROCESS, Fault, Plan, plan_from
from feasibee.field.robot import KEY_VARIABLE, follow_parent, read_order
from feasibee.model.codes import DECISIONS, UNDECIDED
from feasibee.model.record import Record
from feasibee.reference.swarm import WORKED
from feasibee.results.measures import tracked


class World:
    """The world's side of a field, without its clock.

    Parameters
    ----------
    report : callable
        Takes events, as mappings, for whoever watches.
    resumes : bool
        Whether to go on where the log ends.
    wait_for_go : callable
        Returns once a fault of processes has happened.
    """

    def __init__(
        self,
        plan: Plan,
        server: Server,
        report: Callable[[Mapping[str, Any]], None],
        log: Path,
        resumes: bool = False,
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
        self._channels: dict[int, Channel] = {}
        self._waiting: dict[int, Channel] = {}
        self._nonces: dict[int, int] = {}
        self._wait_for_go = wait_for_go
        self._cut_until = -1.0
        """The step until which the two halves of the swarm don't hear each other."""
        self._faults = list(plan.faults)
        self.said: dict[int, str | None] = {}
        self._recorded = -1
        lines = read_lines(log) if resumes else []
        self._resume(lines)
        self.log = LineLog(log, appends=bool(lines))
        if not lines:
            self._write_head()

    def _write_head(self) -> None:
        """Write which field this is; random digits distinguish two fields in one folder."""
        plan, scenario = self.plan, self.plan.scenario
        recipe = {"scenario": scenario.to_toml(), "source": scenario.manifest.source}
        which = {"seed": plan.seed, "run": plan.run, "lockstep": plan.lockstep, "hz": plan.hz}
        session = {"session": secrets.token_hex(8)}
        self.log.write({"feasibee": "field", "version": VERSION, **recipe, **which, **session})

    def _resume(self, lines: list[dict[str, Any]]) -> None:
        """Go on where a log ends."""
        for line in lines:
            if line.get("event") == "fault":
                self._begin_fault(self._faults.pop(0))
            elif "bodies" in line:
                self._restore(line)

    def _restore(self, line: Mapping[str, Any]) -> None:
        """Put the world into the state after a step of the log, the one after its present state."""
        if line["step"]:
            self.bodies.change(line["step"])
        for body, kept, status in zip(self.bodies.bodies, line["bodies"], line["minds"], strict=True):
            body.restore(kept)
            body.remote.report(status)
            body.lost = body.number in line["lost"]
            body.knows = None
        self.step = self._recorded = line["step"]
        self.decision, self.decision_step = line["decision"]
        self._tracked.append((self.bodies.truth, self.bodies.decision))
        spoke = zip(self.bodies.bodies, line["said"], strict=True)
        self.said = {body.process: text for body, text in spoke if text is not None}

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
        self.report({"event": "joined", "robots": len(self.bodies.bodies)})

    def _wait_for(self, bodies: list[Body]) -> list[Body]:
        """Wait until robots have joined and are ready; return those that don't come in time."""
        missing = {body.process for body in bodies}
        until = time.monotonic() + self.plan.wait
        while missing and time.monotonic() < until:
            frame = self.receive(0.2)
            if frame is not None and frame.kind == SAID:
                body = self.body(frame)
                if frame.robot in missing:
                    self.bodies.report(body, frame.body)
                    missing.discard(frame.robot)
                self.answer(body)
        return [body for body in bodies if body.process in missing]

    def change(self, *, waits: bool) -> list[Body]:
        """Let the world change at the beginning of a step; return the bodies that join.

        The processes of robots that leave end. ``waits`` is whether to wait for those that begin.
        """
        left, joined = self.bodies.change(self.step)
        for body in left:
            self._tell("leaves", body)
            for _ in range(3):  # a packet may be lost; who writes again gets another one
                self.send(body, BYE, {})
        for body in joined:
            if body.process >= ROBOTS_LIMIT:
                raise FeasibeeError(
                    f"robots: more than {ROBOTS_LIMIT:,} have come to this field; use fewer steps"
                )
            self._tell("comes", body)
        for body in self._wait_for(joined) if waits else ():
            self.lose(body)
        return joined

    def receive(self, timeout: float) -> Frame | None:
        """Return the next packet of a robot that has joined; answer those that join."""
        frame = self.server.receive(timeout)
        if frame is None:
            return None
        if frame.kind == HELLO:
            self._join(frame)
        elif frame.robot < 0:
            self.server.dropped["of no robot"] += 1
        elif self.body(frame).has_left:
            self.send(self.body(frame), BYE, {})
        else:
            return frame
        return None

    def _join(self, frame: Frame) -> None:
        """Welcome a robot with its settings, let it wait until it comes, or say why it can't join."""
        count, number, nonce = len(self.bodies.everyone), frame.body["robot"], frame.body["nonce"]
        channel = frame.channel
        why = ""
        if number >= count and self.plan.scenario.dynamic:
            self._waiting[number] = channel
            self.server.send(channel, WAIT, {})
            return
        if number >= count:
            why = f"this field has robots 0 to {count - 1}; use one of these as --id"
        elif self.bodies.everyone[number].has_left:
            why = "the robot of this number has left; use another --id"
        elif frame.robot not in (-1, number) or self._nonces.setdefault(number, nonce) != nonce:
            why = "a robot of this number has joined already; use another --id"
        if why:
            self.server.send(channel, REFUSED, {"why": why})
            return
        self._waiting.pop(number, None)
        if self._channels.get(number, channel) is not channel:
            self.server.end(self._channels[number])
        channel.robot, self._channels[number] = number, channel
        body = self.bodies.everyone[number]
        self.send(body, WELCOME, self._welcome(body))

    def _welcome(self, body: Body) -> dict[str, Any]:
        plan = self.plan
        clock = None
        if not plan.lockstep:
            # Not a draw of the model: clocks differ between fields of the same seed.
            drift = random.Random(f"{self.server.session} {body.process}").uniform(-plan.drift, plan.drift)
            clock = {"period": 1.0 / plan.hz, "drift": drift, "jitter": plan.jitter}
        orders = self.bodies.orders(body)
        orders["settings"]["step"] = max(0, self.step - 1)  # in free running, starting has taken some steps
        return {"clock": clock, **orders}

    def send(self, body: Body, kind: int, content: dict[str, Any]) -> None:
        """Send a packet to a robot, if it has joined."""
        if body.process not in self._channels:
            return
        try:
            self.server.send(self._channels[body.process], kind, content)
        except ValueError as error:
            raise FeasibeeError(
                f"robot {body.process}: {error}; use shorter messages or fewer robots"
            ) from None

    def body(self, frame: Frame) -> Body:
        """Return the body of the robot that sent a packet."""
        return self.bodies.everyone[frame.robot]

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
            self._begin_fault(fault)
            event = {"event": "fault", **fault._asdict()}
            self.log.write(event)
            self.report(event)
            if fault.kind in PROCESS:
                self._wait_for_go()

    def _begin_fault(self, fault: Fault) -> None:
        if fault.kind == PARTITION:
            self._cut_until = max(self._cut_until, fault.step + fault.lasts)

    def lose(self, body: Body) -> None:
        """Count a silent robot no longer."""
        body.lost, body.knows = True, None
        self._tell("lost", body)

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
        if step <= self._recorded:  # before the world was restarted
            return
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
        """Whether the swarm has decided, or all have declared, and that ends the run."""
        run = self.plan.scenario.run
        decided = run.stop_at_decision and self.decision != UNDECIDED
        taken = run.stop_when_taken and self.bodies.work and self.bodies.work.is_over
        return decided or bool(taken) or (run.stop_at_declarations and self.bodies.have_all_declared)

    def end(self) -> dict[str, Any]:
        """Let the robots go; return the result."""
        for _ in range(3):  # a packet may be lost; a robot that gets none leaves after its patience
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
            "dropped": dict(self.server.dropped),
            **measures,
        }


RESEND = 0.1
"""Seconds after which an order without an answer is sent again; loopback loses packets under load."""


class Lockstep(World):
    """A field in lockstep, with two exchanges per step.

    A robot begins the step with what it sees, and says its message. It ends the step with the messages that
    it heard, and reports its opinion.
    """

    def play(self) -> None:
        """Play all steps from the present one, which ends once more if the world has started again."""
        self._begun = [body for body in self.bodies.bodies if self.step and body.works(self.step)]
        self._air: dict[int, list[tuple[Body, str]]] = {}
        while True:
            self._end()
            self.look(self.step)
            if self.is_over or self.step == self.plan.scenario.run.steps:
                return
            self._begin()

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

    def _ask(self, kind: int, orders: Mapping[int, dict[str, Any]]) -> dict[int, str | None]:
        """Send each robot its order until it answers or is lost; return the messages."""
        everyone = self.bodies.everyone
        said: dict[int, str | None] = {}
        waiting = set(orders)
        began = now = time.monotonic()
        resent = -RESEND
        while waiting:
            if now - resent > RESEND:
                resent = now
                for number in sorted(waiting):
                    self.send(everyone[number], kind, {"t": self.step, **orders[number]})
            frame = self.receive(RESEND)
            now = time.monotonic()
            if frame is not None and frame.kind == SAID:
                order = frame.body["t"], frame.body["ends"]
                if frame.robot in waiting and order == (self.step, kind == END):
                    self.bodies.report(everyone[frame.robot], frame.body)
                    said[frame.robot] = frame.body["said"]
                    waiting.discard(frame.robot)
                elif frame.robot not in orders:
                    self.answer(everyone[frame.robot])
            if now - began > self.plan.patience:
                for number in sorted(waiting):
                    self.lose(everyone[number])
                waiting.clear()
        return said


AIR_LIMIT = 100_000
"""Largest number of messages under way; more are dropped."""


class FreeRunning(World):
    """A field whose robots have clocks of their own.

    A robot's packet moves its body by one step; the other bodies stand meanwhile. Its message reaches the
    robots in range at this moment, after the delay.
    """

    def play(self) -> None:
        """Play until the robots have done all steps, by the median of their clocks."""
        now = self._passed_at = time.monotonic()
        self._ticks = {body.process: self.step for body in self.bodies.bodies}
        self._seen_at = {body.process: now for body in self.bodies.bodies}
        self._air: list[tuple[float, int, int, list[object]]] = []
        self._order = itertools.count()
        if self.step == 0:
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
                    self.server.dropped["too many messages"] += 1
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


PATIENCE = 2.0
"""Seconds in which standard input ends after standard output has been closed."""


@contextmanager
def _serve(order: Mapping[str, Any]) -> Iterator[Server]:
    """Listen for robots by UDP, where an order says."""
    with closing(Link(order["host"], order["port"], listens=True)) as link:
        yield Server(link, order["session"], os.environ.get(KEY_VARIABLE, "").encode())


Serve = Callable[[Mapping[str, Any]], AbstractContextManager[Server]]
"""Gives the world's side of the connections with the robots, for an order."""


def main(serve: Serve = _serve) -> None:
    """Run the world of one field; report its result or its error as an event."""
    order, parent = read_order()
    ready = Semaphore(0)

    def report(event: Mapping[str, Any]) -> None:
        parent.write(f"{json.dumps(event)}\n")

    def remove_log() -> None:
        if order["temporary"]:
            shutil.rmtree(Path(order["log"]).parent, ignore_errors=True)

    follower = follow_parent(sys.stdin.fileno(), lambda read: ready.release(read.count(b"\n")), remove_log)
    try:
        try:
            _run(order, serve, ready, report)
        except FeasibeeError as error:
            report({"event": "error", "why": str(error)})
            sys.exit(2)
    except BrokenPipeError:  # the field has ended
        follower.join(PATIENCE)
        os._exit(1)


def _run(
    order: Mapping[str, Any], serve: Serve, ready: Semaphore, report: Callable[[Mapping[str, Any]], None]
) -> None:
    """Play the field of an order; report its result. ``ready`` is released after each fault of processes."""
    plan = plan_from(order["plan"])
    with serve(order) as server:
        log, resumes = Path(order["log"]), order["resumes"]
        kind = Lockstep if plan.lockstep else FreeRunning
        world = kind(plan, server, report, log, resumes, ready.acquire)
        robots = [body.process for body in world.bodies.bodies]
        report({"event": "listening", "address": server.address, "robots": robots})
        if not resumes:
            world.gather()
        world.play()
        report({"event": "result", **world.end()})


if __name__ == "__main__":
    main()

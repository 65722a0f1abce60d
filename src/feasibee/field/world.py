"""The world of a field, apart from its clock: bodies, sight, radio, and the robots that joined."""

from __future__ import annotations

import json
import random
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from feasibee.errors import FeasibeeError
from feasibee.field.bodies import Bodies, Body, Change
from feasibee.field.checks import BYE, HELLO, REFUSED, ROBOTS_LIMIT, SAID, WAIT, WELCOME
from feasibee.field.connections import Channel, Frame, Server
from feasibee.field.logs import WorldLog, read_lines
from feasibee.field.node import Status
from feasibee.field.plan import PARTITION, PROCESS, Fault, Plan
from feasibee.model.codes import DECISIONS, UNDECIDED
from feasibee.model.record import Record
from feasibee.results.measures import tracked


class World:
    """The world's side of a field, without its clock.

    Parameters
    ----------
    plan : Plan
        What the field does.
    server : Server
        The connections to robots.
    report : callable
        Takes events, as mappings, for whoever watches.
    log : Path
        The world's log.
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
        self.log = WorldLog(log, plan, appends=bool(lines))

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
            body.remote.report(Status(*status))
            body.lost = body.number in line["lost"]
            body.knows = None
        self.step = self._recorded = line["step"]
        self.decision, self.decision_step = line["decision"]
        self._tracked.append((self.bodies.truth, self.bodies.decision))
        spoke = zip(self.bodies.bodies, line["said"], strict=True)
        self.said = {body.process: text for body, text in spoke if text is not None}

    def gather(self) -> None:
        """Wait until all robots have joined and are ready.

        Raises
        ------
        FeasibeeError
            If some don't come in time.
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
                    body.remote.report(Status(*frame.body["was"]))
                    missing.discard(frame.robot)
                self.answer(body)
        return [body for body in bodies if body.process in missing]

    def change(self, *, waits: bool) -> Change:
        """Begin a step: let the world change. The processes of robots that leave end, those of others begin.

        ``waits`` is whether to wait for those that begin.
        """
        change = self.bodies.change(self.step)
        for body in change.left:
            self._tell("leaves", body)
            for _ in range(3):  # a packet may be lost; who writes again gets another one
                self.send(body, BYE, {})
        for body in change.joined:
            if body.process >= ROBOTS_LIMIT:
                raise FeasibeeError(
                    f"robots: more than {ROBOTS_LIMIT:,} have come to this field; use fewer steps"
                )
            self._tell("comes", body)
        for body in self._wait_for(change.joined) if waits else ():
            self.lose(body)
        return change

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
        line = {
            "step": step,
            "bodies": [body.state() for body in self.bodies.bodies],
            "minds": [body.remote.status for body in self.bodies.bodies],
            "said": [self.said.get(body.process) for body in self.bodies.bodies],
            "lost": self.lost,
            "decision": [self.decision, self.decision_step],
            "robots": [body.number for body in self.bodies.bodies],
            "processes": [body.process for body in self.bodies.bodies],
            "tasks": list(self.bodies.tasks),
            "truth": self.bodies.truth,
        }
        self.log.write(line)

    @property
    def lost(self) -> list[int]:
        """The numbers of the robots whose processes are silent."""
        return [body.number for body in self.bodies.bodies if body.lost]

    @property
    def is_over(self) -> bool:
        """Whether the swarm has decided, and that ends the run."""
        return self.plan.scenario.run.stop_at_decision and self.decision != UNDECIDED

    def _measures(self) -> dict[str, Any]:
        """Return the measures of a field; none if its world doesn't change."""
        if not self.plan.scenario.dynamic:
            return {}
        record = Record.empty(0, 1, 0, len(self._tracked))
        record.truth[0], record.held[0] = np.array(self._tracked).T
        return tracked(record, self.plan.scenario)

    def end(self) -> dict[str, Any]:
        """Let the robots go; return the result."""
        for _ in range(3):  # a packet may be lost; a robot that gets none leaves after its patience
            for body in self.bodies.bodies:
                self.send(body, BYE, {})
            for channel in self._waiting.values():
                self.server.send(channel, BYE, {})
        self.log.write({"event": "end"})
        self.log.close()
        return {
            "decision": DECISIONS[self.decision],
            "decision_step": self.decision_step if self.decision != UNDECIDED else None,
            "steps": self.step,
            "robots": len(self.bodies.bodies),
            "feasible": self.bodies.feasible_count,
            "infeasible": self.bodies.infeasible_count,
            "lost": [body.process for body in self.bodies.bodies if body.lost],
            "dropped": dict(self.server.dropped),
            **self._measures(),
        }


def print_event(event: Mapping[str, Any]) -> None:
    """Print an event as one line of JSON, for the field that started the world."""
    sys.stdout.write(json.dumps(event) + "\n")
    sys.stdout.flush()

"""Viewers of a field: they get the scene once, and a view of each step. No robot waits for them."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final, Protocol

from feasibee.field.checks import MARKS, REFUSED, SCENE, STATE
from feasibee.field.frames import Channel, Frame
from feasibee.reference.mind import BYZANTINE, HONEST, STUBBORN

if TYPE_CHECKING:
    from feasibee.field.bodies import Bodies, Body
    from feasibee.field.connections import Server
    from feasibee.field.plan import Plan

VIEWERS_LIMIT: Final = 10
"""Most viewers at a time."""
KEPT: Final = 3.0
"""Seconds for which a viewer gets views after each of its packets."""
RECENT: Final = 20_000
"""Most robots in all views that a new process of a world keeps, for viewers of the one before."""
PAUSE: Final = 0.1
"""Seconds between two packets of a viewer that are answered."""


class Watched(Protocol):
    """What viewers are shown of a world."""

    plan: Plan
    server: Server
    bodies: Bodies
    decision: int
    decision_step: int

    @property
    def lost(self) -> list[int]:
        """The numbers of the robots whose processes are silent."""

    @property
    def is_cut(self) -> bool:
        """Whether the radio is cut between two halves of the robots."""


class Viewers:
    """Those who watch a field.

    Parameters
    ----------
    world : Watched
        The world that is watched.
    """

    def __init__(self, world: Watched) -> None:
        self._world = world
        self._asked: dict[Channel, float] = {}
        self._latest: dict[str, Any] | None = None
        self._shown: tuple[int, Sequence[Sequence[int]]] | None = None
        self._scene: dict[str, Any] | None = None
        self._recent: deque[dict[str, Any]] = deque(maxlen=1 + RECENT // (1 + len(world.bodies.bodies)))
        self._recent_until = math.inf

    def answer(self, frame: Frame) -> None:
        """Answer a packet of a viewer: with the scene, the latest view, or why it gets none."""
        now = time.monotonic()
        self._forget(now)
        before = self._asked.get(frame.channel)
        if before is None and len(self._asked) >= VIEWERS_LIMIT:
            why = f"it has {VIEWERS_LIMIT} viewers, which is the limit; end one of them"
            self._send(REFUSED, frame.channel, {"why": why})
        elif before is not None and now - before < PAUSE:
            self._world.server.dropped["of a hasty viewer"] += 1
        else:
            self._asked[frame.channel] = now
            self._inform(frame, is_new=before is None)

    def _inform(self, frame: Frame, *, is_new: bool) -> None:
        """Send a viewer the scene or the latest view; a new one that has the scene gets all kept."""
        if not frame.body["has"] or self._latest is None:
            self._scene = self._scene or scene_of(self._world)
            fits = self._send(SCENE, frame.channel, self._scene)
        else:
            views = [*self._recent] if is_new and self._recent else [self._latest]
            fits = all(self._send(STATE, frame.channel, view) for view in views)
        if not fits:
            why = "it has too many robots or tasks to be watched; use feasibee watch without --field"
            self._send(REFUSED, frame.channel, {"why": why})

    def show(self, step: int, places: Sequence[Sequence[int]]) -> None:
        """Send a view of a step to all viewers; keep the first ones for those who ask soon."""
        now = time.monotonic()
        if self._shown is None:
            self._recent_until = now + KEPT
        self._shown = step, places
        self._forget(now)
        keeps = now < self._recent_until
        # Never computed later, when some robots are a step ahead.
        self._latest = view_of(self._world, step, places) if self._asked or keeps else None
        if keeps and self._latest is not None:
            self._recent.append(self._latest)
        elif self._recent:
            self._recent.clear()
        self._send_latest()

    def end(self) -> None:
        """Send the last view again, which says that the field has ended."""
        if self._shown is None or not self._asked:
            return
        self._latest = {**view_of(self._world, *self._shown), "end": True}
        for _ in range(3):  # a packet may be lost
            self._send_latest()

    def _send_latest(self) -> None:
        if self._latest is not None:
            for channel in self._asked:
                self._send(STATE, channel, self._latest)

    def _forget(self, now: float) -> None:
        self._asked = {each: asked for each, asked in self._asked.items() if now - asked < KEPT}

    def _send(self, kind: int, channel: Channel, content: dict[str, Any]) -> bool:
        """Send a packet; return whether it isn't too large."""
        try:
            self._world.server.send(channel, kind, content)
        except ValueError:
            return False
        return True


def scene_of(world: Watched) -> dict[str, Any]:
    """Return what stays as it is in a field: the numbers of its scenario that a viewer draws."""
    plan, bodies = world.plan, world.bodies
    scenario = plan.scenario
    free = scenario.most.robots - scenario.robots.count
    return {
        "strategy": scenario.manifest.name.rpartition("/")[2][:100],
        "seed": plan.seed,
        "run": plan.run,
        "steps": scenario.run.steps,
        "hz": None if plan.lockstep else plan.hz,
        "size": [float(side) for side in scenario.arena.size],
        "walls": scenario.arena.boundary == "walls",
        "diameter": float(scenario.robots.diameter),
        "sight": float(scenario.sensing.range),
        "radio": float(scenario.radio.range),
        "threshold": float(scenario.decision.threshold),
        "commits": scenario.decision.commit is not None,
        "declares": bool(scenario.manifest.declares),
        "seconds": float(scenario.units.seconds or 0),
        "truth": bool(bodies.truth),
        "changes": scenario.dynamic,
        "robots": scenario.robots.count,
        "faults": [body.fault for body in bodies.everyone[: scenario.robots.count]] + [HONEST] * free,
        "classes": [each.name for each in scenario.robots.classes],
        "kinds": bodies.robot_kinds,
        "tasks": [coarse(world, place) for place in bodies.tasks.values()],
    }


def view_of(world: Watched, step: int, places: Sequence[Sequence[int]]) -> dict[str, Any]:
    """Return one step of a field: places, opinions, phases, counts, silent robots and the decision."""
    bodies = world.bodies
    tasks = bodies.tasks.values() if world.plan.scenario.dynamic else ()
    return {
        "t": step,
        "numbers": [body.number for body in bodies.bodies],
        "tasks": [coarse(world, place) for place in tasks],
        "truth": bool(bodies.truth),
        "places": [coarse(world, each) for each in places],
        "headings": [round(math.atan2(dy, dx) * 128 / math.pi) % 256 for _, _, dx, dy, *_ in places],
        "opinions": [body.remote.opinion for body in bodies.bodies],
        "marks": [_marks(body, step) for body in bodies.bodies],
        "lost": world.lost,
        "cut": world.is_cut,
        "counts": [bodies.feasible_count, bodies.infeasible_count, len(bodies.counted)],
        "declared": [bodies.declared(1), bodies.declared(0)],
        "decision": [bodies.decision, world.decision, world.decision_step],
        "end": False,
    }


def coarse(world: Watched, place: Sequence[int]) -> list[int]:
    """Return a place in 65,536ths of the arena's longer side."""
    shift = 16 if world.bodies.world.is_torus else 15
    return [min(each >> shift, 65_535) for each in place[:2]]


def _marks(body: Body, step: int) -> int:
    """Return what a robot last reported besides its opinion, as bits."""
    mind = body.remote
    having = {
        "disseminating": mind.disseminating,
        "committed": mind.committed,
        "declared": mind.declared >= 0,
        "working": body.works(step),
        "byzantine": body.fault == BYZANTINE,
        "stubborn": body.fault == STUBBORN,
    }
    return sum(having[name] << bit for bit, name in enumerate(MARKS))

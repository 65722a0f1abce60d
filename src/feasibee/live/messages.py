"""The messages between page and server.

The page sends JSON, which is validated here. The server answers in JSON and in binary messages: the length of
a head (uint32), the head in JSON, and arrays that JavaScript reads in place. All is little-endian. The head
lists the arrays with their types and lengths; ``static/frames.js`` describes and decodes them.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Annotated, Any, Final, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, JsonValue, TypeAdapter, ValidationError

from feasibee.errors import FeasibeeError, Problem, ScenarioError
from feasibee.live.scene import Logged
from feasibee.simulation.snapshot import FLAGS
from feasibee.simulation.swarm import Swarm

PROTOCOL: Final = 6
"""Version of the messages; raise it when a page of the previous version could not read them."""
NO_TASK: Final = 2**16 - 1
"""Aim of a robot that has none; more tasks than this are beyond the limit of a page."""
MESSAGE_LIMIT: Final = 16 * 1024
"""Most bytes of a message of the page."""


class _Message(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class Open(_Message):
    """Request of the page to begin a run and go to a step."""

    type: Literal["open"]
    point: int | None = None
    """Point of the journal; None for the scenario of the command line."""
    changes: dict[str, JsonValue] = Field({}, max_length=64)
    """Changes to that scenario, by dotted path."""
    seed: str | int | float | None = None
    """As text, since JavaScript's numbers have 53 bits; validated together with the scenario."""
    run: str | int | float | None = None
    step: int = Field(0, ge=0)
    against: str | None = None
    """Strategy of a second swarm, in the same world with the same random numbers."""
    request: int | None = None
    """Number of the request, which its answer repeats, so that the page recognises that of an earlier one."""


class Advance(_Message):
    """Request of the page to advance by some steps and send a frame."""

    type: Literal["advance"]
    steps: int = Field(ge=1, le=1_000_000)


class Seek(_Message):
    """Request of the page to go to a step of the run, or to the decision of a swarm."""

    type: Literal["seek"]
    to: Annotated[int, Field(ge=0)] | Literal["decision"]
    lane: int = Field(0, ge=0, le=1)
    """Swarm whose decision is meant."""
    jump: int = Field(ge=0, le=255)
    """Number that the frames have from here on, so that the page recognises late ones."""


class Inspect(_Message):
    """Request of the page to say with each frame what a robot knows; None: of no robot."""

    type: Literal["inspect"]
    robot: int | None = None


class Look(_Message):
    """Request of the page to look ahead in a run, and to say what is found."""

    type: Literal["look"]
    robot: int | None = None
    """Robot whose changes are looked for."""
    lane: int = Field(0, ge=0, le=1)
    first: int = Field(0, ge=0)
    """Number of changes of the robot that the page has."""
    seen: int = Field(0, ge=0)
    """Number of changes of the world that the page has."""

    def nothing(self, problem: str) -> dict[str, Any]:
        """Return the answer for a run in which nothing can be looked for, and why."""
        return {**self.model_dump(), "type": "outlook", "done": True, "problem": problem}


class Predict(_Message):
    """Request of the page to say what the theory says of a swarm; other messages are answered meanwhile."""

    type: Literal["predict"]
    lane: int = Field(0, ge=0, le=1)


class Why(_Message):
    """Request of the page to say in a sentence why a robot holds its opinion."""

    type: Literal["why"]
    robot: int
    lane: int = Field(0, ge=0, le=1)


Request = Open | Advance | Seek | Inspect | Look | Predict | Why
"""A message of the page."""
_ADAPTER: TypeAdapter[Request] = TypeAdapter(Annotated[Request, Field(discriminator="type")])


def read(text: str | None) -> Request:
    """Parse a message of the page; None stands for bytes.

    Raise a FeasibeeError if the message is invalid.
    """
    if text is None:
        raise FeasibeeError("message: must be text, not bytes; reload the page")
    try:
        return _ADAPTER.validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False, include_input=False)[0]
        place = ".".join(str(part) for part in first["loc"])
        raise FeasibeeError(
            f"message: {place + ': ' if place else ''}{first['msg']}; reload the page"
        ) from None


def problems_of(error: FeasibeeError) -> dict[str, Any]:
    """Return an error as a message: all problems, each with the path of its field, if any."""
    problems: Iterable[Problem] = error.problems if isinstance(error, ScenarioError) else ()
    listed = [{"path": each.path, "text": str(each)} for each in problems]
    return {"type": "error", "problems": listed or [{"path": "", "text": str(error)}]}


def encode_frame(
    swarm: Swarm | Logged, generation: int, first: int, *, lane: int = 0, jump: int = 0
) -> bytes:
    """Encode the current step, with the counts of each step from ``first`` on, so that the plot has all."""
    shown, task_places = swarm.snapshot(), swarm.task_places()
    having = {name: (shown.flags >> bit & 1).sum() for bit, name in enumerate(FLAGS)}
    curves = (swarm.feasible_counts, swarm.infeasible_counts, swarm.counted_counts, swarm.truths)
    feasible, infeasible, counted, truths = (each[first:] for each in curves)
    first_decision, decision_step = swarm.first_decision
    head = {
        "lane": lane,
        "jump": jump,
        "robots": shown.x.size,
        "step": swarm.step,
        "first": first,
        "decisionStep": decision_step,
        "decision": swarm.decision,
        "firstDecision": first_decision,
        "feasible": swarm.feasible_counts[-1],
        "infeasible": swarm.infeasible_counts[-1],
        "counted": swarm.counted.sum(),
        **{name: having[name] for name in ("disseminating", "working", "there", "standing")},
        "declaredFeasible": swarm.declared_counts[0],
        "declaredInfeasible": swarm.declared_counts[1],
        "tasks": task_places[0].size,
        "allTakenStep": swarm.all_taken_step,
        "truth": int(swarm.truth),
        "bits": swarm.bits_sent,
        "robotSteps": swarm.robot_counts[1:].sum(),
    }
    shown_tasks = slice(None) if swarm.scenario.dynamic else slice(0)
    task_x, task_y, numbers = (each[shown_tasks] for each in (*task_places, swarm.task_numbers))
    arrays = {
        "feasibleCounts": feasible.astype("<i4"),
        "infeasibleCounts": infeasible.astype("<i4"),
        "countedCounts": counted.astype("<i4"),
        **shown._asdict(),
        "taskX": task_x,
        "taskY": task_y,
        "taskNumbers": numbers.astype("<u2"),
        "truths": truths.astype("u1"),
    }
    return _binary("frame", generation, head, arrays | _acts(swarm))


def _acts(swarm: Swarm | Logged) -> dict[str, Any]:
    """Return the task of each robot, and the look of each task, if robots act."""
    if not swarm.scenario.acts:
        return {}
    aims = swarm.acting.aims
    return {"aims": np.where(aims < 0, NO_TASK, aims).astype("<u2"), "taken": swarm.acting.looks}


def encode_tasks(swarm: Swarm | Logged, generation: int) -> bytes:
    """Encode the positions of the tasks."""
    return _binary("tasks", generation, {}, dict(zip("xy", swarm.task_places(), strict=True)))


def _binary(kind: str, generation: int, numbers: dict[str, Any], arrays: dict[str, Any]) -> bytes:
    """Return a binary message; arrays of larger items come first, so that each is aligned."""
    ordered = sorted(arrays.items(), key=lambda each: -each[1].itemsize)
    listed = [[name, each.dtype.str[1:], each.size] for name, each in ordered]
    marks = {"type": kind, "protocol": PROTOCOL, "generation": generation & 0xFFFF}
    head = json.dumps({**marks, **numbers, "arrays": listed}, default=int).encode()
    head += b" " * (-len(head) % 4)
    return b"".join([np.uint32(len(head)).tobytes(), head, *(each.tobytes() for _, each in ordered)])

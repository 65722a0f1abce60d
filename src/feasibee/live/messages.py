"""The messages between page and server.

The page sends JSON, which is validated here. The server answers in JSON and in binary messages, whose layout
is in `feasibee.live.layout`.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, JsonValue, TypeAdapter, ValidationError

from feasibee.errors import FeasibeeError, Problem, ScenarioError
from feasibee.live.layout import FRAME, TASKS
from feasibee.live.scene import Logged, curves_of, step_of
from feasibee.simulation.snapshot import FLAGS
from feasibee.simulation.swarm import Swarm

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


Request = Open | Advance | Seek | Inspect | Look
"""A message of the page."""
_ADAPTER: TypeAdapter[Request] = TypeAdapter(Annotated[Request, Field(discriminator="type")])


def read(text: str) -> Request:
    """Parse a message of the page.

    Raises
    ------
    FeasibeeError
        If the message is invalid.
    """
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
    step, curves = step_of(swarm), curves_of(swarm, first)
    having = {name: int((step.shown.flags >> bit & 1).sum()) for bit, name in enumerate(FLAGS)}
    decision, first_decision, decision_step = step.decision
    return FRAME.encode(
        generation=generation & 0xFFFF,
        lane=lane,
        jump=jump,
        robots=step.shown.x.size,
        step=step.step,
        first=first,
        length=len(curves),
        decision_step=decision_step,
        decision=decision,
        first_decision=first_decision,
        **dict(zip(("feasible", "infeasible", "counted"), step.counts, strict=True)),
        **{name: having[name] for name in ("disseminating", "working", "there")},
        **dict(zip(("declared_feasible", "declared_infeasible"), step.declared, strict=True)),
        tasks=step.tasks,
        placed=len(step.places),
        truth=step.truth,
        bits=step.bits,
        robot_steps=step.robot_steps,
        feasible_counts=curves[:, 0],
        infeasible_counts=curves[:, 1],
        counted_counts=curves[:, 2],
        truths=curves[:, 3],
        task_x=step.places[:, 0],
        task_y=step.places[:, 1],
        **step.shown._asdict(),
    )


def encode_tasks(swarm: Swarm | Logged, generation: int) -> bytes:
    """Encode the positions of the tasks."""
    x, y = swarm.task_places()
    return TASKS.encode(generation=generation & 0xFFFF, count=x.size, x=x, y=y)

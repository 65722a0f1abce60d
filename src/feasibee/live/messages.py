"""What the page and the server say to each other.

The page sends JSON, which is checked here. The server answers in JSON, and with binary frames: little-endian,
a header of `HEADER` and then arrays, which the page reads without copying.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import Annotated, Any, Final, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, JsonValue, TypeAdapter, ValidationError

from feasibee.errors import FeasibeeError, Problem, ScenarioError
from feasibee.simulation.swarm import Swarm

PROTOCOL: Final = 1
"""Raised whenever a page of another version couldn't read what the server sends."""
MESSAGE_LIMIT: Final = 16 * 1024
"""Most bytes of a message of the page."""
FRAME, TASKS = 1, 2
HEADER: Final = struct.Struct("<BBHIIIiibbHIIIIIIQ")
"""Protocol, kind, generation, robots, step; first step of the counts, and how many steps they have; step of
the first decision, decision now, first decision, padding; then how many are feasible, infeasible, counted,
disseminating, working and committed; and the bits sent."""
TASKS_HEADER: Final = struct.Struct("<BBHI")
"""Protocol, kind, generation, tasks."""


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


class Advance(_Message):
    """Request of the page to advance by some steps and send a frame."""

    type: Literal["advance"]
    steps: int = Field(ge=1, le=1_000_000)


_ADAPTER: TypeAdapter[Open | Advance] = TypeAdapter(Annotated[Open | Advance, Field(discriminator="type")])


def read(text: str) -> Open | Advance:
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


def encode_frame(swarm: Swarm, generation: int, first: int) -> bytes:
    """Encode the current step, with the counts of each step from ``first`` on, so that the plot has all."""
    shown = swarm.snapshot()
    decision, decision_step = swarm.first_decision
    feasible, infeasible = swarm.feasible_counts[first:], swarm.infeasible_counts[first:]
    marks = np.bincount(shown.marks, minlength=256)
    having = [int(marks[np.arange(256) >> bit & 1 == 1].sum()) for bit in range(8)]
    header = HEADER.pack(
        PROTOCOL,
        FRAME,
        generation & 0xFFFF,
        swarm.scenario.robots.count,
        swarm.step,
        first,
        feasible.size,
        decision_step,
        swarm.decision,
        decision,
        0,
        swarm.feasible_count,
        swarm.infeasible_count,
        having[4],
        having[2],
        having[5],
        having[3],
        swarm.bits_sent,
    )
    arrays = (feasible.astype("<i4"), infeasible.astype("<i4"), shown.x.astype("<u2"), shown.y.astype("<u2"))
    return b"".join(
        [header, *(each.tobytes() for each in arrays), shown.heading.tobytes(), shown.marks.tobytes()]
    )


def encode_tasks(swarm: Swarm, generation: int) -> bytes:
    """Encode the positions of the tasks."""
    x, y = swarm.task_places()
    header = TASKS_HEADER.pack(PROTOCOL, TASKS, generation & 0xFFFF, x.size)
    return header + x.astype("<u2").tobytes() + y.astype("<u2").tobytes()

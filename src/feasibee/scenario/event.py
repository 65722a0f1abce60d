"""The fields of an event: a change of the world at a given step."""

from __future__ import annotations

from pydantic import Field

from feasibee.scenario.field_types import Share
from feasibee.scenario.section import Section


class NewSensing(Section):
    """What an event changes of `Sensing`."""

    miss: Share | None = Field(None, description="New value of sensing.miss; by default it stays.")


class NewRadio(Section):
    """What an event changes of `Radio`."""

    loss: Share | None = Field(None, description="New value of radio.loss; by default it stays.")


class Event(Section):
    """A change of the world at the beginning of a step (model.md 6.17)."""

    step: int = Field(ge=0, le=1_000_000_000, description="Step at whose beginning the world changes.")
    tasks: int = Field(
        0,
        ge=-10_000_000,
        le=10_000_000,
        description="Number of tasks that appear; negative: that vanish, drawn at random.",
    )
    robots: int = Field(
        0,
        ge=-1_000_000,
        le=1_000_000,
        description="Number of robots that join; negative: that leave for good, drawn at random.",
    )
    sensing: NewSensing = Field(NewSensing(), description="New values of sensing.")
    radio: NewRadio = Field(NewRadio(), description="New values of radio.")

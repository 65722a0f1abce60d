"""Check the head of a robot's log: its settings, by the ranges of a scenario's fields."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Final, get_args

from pydantic import Field, Strict, ValidationError

from feasibee.field.checks import FARTHEST, is_insight
from feasibee.model.codes import RUN_LIMIT, SEED_LIMIT
from feasibee.reference.mind import BYZANTINE, HONEST, STOPPED, STUBBORN
from feasibee.scenario.field_types import Duration, Length, Share, Speed
from feasibee.scenario.fields import Faults
from feasibee.scenario.section import Section
from feasibee.scenario.setting import WORDS_LIMIT, excess
from feasibee.strategies.contract import Setting, Strategy

CLASSES: Final = 16
"""Largest number of classes of robots, and of tasks."""

Million = Annotated[int, Field(ge=0, le=10**6)]
Robots = Annotated[int, Field(ge=1, le=10**6)]
Tasks = Annotated[int, Field(ge=0, le=10**7)]
Things = Annotated[int, Field(ge=0, le=2**25)]
Classes = Annotated[int, Field(ge=1, le=CLASSES)]
Steps = Annotated[int, Field(ge=0, le=2**53)]
Word = Annotated[int, Field(ge=0, lt=2**32)]
Seed = Annotated[int, Field(ge=0, lt=SEED_LIMIT)]
Run = Annotated[int, Field(ge=0, lt=RUN_LIMIT)]
Ordinate = Annotated[float, Field(ge=-FARTHEST, le=FARTHEST)]
Weights = Annotated[list[Steps], Field(min_length=1, max_length=CLASSES)]


class _Setting(Section):
    """`Setting` with the ranges of its numbers."""

    robots: Robots
    count: Robots
    tasks: Tasks
    robot_ids: Things
    task_ids: Things
    robot_classes: Classes
    task_classes: Classes
    id_bits: Annotated[int, Field(ge=1, le=32)]
    parameters: list[float]
    knows_count: bool
    colluding: bool
    width: Length
    height: Length
    walled: bool
    sight: Length
    radio: Length
    speed: Speed
    exploration: Duration
    dissemination: Annotated[float, Field(gt=0, le=2e6)]
    mean_run: Duration


class _Commit(Section):
    """`Commit` with the ranges of its numbers."""

    quorum: Annotated[str, Field(pattern=r"^([01]|[0-9]{1,9}/[1-9][0-9]{0,9})$")]
    rounds: Robots
    heard: Robots


class _Settings(Section):
    """`Settings` with the ranges of its numbers."""

    coordinates: Annotated[tuple[Seed, Run, Million], Strict(False)]
    joined: Steps
    phases: Steps
    exploration: Duration
    gain: Duration
    dissemination_floor: Million
    quality_floor: Million
    own_vote: bool
    listens_for: Million | None
    every_message: bool
    inbox_size: Robots | None
    parameters: list[float]
    commit: _Commit | None
    switching: Share | None
    sets: Annotated[list[Annotated[tuple[Weights, Weights], Strict(False)]], Field(min_length=1)]
    me: Annotated[tuple[Million, Million, Word], Strict(False)]
    place: Annotated[tuple[Ordinate, Ordinate], Strict(False)]
    setting: _Setting
    step: Steps
    fault: str
    byzantine_says: str
    repeated: bool


def problem_of(orders: Mapping[str, Any], strategy: Strategy) -> str:
    """Return what is invalid in the orders of a robot's log; empty if its robot can be one of a scenario."""
    try:
        settings = _Settings.model_validate(orders.get("settings"))
    except ValidationError as error:
        where = ".".join(map(str, ("settings", *error.errors(include_url=False)[0]["loc"])))
        return f"has no valid {where}"
    setting = Setting(**settings.setting.model_dump())
    kinds = setting.robot_classes, setting.task_classes
    invented = setting.tasks, setting.robots + 1
    half = min(setting.width, setting.height) / 2
    fits = {
        "insight": is_insight(orders.get("insight")),
        "asks_gap": orders.get("asks_gap") in (False, strategy.knows_gap),
        "settings.fault": settings.fault in (HONEST, STOPPED, BYZANTINE, STUBBORN),
        "settings.byzantine_says": settings.byzantine_says
        in get_args(Faults.model_fields["byzantine_says"].annotation),
        "settings.parameters": settings.parameters == setting.parameters
        and len(setting.parameters) == len(strategy.parameters),
        "settings.sets": all((len(robots), len(tasks)) == kinds for robots, tasks in settings.sets),
        "settings.coordinates": settings.coordinates[2] < setting.robots,
        "settings.me": settings.me[0] < setting.robots and settings.me[1] < setting.robot_classes,
        "settings.setting.count": setting.count <= setting.robots,
        "settings.setting.sight": setting.walled or max(setting.sight, setting.radio) <= half,
        "settings.setting.speed": setting.speed <= half,
        "settings.setting.task_ids": (setting.robot_ids - setting.robots, setting.task_ids - setting.tasks)
        in ((0, 0), invented),
    }
    for name, fit in fits.items():
        if not fit:
            return f"has no valid {name}"
    return _memory_problem(setting, strategy) if strategy.knowledge else ""


def _memory_problem(setting: Setting, strategy: Strategy) -> str:
    """Return why a robot's knowledge would take more memory than that of a scenario's robot may."""
    lengths = strategy.row_lengths(setting)
    if max(lengths) > WORDS_LIMIT:
        return f"has settings with more than {WORDS_LIMIT:,} words of knowledge"
    problem = excess(setting, *lengths)
    return problem and f"has settings that can't be: {problem}"

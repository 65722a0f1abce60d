"""Replay the log of a robot: from its inputs and draws, the same decisions to the bit."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Final, Literal, NamedTuple

from pydantic import Field, Strict, ValidationError

from feasibee.errors import FeasibeeError, one_line, quoted
from feasibee.field.checks import (
    FARTHEST,
    GOES,
    INSIGHT,
    MESSAGE,
    PLACE,
    SIGHTING,
    STATUS,
    TIME,
    WORK,
    many,
    row,
    whole,
)
from feasibee.field.logs import damaged, parsed, read_log
from feasibee.field.node import VERSION, Node
from feasibee.files import named
from feasibee.model.codes import DECISIONS, RUN_LIMIT, SEED_LIMIT
from feasibee.reference.mind import Words, setting_from
from feasibee.scenario.setting import WORDS_LIMIT, excess
from feasibee.scenario.types import Duration, Length, Lie, ManyTasks, Million, Section, Some, Speed
from feasibee.strategies import STRATEGIES
from feasibee.strategies.contract import Setting, Strategy

_UNFIT = (ArithmeticError, AttributeError, LookupError, TypeError, ValueError)
"""Errors of a strategy that is given what its own robots never see, or that isn't the robot's."""
_CLASSES: Final = 16
"""Largest number of classes of robots, and of tasks."""

Things = Annotated[int, Field(ge=0, le=2**25)]
Classes = Annotated[int, Field(ge=1, le=_CLASSES)]
Steps = Annotated[int, Field(ge=0, le=2**53)]
Word = Annotated[int, Field(ge=0, lt=2**32)]
Seed = Annotated[int, Field(ge=0, lt=SEED_LIMIT)]
Run = Annotated[int, Field(ge=0, lt=RUN_LIMIT)]
Ordinate = Annotated[float, Field(ge=-FARTHEST, le=FARTHEST)]
Weights = Annotated[list[Steps], Field(min_length=1, max_length=_CLASSES)]

_WORD = whole(0, 2**32 - 1)
_DRAWS: Final = {"draws": many(row(_WORD, _WORD, _WORD, _WORD))}
_STEP: Final = {
    "step": TIME,
    "place": PLACE,
    "see": many(SIGHTING),
    "heard": many(MESSAGE),
    "status": STATUS,
    "insight": INSIGHT,
    "goes": GOES,
    **WORK,
    **_DRAWS,
}
"""The forms of what a step's line has."""


class _Setting(Section):
    """`Setting` with the ranges of its numbers."""

    robots: Some
    count: Some
    tasks: ManyTasks
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
    flooding: Annotated[float, Field(ge=0, le=2**30)] = 0.0
    delay: Annotated[float, Field(ge=0, le=1_000)] = 0.0
    plan: Annotated[str, Field(pattern=r"^([0-9a-f]{2})*$", max_length=2**25)] = ""
    columns: Annotated[int, Field(ge=0, le=2**12)] = 0
    work: Annotated[float, Field(ge=0, le=2**30)] = 0.0
    charge: Annotated[float, Field(ge=0, le=2**30)] = 0.0


class _Declare(Section):
    """`Declare` with the ranges of its numbers."""

    quorum: Annotated[str, Field(pattern=r"^([01]|[0-9]{1,9}/[1-9][0-9]{0,9})$")]
    rounds: Some
    heard: Some


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
    random_ties: bool = False
    first_sight: bool = False
    listens_for: Million | None
    every_message: bool
    inbox_size: Some | None
    parameters: list[float]
    declare: _Declare | None
    sets: Annotated[list[Annotated[tuple[Weights, Weights], Strict(False)]], Field(min_length=1)]
    me: Annotated[tuple[Million, Million, Word], Strict(False)]
    place: Annotated[tuple[Ordinate, Ordinate], Strict(False)]
    setting: _Setting
    step: Steps
    fault: Literal["honest", "stopped", "byzantine", "stubborn"]
    byzantine_says: Lie
    repeated: bool


class _Rules(Section):
    """`feasibee.robot.acting.Rules` with the ranges of its numbers."""

    start: Steps
    by_word: bool
    by_rank: bool
    tags: bool
    comes_free: bool
    number: Million
    rank: Classes
    ranks: Classes
    count: Million | None


class _Acting(Section):
    """The orders of `feasibee.field.errands.Errands` with the ranges of their numbers."""

    rules: _Rules
    able: Annotated[list[bool], Field(min_length=1, max_length=_CLASSES)]
    frame: Annotated[tuple[Annotated[float, Field(gt=0, le=1e9)], Seed, Seed, bool], Strict(False)]
    tasks: list[Annotated[tuple[Seed, Seed, Annotated[int, Field(ge=0, lt=_CLASSES)]], Strict(False)]] | None


def _acting_fits(orders: Mapping[str, Any]) -> bool:
    """Return whether the orders of an acting robot's log can be some; those of others have none."""
    if "acting" not in orders:
        return True
    try:
        acting = _Acting.model_validate(orders["acting"])
    except ValidationError:
        return False
    kinds = len(acting.able)
    return acting.rules.rank <= acting.rules.ranks and all(kind < kinds for *_, kind in acting.tasks or ())


def _problem_of(orders: Mapping[str, Any], strategy: Strategy) -> str:
    """Return what is invalid in the orders of a robot's log; empty if its robot can be one of a scenario."""
    try:
        settings = _Settings.model_validate(orders.get("settings"))
    except ValidationError as error:
        where = ".".join(map(str, ("settings", *error.errors(include_url=False)[0]["loc"])))
        return f"has no valid {where}"
    setting = setting_from(settings.setting.model_dump())
    kinds = setting.robot_classes, setting.task_classes
    invented = setting.tasks, setting.robots + 1
    half = min(setting.width, setting.height) / 2
    fits = {
        "insight": INSIGHT(orders.get("insight")),
        "acting": _acting_fits(orders),
        "asks_gap": orders.get("asks_gap") in (False, strategy.knows_gap),
        "settings.parameters": settings.parameters == setting.parameters
        and len(setting.parameters) == len(strategy.parameters),
        "settings.sets": all((len(robots), len(tasks)) == kinds for robots, tasks in settings.sets),
        "settings.coordinates": settings.coordinates[2] < setting.robots,
        "settings.me": settings.me[0] < setting.robots and settings.me[1] < setting.robot_classes,
        "settings.setting.count": setting.count <= setting.robots,
        "settings.setting.sight": setting.walled or max(setting.sight, setting.radio) <= half,
        "settings.setting.plan": len(setting.plan) % max(setting.columns, 1) == 0
        and bool(setting.plan) == (setting.columns > 0),
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


class Replay(NamedTuple):
    """A replayed log, equal to what the robot did."""

    number: int
    """The robot's number."""
    steps: int
    """Number of steps in the log."""
    opinion: str
    """The opinion at the end: ``feasible``, ``infeasible`` or ``undecided``."""
    decisions: int
    """Number of phases that ended with a decision."""
    cut: bool
    """Whether the last line is incomplete, as of a process that was killed."""


def replay(path: str | Path, strategy: Strategy | None = None) -> Replay:
    """Replay a robot's log; ``strategy`` is that of the robot, if it isn't built in.

    A log never says which file to run.
    Raise a FeasibeeError if it is no log of a robot, is damaged, or says anything else than the replay.
    """
    first = {"feasibee": "robot", "version": VERSION}
    wrong = f"isn't the log of a robot, version {VERSION}; name robot-K.jsonl"
    lines, rest = read_log(Path(path), "the log of a robot, such as robot-3.jsonl", first, wrong)
    head = parsed(path, 1, lines[0], _DRAWS)
    draws = deque(_draws(head))
    node, written = _node(path, head, draws, strategy)
    _compare(path, 1, head, written.pop(), draws)
    decisions = explores = 0
    for at, text in enumerate(lines[1:], 2):
        line = parsed(path, at, text, _STEP)
        draws.extend(_draws(line))
        try:
            node.speak(line["step"], tuple(line["place"]), line.get("insight"))
            node.sense(line)
            node.finish(line["heard"])
        except _UNFIT as error:
            raise _unfit(path, at, error, draws) from None
        _compare(path, at, line, written.pop(), draws)
        disseminating = node.status.disseminating
        decisions += bool(explores) and not disseminating
        explores = disseminating
    robot, opinion = head["settings"]["coordinates"][2], DECISIONS[node.status.opinion]
    return Replay(robot, len(lines) - 1, opinion, decisions, bool(rest))


def _node(
    path: str | Path, head: dict[str, Any], draws: deque[Words], strategy: Strategy | None
) -> tuple[Node, list[Any]]:
    """Return a robot as at the begin of its log, and the list of the lines that it writes."""
    name = head.get("strategy")
    own = strategy or STRATEGIES.get(str(name))
    if own is None:
        raise FeasibeeError(
            f"{named(path)}: the robot's strategy {quoted(name)} isn't built in; give --strategy FILE"
        )
    orders = {key: head[key] for key in head if key not in ("draws", "status", "feasibee", "version")}
    written: list[Any] = []
    try:
        problem = _problem_of(orders, own)
        if problem:
            raise damaged(path, 1, problem)
        return Node(orders, written.append, lambda _, __: draws.popleft(), own), written
    except _UNFIT as error:
        raise _unfit(path, 1, error, draws) from None


def _unfit(path: str | Path, at: int, error: Exception, draws: deque[Words]) -> FeasibeeError:
    """Return the error of a line that no robot with this head and this strategy has written."""
    if isinstance(error, IndexError) and not draws:
        return damaged(path, at, "has too few draws")
    return damaged(
        path, at, f"makes the strategy fail with {type(error).__name__}: {one_line(str(error), 100)}"
    )


def _draws(line: dict[str, Any]) -> list[Words]:
    return [(a, b, c, d) for a, b, c, d in line["draws"]]


def _compare(path: str | Path, at: int, line: dict[str, Any], again: Any, draws: deque[Words]) -> None:
    """Raise an error if the log says anything else than the replay."""
    if draws:
        raise damaged(path, at, "has too many draws")
    for name in ("said", "see", "heard", "status", "goes", *WORK):
        kept, found = line.get(name), again.get(name)
        if kept != found:
            raise FeasibeeError(
                f"{named(path)}: line {at}: {name} is {quoted(kept)} in the log and {quoted(found)} in the "
                "replay; a line is missing or was changed, or another version or strategy wrote it: use an "
                "intact copy"
            )

"""The numbers of a scenario and a seed, as ``struct params`` of engine.h has them.

Lengths are in units of fixed point: see state.h.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any, Final, NamedTuple, get_type_hints

import numpy as np

ALWAYS, WHILE_DISSEMINATING = -1, 0
"""Values of `DecisionParams.listens_for` in addition to a number of steps."""


class Placement(IntEnum):
    """How robots or tasks are placed (model.md 6.4)."""

    UNIFORM = 0
    CLUSTERS = 1
    POINTS = 2


class Lie(IntEnum):
    """The opinion that a Byzantine robot sends (model.md 6.6)."""

    OPPOSITE = 0
    FEASIBLE = 1
    INFEASIBLE = 2
    RANDOM = 3
    COLLUDING = 4  # the opposite of the truth


class Grid(NamedTuple):
    """A grid of cells over the arena; see cells.h and near.h."""

    columns: int
    rows: int
    width: int  # of the arena
    height: int
    half_width: int  # of a cell
    half_height: int
    scale_x: np.uint64  # cells per unit, times 2**52
    scale_y: np.uint64


class BandParams(NamedTuple):
    """Squared distances in coarse units of which the exact one may lie on either side of a range."""

    low: np.uint32  # surely in range if the squared distance is below this
    width: np.uint32  # surely not, if it is at least this much above


class PlacementParams(NamedTuple):
    """Placement of robots or tasks at the start (model.md 6.4)."""

    how: int  # Placement
    clusters: int
    spread: int
    margin: int  # least distance from the walls


class SeedParams(NamedTuple):
    """The seed, as the key of Philox."""

    low: np.uint32
    high: np.uint32


class SideParams(NamedTuple):
    """The sides of the arena in units of length."""

    width: float
    height: float


class PlaceParams(NamedTuple):
    """The grid of a place (model.md 6.20)."""

    exists: bool
    bits: int  # of a position within its cell
    columns: int
    rows: int
    row_words: int  # of `Ground.passable` and `Ground.walls`
    tile_columns: int
    boxes: int  # columns of `Ground.boxes`
    near: int  # squared cells between a task's cell and the one from which robots reach it, at most
    arrived: int  # way at which a robot has reached a task, in fifths of a cell; -1 if nobody acts


class ArenaParams(NamedTuple):
    """The arena (model.md 1.1, 6.1)."""

    walls: bool
    wraps: bool  # whether differences in 32 bits need no correction: in a square torus, and within walls
    width: int
    height: int
    unit: float  # of fixed point, in units of length
    place: PlaceParams
    sides: SideParams


class RobotParams(NamedTuple):
    """The robots and their bodies (model.md 1.2, 6.2, 6.7)."""

    count: int  # type: ignore[assignment]  # numbers that they have; hides tuple.count
    at_start: int
    arrival_rate: float  # per step
    failure_time: float  # steps, on average; 0.0: none fails
    work: int  # steps until it goes to charge; 0: it never goes
    charge: int  # steps
    away_counts: bool  # whether robots that charge are present
    classes: int
    reach: float  # length of a step
    radius: int
    avoid_collisions: bool
    deflects: bool  # whether a blocked robot turns away and goes on
    knows_count: bool
    apart_limit: np.uint64  # discs overlap if the squared distance is below this
    meet_limit: np.uint64  # discs can't meet within a step unless the squared distance is below this
    meet_band: BandParams  # in units of 2**16
    placement: PlacementParams
    grid: Grid


class ListParams(NamedTuple):
    """The lists of tasks by cell of the paper's world; see lists.h."""

    bits: int  # 2**bits cells a side; 0: no lists
    shift: np.uint32  # bits of a coordinate below those of a place in a list
    band: BandParams  # in units of 2**shift


class TaskParams(NamedTuple):
    """The tasks (model.md 1.3, 6.7)."""

    count: int  # type: ignore[assignment]  # numbers that they have; hides tuple.count
    at_start: int
    arrival_rate: float  # per step
    lifetime: float  # steps, on average; 0.0: they stay
    work: int  # steps that a robot works at one; 0: it stays
    placement: PlacementParams
    grid: Grid
    lists: ListParams
    numbered: bool  # whether few robots look through all tasks by number (general path)


class WalkParams(NamedTuple):
    """The random walk (model.md 2)."""

    mean_run: float  # steps


class SensingParams(NamedTuple):
    """Observation of robots and tasks (model.md 4.2, 6.3)."""

    limit: np.uint64  # in sight if the squared distance is below this
    band: BandParams  # in units of 2**16
    count_self: int  # 0 or 1
    unique: bool  # whether a thing counts once
    by_class: bool  # whether robots or tasks have classes
    only_counts: bool  # whether counts of robots and tasks suffice: no classes, no knowledge
    counts_all: bool  # whether, in addition, all in sight count: no misses, repeated observation
    miss: np.uint64  # probability times 2**32
    false_robots: float  # expected number per step
    false_tasks: float
    misname: np.uint64  # probability times 2**32
    merges: bool  # whether positions have errors, so that tasks may share a name
    merge_limit: np.uint64  # two tasks do if their squared distance is below this
    ahead: bool  # whether robots see only what is ahead
    hides: bool  # whether some of what is in range isn't seen: behind walls, or out of view
    view_cosine: float  # of half the view, times 2**30
    view_sine: float


class RadioParams(NamedTuple):
    """Messages (model.md 1.4, 6.5)."""

    limit: np.uint64  # in radio range if the squared distance is below this
    band: BandParams  # in units of 2**16
    loss: np.uint64  # probability times 2**32
    id_bits: int  # length of an id
    delay: int  # steps
    as_sight: bool  # whether robots hear whom they see, but for misses
    random_ids: bool  # whether ids are random, and may collide
    message_bits: int  # length of a message without its knowledge


class KnowledgeParams(NamedTuple):
    """What robots pass on in addition to opinions (model.md 6.11)."""

    enabled: bool
    words: int  # of what a robot knows
    message_words: int
    robot_ids: int  # inventions included
    task_ids: int
    task_classes: int


class StrategyParams(NamedTuple):
    """The constants that a strategy declares."""

    forgets: bool  # whether each exploration counts afresh
    starts_neutral: bool  # whether robots start without an opinion
    declares: bool  # whether robots declare when they are sure
    judges: bool  # whether opinions follow from knowledge in every step
    gives_probability: bool  # whether robots are asked at the end how probable *feasible* is
    value_scale: float  # the largest value that a message can hold; 0.0: messages hold none
    knowledge: KnowledgeParams


class DeclareParams(NamedTuple):
    """When a robot declares by the opinions that it hears."""

    enabled: bool
    share: int  # of an inbox that must agree: share / whole
    whole: int
    rounds: int
    heard: int


class QuorumParams(NamedTuple):
    """The share of the counted robots that a decision needs: more than share / whole (model.md 4.7)."""

    share: int
    whole: int


class DecisionParams(NamedTuple):
    """The controller (model.md 4)."""

    exploration: float  # steps
    gain: float  # steps
    dissemination_floor: int  # steps
    quality_floor: int
    listens_for: int  # last steps of dissemination, or ALWAYS or WHILE_DISSEMINATING
    every_message: bool  # whether the inbox keeps every message, else the latest of each robot
    inbox_size: int  # senders kept, the newest; 0: all
    inbox_is_set: bool  # few robots with ids of their own, and all senders are kept
    own_vote: int  # 0 or 1
    random_ties: int  # 0 or 1
    first_sight: bool  # whether a robot adopts what its first exploration favours
    declare: DeclareParams
    quorum: QuorumParams


class FaultParams(NamedTuple):
    """Faulty robots (model.md 6.6)."""

    stopped: int  # robots
    byzantine: int
    stubborn: int
    stop_step: int
    byzantine_says: int  # Lie
    colluding: bool  # whether Byzantine robots send in every step, the opposite of the truth (model.md 6.16)
    exactly: bool  # whether they invent as many robots or tasks as this takes


class ActingParams(NamedTuple):
    """When and how robots act (model.md 6.25)."""

    acts: bool
    start: int  # step
    by_word: bool  # whether who has declared feasible acts
    by_rank: bool
    tags: bool
    reach: np.uint64  # has arrived if the squared distance is below this
    ranks: int
    come_free: bool  # whether taken tasks may come free
    list_bits: int  # of a message, in addition
    task_bits: int  # and for each known task


class RunParams(NamedTuple):
    """The length of a run (model.md 4.7)."""

    steps: int
    stop_at_decision: bool
    stop_at_declarations: bool
    stop_when_taken: bool


class Params(NamedTuple):
    """The numbers of a scenario and seed."""

    seed: SeedParams
    arena: ArenaParams
    robots: RobotParams
    tasks: TaskParams
    walk: WalkParams
    sensing: SensingParams
    radio: RadioParams
    strategy: StrategyParams
    decision: DecisionParams
    faults: FaultParams
    run: RunParams
    acting: ActingParams
    truth: bool  # at the start
    changes: bool  # whether robots or tasks come or go (model.md 6.17, 6.23)
    truth_stays: bool  # although they may
    together: bool  # whether all robots sense at once: few of them
    in_sender_order: bool  # whether robots must receive the messages of a step in the order of their senders


def record_type(numbers: type[Any]) -> np.dtype[Any]:
    """Return the record type of a NamedTuple of numbers and of such tuples, from its annotations."""
    kinds = get_type_hints(numbers).items()
    fields = [(name, record_type(kind) if hasattr(kind, "_fields") else kind) for name, kind in kinds]
    return np.dtype(fields, align=True)


PARAMS: Final = record_type(Params)


def packed(params: Params) -> Any:
    """Return the numbers as one record, whose bytes are a ``struct params``."""
    record = np.zeros(1, dtype=PARAMS).view(np.recarray)  # also between the numbers: pages have these bytes
    record[0] = _plain(params)
    return record[0]


def _plain(numbers: Any) -> tuple[Any, ...]:
    return tuple(_plain(each) if hasattr(each, "_fields") else each for each in numbers)

"""From a scenario and a seed to the numbers and arrays that the engine works with."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any, TypeVar

import numpy as np

from feasibee.base.codes import exact
from feasibee.engine import params as numbers
from feasibee.engine.params import BandParams, Lie, Placement
from feasibee.engine.tables import FEW, WORD, EventColumn, Int32s, Int64s, Lowered, Tables
from feasibee.scenario.feasibility import can_do, ranks_of, status_bits, truth
from feasibee.scenario.fields import Placed, Point, Robots, Tasks
from feasibee.scenario.messages import bare_bits
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.setting import knowledge_words
from feasibee.scenario.supported import takes_fast_path
from feasibee.simulation import place
from feasibee.strategies.contract import Setting

Numbers = TypeVar("Numbers")
TURN = 2**32
MOST_ROBOTS = 2**24
"""Robots of the largest swarm; play.c has it, too."""
NUMBERED = 128
"""Tasks that a few robots look through by number; among more, cells find those in sight sooner."""


def lower(scenario: Scenario, seed: int, fast: bool | None = None) -> Lowered:
    """Return a scenario and a seed as the engine takes them.

    ``fast`` says whether the fast path plays them; by default it does where it has the scenario's world.
    """
    assert scenario.flooding is not None or not scenario.waits_for_names, "call flooded first"
    fast = takes_fast_path(scenario) if fast is None else fast
    params = params_of(scenario, seed, fast)
    return Lowered(params, tables_of(scenario, params), scenario.strategy, scenario.setting, fast)


def params_of(scenario: Scenario, seed: int, fast: bool) -> numbers.Params:
    """Return the numbers of a scenario and a seed."""
    unit, setting = unit_of(scenario), scenario.setting
    arena, most = _arena(scenario, unit), scenario.most
    together = most.robots <= FEW
    sensing = scenario.sensing
    numbered = arena.wraps and most.tasks <= NUMBERED and not (sensing.misname or sensing.position_error)
    sight, radio = (squared(reach, unit) for reach in (sensing.range, scenario.radio.range))
    return numbers.Params(
        seed=numbers.SeedParams(low=np.uint32(seed & 0xFFFFFFFF), high=np.uint32(seed >> 32)),
        arena=arena,
        robots=_robots(scenario.robots, setting, most.robots, unit, arena, max(sight, radio)),
        tasks=numbers.TaskParams(
            count=most.tasks,
            at_start=scenario.tasks.count,
            arrival_rate=scenario.tasks.arrival_rate or 0.0,
            lifetime=scenario.tasks.lifetime or 0.0,
            work=scenario.tasks.work or 0,
            placement=_placement(scenario.tasks, unit, 0),
            grid=_grid(most.tasks, math.isqrt(sight) + 1, arena),
            lists=_lists(scenario.tasks.count if fast and together else 0, sight + 1),
            numbered=together and not fast and numbered,
        ),
        walk=_filled(numbers.WalkParams, scenario.walk),
        sensing=_sensing(scenario, sight, unit),
        radio=_radio(scenario, setting.id_bits, radio),
        strategy=_strategy(scenario, setting),
        decision=_decision(scenario, most.robots),
        faults=_faults(scenario),
        run=_filled(numbers.RunParams, scenario.run),
        acting=_acting(scenario, unit),
        truth=truth(scenario),
        changes=scenario.in_motion,
        truth_stays=not scenario.dynamic,
        together=together,
        in_sender_order=not fast and _in_sender_order(scenario),
    )


def _in_sender_order(scenario: Scenario) -> bool:
    """Return whether it matters to receivers in which order the messages of a step come."""
    decides = scenario.strategy.knowledge or scenario.decision.inbox_size
    return bool(decides or scenario.radio.id_bits is not None or scenario.acts)


def _filled(kind: Callable[..., Numbers], section: Any, **given: Any) -> Numbers:
    """Return numbers of a kind: those given, and those that a section of the scenario has by their names."""
    names: tuple[str, ...] = getattr(kind, "_fields")  # noqa: B009  # mypy knows no fields of a callable
    own = {name: getattr(section, name) for name in names if name not in given}
    return kind(**own, **given)


def _arena(scenario: Scenario, unit: Fraction) -> numbers.ArenaParams:
    width, height = (fixed(side, unit) for side in scenario.arena.size)
    walls = scenario.arena.boundary == "walls"
    wraps = walls or width == height
    sides = numbers.SideParams(*map(float, scenario.arena.size))
    return numbers.ArenaParams(walls, wraps, width, height, float(unit), place.params_of(scenario), sides)


def _robots(
    robots: Robots,
    setting: Setting,
    most: int,
    unit: Fraction,
    arena: numbers.ArenaParams,
    squared_reach: int,
) -> numbers.RobotParams:
    """Return the numbers of the robots, who see or hear within ``squared_reach``."""
    radius = math.ceil(exact(robots.diameter) / unit / 2)
    meeting = 2 * radius + 2 * math.ceil(exact(robots.speed) / unit) + 4
    widest = max(math.isqrt(squared_reach), meeting if robots.avoid_collisions else 0) + 1
    return numbers.RobotParams(
        count=most,
        at_start=robots.count,
        arrival_rate=robots.arrival_rate or 0.0,
        failure_time=1 / robots.failure_rate if robots.failure_rate else 0.0,
        work=robots.work or 0,
        charge=robots.charge or 0,
        away_counts=robots.away == "counted",
        classes=max(1, len(robots.classes)),
        reach=float(exact(robots.speed) / unit),
        radius=radius,
        avoid_collisions=robots.avoid_collisions,
        deflects=robots.contact == "deflect",
        knows_count=robots.know_count,
        apart_limit=limit_of((2 * radius) ** 2),
        meet_limit=limit_of(meeting**2),
        meet_band=_widened(band_of(meeting**2, 16)),
        placement=_placement(robots, unit, radius if arena.walls else 0),
        grid=_grid(most, widest, arena),
    )


def _sensing(scenario: Scenario, squared_range: int, unit: Fraction) -> numbers.SensingParams:
    sensing = scenario.sensing
    ahead = sensing.view < 360
    hides = ahead or scenario.place.exists
    half = math.floor(sensing.view * TURN / 720 + 0.5) * (2 * math.pi / TURN)
    by_class = bool(scenario.robots.classes or scenario.tasks.classes)
    only_counts = not (by_class or scenario.strategy.knowledge)
    may_miss = sensing.miss > 0 or any(event.sensing.miss for event in scenario.events)
    return _filled(
        numbers.SensingParams,
        sensing,
        limit=limit_of(squared_range + 1),
        band=band_of(squared_range + 1, 16),
        count_self=int(sensing.count_self),
        unique=sensing.observation == "unique",
        by_class=by_class,
        only_counts=only_counts,
        counts_all=only_counts and not may_miss and sensing.observation == "repeated" and not scenario.acts,
        miss=probability(sensing.miss),
        misname=probability(sensing.wrong),
        merges=sensing.position_error > 0,
        merge_limit=limit_of(squared(sensing.merged, unit) + 1 if sensing.merged >= 0 else 0),
        ahead=ahead,
        hides=hides,
        view_cosine=float(math.floor(2**30 * math.cos(half) + 0.5)),
        view_sine=float(math.floor(2**30 * math.sin(half) + 0.5)),
    )


def _radio(scenario: Scenario, id_bits: int, squared_range: int) -> numbers.RadioParams:
    radio = scenario.radio
    return numbers.RadioParams(
        limit=limit_of(squared_range + 1),
        band=band_of(squared_range + 1, 16),
        loss=probability(radio.loss),
        id_bits=id_bits,
        delay=radio.delay,
        as_sight=radio.range == scenario.sensing.range
        and scenario.sensing.view == 360
        and not (scenario.plan and radio.walls),
        random_ids=radio.id_bits is not None,
        message_bits=bare_bits(scenario, id_bits),
    )


def _strategy(scenario: Scenario, setting: Setting) -> numbers.StrategyParams:
    strategy = scenario.strategy
    words, message_words = knowledge_words(strategy, setting) if strategy.knowledge else (0, 0)
    return _filled(
        numbers.StrategyParams,
        strategy,
        gives_probability=scenario.gives_probability,
        value_scale=float(2**strategy.value_bits - 1),
        knowledge=_filled(
            numbers.KnowledgeParams,
            setting,
            enabled=strategy.knowledge,
            words=words,
            message_words=message_words,
        ),
    )


def _decision(scenario: Scenario, most: int) -> numbers.DecisionParams:
    decision, rule = scenario.decision, scenario.decision.declare
    all_kept = decision.inbox_size is None and scenario.radio.id_bits is None
    return _filled(
        numbers.DecisionParams,
        decision,
        listens_for=_listens_for(decision.listen),
        every_message=decision.inbox == "every-message",
        inbox_size=decision.inbox_size or 0,
        inbox_is_set=most <= FEW and all_kept,
        own_vote=int(decision.own_vote),
        random_ties=int(decision.ties == "random-message"),
        first_sight=decision.start == "first-sight",
        declare=numbers.DeclareParams(
            enabled=rule is not None,
            share=exact(rule.quorum).numerator if rule else 0,
            whole=exact(rule.quorum).denominator if rule else 1,
            rounds=rule.rounds if rule else 0,
            heard=rule.heard if rule else 0,
        ),
        quorum=_quorum(exact(decision.threshold)),
    )


def _listens_for(listen: Any) -> int:
    words = {"always": numbers.ALWAYS, "dissemination": numbers.WHILE_DISSEMINATING}
    return words[listen] if isinstance(listen, str) else int(listen["last"])


def _quorum(threshold: Fraction) -> numbers.QuorumParams:
    """Return a fraction whose products with numbers of robots round down as the threshold's.

    That is the largest one not above it whose denominator isn't above `MOST_ROBOTS`: nothing overflows.
    """
    near = threshold.limit_denominator(MOST_ROBOTS)
    if near <= threshold:
        return numbers.QuorumParams(near.numerator, near.denominator)
    # Of two neighbours among these fractions, the lower is p / q with near * q - p = 1 / denominator.
    inverse = pow(near.numerator, -1, near.denominator)
    below = MOST_ROBOTS - (MOST_ROBOTS - inverse) % near.denominator
    return numbers.QuorumParams((near.numerator * below - 1) // near.denominator, below)


def _faults(scenario: Scenario) -> numbers.FaultParams:
    stopped, byzantine, stubborn = scenario.faulty
    says = scenario.faults.byzantine_says
    colluding = says == "colluding"
    return numbers.FaultParams(
        stopped=stopped,
        byzantine=byzantine,
        stubborn=stubborn,
        stop_step=scenario.faults.stop_step,
        byzantine_says=Lie[says.upper()],
        colluding=colluding,
        exactly=colluding and not (scenario.robots.classes or scenario.tasks.classes),
    )


def _acting(scenario: Scenario, unit: Fraction) -> numbers.ActingParams:
    acting = scenario.acting
    place = 0 if scenario.manifest.sends_positions else 33
    return _filled(
        numbers.ActingParams,
        acting,
        acts=scenario.acts,
        start=scenario.acts_from,
        by_word=acting.start == "declared",
        by_rank=acting.choose == "rank",
        tags=acting.hold == "tag",
        reach=limit_of(squared(acting.reach, unit) + 1),
        ranks=max(ranks_of(scenario.robots)),
        come_free=scenario.may_come_free,
        list_bits=int(place > 0),
        task_bits=place + status_bits(scenario),
    )


def _placement(section: Placed, unit: Fraction, margin: int) -> numbers.PlacementParams:
    return numbers.PlacementParams(
        how=Placement[section.placement.upper()],
        clusters=section.clusters,
        spread=fixed(section.spread, unit),
        margin=margin,
    )


def _grid(points: int, reach: int, arena: numbers.ArenaParams) -> numbers.Grid:
    """Return the finest grid whose half cells are longer than ``reach``, and not more cells than points.

    Up to 32 points need no grid: they are looked at together. Half cells are longer by 1 in 2**16, more than
    the rounding of the scale takes away.
    """
    cells = math.isqrt(points) if points > WORD else 1
    columns, rows = (
        max(1, min(cells, side * 2**16 // (2 * reach * (2**16 + 1)))) for side in (arena.width, arena.height)
    )
    # Within walls a thing may stand on the far one, which belongs to the last cell.
    scale_x, scale_y = (
        np.uint64(2**52 * count // (side + arena.walls))
        for count, side in ((columns, arena.width), (rows, arena.height))
    )
    halves = arena.width // (2 * columns), arena.height // (2 * rows)
    return numbers.Grid(columns, rows, arena.width, arena.height, *halves, scale_x, scale_y)


def _lists(tasks: int, limit: int) -> numbers.ListParams:
    """Return the grid of the lists of tasks in sight: 4, 8 or 16 cells a side, so that one vector has most.

    A place in a list has 16 bits an axis, which span twice the range and a cell. Where that is too much, or
    cells around a task would come up twice, one list has all tasks.
    """
    bits = 4 if tasks >= 64 else 3 if tasks >= 16 else 2
    reach, side = math.isqrt(limit) + 1, TURN >> bits
    shift = max(0, (2 * (reach + side) + 7).bit_length() - 16)
    if not tasks or reach >= (2 ** (bits - 1) - 1) * side or shift > 16:
        bits, shift = 0, 16
    return numbers.ListParams(bits, np.uint32(shift), band_of(limit, shift))


def tables_of(scenario: Scenario, params: numbers.Params) -> Tables:
    """Return the arrays of a scenario: classes, sets of skills, given points, events, place."""
    robots, tasks = scenario.robots, scenario.tasks
    return Tables(
        class_of=np.concatenate(
            [
                _numbers([each.count for each in robots.classes], scenario.most.robots),
                _numbers([each.count for each in tasks.classes], scenario.most.tasks),
            ]
        ),
        adds=_adds(scenario),
        points=np.concatenate(
            [
                _given_points(scenario, robots, params.robots.placement.margin, params.arena),
                _given_points(scenario, tasks, 0, params.arena),
            ]
        ),
        ranks=np.array(ranks_of(robots), np.int64),
        able=np.array(can_do(robots, tasks), np.int64),
        events=_events(scenario, params),
        ground=place.tables_of(scenario),
    )


def _events(scenario: Scenario, params: numbers.Params) -> Int64s:
    """Return the events in the order in which they happen: by step, then as in the file."""

    def place(at: Point | None, of_tasks: bool) -> list[int]:
        margin = 0 if of_tasks else params.robots.placement.margin
        return _place_at(scenario, at, margin, params.arena) if at else [-1, -1]

    rows = [
        [
            event.step,
            event.tasks,
            event.robots,
            -1 if event.sensing.miss is None else int(probability(event.sensing.miss)),
            -1 if event.radio.loss is None else int(probability(event.radio.loss)),
            -1 if event.task is None else event.task,
            -1 if event.robot is None else event.robot,
            *place(event.at, event.of_tasks),
        ]
        for event in sorted(scenario.events, key=lambda event: event.step)
    ]
    return np.array(rows, np.int64).reshape(-1, len(EventColumn))


def _adds(scenario: Scenario) -> Any:
    """Return what each class adds to each set of skills: each subset of them, then all robots and places."""
    robots, tasks = scenario.robots.classes, scenario.tasks.classes
    skills = sorted({s for each in robots for s in each.skills} | {s for each in tasks for s in each.needs})
    subsets = range(1, 2 ** len(skills))
    has = [sum(2 ** skills.index(skill) for skill in set(each.skills)) for each in robots] or [0]
    robot_adds = [[int(mask & subset > 0) for mask in has] for subset in subsets]
    task_adds = [
        [
            sum(number for skill, number in each.needs.items() if subset >> skills.index(skill) & 1)
            for each in tasks
        ]
        or [0]
        for subset in subsets
    ]
    robot_adds.append([1] * len(has))
    task_adds.append([sum(each.needs.values()) for each in tasks] or [1])
    return np.hstack([np.array(robot_adds, np.int64), np.array(task_adds, np.int64)])


def _numbers(counts: list[int], total: int) -> Int32s:
    """Return the class of each robot or task: first those of class 0, then those of class 1, ...

    Those that aren't there at the start have class 0 until a run draws theirs.
    """
    kinds = np.zeros(total, np.int32)
    kinds[: sum(counts)] = np.repeat(np.arange(len(counts), dtype=np.int32), counts)
    return kinds


def _given_points(
    scenario: Scenario, section: Robots | Tasks, margin: int, arena: numbers.ArenaParams
) -> Int32s:
    """Return given points in fixed point, off the walls by a margin."""
    if section.placement != "points":
        return np.zeros((section.count, 2), np.int32)
    places = [_place_at(scenario, point, margin, arena) for point in section.points]
    return np.array(places, np.int64).astype(np.uint32).view(np.int32).reshape(-1, 2)


def _place_at(scenario: Scenario, point: Point, margin: int, arena: numbers.ArenaParams) -> list[int]:
    """Return a point in fixed point, off the walls by a margin."""
    sides, unit = (arena.width, arena.height), unit_of(scenario)
    edge = max(margin, int(arena.place.exists))
    return [
        min(max(math.floor(exact(p) / unit), margin), side - edge)
        for p, side in zip(point, sides, strict=True)
    ]


def unit_of(scenario: Scenario) -> Fraction:
    """Return the unit of fixed point: the longer side is 2**32 of them on the torus, 2**31 within walls."""
    if scenario.plan:
        return scenario.plan.unit
    longer = max(exact(side) for side in scenario.arena.size)
    return longer / (TURN // 2 if scenario.arena.boundary == "walls" else TURN)


def fixed(length: float, unit: Fraction) -> int:
    """Return a length in whole units of fixed point, rounded down."""
    return math.floor(exact(length) / unit)


def squared(length: float, unit: Fraction) -> int:
    """Return the square of a length in units of fixed point, rounded down."""
    return math.floor((exact(length) / unit) ** 2)


def limit_of(squared: int) -> np.uint64:
    """Return a bound of squared distances; none is larger than 2**63."""
    return np.uint64(min(squared, 2**63 + 1))


def band_of(limit: int, shift: int) -> BandParams:
    """Return the squared distances that leave open whether a point is in range, without ``shift`` bits.

    A rounded coordinate is off by less than 1, a difference of two likewise, and a distance by less than 1.5.
    All points are in doubt for a range too short or too long for 16 bits.
    """
    reach = math.sqrt(limit) / 2**shift
    low = math.floor(max(reach - 1.5, 0) ** 2)
    high = math.ceil((reach + 1.5) ** 2)
    if low == 0 or high > TURN // 2:
        return BandParams(np.uint32(0), np.uint32(TURN - 1))
    return BandParams(np.uint32(low), np.uint32(min(high - low, TURN - 1)))


def _widened(band: BandParams) -> BandParams:
    """Return a band that leaves nothing in doubt, for what may be found although it is too far."""
    return BandParams(band.low + band.width, np.uint32(0)) if band.low > 0 else band


def probability(share: float) -> np.uint64:
    """Return a probability times 2**32; 1 for any above 0."""
    return np.uint64(math.ceil(exact(share) * TURN))

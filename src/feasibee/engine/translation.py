"""From a scenario to the numbers that the kernels work with."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np

from feasibee.engine.layout import (
    ALWAYS,
    CENSUS,
    NOTHING,
    SKETCH,
    TALLY,
    TURN,
    WHILE_DISSEMINATING,
    WORD,
    Grid,
    Int32s,
    Kinds,
    Params,
    Placing,
)
from feasibee.model.codes import exact
from feasibee.scenario.fields import Placed, Robots, Tasks
from feasibee.scenario.scenario import Scenario
from feasibee.strategies import contract

KNOWLEDGE = {"tally": TALLY, "estimate": TALLY, "census": CENSUS, "sketch": SKETCH}


def params_of(scenario: Scenario, seed: int) -> Params:
    """Translate a scenario into the kernels' numbers."""
    return Params(
        robots=scenario.robots.count,
        tasks=scenario.tasks.count,
        robot_classes=max(1, len(scenario.robots.classes)),
        seed_low=np.uint32(seed & 0xFFFFFFFF),
        seed_high=np.uint32(seed >> 32),
        mixed=_is_mixed(scenario),
        together=scenario.robots.count <= WORD and is_paper(scenario),
        steps=scenario.run.steps,
        stop_at_decision=scenario.run.stop_at_decision,
        **_space(scenario),
        **_senses(scenario),
        **_controller(scenario),
        **_faults(scenario),
    )


def _space(scenario: Scenario) -> dict[str, Any]:
    """Return the numbers of arena, bodies and reaches, in units of fixed point."""
    robots = scenario.robots
    unit = unit_of(scenario)
    width, height = (math.floor(exact(side) / unit) for side in scenario.arena.size)
    walls = scenario.arena.boundary == "walls"
    radius = math.ceil(exact(robots.diameter) / unit / 2)
    meeting = 2 * radius + 2 * math.ceil(exact(robots.speed) / unit) + 4
    sight = math.floor((exact(scenario.sensing.range) / unit) ** 2)
    radio = math.floor((exact(scenario.radio.range) / unit) ** 2)
    widest = max(math.isqrt(sight), math.isqrt(radio), meeting if robots.avoid_collisions else 0) + 1
    return {
        "walls": walls,
        "wraps": walls or width == height,
        "width": width,
        "height": height,
        "sight_limit": _limit(sight + 1),
        "radio_limit": _limit(radio + 1),
        "reach": float(exact(robots.speed) / unit),
        "radius": radius,
        "avoid_collisions": robots.avoid_collisions,
        "apart_limit": _limit((2 * radius) ** 2),
        "meet_limit": _limit(meeting**2),
        "robot_placing": _placing(robots, unit, radius if walls else 0),
        "task_placing": _placing(scenario.tasks, unit, 0),
        "mean_run": scenario.walk.mean_run,
        "robot_grid": _grid(robots.count, widest, width, height, walls),
        "task_grid": _grid(scenario.tasks.count, math.isqrt(sight) + 1, width, height, walls),
    }


def _senses(scenario: Scenario) -> dict[str, Any]:
    """Return the numbers of what robots see and hear."""
    sensing, radio = scenario.sensing, scenario.radio
    id_bits = radio.id_bits or max(1, (scenario.robots.count - 1).bit_length())
    only_counts = not (_is_mixed(scenario) or scenario.strategy.knowledge)
    return {
        "count_self": int(sensing.count_self),
        "unique": sensing.observation == "unique",
        "for_life": sensing.memory == "life",
        "only_counts": only_counts,
        "counts_all": only_counts and sensing.miss == 0 and sensing.observation == "repeated",
        "miss": _probability(sensing.miss),
        "loss": _probability(radio.loss),
        "false_robots": sensing.false_robots,
        "false_tasks": sensing.false_tasks,
        "message_bits": _message_bits(scenario, id_bits),
        "id_bits": id_bits,
        "random_ids": radio.id_bits is not None,
    }


def _is_mixed(scenario: Scenario) -> bool:
    return bool(scenario.robots.classes or scenario.tasks.classes)


def _controller(scenario: Scenario) -> dict[str, Any]:
    """Return the numbers of the robots' minds."""
    decision, strategy, rule = scenario.decision, scenario.strategy, scenario.decision.commit
    return {
        "exploration": decision.exploration,
        "gain": decision.gain,
        "dissemination_floor": decision.dissemination_floor,
        "quality_floor": decision.quality_floor,
        "forgets": strategy.forgets,
        "starts_neutral": strategy.starts_neutral,
        "says": strategy.say is not contract.say,
        "value_scale": float(2**strategy.value_bits - 1),
        "inbox_size": decision.inbox_size or 0,
        "commit": rule is not None,
        "commit_share": exact(rule.quorum).numerator if rule else 0,
        "commit_whole": exact(rule.quorum).denominator if rule else 1,
        "commit_rounds": rule.rounds if rule else 0,
        "commit_heard": rule.heard if rule else 0,
        "knowledge": KNOWLEDGE[strategy.name] if strategy.knowledge else NOTHING,
        "estimates": strategy.name == "estimate",
        "own_vote": int(decision.own_vote),
        "listens_for": _listens_for(decision.listen),
        "every_message": decision.inbox == "every-message",
    }


def _faults(scenario: Scenario) -> dict[str, Any]:
    """Return the numbers of what goes wrong, and of how many robots make a decision."""
    stopped, byzantine, stubborn = scenario.faulty
    says = ("opposite", "feasible", "infeasible", "random").index(scenario.faults.byzantine_says)
    honest = scenario.robots.count - byzantine
    return {
        "stopped": stopped,
        "byzantine": byzantine,
        "stubborn": stubborn,
        "stop_step": scenario.faults.stop_step,
        "byzantine_says": says,
        "quorum": _quorum(scenario, honest),
        "quorum_stopped": _quorum(scenario, honest - stopped),
    }


def unit_of(scenario: Scenario) -> Fraction:
    """Return the unit of fixed point: the longer side is 2**32 of them on the torus, 2**31 within walls."""
    longer = max(exact(side) for side in scenario.arena.size)
    return longer / (TURN // 2 if scenario.arena.boundary == "walls" else TURN)


def is_paper(scenario: Scenario) -> bool:
    """Tell whether nothing is beyond the paper but its strategy.

    No walls, collisions, classes, errors, losses or faults, and messages of which each robot's latest counts.
    """
    arena, robots, tasks = scenario.arena, scenario.robots, scenario.tasks
    sensing, faults = scenario.sensing, scenario.faults
    width, height = arena.size
    return (
        arena.boundary == "torus"
        and width == height
        and not robots.avoid_collisions
        and robots.placement == tasks.placement == "uniform"
        and not (robots.classes or tasks.classes)
        and sensing.observation == "repeated"
        and sensing.miss == sensing.false_robots == sensing.false_tasks == scenario.radio.loss == 0
        and faults.stopped == faults.byzantine == faults.stubborn == 0
        and scenario.decision.listen in ("always", "dissemination")
        and (scenario.decision.inbox_size, scenario.decision.commit, scenario.radio.id_bits)
        == (None, None, None)
        and scenario.strategy.knowledge is None
    )


def _listens_for(listen: Any) -> int:
    words = {"always": ALWAYS, "dissemination": WHILE_DISSEMINATING}
    return words[listen] if isinstance(listen, str) else int(listen["last"])


def _message_bits(scenario: Scenario, id_bits: int) -> int:
    """Return the length of what a message holds beside knowledge: id, opinion, value and commitment."""
    commitment = int(scenario.decision.commit is not None)
    if scenario.strategy.knowledge:
        return (id_bits + 2) * commitment
    return id_bits + 1 + scenario.strategy.value_bits + commitment


def _limit(squared: int) -> np.uint64:
    """Return a bound of squared distances; none is larger than 2**63."""
    return np.uint64(min(squared, 2**63 + 1))


def _probability(share: float) -> np.uint64:
    return np.uint64(math.ceil(exact(share) * TURN))


def _quorum(scenario: Scenario, counted: int) -> int:
    return math.floor(exact(scenario.decision.threshold) * counted) + 1


def _placing(section: Placed, unit: Fraction, margin: int) -> Placing:
    how = ("uniform", "clusters", "corner", "points").index(section.placement)
    return Placing(how, section.clusters, math.floor(exact(section.spread) / unit), margin)


def _grid(points: int, reach: int, width: int, height: int, walls: bool) -> Grid:
    """Return the finest grid whose half cells are longer than ``reach``, and not more cells than points.

    Up to 32 points need no grid: they are looked at together. Half cells are longer by 1 in 2**18, more than
    the rounding of the scale takes away.
    """
    bits = 0
    if points > WORD:
        by_range = (min(width, height) * 2**18 // (2 * reach * (2**18 + 1))).bit_length() - 1
        bits = max(0, min(by_range, (points.bit_length() - 1) // 2))
    # Within walls a thing may stand on the far one, which belongs to the last cell.
    scales = (np.uint64(2 ** (52 + bits) // (side + walls)) for side in (width, height))
    return Grid(bits, width, height, *scales)


def kinds_of(scenario: Scenario, params: Params) -> Kinds:
    """Lay out classes and sets of skills: each subset of them, and then all robots against all places."""
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
    unit = unit_of(scenario)
    return Kinds(
        of=np.concatenate(
            [
                _numbers([each.count for each in robots], params.robots),
                _numbers([each.count for each in tasks], params.tasks),
            ]
        ),
        adds=np.hstack([np.array(robot_adds, np.int64), np.array(task_adds, np.int64)]),
        points=np.concatenate(
            [
                _fixed(scenario.robots, unit, params.robot_placing.margin, params),
                _fixed(scenario.tasks, unit, 0, params),
            ]
        ),
        parameters=np.array(list(scenario.decision.parameters.values()), np.float64),
    )


def _numbers(counts: list[int], total: int) -> Int32s:
    """Return the class of each of all things: first those of class 0, then those of class 1, ..."""
    return np.repeat(np.arange(len(counts) or 1, dtype=np.int32), counts or [total])


def _fixed(section: Robots | Tasks, unit: Fraction, margin: int, params: Params) -> Int32s:
    """Return given points in fixed point, off the walls by a margin."""
    if section.placement != "points":
        return np.zeros((section.count, 2), np.int32)
    sides = (params.width, params.height)
    places = [
        [
            min(max(math.floor(exact(p) / unit), margin), side - margin)
            for p, side in zip(point, sides, strict=True)
        ]
        for point in section.points
    ]
    return np.array(places, np.int64).astype(np.uint32).view(np.int32).reshape(-1, 2)

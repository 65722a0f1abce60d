"""A scenario as one robot's moves between classes; the strategy's own functions say how it decides."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import product, repeat
from typing import Final

import numpy as np

from feasibee.scenario.fields import Decision
from feasibee.scenario.scenario import Scenario
from feasibee.strategies.contract import Inbox, Mind, Strategy
from feasibee.theory.classes import Array, Moves
from feasibee.theory.geometry import Space, audible, ending
from feasibee.theory.quality import GRID, Sight, company, durations, qualities
from feasibee.theory.saddle import changing

MOST_VOTES = 13
"""Largest number of votes for each opinion that an inbox keeps; fewer if robots hear few."""
LEAST = 0.05
"""Least relative number of votes heard before a dissemination; fitted durations may give less."""
CHANCES = 60
"""Number of values that stand for a random number from 0 to 1."""


SAYS: Final = {
    "opposite": ((0, 1), (1, 0)),
    "feasible": ((1, 0), (1, 0)),
    "infeasible": ((0, 1), (0, 1)),
    "random": ((0.5, 0.5), (0.5, 0.5)),
}
"""What Byzantine robots broadcast, feasible and infeasible, by the opinion that they hold."""


def swarm_of(scenario: Scenario, feasible_ones: int | None = None) -> Moves:
    """Return the numbers of one robot of a scenario; it isn't checked that the theory covers the scenario.

    Of the stubborn robots, ``feasible_ones`` hold feasible; half of them by default.
    """
    decision, strategy = scenario.decision, scenario.strategy
    parameters = tuple(float(decision.parameters[name]) for name in strategy.parameters)

    def rule(most: int) -> Array:
        return adopting(strategy, parameters, voting_of(decision), most)

    space = Space(scenario.arena.size, scenario.robots.speed, ending(scenario.walk.mean_run))
    explored = ending(decision.exploration)
    feasible = qualities(_sight(scenario, space, explored))
    none = np.zeros_like(feasible)
    none[:, GRID // 2] = 1
    rated = (feasible, feasible[:, ::-1], none)[: len(rule(1))]
    means = [strategy.dissemination(each / GRID, decision.gain) for each in range(GRID + 1)]
    steps = np.array([1 / ending(mean) for mean in means])
    ends, weights = map(np.array, zip(*(durations(each[0], steps) for each in rated), strict=True))
    delivered, hear = 1 - scenario.radio.loss, decision.listen == "always"
    heard = audible(space, scenario.radio.range, delivered, explored, ends, weights, hear)
    sending = (weights / ends).sum(1)[:2]
    free, speaking, stubborn = _others(scenario, feasible_ones, sending / (1 / explored + sending))
    swarm = Moves(
        free,
        rule(1),
        explored,
        ends,
        weights,
        heard,
        _heard(scenario, rated, steps, ends, weights) if hear else np.ones_like(ends),
        speaking,
        stubborn,
        begins=_begins(decision.start, feasible[0]),
    )
    _, votes = swarm.activity()
    most = min(MOST_VOTES, math.ceil(1 + votes + 2.5 * math.sqrt(votes)))
    swarm = replace(swarm, adopting=rule(most))
    return replace(swarm, kept=1 - changing(swarm) / 2)  # a vote is half a round old on average


def _heard(scenario: Scenario, rated: Sequence[Array], steps: Array, ends: Array, weights: Array) -> Array:
    """Return how many votes robots of each duration heard while exploring, relative to the mean."""
    met = np.array([company(*each) for each in zip(rated, repeat(steps), ends, weights)])
    in_sight = min(1.0, (scenario.sensing.range / scenario.radio.range) ** 2)  # of those that are heard
    heard: Array = np.maximum(LEAST, 1 + (met - 1) * in_sight)
    return heard


def _others(scenario: Scenario, feasible_ones: int | None, sending: Array) -> tuple[int, Array, Array]:
    """Return the number of robots without a fault, and what Byzantine and stubborn ones broadcast.

    ``sending`` is the part of the time in which a robot of each opinion broadcasts.
    """
    _, lying, stubborn = scenario.faulty
    free = scenario.robots.count - lying - stubborn
    says = np.array(SAYS[scenario.faults.byzantine_says]) if lying else np.zeros((2, 2))
    first = stubborn // 2 if feasible_ones is None else feasible_ones
    held = np.array([first, stubborn - first])
    return free, np.eye(2) + lying / free * says, np.concatenate([held * sending, held])


def _begins(start: str, feasible: Array) -> float:
    """Return the probability that a robot begins with *feasible*: of a coin, or of its first exploration."""
    if start == "coin":
        return 0.5
    middle = GRID // 2
    return float(feasible[middle + 1 :].sum() + feasible[middle] / 2)


def _sight(scenario: Scenario, space: Space, explored: float) -> Sight:
    """Return what a robot of a scenario sees while it explores."""
    sensing = scenario.sensing
    others = scenario.robots.count - 1
    tasks, floor = scenario.tasks.count, scenario.decision.quality_floor
    seen, itself = 1 - sensing.miss, sensing.count_self
    return Sight(space, sensing.range, scenario.radio.range, seen, others, tasks, itself, floor, explored)


def voting_of(decision: Decision) -> tuple[bool, bool]:
    """Return whether a robot's own opinion counts, and whether a tie takes a random message."""
    return decision.own_vote, decision.ties == "random-message"


@lru_cache(maxsize=32)
def adopting(
    strategy: Strategy, parameters: tuple[float, ...], voting: tuple[bool, bool], most: int
) -> Array:
    """Return the probability of each opinion after a decision: feasible, infeasible, and none if it occurs.

    ``voting`` is that of `voting_of`.
    The shape is (opinions, most + 1, most + 1, opinions): opinion before, votes for feasible and infeasible.
    """
    found = np.zeros((3, most + 1, most + 1, 3))
    for row, yes, no in np.ndindex(found.shape[:3]):
        found[row, yes, no] = _chosen(strategy, parameters, voting, (1, 0, -1)[row], yes, no)
    opinions = 3 if found[:2, ..., 2].any() else 2
    return found[:opinions, ..., :opinions]


@lru_cache(maxsize=2048)
def _chosen(
    strategy: Strategy,
    parameters: tuple[float, ...],
    voting: tuple[bool, bool],
    opinion: int,
    yes: int,
    no: int,
) -> Array:
    """Return the probabilities of feasible, infeasible and none after a decision with these votes."""
    found = np.zeros(3)
    own_vote, random_ties = map(int, voting)
    mind = Mind(opinion, 0.5, 0.5, own_vote, (), parameters, random_ties)
    draws = {1: yes / (yes + no), 0: no / (yes + no)} if yes + no else {-1: 1.0}
    for (heard, weight), chance in product(draws.items(), (np.arange(CHANCES) + 0.5) / CHANCES):
        chosen = strategy.decide(mind, Inbox(yes, no, heard, 0.0, 0.0, chance))
        found[(1, 0, -1).index(chosen)] += weight / CHANCES
    return found

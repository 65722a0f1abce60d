"""States of a swarm on the way from one consensus to the other, and the point where it tips."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from feasibee.theory.classes import CLASS, EXPLORING, SENDING, Array, Hearing, Moves

ITERATIONS = 400
"""Most iterations for the value of the classes, and for the share of robots without an opinion."""

SHIFT = 0.3
"""What is taken from all eigenvalues, none of which is far below 0: all but the largest fade sooner."""


@dataclass(frozen=True)
class Manifold:
    """States at which all but the balance of opinions is at rest, and what changes that balance there."""

    states: Array
    """Number of robots in each class, shape (points, opinions, phases, votes)."""
    value: Array
    """What a robot of each class adds to the balance in the long run, shape as ``states``.

    It is 1 more for feasible than for infeasible, with an empty inbox."""
    growth: Array
    """Factor per step by which a deviation grows, shape (points,)."""
    drift: Array
    """Mean change of the value per step, in robots, shape (points,)."""
    noise: Array
    """Variance of that change, shape (points,)."""

    @property
    def places(self) -> Array:
        """How far each state is from the first, in robots, by changes of the value; shape (points,)."""
        middle = (self.value[1:] + self.value[:-1]) / 2
        return np.concatenate([[0.0], np.cumsum((middle * np.diff(self.states, axis=0)).sum(CLASS))])

    @property
    def holders(self) -> Array:
        """Number of robots that hold each opinion, shape (points, opinions)."""
        held: Array = self.states.sum(CLASS[1:])
        return held


def manifold(swarm: Moves, shares: Array) -> Manifold:
    """Return the states at which these shares of all rounds with an opinion begin with *feasible*."""
    states, hearing, _, _ = _balanced(swarm, shares)
    value, growth = _values(swarm, states, hearing)
    change = swarm.forward(states, hearing) - states
    return Manifold(states, value, growth, (value * change).sum(CLASS), swarm.noise(states, value, hearing))


def _rounds(swarm: Moves, hearing: Hearing) -> tuple[Array, Array]:
    """Return the mean steps in each class in a round from each opinion, and chances of the next opinion."""
    visits = np.zeros((*hearing.feasible.shape[:-2], *swarm.adopting.shape[1:3]))
    visits[..., EXPLORING, 0, 0] = 1
    exploring, sending = (
        Hearing(hearing.feasible[..., phases, :, :], hearing.infeasible[..., phases, :, :], hearing.sends)
        for phases in (slice(SENDING), slice(SENDING, None))
    )
    explorers = exploring.steps_until(visits[..., :SENDING, :, :], np.array([1 - swarm.explored]))
    visits[..., :SENDING, :, :] += (1 - swarm.explored) * explorers
    first = swarm.explored * hearing.sends * explorers
    senders = sending.steps_until(first, 1 - swarm.ends)
    visits[..., SENDING:, :, :] = first + (1 - swarm.ends)[..., None, None] * senders
    return visits, swarm.decided(senders)


def _balanced(swarm: Moves, shares: Array) -> tuple[Array, Hearing, Array, Array]:
    """Return states, how votes add up there, rounds per step by opinion, and chances of the next opinion.

    Robots without an opinion are in balance with the others.
    """
    opinions = len(swarm.ends)
    sending = (swarm.weights / swarm.ends).sum(1)
    lasting = 1 / swarm.explored + sending
    none = np.full(len(shares), 0.2 if opinions > 2 else 0.0)
    for _ in range(ITERATIONS):
        parts = np.stack([shares * (1 - none), (1 - shares) * (1 - none), none][:opinions], axis=1)
        rounds = swarm.robots * parts / (parts @ lasting)[:, None]
        counts = np.concatenate([rounds[:, :2] * sending[:2], rounds[:, :2] * lasting[:2]], axis=1)
        hearing = swarm.hearing(counts)
        visits, chances = _rounds(swarm, hearing)
        if opinions == 2:
            break
        lost = shares * chances[:, 0, 2] + (1 - shares) * chances[:, 1, 2]
        before, none = none, lost / np.maximum(lost + 1 - chances[:, 2, 2], 1e-300)
        if np.abs(none - before).max() < 1e-9:
            break
    states = visits * rounds[..., None, None, None]
    states *= (swarm.robots / states.sum(CLASS))[:, None, None, None, None]
    return states, hearing, rounds, chances


def _values(swarm: Moves, states: Array, hearing: Hearing) -> tuple[Array, Array]:
    """Return the value of each class, a left eigenvector of the linear dynamics, and its eigenvalue."""
    counts, small = swarm.counts(states), 1e-4 * swarm.robots
    influence = []  # what one more of each kind that others hear changes
    for kind in np.eye(counts.shape[1]):
        more, fewer = (swarm.hearing(counts + sign * small * kind) for sign in (1, -1))
        influence.append((swarm.forward(states, more) - swarm.forward(states, fewer)) / (2 * small))
    points = len(states)
    weights = np.stack([*influence, states / swarm.robots], axis=1).reshape(points, len(influence) + 1, -1)
    value = np.zeros_like(states)
    value[:, 0], value[:, 1] = 0.5, -0.5
    growth = np.zeros(len(states))
    for iteration in range(ITERATIONS):
        effect = (weights[:, :-1] @ value.reshape(points, -1, 1))[..., None, None]
        after = swarm.backward(value, hearing)
        after[:, :2, SENDING:] += effect[:, :2]
        after[:, :2] += effect[:, 2:]
        after -= (weights[:, -1:] @ after.reshape(points, -1, 1))[..., None, None]
        found = after[:, 0, EXPLORING, 0, 0] - after[:, 1, EXPLORING, 0, 0]
        value = (after - SHIFT * value) / (found - SHIFT)[:, None, None, None, None]
        if np.abs(found - growth).max() < 1e-7 and iteration > 30:
            break
        growth = found
    return value, found


@dataclass(frozen=True)
class Tipping:
    """Where a swarm tips: with more robots for feasible than that, it drifts to feasible."""

    point: float
    """Share of feasible opinions at the start from which the swarm drifts to neither consensus."""
    growth: float
    """Factor per step by which a deviation from it grows, above 1."""
    coins: float
    """Variance of the number of feasible opinions at the start, in robots squared."""
    later: float
    """Variance that all later steps add, in the same unit: noise / (growth² - 1)."""

    @property
    def e_fold(self) -> float:
        """Steps in which a deviation grows by a factor e."""
        return 1 / math.log(self.growth)

    @property
    def coins_share(self) -> float:
        """Share of the variance that is in the swarm from the start."""
        return self.coins / (self.coins + self.later)

    def share(self, robots: int) -> float:
        """Return the share of swarms that decide feasible: the formula, without a chain."""
        deviation = robots * (0.5 - self.point) / math.sqrt(self.coins + self.later)
        return 0.5 * (1 + math.erf(deviation / math.sqrt(2)))


def tipping(swarm: Moves) -> Tipping | None:
    """Return where a swarm tips; None if it has no such point, or opinions don't grow there."""
    low, high = 0.02, 0.98
    for points in (13, 6, 6):
        shares = np.linspace(low, high, points)
        drift = _flow(swarm, shares)
        crossings = np.flatnonzero((drift[:-1] <= 0) & (drift[1:] > 0))
        if not crossings.size:
            return None
        at = min(crossings, key=lambda k: abs(shares[k] - 0.5))
        low, high = shares[at], shares[at + 1]
    root = low - drift[at] * (high - low) / (drift[at + 1] - drift[at])
    along = manifold(swarm, np.array([root]))
    growth = float(along.growth[0])
    if growth <= 1:
        return None
    state = swarm.start()[None]
    for _ in range(steps := swarm.round_length()):  # until what explorers heard tells what they saw
        state = swarm.forward(state, swarm.hearing_at(state))
    moved = float((along.value * (state - along.states)).sum()) / growth**steps
    later = float(along.noise[0]) / (growth**2 - 1)
    return Tipping(swarm.begins - moved / swarm.robots, growth, swarm.coins, later)


def changing(swarm: Moves) -> float:
    """Return the share of rounds that end with another opinion, at half and half."""
    _, _, _, chances = _balanced(swarm, np.array([0.5]))
    return float(1 - (chances[0, 0, 0] + chances[0, 1, 1]) / 2)


def _flow(swarm: Moves, shares: Array) -> Array:
    """Return the robots per step that change to feasible, less those that change to infeasible."""
    _, _, rounds, chances = _balanced(swarm, shares)
    flow = (rounds[:, None, :] @ chances)[:, 0] - rounds
    return flow[:, 0] - flow[:, 1]

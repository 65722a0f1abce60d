"""The effective chain: the balance of opinions as one number, which moves by one robot at a time."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from feasibee.theory.classes import CLASS, Array, Moves
from feasibee.theory.saddle import Manifold, manifold

SHARES = np.array([0.004, 0.015, *np.linspace(0.04, 0.96, 17), 0.985, 0.996])
"""Shares of feasible opinions at which drift and noise are computed."""


@dataclass(frozen=True)
class Chain:
    """A chain in time, from the coins at the start to the decision; it moves by one state at a time."""

    up: Array
    """Rate per step from each state to the next one: one robot more for feasible; shape (states,)."""
    down: Array
    """Rate per step to the state before."""
    at_once: Array
    """Share of the moves up to the last state, and down to the first, that decide: shape (2,).

    All moves beyond these two decide. So the decision may lie anywhere between two states."""
    start: Array
    """Probability of each state at the start, shape (states,)."""
    decided: tuple[float, float]
    """Probabilities that the start is already a decision: for feasible and for infeasible."""
    shares: Array
    """Share of robots with the opinion feasible in each state, shape (states,)."""

    def moves(self) -> tuple[Array, Array]:
        """Return the rates between states, and to both decisions; shapes (states, states), (states, 2)."""
        up, down, exits = self.up.copy(), self.down.copy(), np.zeros((len(self.up), 2))
        exits[-1, 0], exits[0, 1] = up[-1], down[0]
        exits[-2, 0], exits[1, 1] = self.at_once * (up[-2], down[1])
        up[-2] -= exits[-2, 0]
        down[1] -= exits[1, 1]
        return np.diag(up[:-1], 1) + np.diag(down[1:], -1), exits

    def over_time(self, steps: int) -> Array:
        """Return the probabilities to have decided feasible and infeasible by each step: (steps + 1, 2)."""
        return self.states_over_time(steps)[1]

    def states_over_time(self, steps: int) -> tuple[Array, Array]:
        """Return the probability of each state at each step, (steps + 1, states), and of both decisions."""
        among, exits = self.moves()
        onward = np.linalg.inv(np.diag(1 + self.up + self.down) - among)  # implicit steps: never negative
        states = np.zeros((steps + 1, len(self.up)))
        state = self.start
        for step in range(1, steps + 1):
            states[step] = state = state @ onward
        decided = np.cumsum(states @ exits, axis=0) + self.decided
        states[0] = self.start
        return states, decided


def chain_of(swarm: Moves, needed: tuple[int, int], along: Manifold | None = None) -> tuple[Chain, Manifold]:
    """Return the effective chain of a swarm, and the states that it was made of.

    ``needed`` is the least number of robots that change their opinion, for feasible and for infeasible, that
    is a decision. With more than there are, there is no such decision. ``along`` has these states, if they
    are known.
    """
    along = along or manifold(swarm, SHARES)
    places, held = along.places, along.holders
    first, spread = _beginning(swarm, along, places)
    first -= swarm.begins * swarm.robots  # place of 0 robots for feasible
    able = np.array(needed) <= swarm.robots
    high = float(np.interp(needed[0], held[:, 0], places)) - first + (not able[0])
    low = float(np.interp(-needed[1], -held[:, 1], places)) - first - (not able[1])
    numbers = np.arange(math.floor(low), math.ceil(high) + 1)
    between = np.array([high - numbers[-1] + 1, numbers[0] + 1 - low])  # parts of the last moves, 0 to 1
    drift, noise = (np.interp(numbers + first, places, each) for each in (along.drift, along.noise))
    up = np.maximum((noise + drift) / 2, np.maximum(drift, 0) + 1e-12)
    down = np.maximum((noise - drift) / 2, np.maximum(-drift, 0) + 1e-12)
    start = _start(swarm, spread, numbers)
    inner = slice(1, -1)
    up[-2] *= able[0]
    down[1] *= able[1]
    return Chain(
        up[inner],
        down[inner],
        (1 - between) / (1 + between) * able,
        start[inner],
        (float(start[-1] * able[0]), float(start[0] * able[1])),
        np.interp(numbers[inner] + first, places, held[:, 0]) / swarm.robots,
    ), along


def opinions_over_time(swarm: Moves, along: Manifold, steps: int) -> Array:
    """Return the share of robots for feasible by step, also of swarms that have decided: (steps + 1, 3).

    The columns are the mean over swarms, and its 5 and 95 % quantiles to the next half robot.
    """
    chain, _ = chain_of(swarm, (swarm.robots, swarm.robots), along)  # it ends at a consensus, which stays
    states, (yes, no) = (each.T for each in chain.states_over_time(steps))
    shares = np.array([0.0, *chain.shares, 1.0])
    law = np.cumsum([no, *states, yes], axis=0)
    low, high = (shares[(law < part).sum(0)] for part in (0.05, 0.95))
    half = 0.5 / swarm.robots  # a count is whole, and a state of the chain isn't
    found = np.stack([shares @ np.diff(law, axis=0, prepend=0), low - half, high + half], axis=1)
    early = _unmixed(swarm, along, steps)
    found[: len(early)] += early[:, None]
    return found.clip(0, 1)


def _unmixed(swarm: Moves, along: Manifold, steps: int) -> Array:
    """Return by how much the mean share for feasible exceeds that of a mixed swarm, in the first steps.

    Robots draw a coin first. They hold what their exploration favours, if they begin so, from its end on.
    """
    state, found = swarm.start()[None], []
    for step in range(min(steps + 1, 5 * swarm.round_length())):
        offsets = (along.value * (along.states - state)).sum(CLASS)
        mixed = float(np.interp(0, offsets, along.holders[:, 0]))
        exploring = swarm.robots * (1 - swarm.explored) ** step
        found.append(float(swarm.counts(state)[0, 2]) - mixed + exploring * (0.5 - swarm.begins))
        state = swarm.forward(state, swarm.hearing_at(state))
    return np.array(found) / swarm.robots


def _beginning(swarm: Moves, along: Manifold, places: Array) -> tuple[float, float]:
    """Return the place at which the chain begins, and the share of the coins' variance that it begins with.

    All robots begin to explore at once, with empty inboxes. Until their rounds mix, the swarm has less noise
    than the chain. Mean and variance are those with which the chain comes to the same state later.
    """
    offsets = (along.value * (along.states - swarm.start())).sum(CLASS)
    place = float(np.interp(0, offsets, places))
    value = along.value[int(np.abs(places - place).argmin())]
    states, way = [swarm.start()[None]], [place]
    for _ in range(swarm.round_length()):
        states.append(swarm.forward(states[-1], swarm.hearing_at(states[-1])))
        way.append(way[-1] + float(np.interp(way[-1], places, along.drift)))
    first = np.concatenate(states[:-1])
    noise = swarm.noise(first, value, swarm.hearing_at(first))
    grown = np.cumprod(np.interp(way[:-1], places, along.growth) ** 2)
    missing = ((np.interp(way[:-1], places, along.noise) - noise) / grown).sum()
    after = float(np.interp(0, (along.value * (along.states - states[-1])).sum(CLASS), places))
    place += (after - way[-1]) / math.sqrt(grown[-1])
    return place, max(0.1, 1 - float(missing) / swarm.coins)


def _start(swarm: Moves, spread: float, numbers: NDArray[np.int64]) -> Array:
    """Return the probability of each number of feasible opinions at the start; the ends hold all beyond them.

    ``spread`` is the share of the variance of the coins that the start has.
    """
    law = np.ones(1)
    for _ in range(swarm.robots):
        law = np.convolve(law, [1 - swarm.begins, swarm.begins])
    law = law ** (1 / spread)
    kept = np.zeros(len(numbers))
    np.add.at(
        kept, np.clip(np.arange(swarm.robots + 1), numbers[0], numbers[-1]) - numbers[0], law / law.sum()
    )
    return kept

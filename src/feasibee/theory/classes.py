"""One robot in the field of the others: its classes, and the chances of moving from one to another.

A class is an opinion, a phase and the votes heard. The phases are exploring, and disseminating for each
duration. Contacts are annealed: each is with a random robot, but they begin and end at the rates of real
space. Only the last message of a sender before the hearer decides counts: it replaces the others.

States have the axes (points, opinions, phases, votes for feasible, votes for infeasible): several states of
the swarm are computed at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
EXPLORING, SENDING = 0, 1
"""Phases; one of dissemination for each duration, from `SENDING` on."""
FITTING = 5
"""Number of iterations that keep the probabilities of the durations."""
CLASS = (-4, -3, -2, -1)
"""The axes of a state other than points."""


class Hearing(NamedTuple):
    """How votes add up in one step: chances from each number to each, (points, opinions, phases, n, n)."""

    feasible: Array
    infeasible: Array
    sends: Array
    """Probability of each duration after an exploration: (points, opinions, durations, n, n)."""

    def after(self, state: Array) -> Array:
        """Return a state after this step's votes."""
        return np.swapaxes(self.feasible, -1, -2) @ state @ self.infeasible

    def before(self, value: Array) -> Array:
        """Return the mean of a value after this step's votes, by the class before them."""
        return self.feasible @ value @ np.swapaxes(self.infeasible, -1, -2)

    def steps_until(self, start: Array, goes_on: Array) -> Array:
        """Return the mean steps in each class, after hearing; each step goes on with a chance.

        Votes only add up, so the classes with no vote for infeasible come first, then those with one, ...
        """
        wanted, transposed = self.after(start), goes_on[..., None, None] * np.swapaxes(self.feasible, -1, -2)
        same, found = np.eye(start.shape[-2]), np.zeros_like(wanted)
        for votes in range(start.shape[-1]):
            fewer = transposed @ (found @ self.infeasible[..., :, votes, None])
            stays = same - transposed * self.infeasible[..., votes, votes, None, None]
            found[..., votes, None] = np.linalg.solve(stays, wanted[..., votes, None] + fewer)
        return found


@dataclass(frozen=True)
class Moves:
    """The numbers that one robot's moves between classes depend on."""

    robots: int
    """Number of robots that are honest and may change their opinion."""
    adopting: Array
    """Probability of each opinion after a decision, shape (opinions, votes, votes, opinions)."""
    explored: float
    """Probability per step that an exploration ends."""
    ends: Array
    """Probability per step that a dissemination ends, shape (opinions, durations)."""
    weights: Array
    """Probability of each duration of dissemination, shape (opinions, durations)."""
    audible: Array
    """Probability that a sender is heard in a step, for the last time before the hearer decides.

    By opinion and phase of the hearer, and by opinion of the sender; shape (opinions, phases, 2)."""
    company: Array
    """How many votes robots of each duration heard while exploring, relative to the mean: as ``weights``."""
    speaking: Array
    """What others hear of each robot that broadcasts, by its opinion: shape (2, 2).

    Above the identity, it is what Byzantine robots say, as parts of the honest ones."""
    stubborn: Array
    """Robots that broadcast feasible and infeasible for good, and all that hold them: shape (4,)."""
    kept: float = 1.0
    """Probability that a robot still holds the opinion with which it was heard, on average over a round."""

    begins: float = 0.5
    """Probability that a robot begins with the opinion *feasible*."""

    @property
    def coins(self) -> float:
        """Variance of the number of robots that begin with *feasible*."""
        return self.robots * self.begins * (1 - self.begins)

    def start(self) -> Array:
        """Return the mean state at the start, all exploring: no points."""
        state = np.zeros((len(self.ends), SENDING + self.ends.shape[1], *self.adopting.shape[1:3]))
        state[:2, EXPLORING, 0, 0] = self.robots * self.begins, self.robots * (1 - self.begins)
        return state

    def round_length(self) -> int:
        """Return the number of steps after which rounds that began together are mixed: two rounds."""
        return int(np.ceil(2 / self.explored + (self.weights / self.ends)[:2].sum()))

    def counts(self, state: Array) -> Array:
        """Return the robots that broadcast feasible and infeasible, and all that hold them: (..., 4)."""
        phases = state[..., :2, :, :, :].sum((-1, -2))
        return np.concatenate([phases[..., SENDING:].sum(-1), phases.sum(-1)], axis=-1)

    def field(self, counts: Array) -> Array:
        """Return the robots that are heard for feasible and infeasible, and all that speak for them."""
        heard: Array = counts @ np.kron(np.eye(2), self.speaking) + self.stubborn
        return heard

    def arrivals(self, counts: Array) -> tuple[Array, Array]:
        """Return the mean votes per step that stay, and the mean votes held: (points, opinions, phases, 2).

        A robot of an opinion that X robots hold hears X - 1 of them.
        """
        sending, total = counts[..., None, :2], counts[..., None, 2:]
        others = sending * np.maximum(0, 1 - np.eye(len(self.ends), 2) / np.maximum(total, 1))
        coming = others[..., None, :] * self.audible
        held = np.empty_like(coming)
        held[..., :1, :] = coming[..., :1, :] * (1 / self.explored - 1)
        held[..., 1:, :] = (
            coming[..., :1, :] / self.explored + coming[..., 1:, :] * (1 / self.ends - 1)[..., None]
        )
        return coming, held

    def _sends(self, mean: Array) -> Array:
        """Return the probability of each duration by the votes that explorers hold, ``mean`` on average.

        Explorations are geometric, and so are these votes. Who saw robots has heard more of them. The
        durations keep their probabilities.
        """
        most = self.adopting.shape[1]
        mean, votes = mean[..., None, None], np.arange(2 * most - 1)
        law = (mean / (1 + mean)) ** votes
        law = law / law.sum(-1, keepdims=True)
        ratio = (1 + mean) / (1 + mean * self.company[..., None])
        found = self.weights[..., None] * ratio * (self.company[..., None] * ratio) ** votes
        wanted = np.maximum(self.weights, 1e-12)[..., None]
        for _ in range(FITTING):
            found = found / found.sum(-2, keepdims=True)
            found *= wanted / np.maximum((found * law).sum(-1, keepdims=True), 1e-12)
        found = found / found.sum(-2, keepdims=True)
        chances: Array = found[..., np.add.outer(np.arange(most), np.arange(most))]
        return chances

    def hearing(self, counts: Array, explorers: Array | None = None) -> Hearing:
        """Return how votes add up in one step: a robot that is counted already adds none.

        ``explorers`` are the mean votes that explorers hold, if the state isn't at rest: (points, opinions).
        """
        counts = self.field(counts)
        coming, held = self.arrivals(counts)
        holders = np.maximum(counts[..., None, 2:] - np.eye(len(self.ends), 2), 1e-9)[..., None, :]
        most = self.adopting.shape[1]
        votes = np.arange(most)
        others = np.maximum(holders - held, 1e-9)[..., None]
        left = np.maximum(others - self.kept * (votes - held[..., None]), 0) / others
        mean = coming[..., None] * left
        factorials = np.cumprod(np.maximum(votes, 1)).astype(float)
        poisson = np.exp(-mean)[..., None] * mean[..., None] ** votes / factorials
        jumps = votes - votes[:, None]
        moves = np.where(
            jumps >= 0,
            np.take_along_axis(poisson, np.broadcast_to(np.maximum(jumps, 0), poisson.shape), -1),
            0.0,
        )
        moves[..., -1] += 1 - moves.sum(-1)
        if explorers is None:
            explorers = coming[..., EXPLORING, :].sum(-1) / self.explored
        return Hearing(moves[..., 0, :, :], moves[..., 1, :, :], self._sends(explorers))

    def forward(self, state: Array, hearing: Hearing) -> Array:
        """Return the state one step later, on average."""
        heard = hearing.after(state)
        explorers, senders = heard[..., EXPLORING, :, :], heard[..., SENDING:, :, :]
        after = np.empty_like(heard)
        after[..., EXPLORING, :, :] = (1 - self.explored) * explorers
        after[..., SENDING:, :, :] = self.explored * hearing.sends * explorers[..., None, :, :]
        after[..., SENDING:, :, :] += (1 - self.ends)[..., None, None] * senders
        after[..., EXPLORING, 0, 0] += self.decided(senders).sum(-2)
        return after

    def decided(self, senders: Array) -> Array:
        """Return the robots that end their dissemination, by opinion before and after."""
        ended = (self.ends[..., None, None] * senders).sum(-3)
        moved: Array = np.einsum("...ofh,ofhp->...op", ended, self.adopting)
        return moved

    def backward(self, value: Array, hearing: Hearing) -> Array:
        """Return the mean value of the classes that a robot of each class moves to in one step."""
        decided = np.einsum("ofhp,...p->...ofh", self.adopting, value[..., EXPLORING, 0, 0])
        sending = value[..., SENDING:, :, :]
        after = np.empty(np.broadcast_shapes(value.shape, hearing.feasible.shape))
        after[..., EXPLORING, :, :] = (1 - self.explored) * value[
            ..., EXPLORING, :, :
        ] + self.explored * np.einsum("...odfh,...odfh->...ofh", hearing.sends, sending)
        after[..., SENDING:, :, :] = self.ends[..., None, None] * decided[..., None, :, :]
        after[..., SENDING:, :, :] += (1 - self.ends)[..., None, None] * sending
        return hearing.before(after)

    def noise(self, state: Array, value: Array, hearing: Hearing) -> Array:
        """Return the variance of the change of a value in one step, summed over the robots: (points,)."""
        spread = self.backward(value**2, hearing) - self.backward(value, hearing) ** 2
        total: Array = (state * spread).sum(CLASS)
        return total

    def hearing_at(self, state: Array) -> Hearing:
        """Return how votes add up at a state that isn't at rest, by the votes that explorers hold."""
        explorers, most = state[..., EXPLORING, :, :], self.adopting.shape[1]
        votes = np.add.outer(np.arange(most), np.arange(most))
        mean = (explorers * votes).sum((-1, -2)) / np.maximum(explorers.sum((-1, -2)), 1e-12)
        return self.hearing(self.counts(state), mean)

    def activity(self) -> tuple[float, float]:
        """Return how many robots broadcast at a time, and how many one hears per round, at half and half."""
        sending = (self.weights / self.ends).sum(1)[:2]
        shares = self.robots / 2 * sending / (1 / self.explored + sending)
        steps = np.concatenate(
            [np.full((len(self.ends), 1), 1 / self.explored), self.weights / self.ends], axis=1
        )
        coming, _ = self.arrivals(self.field(np.concatenate([shares, np.full(2, self.robots / 2)])))
        return float(shares.sum()), float((coming.sum(-1) * steps)[:2].sum() / 2)

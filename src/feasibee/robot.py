"""The controller of one robot: explore, disseminate, decide. Standard library only.

The same object runs in the reference simulation and on a real robot: give it what the robot sees and hears
each step, broadcast what it says, and let it know that a step is over.

Examples
--------
A robot that sees three robots and one task in every step, and hears robot 7 say *infeasible*:

>>> import random
>>> from feasibee.robot import Controller
>>> from feasibee.strategies import dmmd
>>> random.seed(1)
>>> robot = Controller(dmmd, opinion=1, draw_duration=lambda mean: int(random.expovariate(1 / mean)) + 1)
>>> for _ in range(100):
...     robot.observe(robots=3, tasks=1)
...     if robot.listens:
...         robot.hear(sender=7, opinion=0)
...     message = robot.message  # broadcast it, if it isn't None
...     robot.end_step()
>>> robot.opinion  # one vote against its own is a tie, and a tie keeps the opinion
1
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol


class Strategy(Protocol):
    """What a file in ``strategies/`` provides."""

    def quality(self, robots_seen: int, tasks_seen: int, /) -> float:
        """Return the quality of *feasible*, between 0 and 1."""

    def dissemination(self, quality: float, gain: float, /) -> float:
        """Return the mean duration of broadcasting an opinion of this quality, in steps."""

    def decide(self, opinion: int, feasible_votes: int, infeasible_votes: int, /) -> int:
        """Return the next opinion, 1 or 0."""


class Controller:
    """One robot's mind (model.md 4).

    Parameters
    ----------
    strategy : Strategy
        How opinions are rated and chosen, such as ``feasibee.strategies.dmmd``.
    opinion : int
        The first opinion: 1 (feasible) or 0 (infeasible).
    draw_duration : callable
        Given a mean, draws how many whole steps a phase lasts: at least 1.
    exploration : float
        Mean duration of exploration, in steps.
    gain : float
        Mean steps of dissemination for an opinion of quality 1.
    own_vote : bool
        Whether its own opinion counts in its majority.
    listen_always : bool
        Whether it hears in both phases, or only while it disseminates.
    every_message : bool
        Whether every message is a vote, or the latest of each robot.
    stubborn : bool
        Whether it never changes its opinion (a fault).
    sets : sequence of pairs
        For unlike robots and tasks: what each class of robots and each class of tasks adds to the two sides
        of a set of skills; by default all robots against all tasks.
    """

    def __init__(
        self,
        strategy: Strategy,
        opinion: int,
        draw_duration: Callable[[float], int],
        *,
        exploration: float = 10.0,
        gain: float = 10.0,
        own_vote: bool = True,
        listen_always: bool = True,
        every_message: bool = False,
        stubborn: bool = False,
        sets: Sequence[tuple[Sequence[int], Sequence[int]]] = (((1,), (1,)),),
    ) -> None:
        self.strategy = strategy
        self.opinion = opinion
        self.exploration = exploration
        self.gain = gain
        self.own_vote = own_vote
        self.listen_always = listen_always
        self.every_message = every_message
        self.stubborn = stubborn
        self.sets = sets
        self.explorations = 0
        self._draw_duration = draw_duration
        self._explore()

    @property
    def message(self) -> int | None:
        """The opinion to broadcast in this step, with the robot's id; None while it explores."""
        return self.opinion if self.disseminating else None

    @property
    def listens(self) -> bool:
        """Whether messages count in this step."""
        return self.listen_always or self.disseminating

    def observe(self, robots: int | Sequence[int], tasks: int | Sequence[int]) -> None:
        """Count robots and tasks in sight, by class if there are several, if exploring (model.md 4.2)."""
        if not self.disseminating:
            for seen, new in ((self.robots_seen, robots), (self.tasks_seen, tasks)):
                for kind, number in enumerate([new] if isinstance(new, int) else new):
                    seen[kind] += number

    def hear(self, sender: int, opinion: int) -> None:
        """Keep a message: the latest of each sender, or every one (model.md 4.5)."""
        if self.every_message:
            self._messages.append(opinion)
        else:
            self._latest[sender] = opinion

    def end_step(self) -> None:
        """Let the time of one step pass; a phase that ends makes its transition (model.md 3.3)."""
        self.phase_left -= 1
        if self.phase_left == 0:
            if self.disseminating:
                self._decide()
                self._explore()
            else:
                self._disseminate()

    def _explore(self) -> None:
        """Start afresh: no counts, an empty inbox (model.md 4.2, 4.6)."""
        self.disseminating = False
        self.explorations += 1
        self.robots_seen = [0] * len(self.sets[0][0])
        self.tasks_seen = [0] * len(self.sets[0][1])
        self._latest: dict[int, int] = {}
        self._messages: list[int] = []
        self.phase_left = self._draw_duration(self.exploration)

    def _disseminate(self) -> None:
        """Rate the own opinion and broadcast it accordingly (model.md 4.3, 4.4)."""
        quality = self._feasible_quality()
        if self.opinion == 0:
            quality = 1.0 - quality
        self.disseminating = True
        self.phase_left = self._draw_duration(self.strategy.dissemination(quality, self.gain))

    def _feasible_quality(self) -> float:
        """Return the quality of *feasible*: that of the scarcest skills seen (model.md 4.3, 6.7)."""
        seen = [(_sum(robots, self.robots_seen), _sum(tasks, self.tasks_seen)) for robots, tasks in self.sets]
        observed = [(robots, tasks) for robots, tasks in seen if robots + tasks > 0]
        return min(self.strategy.quality(robots, tasks) for robots, tasks in observed or [(0, 0)])

    def _decide(self) -> None:
        """Follow the inbox (model.md 4.6)."""
        votes = [*self._latest.values(), *self._messages]
        if self.own_vote:
            votes.append(self.opinion)
        feasible = sum(votes)
        decided = self.strategy.decide(self.opinion, feasible, len(votes) - feasible)
        if not self.stubborn:
            self.opinion = decided


def _sum(weights: Sequence[int], counts: Sequence[int]) -> int:
    return sum(weight * count for weight, count in zip(weights, counts, strict=True))

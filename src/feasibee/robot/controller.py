"""The controller of one robot: explore, disseminate, decide. Standard library only.

The same object runs in the reference simulation and on a real robot: give it what the robot sees and hears
each step, broadcast what it says, and let it know that a step is over.

Examples
--------
A robot that sees three robots and one task in every step, and hears robot 7 say *infeasible*:

>>> import random
>>> from feasibee.robot import Controller, Message
>>> from feasibee.strategies import STRATEGIES
>>> random.seed(1)
>>> robot = Controller(
...     STRATEGIES["dmmd"],
...     opinion=1,
...     draw_duration=lambda mean: int(mean * random.expovariate(1.0)) + 1,
...     draw_choice=lambda: (random.random(), random.random()),
... )
>>> for _ in range(100):
...     robot.observe(robots=3, tasks=1)
...     if robot.listens:
...         robot.hear(7, Message(opinion=0))
...     message = robot.message()  # broadcast it with the robot's id, if it isn't None
...     robot.end_step()
>>> robot.opinion  # one vote against its own is a tie, and a tie keeps the opinion
1
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

from feasibee.robot.knowledge import Knowledge
from feasibee.strategies.contract import Inbox, Me, Mind, Setting, Strategy, Thing, sent

NONE = -1


class Message(NamedTuple):
    """What a robot broadcasts in addition to its id."""

    opinion: int
    """The opinion: 1 feasible, 0 infeasible; -1 if the bytes that hold knowledge don't have it."""
    value: int = 0
    """The value as a whole number of ``value_bits`` bits; 0 if the strategy sends none."""
    declared: bool = False
    """Whether the sender has declared its opinion, if it declares by votes."""
    knowledge: tuple[int, ...] = ()
    """The words of the message, if the strategy passes on knowledge."""
    news: tuple[tuple[int, int], ...] = ()
    """Name and version of each task that it lists, if robots act (model.md 6.25.5)."""


class Declare(NamedTuple):
    """The rule by which a robot declares its opinion, because others hold it, too (model.md 6.14)."""

    quorum: Fraction
    """Least share of the inbox that must agree with the opinion."""
    rounds: int
    """Number of successive decisions with such an inbox."""
    heard: int
    """Least number of messages in such an inbox."""


@dataclass(frozen=True, kw_only=True)
class Settings:
    """The numbers and rules of one robot, which never change."""

    exploration: float = 10.0
    """Mean duration of exploration, in steps."""
    gain: float = 10.0
    """Mean steps of dissemination for an opinion of quality 1."""
    dissemination_floor: int = 0
    """Steps that each dissemination lasts longer."""
    quality_floor: int = 0
    """Both counts are taken for at least this when they are rated."""
    own_vote: bool = True
    """Whether its own opinion counts in its majority."""
    random_ties: bool = False
    """Whether it takes a random message when votes tie; otherwise it keeps its opinion."""
    first_sight: bool = False
    """Whether it adopts at the end of its first exploration what its counts favour."""
    listens_for: int | None = None
    """It hears only in the last so many steps of dissemination: 0 for all of it, None for always."""
    every_message: bool = False
    """Whether every message is a vote, or the latest of each robot."""
    inbox_size: int | None = None
    """How many different robots' messages it keeps, the newest; by default all."""
    parameters: Sequence[float] | None = None
    """The strategy's, in its order; by default its own."""
    declare: Declare | None = None
    """When it declares by the opinions that it hears; by default never."""
    sets: Sequence[tuple[Sequence[int], Sequence[int]]] = (((1,), (1,)),)
    """For unlike robots and tasks: what each class of both adds to the two sides of a set of skills."""
    me: tuple[int, int, int] = (0, 0, 0)
    """Its id, class and hash (32 random bits), for strategies that pass on knowledge."""
    place: tuple[float, float] = (0.0, 0.0)
    """Its first position in the frame that all robots share, in units, for strategies that use it."""
    setting: Setting | None = None
    """The numbers that strategies that pass on knowledge need."""
    step: int = 0
    """Number of steps that have passed, if it joins robots that began earlier: 0 to 2**32 - 1."""


DEFAULTS = Settings()


class Controller:
    """The controller of one robot (model.md 4).

    Parameters
    ----------
    strategy : Strategy
        How opinions are rated, told and chosen, such as ``STRATEGIES["dmmd"]``.
    opinion : int
        The first opinion: 1 (feasible) or 0 (infeasible); some strategies start without one.
    draw_duration : callable
        Given a mean, which may be 0, draws how many whole steps a phase lasts: at least 1.
    draw_choice : callable
        Draws two numbers, each at least 0 and below 1: the chance left to a decision, and the message drawn.
    settings : Settings, optional
        Its numbers and rules.
    stubborn : bool
        Whether it never changes its opinion (a fault).
    """

    def __init__(
        self,
        strategy: Strategy,
        opinion: int,
        draw_duration: Callable[[float], int],
        draw_choice: Callable[[], tuple[float, float]],
        settings: Settings = DEFAULTS,
        *,
        stubborn: bool = False,
    ) -> None:
        self.strategy = strategy
        self.opinion = NONE if strategy.starts_neutral else opinion
        self.settings = settings
        self._stubborn = stubborn
        self.declared = NONE
        """The opinion that it has declared: 1 feasible, 0 infeasible, -1 not yet (model.md 6.15)."""
        self.explorations = 0
        self.feasible_quality = 0.5
        parameters = settings.parameters
        self._parameters = list(strategy.parameters.values() if parameters is None else parameters)
        self._memory = [0.0] * strategy.memory
        self.knowledge: Knowledge | None = None
        if strategy.knowledge:
            if settings.setting is None:
                raise TypeError(f"{strategy.name} passes on knowledge: give the controller a setting")
            x, y = settings.place
            me = Me(*settings.me, settings.step, self._memory, settings.setting, x=x, y=y)
            self.knowledge = Knowledge(strategy, me)
        self._agreed = 0
        self._draw_duration = draw_duration
        self._draw_choice = draw_choice
        robots, tasks = settings.sets[0]
        self.robots_seen = [0] * len(robots)
        self.tasks_seen = [0] * len(tasks)
        self._explore()

    def message(self) -> Message | None:
        """Return the message of this step, None while exploring or silent; call it once per step."""
        if not self.disseminating or self._said == NONE:
            return None
        return self.compose(self._said, self._value)

    def compose(self, opinion: int, value: int) -> Message:
        """Return a message of this step with this opinion and value; call it at most once per step."""
        knowledge = self.knowledge.message() if self.knowledge else ()
        says_declared = self.settings.declare is not None and self.declared != NONE
        return Message(opinion, value, says_declared, knowledge)

    @property
    def _keeps_opinion(self) -> bool:
        return self._stubborn or self.declared != NONE

    def probability(self) -> float:
        """Return how probable it is that the tasks are feasible, as the robot believes (model.md 6.15.9)."""
        if self.declared != NONE:
            return float(self.declared)
        functions: Any = self.strategy  # without knowledge it may need no setting
        known = tuple(self.knowledge.words) if self.knowledge else ()
        mind = self._mind()._replace(memory=tuple(self._memory))
        return float(functions.probability(mind, known, self.settings.setting))

    def move_to(self, x: float, y: float) -> None:
        """Store the robot's position in the frame that all robots share, in units."""
        if self.knowledge:
            self.knowledge.move_to(x, y)

    @property
    def listens(self) -> bool:
        """Whether messages count in this step."""
        if self.settings.listens_for is None:
            return True
        return self.disseminating and not 0 < self.settings.listens_for < self.phase_left

    def observe(self, robots: int | Sequence[int], tasks: int | Sequence[int]) -> None:
        """Count robots and tasks in sight while exploring, by class if there are several (model.md 4.2)."""
        if not self.disseminating:
            for seen, new in ((self.robots_seen, robots), (self.tasks_seen, tasks)):
                for kind, number in enumerate([new] if isinstance(new, int) else new):
                    seen[kind] += number

    def recognise(self, things: Iterable[Thing]) -> None:
        """Add robots and tasks in sight to the knowledge while exploring (model.md 6.11)."""
        if self.knowledge and not self.disseminating:
            self.knowledge.observe(things)

    def hear(self, sender: int, message: Message) -> None:
        """Keep a message: the latest of each sender, or every one (model.md 4.5)."""
        if self.knowledge:
            self.knowledge.merge(message.knowledge, sender)
        if message.opinion == NONE:  # a message of knowledge by wire: it has no opinion
            return
        if self.settings.every_message:
            self._messages.append(message)
            return
        self._latest.pop(sender, None)  # the newest come last
        self._latest[sender] = message
        if self.settings.inbox_size is not None and len(self._latest) > self.settings.inbox_size:
            self._latest.pop(next(iter(self._latest)))

    def end_step(self) -> None:
        """End a step; if its phase ends, the robot changes phase (model.md 3.3)."""
        if self.knowledge:
            self._follow(self.knowledge)
        self.phase_left -= 1
        if self.phase_left == 0:
            if self.disseminating:
                self._decide()
                self._explore()
            else:
                self._disseminate()
        self.rest()

    def rest(self) -> None:
        """Let its clock go on: all that happens in a step in which the robot charges (model.md 6.23)."""
        if self.knowledge:
            self.knowledge.end_step(explores=not self.disseminating)

    def _follow(self, knowledge: Knowledge) -> None:
        """Declare, or adopt the opinion that follows from what is known (model.md 6.11, 6.15)."""
        keeps_opinion = self._keeps_opinion
        opinion = knowledge.judge()
        if self.declared == NONE and self.strategy.declare is not None:
            opinion = self.declared = knowledge.declare()
        if opinion != NONE and not keeps_opinion:
            self.opinion = opinion

    def _explore(self) -> None:
        """Begin exploring: empty the inbox; reset the counts if the strategy forgets (model.md 4.2, 4.6)."""
        self.disseminating = False
        self.explorations += 1
        if self.strategy.forgets:
            self.robots_seen = [0] * len(self.robots_seen)
            self.tasks_seen = [0] * len(self.tasks_seen)
        self._latest: dict[int, Message] = {}
        self._messages: list[Message] = []
        self.phase_left = self._draw_duration(self.settings.exploration)

    def _disseminate(self) -> None:
        """Begin disseminating, for a time drawn by the quality of the opinion (model.md 4.3, 4.4)."""
        self._rate()
        if self.settings.first_sight and self.explorations == 1 and not self._keeps_opinion:
            self._adopt_first_sight()
        self.disseminating = True
        mind = self._mind()
        self._said = _opinion(self.strategy.say(mind))
        self._value = 0
        if self.strategy.value_bits:
            self._value = sent(self.strategy.value(mind), self.strategy.value_bits)
        mean = self.strategy.dissemination(mind.quality, self.settings.gain)
        if "lasting" in self.strategy.functions:
            mean = self.strategy.lasting(mind, self.settings.gain)
        self.phase_left = self.settings.dissemination_floor + self._draw_duration(mean)

    def _adopt_first_sight(self) -> None:
        """Adopt what the robot's own counts favour; keep its opinion with a tie (model.md 6.10)."""
        if self.feasible_quality != 0.5:
            self.opinion = int(self.feasible_quality > 0.5)

    def _rate(self) -> None:
        """Rate *feasible*: the least quality over the sets of skills (model.md 4.3, 6.7)."""
        robots, tasks = self.knowledge.counted() if self.knowledge else (self.robots_seen, self.tasks_seen)
        sides = [(_sum(robot, robots), _sum(task, tasks)) for robot, task in self.settings.sets]
        observed = [pair for pair in sides if sum(pair) > 0] or [(0, 0)]
        floor = self.settings.quality_floor
        self.feasible_quality = min(
            self.strategy.quality(max(floor, robots), max(floor, tasks)) for robots, tasks in observed
        )

    def _mind(self) -> Mind:
        qualities = {1: self.feasible_quality, 0: 1.0 - self.feasible_quality, NONE: 0.5}
        own_vote = int(self.settings.own_vote)
        quality = qualities[self.opinion]
        held = self.opinion, quality, self.feasible_quality, own_vote, self._memory, self._parameters
        return Mind(*held, int(self.settings.random_ties))

    def _inbox(self) -> Inbox:
        """Return the counts of the messages heard, one drawn message, and a chance."""
        chance, drawn = self._draw_choice()
        # The draw is among all those that say feasible, in the order of their senders, and then the others.
        senders = sorted(self._latest)
        votes = [self._latest[sender] for sender in senders] + self._messages
        votes.sort(key=lambda message: -message.opinion)
        if not votes:
            return Inbox(0, 0, NONE, 0.0, 0.0, chance)
        feasible = sum(message.opinion for message in votes)
        heard = votes[int(drawn * len(votes))]
        one = 2**self.strategy.value_bits - 1 or 1
        mean = sum(message.value for message in votes) / (len(votes) * one)
        return Inbox(feasible, len(votes) - feasible, heard.opinion, heard.value / one, mean, chance)

    def _decide(self) -> None:
        """Decide by the inbox or the knowledge (model.md 4.6)."""
        if self.knowledge:
            self._rate()
        inbox = self._inbox()
        decided = _opinion(self.strategy.decide(self._mind(), inbox))
        if not self._keeps_opinion:
            self.opinion = decided
        if self.settings.declare is not None:
            self._declare_by_votes(self.settings.declare, inbox)

    def _declare_by_votes(self, rule: Declare, inbox: Inbox) -> None:
        """Declare if enough successive inboxes agreed with the robot's opinion (model.md 6.14)."""
        agreeing = {1: inbox.feasible_votes, 0: inbox.infeasible_votes}.get(self.opinion, 0)
        votes = inbox.feasible_votes + inbox.infeasible_votes
        agrees = self.opinion != NONE and votes >= rule.heard and agreeing >= rule.quorum * votes
        self._agreed = self._agreed + 1 if agrees else 0
        if self.declared == NONE and self._agreed >= rule.rounds:
            self.declared = self.opinion


def _opinion(number: int) -> int:
    return number if number in (0, 1) else NONE


def _sum(weights: Sequence[int], counts: Sequence[int]) -> int:
    return sum(weight * count for weight, count in zip(weights, counts, strict=True))

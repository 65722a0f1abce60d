"""The length of the messages of a scenario's strategy, without simulating it."""

from __future__ import annotations

from typing import Any, NamedTuple

from feasibee.scenario.scenario import Scenario
from feasibee.strategies.contract import Me, Setting, Strategy, Thing
from feasibee.strategies.words import Words


class MessageBits(NamedTuple):
    """Length of a message, in bits."""

    first: int
    """At step 0."""
    full: int
    """Once the sender and all others have seen every robot and task once, and it has heard from all."""

    def __str__(self) -> str:
        return str(self.first) if self.first == self.full else f"{self.first} to {self.full}"


def message_bits(scenario: Scenario) -> MessageBits:
    """Return the length of a message at the start and when a robot knows of everything.

    Messages of opinions have one length. Those with knowledge grow with what the sender knows; some go on
    growing with its counts.

    Examples
    --------
    >>> from feasibee import Scenario
    >>> from feasibee.scenario.messages import message_bits
    >>> str(message_bits(Scenario(decision={"strategy": "census"})))
    '8 to 782'
    """
    strategy, setting = scenario.strategy, scenario.setting
    more = bare_bits(scenario, setting.id_bits)
    if not strategy.knowledge:
        return MessageBits(more, more)
    robots = [_me(strategy, setting, number) for number in range(setting.robots)]
    first = knowledge_bits(strategy, _started(strategy, robots[0]), robots[0])
    full = knowledge_bits(strategy, _after_all(strategy, robots), robots[0])
    return MessageBits(first + more, full + more)


def bare_bits(scenario: Scenario, id_bits: int) -> int:
    """Return the length of a message without its knowledge: id, opinion, value and declaration."""
    says_declared = int(scenario.decision.declare is not None)
    if scenario.strategy.knowledge:
        return (id_bits + 2) * says_declared
    return id_bits + 1 + scenario.strategy.value_bits + says_declared


def _after_all(strategy: Strategy, robots: list[Me]) -> Words:
    """Return what the first robot knows once all have seen everything, and it has heard from all."""
    functions: Any = strategy
    knowledge = []
    for me in robots:
        known = _started(strategy, me)
        for thing in _things(me):
            functions.observe(known, thing, me)
        knowledge.append(known)
    for me, known in zip(robots[1:], knowledge[1:], strict=True):
        functions.merge(knowledge[0], _message(strategy, known, me), me.id, robots[0])
    return knowledge[0]


def _me(strategy: Strategy, setting: Setting, number: int) -> Me:
    kind = number % setting.robot_classes
    return Me(number, kind, _hash(number, True), 0, [0.0] * strategy.memory, setting, False)


def _started(strategy: Strategy, me: Me) -> Words:
    known = Words([0] * strategy.row_lengths(me.setting)[0])
    if strategy.start is not None:
        strategy.start(known, me)
    return known


def _things(me: Me) -> list[Thing]:
    """Return all that a robot can see, along the diagonal of the arena."""
    setting = me.setting
    found = []
    for is_robot, count, kinds in (
        (True, setting.robots, setting.robot_classes),
        (False, setting.tasks, setting.task_classes),
    ):
        for number in range(count):
            share = (number + 0.5) / count
            place = share * setting.width, share * setting.height
            found.append(Thing(is_robot, number, number % kinds, _hash(number, is_robot), *place))
    return [thing for thing in found if not (thing.is_robot and thing.id == me.id)]


def _hash(number: int, is_robot: bool) -> int:
    """Return 32 bits that look random, and differ for each robot and task."""
    return 2654435761 * (2 * number + is_robot + 1) % 2**32


def _message(strategy: Strategy, known: Words, me: Me) -> tuple[int, ...]:
    functions: Any = strategy
    if functions.encode is None:
        return tuple(known)
    message = Words([0] * strategy.row_lengths(me.setting)[1])
    functions.encode(message, known, me)
    return tuple(message)


def knowledge_bits(strategy: Strategy, known: Words, me: Me) -> int:
    """Return the length of the knowledge in the message of a robot that knows these words."""
    functions: Any = strategy
    return int(functions.bits(_message(strategy, known, me), me))

"""The length of the messages of a scenario's strategy, without simulating it."""

from __future__ import annotations

from typing import NamedTuple

from feasibee.robot.knowledge import Knowledge
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
    robots = [Knowledge(strategy, _me(strategy, setting, number)) for number in range(setting.robots)]
    first = knowledge_bits(strategy, Words(robots[0].words), robots[0].me)
    for robot in robots:
        robot.observe(_things(robot.me))
    for robot in robots[1:]:
        robots[0].merge(robot.message(), robot.me.id)
    return MessageBits(first + more, robots[0].bits(robots[0].message()) + more)


def bare_bits(scenario: Scenario, id_bits: int) -> int:
    """Return the length of a message without its knowledge: id, opinion, value and declaration."""
    says_declared = int(scenario.decision.declare is not None)
    if scenario.strategy.knowledge:
        return (id_bits + 2) * says_declared
    return id_bits + 1 + scenario.strategy.value_bits + says_declared


def _me(strategy: Strategy, setting: Setting, number: int) -> Me:
    kind = number % setting.robot_classes
    return Me(number, kind, _hash(number, True), 0, [0.0] * strategy.memory, setting, False)


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


def knowledge_bits(strategy: Strategy, known: Words, me: Me) -> int:
    """Return the length of the knowledge in the message of a robot that knows these words."""
    robot = Knowledge(strategy, me)
    robot.words = known
    return robot.bits(robot.message())

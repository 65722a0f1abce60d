"""One robot of a field without its network: settings and senses in, messages out, each step in its log."""

from __future__ import annotations

import json
from collections import Counter, deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any, Final, NamedTuple

from feasibee.base.codes import DECISIONS
from feasibee.base.errors import FeasibeeError, quoted
from feasibee.base.files import named
from feasibee.field.errands import Errands
from feasibee.field.logs import read_log, reading
from feasibee.reference.draws import philox
from feasibee.reference.mind import BYZANTINE, Draw, Mind, Words, settings_from
from feasibee.robot.controller import Message
from feasibee.robot.wire import Wire, WireError
from feasibee.strategies import STRATEGIES, roster
from feasibee.strategies.contract import Setting, Strategy, Thing

_ROSTER: Final[Any] = roster
"""The strategy's file, whose functions have no types."""


class _TaskNames:
    """The numbers that a robot gives to tasks, in the order in which it meets them."""

    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        invented = setting.robots + 1 if setting.robot_ids > setting.robots else 0
        wrong = setting.tasks + invented
        self._names = {_ROSTER.invented(k, _ROSTER.POSITION_BITS): k for k in range(setting.tasks, wrong)}
        self._free = chain(range(setting.tasks), range(wrong, setting.task_ids))

    def of_position(self, position: int) -> int:
        """Return the number of the task at a position; -1 if there can't be another task."""
        if position not in self._names and (number := next(self._free, -1)) >= 0:
            self._names[position] = number
        return self._names.get(position, -1)

    def named(self, thing: Thing) -> Thing:
        """Return a task in sight with its number here; robots and nameless tasks stay as they are."""
        if thing.is_robot or thing.id < 0:
            return thing
        return thing._replace(id=self.of_position(_ROSTER.place_of(thing, self._setting)))


WORK: Final = "taken", "acts", "ways"
"""What an acting robot senses in addition, as `Bodies.sight_of` or a driver says it."""
VERSION: Final = 3
"""Version of a robot's log."""
HEARD_LIMIT: Final = 4_096
"""Largest number of messages that a robot keeps for one step; more are dropped."""


class Status(NamedTuple):
    """What a robot reports to the observer; no body's way depends on it."""

    opinion: int
    declared: int
    disseminating: bool
    phase_left: int
    phases: int
    """Number of phases that the robots of its number have begun; a later robot's draws go on from there."""


class Node:
    """The mind of one robot, with its messages as bytes.

    ``orders`` are what the world sends a robot that joins: ``strategy``, ``settings`` and ``insight``.
    ``write`` takes each line of the log, as a mapping.

    ``draw`` returns the random words of a counter and a purpose, by default those of the robot's coordinates.
    ``strategy`` is by default the built-in one of the name in ``orders``. ``brain`` is the robot's program in
    C, which `brain.compiled` made; a Byzantine robot has none.
    """

    def __init__(
        self,
        orders: Mapping[str, Any],
        write: Callable[[Mapping[str, Any]], None] | None = None,
        draw: Draw | None = None,
        strategy: Strategy | None = None,
        brain: Path | None = None,
    ) -> None:
        settings = settings_from(orders["settings"])
        strategy = strategy if strategy is not None else STRATEGIES[orders["strategy"]]
        self.step = 0
        self.dropped: Counter[str] = Counter()
        self._write = write
        self._draws: list[Words] = []
        self._drawn = draw or partial(philox, *settings.coordinates)
        self._insight = orders["insight"] or {"truth": 0, "invented": ((), ())}
        self._id = settings.me[0]
        setting = settings.setting
        self._names = _TaskNames(setting) if strategy is STRATEGIES["roster"] else None
        # Messages may name invented robots, and those of any number.
        id_bits = max(setting.id_bits, (max(setting.robots, setting.robot_ids) - 1).bit_length())
        task_of = self._names.of_position if self._names else None
        declares = settings.declare is not None
        self._errands = Errands(orders["acting"], setting) if "acting" in orders else None
        if brain is not None and settings.fault != BYZANTINE:
            from feasibee.field.brain import CompiledMind

            told = replace(settings, setting=setting._replace(id_bits=id_bits))
            self._mind: Mind = CompiledMind(brain, strategy, told, self._draw, task_of)
            self._wire: Any = self._mind
        else:
            self._mind = Mind(strategy, settings, self._draw)
            self._wire = Wire(
                strategy,
                id_bits,
                declares=declares,
                setting=setting,
                task_of=task_of,
                rules=self._errands.errand.rules if self._errands else None,
            )
        self._line: dict[str, Any] = {"feasibee": "robot", "version": VERSION, **orders}
        self._log()

    @property
    def status(self) -> Status:
        """What the robot holds now."""
        mind = self._mind
        held = mind.opinion, mind.declared, mind.disseminating
        return Status(*held, mind.phase_left, mind.phases)

    @property
    def confidence(self) -> float:
        """How likely its opinion is, 0 to 1: by the strategy's own probability, or else by its quality."""
        mind, own = self._mind, self._mind.strategy.gives_probability
        feasible = mind.probability() if own else mind.feasible_quality
        return {1: feasible, 0: 1.0 - feasible}.get(mind.opinion, 0.5)

    @property
    def goes(self) -> list[int] | None:
        """What its body needs to know of its errand; None if it doesn't act."""
        return self._errands.goes if self._errands else None

    @property
    def way(self) -> dict[str, Any]:
        """Where its driver shall go; empty if it doesn't act."""
        return self._errands.in_units if self._errands else {}

    def speak(self, step: int, place: tuple[float, float], insight: Any = None) -> str | None:
        """Begin a step at a place; return the robot's message as hexadecimal digits, if it has one.

        ``insight`` is what Byzantine robots know, once it has changed.
        """
        self.step = step
        if insight is not None:
            self._insight = insight
        self._mind.move_to(*place)
        message = self._mind.says(step, self._insight["truth"], self._inventions)
        if self._errands:
            self._errands.move_to(place)
            if message is not None:
                news = self._errands.errand.news(lies=self._mind.settings.fault == BYZANTINE)
                message = message._replace(news=tuple(sorted(news.items())))
        said = None if message is None else self._encoded(message)
        self._line = {"step": step, "place": list(place), "said": said, "see": [], "heard": []}
        if insight is not None:
            self._line["insight"] = insight
        return said

    def _inventions(self, feasible: int) -> list[Thing]:
        """Return what a Byzantine robot invents: tasks, which speak for *infeasible*, or robots."""
        return [sighting_from(each)[0] for each in self._insight["invented"][feasible]]

    def _encoded(self, message: Message) -> str | None:
        try:
            frame: bytes = self._wire.encode(self._id, message)
            return frame.hex()
        except WireError:  # a user's strategy may say what its messages can't hold
            self.dropped["message that can't be encoded"] += 1
            return None

    def sense(self, sensed: Mapping[str, Any]) -> None:
        """Store what it sees: robots and tasks in the form of `sighting_of`, and what `WORK` names."""
        sightings = sensed["see"]
        seen = [each for each in sightings if self._can_be(sighting_from(each)[0])]
        self.dropped["impossible sighting"] += len(sightings) - len(seen)
        self._line["see"] = seen
        things = [sighting_from(each) for each in seen]
        if self._errands:
            told = {name: sensed[name] for name in WORK if sensed.get(name) is not None}
            self._line |= told
            self._errands.sense(told)
            if not self._mind.disseminating:
                self._errands.see(things, told.get("taken", ()))
        self._mind.see((self._names.named(thing) if self._names else thing, which) for thing, which in things)

    def _can_be(self, thing: Thing) -> bool:
        """Return whether the scenario has such an id and class."""
        setting = self._mind.settings.setting
        ids, kinds = (
            (setting.robot_ids, setting.robot_classes)
            if thing.is_robot
            else (setting.task_ids, setting.task_classes)
        )
        return -1 <= thing.id < ids and 0 <= thing.kind < kinds

    def finish(self, heard: Iterable[Sequence[Any]]) -> None:
        """End the step with the messages heard: pairs of a sender's number and its bytes."""
        for sender, text in heard:
            if not self._mind.listens:
                break
            try:
                named, message = self._wire.decode(bytes.fromhex(text))
            except (WireError, ValueError, TypeError):
                self.dropped["malformed message"] += 1
                continue
            self._line["heard"].append([sender, text])
            self._mind.hear(sender if named == -1 else named, message)
            if self._errands:
                self._errands.hear(message.news)
        self._mind.end_step()
        if self._errands:
            if self._mind.settings.fault != BYZANTINE:
                self._errands.errand.choose(self.step, self._mind.declared, self._errands.way)
            self._line["goes"] = self.goes
        self._log()

    def _draw(self, counter: int, purpose: int) -> Words:
        words = self._drawn(counter, purpose)
        if self._write is not None:
            self._draws.append(words)
        return words

    def _log(self) -> None:
        """Write the line of this step, with the draws since the last one."""
        if self._write is not None:
            self._write({**self._line, "draws": self._draws, "status": list(self.status)})
            self._draws = []


def is_message(value: Any) -> bool:
    """Return whether a value is a pair of a sender's number and hexadecimal digits."""
    return (
        isinstance(value, list)
        and len(value) == 2
        and type(value[0]) is int
        and -1 <= value[0] <= 2**32
        and isinstance(value[1], str)
    )


def sighting_of(thing: Thing, number: int) -> list[Any]:
    """Return a sighting as a list, the form that a message and a log hold."""
    return [int(thing.is_robot), thing.id, thing.kind, thing.hash, thing.x, thing.y, number]


def sighting_from(plain: Sequence[Any]) -> tuple[Thing, int]:
    """Return a robot or task in sight, and its number, from a list of `sighting_of`."""
    is_robot, name, kind, mark, x, y, number = plain
    return Thing(bool(is_robot), name, kind, mark, x, y), number


class Replay(NamedTuple):
    """A replayed log, equal to what the robot did."""

    number: int
    """The robot's number."""
    steps: int
    """Number of steps in the log."""
    opinion: str
    """The opinion at the end: ``feasible``, ``infeasible`` or ``undecided``."""
    decisions: int
    """Number of phases that ended with a decision."""
    cut: bool
    """Whether the last line is incomplete, as of a process that was killed."""


def replay(path: str | Path, strategy: Strategy | None = None) -> Replay:
    """Replay a robot's log; ``strategy`` is that of the robot, if it isn't built in.

    A log never says which file to run. Raise a FeasibeeError if it is no log of a robot, is damaged, or says
    anything else than the replay.
    """
    path, first = Path(path), {"feasibee": "robot", "version": VERSION}
    wrong = f"isn't the log of a robot, version {VERSION}; name robot-K.jsonl"
    lines, rest = read_log(path, "the log of a robot, such as robot-3.jsonl", first, wrong)
    head = json.loads(lines[0])
    own = strategy or STRATEGIES.get(str(head.get("strategy")))
    if own is None:
        what = f"the robot's strategy {quoted(head.get('strategy'))} isn't built in"
        raise FeasibeeError(f"{named(path)}: {what}; give --strategy FILE")
    draws, written = deque[Words](), list[Any]()
    decisions = explores = 0
    for at, text in enumerate(lines, 1):
        with reading(path, at):
            line = json.loads(text)
            draws.extend((a, b, c, d) for a, b, c, d in line["draws"])
            if at == 1:
                node = Node(head, written.append, lambda _, __: draws.popleft(), own)
            else:
                node.speak(line["step"], tuple(line["place"]), line.get("insight"))
                node.sense(line)
                node.finish(line["heard"])
            if draws:
                raise ValueError("too many draws")
            _compare(path, at, line, written.pop())
        disseminating = node.status.disseminating
        decisions += bool(explores) and not disseminating
        explores = disseminating
    opinion = DECISIONS[node.status.opinion]
    return Replay(head["settings"]["coordinates"][2], len(lines) - 1, opinion, decisions, bool(rest))


def _compare(path: Path, at: int, line: dict[str, Any], again: Any) -> None:
    """Raise an error if the log says anything else than the replay."""
    for name in ("said", "see", "heard", "status", "goes", *WORK):
        kept, found = line.get(name), again.get(name)
        if kept != found:
            raise FeasibeeError(
                f"{named(path)}: line {at}: {name} is {quoted(kept)} in the log and {quoted(found)} in the "
                "replay; a line is missing or was changed, or another version or strategy wrote it: use an "
                "intact copy"
            )

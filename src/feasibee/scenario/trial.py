"""A user's strategy: its text is run once, its functions are tried, and each later call is checked."""

from __future__ import annotations

import ast
import sys
import traceback
from collections.abc import Callable, Mapping, Sequence
from functools import partial, wraps
from hashlib import sha256
from itertools import product
from pathlib import Path
from types import ModuleType
from typing import Any, Final

from feasibee.base.codes import BITS_LIMIT, COUNT_LIMIT, is_whole
from feasibee.base.errors import FeasibeeError
from feasibee.robot.controller import Message
from feasibee.robot.knowledge import Knowledge
from feasibee.robot.wire import Wire, WireError
from feasibee.scenario.setting import WORDS_LIMIT, setting_from
from feasibee.strategies import layout
from feasibee.strategies.contract import (
    ARGUMENTS,
    CONSTANTS,
    LIMITS,
    MUST,
    Inbox,
    Manifest,
    Me,
    Mind,
    Setting,
    Strategy,
    Thing,
)
from feasibee.strategies.overflow import NAMES, checked
from feasibee.strategies.words import Words

Rule = tuple[str, Callable[[Any], bool]]
_LAYOUT: Final[Any] = layout
"""The module, whose functions have no types."""


def _whole(least: int, most: int) -> Rule:
    return f"must be a whole number from {least} to {most}", lambda value: is_whole(value, most, least)


def _is_number(least: float, most: float, value: Any) -> bool:
    return isinstance(value, int | float) and least <= value <= most


ROWS: Final = "must return nothing: it writes into"
RULES: Final[Mapping[str, Rule]] = {
    **{name: (MUST[name], partial(_is_number, least, most)) for name, (least, most) in LIMITS.items()},
    **dict.fromkeys(
        ("decide", "say", "declare", "judge"),
        (MUST["decide"], lambda value: _is_number(-1, 1, value) and value in (1, 0, -1)),
    ),
    "words": _whole(1, WORDS_LIMIT),
    "message_words": _whole(0, WORDS_LIMIT),
    **dict.fromkeys(("start", "observe", "merge"), (f"{ROWS} known", lambda value: value is None)),
    **dict.fromkeys(("encode", "lie"), (f"{ROWS} message", lambda value: value is None)),
    "count": (f"{ROWS} counts", lambda value: value is None),
    "describe": ("must be a text on one line", lambda value: isinstance(value, str) and value.isprintable()),
    "bits": (MUST["bits"], lambda value: is_whole(value, BITS_LIMIT)),
    "pack": ("must return nothing: it writes with writer", lambda value: value is None),
    **dict.fromkeys(
        ("layout", "unpack"),
        ("must be the sender's id, or -1 if it isn't sent", lambda value: is_whole(value, COUNT_LIMIT, -1)),
    ),
}
"""What each function must return."""
FAILURES: Final = (Exception, SystemExit)
SHOWN: Final = 300
"""Number of characters of arguments and values that an error shows."""


def tried(manifest: Manifest) -> Strategy:
    """Run the text of a user's strategy; return the strategy, after a trial of each function.

    Raise a FeasibeeError if the file fails, or a function fails or returns nonsense: function, line,
    arguments and value.
    """
    file = Path(manifest.name).name
    module = _executed(manifest, file)
    functions: dict[str, Any] = {
        name: _checked(getattr(module, name), name, file) for name in ARGUMENTS if hasattr(module, name)
    }
    if "layout" in functions:
        functions |= _LAYOUT.both_ways(functions["layout"])
    declared: dict[str, Any] = {field: getattr(manifest, field) for field in CONSTANTS.values()}
    strategy = Strategy(
        name=manifest.name, source=manifest.source, functions=frozenset(functions), **declared, **functions
    )
    _try(strategy)
    if strategy.knowledge:
        _try_knowledge(strategy, file)
    return strategy


def _executed(manifest: Manifest, file: str) -> ModuleType:
    """Run the text as a module, which is named after the text."""
    digest = sha256(manifest.source.encode()).hexdigest()[:16]
    module = ModuleType(f"feasibee_strategy_{digest}")
    module.__file__ = manifest.name
    module.__dict__.update(NAMES)
    sys.modules[module.__name__] = module
    try:
        exec(compile(checked(ast.parse(manifest.source, file)), file, "exec"), module.__dict__)
    except FAILURES as error:
        raise FeasibeeError(f"{_where(error, file)}: {_said(error)}") from None
    for name, field in CONSTANTS.items():
        if getattr(module, name, getattr(manifest, field)) != getattr(manifest, field):
            raise FeasibeeError(f"{file}: {name} changes while the file runs; write its value out once")
    return module


def _checked(function: Any, name: str, file: str) -> Callable[..., Any]:
    """Return a function that checks what the user's function returns, and names its line in errors."""
    if not isinstance(function, type(_checked)):
        raise FeasibeeError(f"{file}: {name} isn't a plain function; write def {name}(...)")
    rule, holds = RULES[name]

    @wraps(function)
    def call(*arguments: Any) -> Any:
        try:
            result = function(*arguments)
        except WireError:  # of the bytes that were read, or of a number that doesn't fit
            raise
        except FAILURES as error:
            raise FeasibeeError(
                f"{_where(error, file)}: {_call(name, arguments)} fails: {_said(error)}"
            ) from None
        if not holds(result):
            line = function.__code__.co_firstlineno
            shown = repr(result)[:SHOWN]
            raise FeasibeeError(f"{file}, line {line}: {_call(name, arguments)} returns {shown}; {rule}")
        if name == "count" and not all(is_whole(each, COUNT_LIMIT) for each in arguments[1]):
            line, written = function.__code__.co_firstlineno, repr(list(arguments[1]))[:SHOWN]
            raise FeasibeeError(f"{file}, line {line}: count writes {written} into counts; {MUST['count']}")
        return result

    return call


def _try(strategy: Strategy) -> None:
    """Call the functions with arguments as in a simulation: nothing, little and much seen and heard."""
    counts = ((0, 0), (0, 1), (1, 0), (3, 2), (5, 2), (1000, 3), (3, 1000), (1000, 1000))
    rated = sorted({strategy.quality(*seen) for seen in counts})
    for quality, gain in product({0.5, *rated, *(1.0 - each for each in rated)}, (1e-3, 10.0, 1e6)):
        strategy.dissemination(quality, gain)
    inboxes = (
        Inbox(2, 1, 1, 0.5, 0.5, 0.25),
        Inbox(0, 0, -1, 0.0, 0.0, 0.0),
        Inbox(0, 3, 0, 0.0, 0.1, 0.99),
        Inbox(1000, 1000, 1, 1.0, 0.5, 0.5),
    )
    for opinion, feasible_quality in product((1, 0, -1) if strategy.starts_neutral else (1, 0), rated):
        quality = {1: feasible_quality, 0: 1.0 - feasible_quality, -1: 0.5}[opinion]
        for own_vote, random_ties, inbox in product((1, 0), (1, 0), inboxes):
            mind = _mind(strategy, opinion, quality, feasible_quality, own_vote)
            mind = mind._replace(random_ties=random_ties)
            strategy.say(mind)
            strategy.value(mind)
            strategy.lasting(mind, 10.0)
            strategy.decide(mind, inbox)
            if not strategy.knowledge:
                _try_probability(
                    strategy, mind, (), setting_from((3, 4), (0, 0), False, None, mind.parameters)
                )


def _try_probability(strategy: Strategy, mind: Mind, known: Sequence[int], setting: Setting) -> None:
    """Ask a robot how probable *feasible* is: to write to its memory or its knowledge is an error."""
    strategy.probability(mind._replace(memory=tuple(mind.memory)), tuple(known), setting)


def _try_knowledge(strategy: Strategy, file: str) -> None:
    """Call the functions for knowledge: without and with classes, for honest and Byzantine robots."""
    functions: Any = strategy
    parameters = strategy.parameters.values()
    for counts, classes, liars in (((3, 4), (0, 0), False), ((4, 2), (2, 3), True), ((1, 0), (0, 0), True)):
        setting = setting_from(counts, classes, liars, None, parameters)
        for number in sorted({0, setting.robots - 1}):
            kind, memory = setting.robot_classes - 1, [0.0] * strategy.memory
            me = Me(number, kind, 2**32 - 1 - number, 0, memory, setting)
            robot, messages = _said_by(strategy, me)
            for each in filter(None, (functions.declare, functions.judge)):
                each(robot.words, me)
            for message in messages:
                robot.bits(message)
                functions.merge(robot.words, message, 0, me._replace(step=1000))
                _try_bytes(strategy, message, me, file)
            robots, tasks = robot.counted()
            if functions.describe:
                functions.describe(tuple(robot.words), me)
            if not any(classes):
                _try_probability(strategy, _mind(strategy, 1, 0.5, 0.5, 1), robot.words, setting)
            strategy.quality(sum(robots), sum(tasks))


def _try_bytes(strategy: Strategy, message: tuple[int, ...], me: Me, file: str) -> None:
    """Send a message as bytes: these must hold all of it, in as many bits as the strategy says."""
    functions: Any = strategy
    if strategy.functions.isdisjoint({"pack", "unpack"}):
        return
    writes, reads = ("layout", "layout") if functions.layout else ("pack", "unpack")
    both = " and ".join(dict.fromkeys((writes, reads)))
    id_bits = max(me.setting.id_bits, (me.setting.robot_ids - 1).bit_length())  # also of invented robots
    me = me._replace(setting=me.setting._replace(id_bits=id_bits))
    wire = Wire(strategy, id_bits, setting=me.setting)
    sent = Message(-1, knowledge=message)
    try:
        written, counted = wire.bits(me.id, sent), functions.bits(message, me)
        heard = wire.decode(wire.encode(me.id, sent)).message
    except WireError as error:
        raise FeasibeeError(f"{file}: {both} of {message!r}: {error}") from None
    if written != counted:
        told = f"{writes} writes {written} bits of {message!r}, and bits returns {counted}"
        raise FeasibeeError(f"{file}: {told}; they must be equal")
    if heard != sent:
        told = f"{reads} reads {heard.knowledge!r} from what {writes} wrote of {message!r}"
        raise FeasibeeError(f"{file}: {told}; they must be equal")


def _said_by(strategy: Strategy, me: Me) -> tuple[Knowledge, list[tuple[int, ...]]]:
    """Return a robot that has seen everything, and its messages, true and false."""
    robot, setting = Knowledge(strategy, me), me.setting
    functions: Any = strategy
    for each in filter(None, (functions.declare, functions.judge)):
        each(Words(robot.words), me._replace(step=1000))
    robot.observe(_things(setting, false=not strategy.by_name))
    messages = [robot.message()]
    if functions.lie is not None and setting.robot_ids > setting.robots:
        messages += [robot.lie(messages[0], feasible, ()) for feasible in (1, 0)]
    return robot, messages


def _things(setting: Setting, false: bool) -> list[Thing]:
    """Return the robots and tasks that can be seen or invented, and one of each that isn't there."""
    robots = [Thing(True, k, k % setting.robot_classes, 2**32 - 1 - 77 * k) for k in range(setting.robot_ids)]
    tasks = [Thing(False, k, k % setting.task_classes, 2**31 + 128 * k) for k in range(setting.task_ids)]
    return [*robots, *tasks, *([Thing(True, -1, 0, 0), Thing(False, -1, 0, 0)] if false else [])]


def _mind(strategy: Strategy, opinion: int, quality: float, feasible_quality: float, own_vote: int) -> Mind:
    parameters = [float(number) for number in strategy.parameters.values()]
    return Mind(opinion, quality, feasible_quality, own_vote, [0.0] * strategy.memory, parameters)


def _call(name: str, arguments: tuple[Any, ...]) -> str:
    return f"{name}({', '.join(map(repr, arguments))[:SHOWN]})"


def _where(error: BaseException, file: str) -> str:
    """Return the last line of the file that an error passed through."""
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == file]
    return f"{file}, line {lines[-1]}" if lines else file


def _said(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}".splitlines()[0][:SHOWN]

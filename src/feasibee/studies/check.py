"""What a strategy needs and takes, whether it is the same everywhere, and how often it is right."""

from __future__ import annotations

import random
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from feasibee.base.errors import FeasibeeError
from feasibee.field.brain import CompiledMind, compiled
from feasibee.reference.mind import BYZANTINE, Mind, MindSettings
from feasibee.reference.robot import Robot
from feasibee.reference.swarm import Swarm
from feasibee.robot import firmware
from feasibee.robot.controller import Message
from feasibee.robot.sizes import PROCESSORS, size_of
from feasibee.robot.wire import Wire, WireError
from feasibee.scenario.messages import MessageBits, message_bits
from feasibee.scenario.plugins import manifest_of
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.sweep import Execution
from feasibee.strategies.contract import Strategy, Thing
from feasibee.studies.comparison import Outcome, compare, contenders_of, origin

TASKS: Final = (10, 16, 20, 21, 25, 40)
"""Numbers of tasks for the paper's 20 robots: six ratios, two of them on either side of ratio one."""
BESIDE: Final = ("dmmd", "census")
"""Strategies to compare with: the paper's, and one that passes on all that is known."""
WORLDS: Final = 6
"""Number of random worlds in which Python, engine and C are compared."""
STEPS: Final = 120
"""Number of steps in each of them."""
AGREE: Final = "agree"


@dataclass(frozen=True)
class Check:
    """What was found of a strategy, in the paper's world unless said otherwise."""

    strategy: str
    """Its file."""
    needs: tuple[str, ...]
    """What a robot needs: ``"names"``, ``"ids"`` or ``"count"``."""
    bits: MessageBits
    """Length of a message in bits, at first and when the robot knows everything."""
    words: int
    """Number of words that a robot knows."""
    message_words: int
    """Number of words of a message, before it is encoded."""
    memory: int
    """Number of floats that a robot keeps."""
    in_c: str
    """Empty if it has been translated to C; otherwise why not."""
    needs_double: bool
    """Whether its C needs ``FEASIBEE_DOUBLE``."""
    sizes: dict[str, tuple[int, int] | str]
    """By processor, bytes in flash and in RAM, or why there are none."""
    engine: str
    """Whether the engine agrees with Python in random worlds: ``"agree"``, or where not."""
    c: str
    """Whether C agrees with Python."""
    outcomes: tuple[Outcome, ...]
    """Runs with the strategy and with those to compare with, at each number of tasks."""

    @property
    def agrees(self) -> bool:
        """Whether engine, Python and C agree, as far as the strategy has been translated to C."""
        return self.engine == AGREE and (self.c == AGREE or bool(self.in_c))

    def to_dict(self, seed: int) -> dict[str, Any]:
        """Return it as plain tables, for programs."""
        plain = {each.name: getattr(self, each.name) for each in fields(self)[:-1]}
        outcomes = [each.to_dict() for each in self.outcomes]
        return {**plain, "bits": self.bits._asdict(), **origin(seed), "outcomes": outcomes}


def check(name: str, runs: int = 200, seed: int = 0, execution: Execution | None = None) -> Check:
    """Check a user's strategy.

    ``name`` is the path of its file, and ``runs`` the number of runs at each number of tasks.

    Raise a FeasibeeError if it isn't a strategy, or fails in a run.
    """
    scenario = _paper(name)
    strategy, setting = scenario.strategy, scenario.setting
    if not strategy.source:
        raise FeasibeeError(f"{name}: is built in; name a file of your own, such as mine.py")
    Runs.of_point(0, runs, seed)  # raises before any work
    known, told = strategy.row_lengths(setting) if strategy.knowledge else (0, 0)
    contenders = contenders_of(scenario, [name, *BESIDE])
    in_c = _problem(lambda: firmware.header(strategy))
    return Check(
        strategy=name,
        needs=strategy.needs(strategy.parameters),
        bits=message_bits(scenario),
        words=known,
        message_words=told,
        memory=strategy.memory,
        in_c=in_c,
        needs_double=not in_c and firmware.needs_double(strategy),
        sizes={} if in_c else {each: _size(each, scenario) for each in PROCESSORS},
        engine=_agreement(name, seed, _same_in_engine),
        c=in_c or _agreement(name, seed, _same_in_c),
        outcomes=tuple(compare(contenders, TASKS, runs, seed, execution, curves=False)),
    )


def _paper(name: str) -> Scenario:
    """Return the paper's swarm with a strategy, whose robots know their number if it needs that."""
    needs_count = manifest_of(name).needs_count
    return Scenario(robots={"know_count": needs_count}, decision={"strategy": name})


def _problem(work: Callable[[], object]) -> str:
    """Return the error that a function raises, empty if none."""
    try:
        work()
    except FeasibeeError as error:
        return str(error)
    return ""


def _size(processor: str, scenario: Scenario) -> tuple[int, int] | str:
    """Return the bytes of a robot's controller in flash and RAM, or why there are none."""
    if not PROCESSORS[processor].found:
        return f"no compiler here; install {PROCESSORS[processor].packages}"
    try:
        return size_of(PROCESSORS[processor], scenario.strategy, scenario.setting)
    except FeasibeeError as error:
        return "too large for its memory" if "region" in str(error) else str(error)


# --- The same everywhere ---


def _worlds(name: str, seed: int) -> Iterator[Scenario]:
    """Yield random worlds that a strategy supports."""
    draw, base = random.Random(f"{seed}"), _paper(name)
    lies = "encode" not in base.manifest.functions or "lie" in base.manifest.functions
    for _ in range(WORLDS):
        count = draw.randint(3, 10)
        yield base.replace(
            {
                "robots.count": count,
                "tasks.count": draw.randint(1, count + 5),
                "robots.know_count": base.robots.know_count or draw.random() < 0.5,
                "arena.side": draw.choice([8.0, 12.0]),
                "arena.boundary": draw.choice(["torus", "walls"]),
                "sensing.miss": draw.choice([0.0, 0.3]),
                "faults.byzantine": draw.choice([0.0, 0.2]) if lies else 0.0,
                "radio.loss": draw.choice([0.0, 0.3]),
                "radio.range": draw.choice([2.0, 4.0]),
                "run.steps": STEPS,
            }
        )


def _agreement(name: str, seed: int, check_one: Callable[[Scenario, int], None]) -> str:
    """Return whether a check holds in all random worlds, or where it doesn't."""
    for number, scenario in enumerate(_worlds(name, seed)):
        problem = _problem(lambda scenario=scenario: check_one(scenario, seed))  # type: ignore[misc]
        if problem:
            return f"world {number} ({scenario.robots.count} robots, {scenario.tasks.count} tasks): {problem}"
    return AGREE


def _same_in_engine(scenario: Scenario, seed: int) -> None:
    """Raise an error if the engine and Python simulate a world in two ways."""
    options: Any = {"curves": True}
    one, other = (
        simulate_record(scenario, Runs(2, seed), backend=each, **options) for each in ("engine", "reference")
    )
    for each in fields(one):
        if not np.array_equal(getattr(one, each.name), getattr(other, each.name)):
            raise FeasibeeError(f"{each.name} differs between engine and Python; report this file as a bug")


def _same_in_c(scenario: Scenario, seed: int) -> None:
    """Raise an error where a robot in C differs from one in Python."""
    with tempfile.TemporaryDirectory() as folder:
        live(scenario, compiled(scenario.strategy, scenario.setting, Path(folder)), seed, 0)


class Twin(Mind):
    """A mind in Python with one in C, which senses the same and must say, hold and declare the same.

    Robots hear what was sent as bytes, as real ones do. ``library`` is the program in C that
    `feasibee.field.brain.compiled` made.
    """

    def __init__(self, library: Path, strategy: Strategy, settings: MindSettings) -> None:
        setting = settings.setting
        id_bits = max(setting.id_bits, (max(setting.robots, setting.robot_ids) - 1).bit_length())
        settings = replace(settings, setting=setting._replace(id_bits=id_bits))
        self._wire = Wire(strategy, id_bits, declares=settings.declare is not None, setting=settings.setting)
        super().__init__(strategy, settings)
        self._other = CompiledMind(library, strategy, settings, self._words)
        self._compare()

    def move_to(self, x: float, y: float) -> None:
        """Store the robot's position."""
        super().move_to(x, y)
        self._other.move_to(x, y)

    def observe(self, robots: int | Sequence[int], tasks: int | Sequence[int]) -> None:
        """Count robots and tasks in sight."""
        super().observe(robots, tasks)
        self._other.observe(robots, tasks)

    def recognise(self, things: Iterable[Thing]) -> None:
        """Add robots and tasks in sight to the knowledge."""
        things = list(things)
        super().recognise(things)
        self._other.recognise(things)

    def message(self) -> Message | None:
        """Return the message of this step, if any, as it is heard."""
        said, other = super().message(), self._other.message()
        frame = None if said is None else self._bytes(self.settings.me[0], said)
        if frame != other:
            shown = ("nothing" if each is None else each.hex() for each in (frame, other))
            raise FeasibeeError("Python sends {}, and C {}".format(*shown))
        return said

    def hear(self, sender: int, message: Message) -> None:
        """Hear a message as the bytes that were sent; a lie may not fit its bits, and isn't heard."""
        frame = self._bytes(sender, message)
        if not frame:
            return
        try:
            heard = self._wire.decode(frame).message
            self._other.decode(frame)
        except WireError as error:
            raise FeasibeeError(f"{frame.hex()}, which Python sends, isn't read: it {error}") from None
        super().hear(sender, heard)
        self._other.hear(sender, None)

    def _bytes(self, sender: int, message: Message) -> bytes:
        """Return a message as bytes, none if it doesn't fit its bits."""
        try:
            return self._wire.encode(sender, message)
        except WireError:
            return b""

    def end_step(self) -> None:
        """End a step."""
        super().end_step()
        self._other.end_step()
        self._compare()

    def _compare(self) -> None:
        """Raise an error if both minds differ."""
        held = [
            (each.opinion, each.declared, each.disseminating, each.phase_left) for each in (self, self._other)
        ]
        if held[0] != held[1]:
            names = "opinion, declaration, whether it disseminates and for how long"
            raise FeasibeeError(f"{names} are {held[0]} in Python, and {held[1]} in C")


def live(scenario: Scenario, library: Path, seed: int, run: int) -> None:
    """Simulate a run of robots without classes; raise an error that names the first step and difference."""

    class TwinRobot(Robot):
        """A robot with two minds, unless it is Byzantine."""

        def mind_of(self, settings: MindSettings) -> Mind:
            if settings.fault == BYZANTINE:
                return Mind(scenario.strategy, settings)
            return Twin(library, scenario.strategy, settings)

    class Twins(Swarm):
        """A swarm of them."""

        robot_type = TwinRobot

    swarm = Twins(scenario, seed, run)
    for step in range(scenario.run.steps):
        try:
            swarm.step()
        except FeasibeeError as error:
            raise FeasibeeError(f"step {step + 1}: {error}") from None

"""The brain of a robot in C: the program that is flashed, compiled for this machine, in a robot's process."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Final

from feasibee.base.purposes import FIRST_OPINION, PHASE
from feasibee.reference.mind import STUBBORN, Draw, Mind, MindSettings
from feasibee.robot import firmware
from feasibee.robot.compiler import run_compiler
from feasibee.robot.given import LARGEST, numbers_of
from feasibee.robot.wire import WireError, name_of
from feasibee.strategies.contract import Setting, Strategy, Thing

SOURCE: Final = Path(__file__).parent / "brain.c"
FLAGS: Final = (
    "-std=c99",
    "-O2",
    "-ffp-contract=off",
    "-fPIC",
    "-shared",
    "-fvisibility=hidden",
    "-Werror=implicit-function-declaration",
)
"""No contraction: each operation rounds as in Python."""
FRAME: Final = 65_535
"""Most bytes of a frame."""


def compiled(strategy: Strategy, setting: Setting, folder: Path) -> Path:
    """Compile the program of the robots of a scenario; return the library in the folder.

    ``setting`` has the numbers of the scenario, which say how much the robots know. Raise a FeasibeeError if
    there is no compiler, or it fails.
    """
    (folder / "feasibee.h").write_text(firmware.header(strategy), encoding="utf-8")
    library = folder / "brain.so"
    includes = (f"-I{folder}", f"-I{firmware.FOLDER}", str(SOURCE))
    defined = [f"-D{name}={value}" for name, value in _macros(strategy, setting).items()]
    run_compiler(*FLAGS, *defined, *includes, "-o", str(library), "-lm")
    return library


def _macros(strategy: Strategy, setting: Setting) -> dict[str, Any]:
    """Return what brain.c needs to know of a strategy and a scenario."""
    known, told = strategy.row_lengths(setting) if strategy.knowledge else (0, 0)
    return {
        "FEASIBEE_DOUBLE": "1",
        "FEASIBEE_ID": "uint32_t",
        "FEASIBEE_CLASSES": max(setting.robot_classes, setting.task_classes),
        "FEASIBEE_INBOX": _inbox(setting),
        "FEASIBEE_WORDS": known,
        "FEASIBEE_MESSAGE_WORDS": max(told, 1),
        "FEASIBEE_PARAMETERS": max(len(strategy.parameters), 1),
        "STRATEGY": firmware.constant(strategy),
        "NAME": f'"{name_of(strategy)}"',
    }


def _inbox(setting: Setting) -> int:
    """Return the most senders whose message a robot keeps."""
    return min(max(setting.robots, 1), LARGEST)


class CompiledMind(Mind):
    """The mind of one robot, which runs in C; its draws are made here, and its frames are C's, too.

    ``library`` is what `compiled` made; ``strategy``, ``settings`` and ``words`` are those of `Mind`.
    ``task_of`` returns the id of a task, given its name in a message.
    """

    def __init__(
        self,
        library: Path,
        strategy: Strategy,
        settings: MindSettings,
        words: Draw,
        task_of: Callable[[int], int] | None = None,
    ) -> None:
        self.strategy, self.settings, self._words = strategy, settings, words
        self.phases, self.knowledge = settings.phases, None
        self._remembered, self._remembers_since = set(), 0
        robots, tasks = settings.sets[0]
        self.robots_seen, self.tasks_seen = [0] * len(robots), [0] * len(tasks)
        self._library = ctypes.CDLL(str(library))
        self._brain = ctypes.create_string_buffer(self._library.brain_size())
        self._state = (ctypes.c_int32 * 5)()
        self._frame = (ctypes.c_uint8 * FRAME)()
        opinion = words(settings.joined, FIRST_OPINION)[0] >> 31
        numbers = numbers_of(strategy, settings, settings.setting, _inbox(settings.setting))
        own = *settings.me, settings.step, opinion, settings.fault == STUBBORN, *settings.place
        self._begin([float(each) for each in (*own, *numbers.values())], task_of)

    def _begin(self, numbers: list[float], task_of: Callable[[int], int] | None) -> None:
        void, u32, i32, real = None, ctypes.c_uint32, ctypes.c_int32, ctypes.c_double
        none: Any = ctypes.CFUNCTYPE(i32, u32)()
        self._kept = (  # as long as C may use them
            (real * len(numbers))(*numbers),
            ctypes.CFUNCTYPE(u32, real)(self._duration),
            ctypes.CFUNCTYPE(void, ctypes.POINTER(u32))(self._choose),
            ctypes.CFUNCTYPE(i32, u32)(task_of) if task_of else none,
            self._sets(),
            len(self.settings.sets),
            self.settings.setting.plan,
            len(self.settings.setting.plan),
        )
        self._library.brain_move.argtypes = ctypes.c_void_p, real, real
        self._library.brain_recognise.argtypes = (
            ctypes.c_void_p,
            ctypes.c_bool,
            i32,
            ctypes.c_uint8,
            u32,
            real,
            real,
        )
        self._library.brain_begin(self._brain, *self._kept)

    def _sets(self) -> Any:
        """Return what each class adds to each set of skills, as `struct feasibee_set` has it."""
        most = max(map(len, self.settings.sets[0]))
        weights = [
            weight
            for sides in self.settings.sets
            for side in sides
            for weight in (*side, *[0] * (most - len(side)))
        ]
        return (ctypes.c_uint16 * len(weights))(*weights)

    def _choose(self, words: Any) -> None:
        _, words[0], words[1], _ = self._words(self.phases, PHASE)

    def _read(self, place: int) -> int:
        self._library.brain_state(self._brain, self._state)
        return self._state[place]

    opinion: Any = property(lambda self: self._read(0))
    declared: Any = property(lambda self: self._read(1))
    disseminating: Any = property(lambda self: bool(self._read(2)))
    phase_left: Any = property(lambda self: self._read(3))
    listens: Any = property(lambda self: bool(self._read(4)))

    explorations: Any = property(lambda self: (self.phases - self.settings.phases + 1) // 2)

    def move_to(self, x: float, y: float) -> None:
        """Store the robot's position in the frame that all robots share, in units."""
        self._library.brain_move(self._brain, x, y)

    def message(self) -> Any:
        """Return the frame of this step, None if the robot is silent, empty if it can't be encoded."""
        length = self._library.brain_speak(self._brain, self._frame, FRAME)
        return None if length == 0 else bytes(self._frame[: max(length, 0)])

    def observe(self, robots: Any, tasks: Any) -> None:
        """Count robots and tasks in sight."""
        for is_robot, counts in ((True, robots), (False, tasks)):
            for kind, number in enumerate(counts):
                for _ in range(number):
                    self._library.brain_observe(self._brain, is_robot, kind)

    def recognise(self, things: Iterable[Thing]) -> None:
        """Add robots and tasks in sight to the knowledge."""
        for thing in things:
            self._library.brain_recognise(self._brain, *thing)

    def encode(self, _: int, frame: bytes) -> bytes:
        """Return a message as bytes, as `Wire` does."""
        if not frame:
            raise WireError("doesn't fit its bits")
        return frame

    def decode(self, frame: bytes) -> tuple[int, None]:
        """Return the sender of a frame, -1 if it isn't sent; its message stays in C."""
        sender = self._library.brain_decode(self._brain, frame, len(frame))
        if sender < -1:
            raise WireError("is no frame of this strategy")
        return sender, None

    def hear(self, sender: int, message: Any) -> None:
        """Let the robot in C hear the message that was decoded last."""
        self._library.brain_hear(self._brain, sender)

    def end_step(self) -> None:
        """End a step."""
        self._library.brain_end_step(self._brain)

"""Three robots that hear each other's frames on a simulated board (frames.c), and the same in Python."""

from __future__ import annotations

from array import array
from zlib import crc32

from benchmarks.sizes import PROCESSORS, SHARED, setting_in_c
from feasibee.robot import Controller, Settings, Wire, firmware
from feasibee.scenario.setting import setting_from
from feasibee.strategies import STRATEGIES
from feasibee.strategies.contract import Thing
from tests.robot import boards

ROBOTS = 3


def in_c(strategy, setting, longest):
    """Return the strategy, its setting and the length of its longest frame in C."""
    knowledge = STRATEGIES[strategy].knowledge
    rows = STRATEGIES[strategy].row_lengths(setting) if knowledge else (0, 0)
    return "\n".join(
        [
            f"#define FEASIBEE_WORDS {rows[0]}",
            f"#define FEASIBEE_MESSAGE_WORDS {rows[1]}",
            f"#define FRAME {longest}",
            f'#define NAME "{strategy}"',
            f"#define STRATEGY {boards.constant(strategy)}",
            "#ifdef FEASIBEE_H",
            setting_in_c(setting),
            "#endif",
            "",
        ]
    )


def build(board, swarm, folder, steps, *flags):
    """Compile the program of ``frames.c`` for a board and a swarm that was run in Python."""
    strategy = swarm.strategy
    processor = PROCESSORS[boards.BOARDS[board].processor]
    boards.needs(processor.compiler[0], processor.packages)
    (folder / "swarm.h").write_text(in_c(strategy, swarm.setting, swarm.longest))
    (folder / "feasibee.h").write_text('#include "swarm.h"\n' + firmware.header(strategy, inbox=12))
    path = folder / "frames.elf"
    include = [f"-I{folder}", f"-I{boards.SOURCES}", f"-DSTEPS={steps}"]
    source = str(boards.SOURCES / "frames.c")
    boards.run(
        [*processor.compiler, *SHARED, *include, *flags, source, "-o", str(path), *boards.BOARDS[board].link]
    )
    return boards.Program(boards.BOARDS[board], path, *processor.bytes_of(path))


class Swarm:
    """The robots of ``frames.c``, in Python."""

    def __init__(self, strategy, quiet=0.0):
        self.strategy = strategy
        parameters = dict(STRATEGIES[strategy].parameters)
        parameters |= {"quiet": quiet} if "quiet" in parameters else {}
        self.longest = 0
        self.setting = setting_from((36, 34), (0, 0), False, None, parameters.values())
        self.wire = Wire(STRATEGIES[strategy], self.setting.id_bits, setting=self.setting)
        self.words = words = boards.Words(17)
        self.robots = [
            Controller(
                STRATEGIES[strategy],
                opinion=number & 1,
                settings=Settings(me=(number, 0, words.word()), setting=self.setting),
                draw_duration=lambda mean: 1 + (words.word() & 7),
                draw_choice=lambda: (words.word() / 2**32, words.word() / 2**32),
            )
            for number in range(ROBOTS)
        ]

    def run(self, steps):
        """Return the lines that ``frames.c`` prints."""
        return [line for _ in range(steps) for line in self._step()]

    def _step(self):
        said = [robot.message() for robot in self.robots]
        frames = [self.wire.encode(number, each) if each else b"" for number, each in enumerate(said)]
        self.longest = max(self.longest, *map(len, frames))
        for own, robot in enumerate(self.robots):
            self._recognise(robot)
            word = self.words.word()
            for other, frame in enumerate(frames):
                if other != own and word >> other & 1 and frame and robot.listens:
                    robot.hear(*self.wire.decode(frame))
        for robot, frame in zip(self.robots, frames, strict=True):
            robot.end_step()
            yield line_of(robot, frame)

    def _recognise(self, robot):
        for _ in range(self.words.word() & 3):
            word = self.words.word()
            number = (word >> 1) % (self.setting.robots if word & 1 else self.setting.tasks)
            mark = (number * 2 + (word & 1) + 1) * 2654435761 & 0xFFFFFFFF
            robot.recognise([Thing(bool(word & 1), number, 0, mark)])
            robot.observe(word & 1, 1 - (word & 1))


def line_of(robot, frame):
    """Return a robot's state as ``frames.c`` prints it."""
    known = f"{crc32(array('i', robot.knowledge.words).tobytes()):08x}" if robot.knowledge else ""
    held = (robot.opinion + 1) | (robot.declared + 1) << 2
    phase = robot.disseminating | (robot.declared != -1) << 1
    return f"{held:x}{phase:x}{robot.phase_left:02x}{crc32(frame):08x}{known}"

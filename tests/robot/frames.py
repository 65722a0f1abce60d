"""Three robots that hear each other's frames on a simulated board (frames.c), and the same in Python."""

from __future__ import annotations

from array import array
from zlib import crc32

from feasibee.robot import Controller, Settings, firmware
from feasibee.robot.sizes import setting_in_c
from feasibee.scenario.setting import setting_from
from feasibee.strategies import STRATEGIES
from feasibee.strategies.contract import Thing
from tests.robot import boards
from tests.robot.driving import Draws, constant
from tests.robot.swarms import names_of, wire_of

ROBOTS = 3


def in_c(strategy, setting, longest, names):
    """Return the strategy, its setting, the names of tasks and the length of its longest frame in C."""
    knowledge = STRATEGIES[strategy].knowledge
    rows = STRATEGIES[strategy].row_lengths(setting) if knowledge else (0, 0)
    return "\n".join(
        [
            f"#define FEASIBEE_WORDS {rows[0]}",
            f"#define FEASIBEE_MESSAGE_WORDS {rows[1]}",
            f"#define FRAME {longest}",
            f'#define NAME "{strategy}"',
            f"#define STRATEGY {constant(strategy)}",
            *([f"#define NAMES {', '.join(map(str, names))}"] if names else []),
            "#ifdef FEASIBEE_H",
            setting_in_c(setting),
            "#endif",
            "",
        ]
    )


def build(board, swarm, folder, steps, *flags):
    """Compile the program of ``frames.c`` for a board and a swarm that was run in Python."""
    strategy = swarm.strategy
    (folder / "swarm.h").write_text(in_c(strategy, swarm.setting, swarm.longest, swarm.names))
    header = '#include "swarm.h"\n' + firmware.header(strategy, inbox=12)
    source = boards.SOURCES / "frames.c"
    return boards.compiled(board, folder, header, source, f"-DSTEPS={steps}", *flags)


class Swarm:
    """The robots of ``frames.c``, in Python."""

    def __init__(self, strategy, quiet=0.0, has_places=False):
        self.strategy = strategy
        self.has_places = has_places
        parameters = dict(STRATEGIES[strategy].parameters)
        parameters |= {"quiet": quiet} if "quiet" in parameters else {}
        self.longest = 0
        self.setting = setting_from((36, 34), (0, 0), False, None, parameters.values())
        places = [place_of(hash_of(task, is_robot=False)) for task in range(self.setting.tasks)]
        self.names = names_of(strategy, self.setting, places)
        self.wire = wire_of(strategy, self.setting, self.names)
        self.draws = draws = Draws(17)
        self.robots = [
            Controller(
                STRATEGIES[strategy],
                opinion=number & 1,
                settings=Settings(me=(number, 0, draws.word()), setting=self.setting),
                draw_duration=lambda mean: 1 + (draws.word() & 7),
                draw_choice=draws.choice,
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
            word = self.draws.word()
            for other, frame in enumerate(frames):
                if other != own and word >> other & 1 and frame and robot.listens:
                    robot.hear(*self.wire.decode(frame))
        for robot, frame in zip(self.robots, frames, strict=True):
            robot.end_step()
            yield line_of(robot, frame)

    def _recognise(self, robot):
        if self.has_places:
            robot.move_to(*place_of(self.draws.word()))
        for _ in range(self.draws.word() & 3):
            word = self.draws.word()
            number = (word >> 1) % (self.setting.robots if word & 1 else self.setting.tasks)
            mark = hash_of(number, is_robot=word & 1)
            place = place_of(mark) if self.has_places else ()
            robot.recognise([Thing(bool(word & 1), number, 0, mark, *place)])
            robot.observe(word & 1, 1 - (word & 1))


def hash_of(number, is_robot):
    """Return the hash of a thing."""
    return (number * 2 + is_robot + 1) * 2654435761 & 0xFFFFFFFF


def place_of(word):
    """Return a place in the arena."""
    return (word & 255) / 16, (word >> 8 & 255) / 16


def line_of(robot, frame):
    """Return a robot's state as ``frames.c`` prints it."""
    known = f"{crc32(array('i', robot.knowledge.words).tobytes()):08x}" if robot.knowledge else ""
    held = (robot.opinion + 1) | (robot.declared + 1) << 2
    phase = robot.disseminating | (robot.declared != -1) << 1
    return f"{held:x}{phase:x}{robot.phase_left:02x}{crc32(frame):08x}{known}"

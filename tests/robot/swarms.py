"""Swarms of controllers that pass on knowledge, the same in Python and in C (swarm.c)."""

from __future__ import annotations

import random
import struct
import subprocess
from array import array
from contextlib import suppress
from fractions import Fraction
from functools import cache
from zlib import crc32

from feasibee.robot import Controller, Declare, Message, Settings, Wire, WireError, firmware
from feasibee.robot.knowledge import Knowledge
from feasibee.robot.translate import Translation
from feasibee.scenario.setting import setting_from
from feasibee.strategies import STRATEGIES, roster
from feasibee.strategies.certified import NEVER
from feasibee.strategies.contract import Me, Thing
from feasibee.strategies.sight import TASKS, WALL
from tests.robot.driving import Draws, assert_equal

NAMES = list(STRATEGIES)
KNOWLEDGE = [name for name in NAMES if STRATEGIES[name].knowledge]
STATE = struct.Struct("<BBBIHIIIHII")
"""Opinion + 1, declared + 1, phase, steps left, length and CRC of the frame, CRCs, rating; bits, lie."""
VARIANTS = {
    "turns": {
        "names": [-1.0, 0.0, 1.0, 3.0],
        "name_bits": [4.0, 9.0, 20.0, 31.0],
        "quiet": [0.0, 0.0, 20.0, 33.5],
        "tolerates": [0.0, 0.0, 1.0, 2.0],
        "looks": [1.0, 2.0],
    },
    "quiet-census": {
        "quiet": [0.0, 20.0, 33.5],
        "tolerates": [0.0, 0.0, 1.0, 2.0],
        "hurry": [0.0, 0.3, 0.5, 2.0],
        "lasts": [0.0, 2.5, 40.0],
    },
    "map": {"cell": [4.0, 7.0, 30.0], "rows": [0.0, 0.0, 1.0, 2.0], "tolerates": [0.0, 0.0, 1.0, 2.0]},
    "roster": {
        "task_timeout": [0.0, 9.0, 30.5, 1e5],
        "robot_timeout": [0.0, 9.0, 30.5, 1e5],
        "looks": [1.0, 2.0],
        "tolerates": [0.0, 0.0, 1.0, 2.0],
    },
}
"""Values of parameters to draw from."""
EXACT = {"quiet": [20.0, 33.5]}
"""Values without which C computes in floating point."""
EXTRAS = "bits", "lie"
"""Functions that robots don't need, which swarm.c calls by their names."""
CLASSES = 4
"""FEASIBEE_CLASSES, with which the programs are compiled that compute in double."""
IN_DOUBLE = "-DFEASIBEE_DOUBLE", "-DFEASIBEE_BOUNDS", f"-DFEASIBEE_CLASSES={CLASSES}"
"""Options of programs that compute in double: they check each place in a row, and have classes."""
RULE = Declare(Fraction(9, 10), 2, 3)
FIRST_STEPS = [0, 0, 3, 4_000, 100_000]
"""Steps that have passed when a robot begins."""


@cache
def extras_in_c():
    """Return the functions of each strategy in C."""
    translation = Translation()  # names depend on what was translated before, as in the whole header
    return {name: firmware.functions(strategy, translation) for name, strategy in STRATEGIES.items()}


def has_extra(name, extra, whole_numbers):
    """Return whether a strategy has a function in C."""
    found = extras_in_c()[name].get(extra)
    return found is not None and not (whole_numbers and any(found.needs))


def extras(whole_numbers=False):
    """Return the option of the compiler that lists them, as they stand in swarm.c."""
    rows = [
        ", ".join(
            extras_in_c()[name][each].name if has_extra(name, each, whole_numbers) else "NULL"
            for each in EXTRAS
        )
        if name in KNOWLEDGE
        else "NULL, NULL"
        for name in NAMES
    ]
    return "-DEXTRAS=" + ", ".join(f"{{{row}}}" for row in rows)


def forged(frame, number, draw):
    """Return a frame with other bits, in runs, so that numbers are often the least or largest possible."""
    bits, bit = 0, draw.getrandbits(1)
    for _ in range(number):
        bit ^= draw.random() < 0.15
        bits = bits << 1 | bit
    body = frame[:3] + (bits << -number % 8).to_bytes(len(frame) - 7, "big")
    return body + crc32(body).to_bytes(4, "big")


def plan_of(draw):
    """Return the plan of a random place, or none."""
    columns = draw.choice([0, 0, 4, 7])
    cells = bytes(draw.choices([0, TASKS, WALL], [1, 4, 1], k=columns * draw.randint(3, 8)))
    return {"plan": cells, "columns": columns}


def setting_of(strategy, draw, whole_numbers, fixed):
    """Return a random setting with random parameters, some of them from the values in ``fixed``."""
    robots, tasks = draw.choice(fixed.get("robots", [*range(4, 25), 200])), draw.randint(1, 24)
    variants = VARIANTS.get(strategy.name, {}) | (EXACT if whole_numbers else {}) | fixed
    drawn = {name: draw.choice(variants[name]) for name in strategy.parameters}
    setting = setting_from(
        (robots, tasks),
        (0, 0) if whole_numbers or strategy.one_class else (draw.randint(1, 4), draw.randint(1, 3)),
        draw.random() < 0.5,
        None,
        drawn.values(),
        knows_count=strategy.needs_count or draw.choice(fixed.get("knows_count", [False, True])),
        size=(draw.choice([8.0, 20.0]), draw.choice([7.0, 20.0])),
        colluding=draw.random() < 0.5,
        walled=draw.random() < 0.5,
        sight=draw.choice([1.0, 2.5]),
        radio=draw.choice([1.5, 2.0]),
        speed=draw.choice([1.0, 8.0, 100.0]),  # the faster, the shorter are quiet times
        exploration=draw.choice([1.0, 4.0, 10.0]),
        dissemination=draw.choice([0.0, 3.0, 10.0]),
        mean_run=draw.choice([0.2, 3.0, 100.0]),
        flooding=draw.choice([0.0, 0.0, 7.0, float(NEVER)]),
        delay=draw.choice([0.0, 0.0, 5.0]),
        **plan_of(draw),
        work=draw.choice([1.0, 40.0]),
        charge=draw.choice([0.0, 0.0, 10.0]),
    )
    return setting._replace(id_bits=max(setting.id_bits, (setting.robot_ids - 1).bit_length()))


def names_of(name, setting, places):
    """Return the names that tasks have in messages, if the strategy names them by their places."""
    if name != "roster":
        return []
    return [roster.place_of(Thing(False, 0, 0, 0, *place), setting) for place in places]


def wire_of(name, setting, names, declares=False):
    """Return the wire of a swarm whose tasks have these names."""
    ids = {each: number for number, each in enumerate(names)}
    task_of = (lambda each: ids.get(each, -1)) if names else None
    return Wire(STRATEGIES[name], setting.id_bits, declares=declares, setting=setting, task_of=task_of)


def setting_bytes(name, setting, declares, names=()):
    """Return what `read_setting` of stream.h reads."""
    numbers = [setting.width, setting.height, setting.sight, setting.radio, setting.speed]
    numbers += [setting.exploration, setting.dissemination, setting.mean_run, setting.flooding]
    numbers += [setting.delay, setting.work, setting.charge]
    numbers += setting.parameters
    packed = struct.pack(
        "<BHHHHH6B17dBB",
        NAMES.index(name),
        *(setting.robots, setting.count, setting.tasks, setting.robot_ids, setting.task_ids),
        *(setting.robot_classes, setting.task_classes, setting.colluding),
        *(setting.id_bits, setting.knows_count, setting.walled),
        *(*numbers, *[0.0] * (17 - len(numbers))),
        *(setting.columns, len(setting.plan)),
    )
    kept = RULE.rounds if declares else 0, STRATEGIES[name].memory
    return packed + setting.plan + struct.pack(f"<BBH{len(names)}I", *kept, len(names), *names)


class Episode:
    """A swarm, drawn at random, and what its robots see and hear."""

    def __init__(self, name, seed, steps, whole_numbers=False, fixed=None):
        self.draw = draw = random.Random(f"{name} {seed}")
        self.steps = steps
        self.whole_numbers = whole_numbers
        self.strategy = strategy = STRATEGIES[name]
        self.first_steps = (fixed or {}).get("first_steps", FIRST_STEPS)
        self.setting = setting = setting_of(strategy, draw, whole_numbers, fixed or {})
        self.declares = declares = not strategy.declares and draw.random() < 0.3
        things = range(setting.robot_ids + setting.task_ids)
        self.places = [self.place() for _ in things]
        self.names = names_of(name, setting, self.places[setting.robot_ids :])
        self.wire = wire_of(name, setting, self.names, declares)
        self.number = draw.randint(2, 4)
        self.stream = bytearray(setting_bytes(name, setting, declares, self.names))
        self.stream += struct.pack("<BI", self.number, steps)
        self.robots = [self._robot(k, RULE if declares else None) for k in range(self.number)]
        liar = Me(setting.robots - 1, 0, draw.getrandbits(32), 0, [0.0] * strategy.memory, setting)
        self.liar = Knowledge(strategy, liar)
        self.frames = []
        self.kinds = [
            draw.randrange(setting.robot_classes if thing < setting.robot_ids else setting.task_classes)
            for thing in things
        ]
        self.hashes = [draw.getrandbits(32) for _ in things]

    def _robot(self, number, rule):
        word, mark = self.draw.randrange(1, 2**32), self.draw.getrandbits(32)
        opinion, step = self.draw.getrandbits(1), self.draw.choice(self.first_steps)
        kind = self.draw.randrange(self.setting.robot_classes)
        self.stream += struct.pack("<BIIIB", kind, word, mark, step, opinion)
        draws = Draws(word, self.whole_numbers)
        return Controller(
            self.strategy,
            opinion,
            draws.duration,
            draws.choice,
            Settings(
                exploration=self.setting.exploration,
                gain=self.setting.dissemination,
                parameters=self.setting.parameters,
                declare=rule,
                me=(number, kind, mark),
                sets=[([1] * self.setting.robot_classes, [1] * self.setting.task_classes)],
                setting=self.setting,
                step=step,
            ),
        )

    def place(self):
        """Return a random place."""
        return self.draw.uniform(0, self.setting.width), self.draw.uniform(0, self.setting.height)

    def things(self):
        """Return some things in sight."""
        for _ in range(self.draw.choice([0, 0, 1, 2, 5])):
            is_robot = self.draw.random() < 0.5
            number = self.draw.randrange(self.setting.robots if is_robot else self.setting.tasks)
            mark = number + (0 if is_robot else self.setting.robot_ids)
            yield Thing(is_robot, number, self.kinds[mark], self.hashes[mark], *self.places[mark])

    def strange_frames(self):
        """Return frames of a robot that may lie, some of them damaged or forged."""
        draw = self.draw
        for _ in range(draw.choice([0, 0, 1])):
            self.liar.observe(self.things())
            self.liar.end_step(explores=bool(draw.getrandbits(1)))
            # What it knows may be old: the oldest age that a message holds is 4,095 steps.
            later = self.liar.me.step + draw.choice([0, 0, 0, 40, 4_095 - draw.randrange(20)])
            self.liar.me = self.liar.me._replace(step=later)
            words = self.liar.message()
            lies = self.strategy.lie is not None and self.setting.robot_ids > self.setting.robots
            if lies and draw.random() < 0.5:
                words = self.liar.lie(words, draw.getrandbits(1), [])
            said = Message(1, knowledge=words)
            try:
                frame = self.wire.encode(self.liar.me.id, said)
            except WireError:
                continue
            if draw.random() < 0.5:
                frame = forged(frame, self.wire.bits(self.liar.me.id, said), draw)
            elif draw.random() < 0.5:
                body = bytearray(frame[:-4])
                body[draw.randrange(len(body))] ^= 1 << draw.randrange(8)
                body = body[: draw.randrange(3, len(body) + 1)] if draw.random() < 0.3 else body
                frame = bytes(body) + (crc32(body) ^ draw.choice([0, 0, 1])).to_bytes(4, "big")
            yield frame

    def states(self):
        """Return what the robots in Python do; complete the stream for those in C."""
        out = bytearray()
        for _ in range(self.steps):
            said = [robot.message() for robot in self.robots]
            measured = [self._measured(*each) for each in enumerate(said)]
            frames = [
                self.wire.encode(number, message) if message else b"" for number, message in enumerate(said)
            ]
            self.frames += filter(None, frames)
            for robot in self.robots:
                self._perceive(robot, frames)
            for robot, frame, numbers in zip(self.robots, frames, measured, strict=True):
                robot.end_step()
                out += self._state(robot, frame, numbers)
        return bytes(out)

    def _measured(self, number, message):
        """Return the length of a message in bits, and a CRC of what a Byzantine robot would make of it."""
        if message is None:
            return 0, 0
        knowledge, has_liars = self.robots[number].knowledge, self.setting.robot_ids > self.setting.robots
        length = knowledge.bits(message.knowledge) if self._has("bits") else 0
        told = message.knowledge
        if self._has("lie") and has_liars:
            told = knowledge.lie(told, number & 1, [])
        return length, crc32(array("i", told).tobytes())

    def _has(self, extra):
        return has_extra(self.strategy.name, extra, self.whole_numbers)

    def _perceive(self, robot, frames):
        things = list(self.things())
        if not self.whole_numbers:
            place = self.place()
            robot.move_to(*place)
            self.stream += struct.pack("<dd", *place)
        robot.recognise(things)
        self.stream.append(len(things))
        for thing in things:
            self.stream += struct.pack("<BhBI", thing.is_robot, thing.id, thing.kind, thing.hash)
            if not self.whole_numbers:
                self.stream += struct.pack("<dd", thing.x, thing.y)
        own = self.robots.index(robot)
        heard = self.draw.getrandbits(self.number) & ~(1 << own)
        strange = list(self.strange_frames())
        self.stream += bytes([heard, len(strange)])
        for frame in strange:
            self.stream += struct.pack("<H", len(frame)) + frame
        for frame in [frames[k] for k in range(self.number) if heard >> k & 1] + strange:
            if frame and robot.listens:
                with suppress(WireError):
                    robot.hear(*self.wire.decode(frame))

    def _state(self, robot, frame, measured):
        knowledge = robot.knowledge
        known = crc32(array("i", knowledge.words).tobytes())
        memory = crc32(array("d", knowledge.me.memory).tobytes())
        flags = int(robot.disseminating)
        return STATE.pack(
            robot.opinion + 1,
            robot.declared + 1,
            flags,
            robot.phase_left,
            len(frame),
            crc32(frame),
            known,
            memory,
            0 if self.whole_numbers else int(robot.feasible_quality * 4096),
            *measured,
        )


def assert_same(command, name, robot_steps, whole_numbers=False, length=50, fixed=None):
    """Compare what swarms in C and in Python do, robot by robot and step by step."""
    done = seed = 0
    while done < robot_steps:
        episode = Episode(name, seed, length, whole_numbers, fixed)
        expected = episode.states()
        ran = subprocess.run(command, input=bytes(episode.stream), capture_output=True, check=False)
        assert ran.returncode == 0, (name, seed, ran.returncode, ran.stderr.decode()[-3000:])
        done += episode.number * length
        seed += 1
        assert_equal(ran.stdout, expected, STATE, (name, seed - 1, episode.number))

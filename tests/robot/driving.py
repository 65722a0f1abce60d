"""Drive a controller in Python and in C by the same random stream, and compile the latter."""

from __future__ import annotations

import dataclasses
import hashlib
import importlib.util
import math
import random
import shutil
import struct
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import pytest

from benchmarks.sizes import names_in_c
from feasibee.robot import Controller, Declare, Message, Settings
from feasibee.robot.firmware import header
from feasibee.strategies import STRATEGIES
from tests.once import made_once

HERE = Path(__file__).parent
NAMES = names_in_c(knowledge=False)
"""Strategies of drive.c."""
STRICT = [
    *("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wsign-conversion"),
    *("-Wshadow", "-Wcast-qual", "-Wundef", "-Werror"),
]
SANITIZED = ["-g", "-O0", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
INBOX = 64
SENDERS = 40
STATE = struct.Struct("<BBBHId")
"""Opinion + 1; bits: listens, broadcasts, disseminates, declared; message; value; phase left; last mean."""


def constant(strategy):
    """Return the name of a strategy in C."""
    return f"feasibee_{strategy.replace('-', '_')}"


def needs(tool, packages):
    """Skip a test if a tool is missing."""
    if shutil.which(tool) is None:
        pytest.skip(f"no {tool}; Debian has it in {packages}")


def run(command):
    """Run a command and return all that it printed; its errors are the test's."""
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=600, stdin=subprocess.DEVNULL, check=False
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout + done.stderr


def built(folder, code, text, *options, command=("cc", "-std=c99"), packages="gcc"):
    """Compile C code that includes the text of a header, without warnings, and return the program."""
    needs(command[0], packages)
    (folder / "feasibee.h").write_text(text)
    (folder / "program.c").write_text(code)
    run([*command, *STRICT, "-I", folder, folder / "program.c", "-o", folder / "program", *options, "-lm"])
    return folder / "program"


def zig():
    """Return the command that compiles C to WebAssembly; skip a test without it, or without Node."""
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip("needs the package ziglang from PyPI")
    needs("node", "nodejs")
    return [sys.executable, "-m", "ziglang", "cc", "-target", "wasm32-wasi", "-O2"]


def in_node(wasm):
    """Return the command that runs a program in WebAssembly."""
    return ["node", "--no-warnings", HERE / "wasi.mjs", wasm]


def compiled(folder, source, *options, command=None, name="program", text=None):
    """Return the program of a C file that includes feasibee.h; each is compiled once for all workers."""
    if command is None:
        needs("cc", "gcc")
    command = [*(command or ["cc"]), "-std=c99", *STRICT, *options]
    key = hashlib.sha256(repr((source, command, text)).encode()).hexdigest()[:16]

    def make(out):
        (out.parent / "feasibee.h").write_text(text or header())
        subprocess.run([*command, "-I", out.parent, HERE / source, "-o", out, "-lm"], check=True)

    return made_once(folder, f"{key}-{name}", make)


def program(folder, source, names, *options, without=(), **how):
    """Return a C file of this folder as a program with some strategies, NULL for those ``without``."""
    macros = [
        "-DSTRATEGIES=" + ", ".join("NULL" if name in without else f"&{constant(name)}" for name in names),
        "-DNAMES=" + ", ".join(f'"{name}"' for name in names),
    ]
    return compiled(folder, source, *options, *macros, **how)


@dataclasses.dataclass
class Episode:
    """Settings, drawn at random, and what one robot sees and hears."""

    strategy: str
    seed: int
    steps: int

    def __post_init__(self):
        draw = random.Random(f"{self.strategy} {self.seed}")
        pick = draw.choice
        values = STRATEGIES[self.strategy].value_bits > 0
        self.opinion = draw.getrandbits(1)
        self.stubborn = draw.random() < 0.1
        quorum = pick([(1, 2), (9, 10), (1, 1), (2, 3), (0, 1)])
        self.rule = (draw.randrange(1, 4), draw.randrange(5), *quorum) if draw.random() < 0.4 else None
        self.own = {
            "k": float(draw.randrange(1, 6)),
            "credence": pick([0.6, 0.9, 0.95, 0.9999]),
            "positive_feedback": float(draw.getrandbits(1)),
        }
        every_message = not values and draw.random() < 0.25
        first_sight = not STRATEGIES[self.strategy].starts_neutral and draw.random() < 0.4
        self.settings = Settings(
            exploration=pick([0.0, 1.0, 2.5, 10.0, 25.0]),
            gain=pick([0.0, 1.5, 10.0, 12.75, 60.0]),
            dissemination_floor=pick([0, 0, 3, 30]),
            quality_floor=pick([0, 0, 1, 7]),
            own_vote=draw.random() < 0.7,
            random_ties=draw.random() < 0.5,
            first_sight=first_sight,
            listens_for=pick([None, None, 0, 3, 10]),
            every_message=every_message,
            inbox_size=None if every_message else pick([None, None, 1, 2, 5]),
            parameters=[self.own[name] for name in STRATEGIES[self.strategy].parameters],
            declare=self.rule and Declare(Fraction(*self.rule[2:]), *self.rule[:2]),
        )
        self.word = draw.randrange(1, 2**32)
        feasible, most = pick([0.0, 0.2, 0.5, 0.9, 1.0]), pick([0, 2, 6])
        self.sights = [(draw.randrange(4), draw.randrange(pick([1, 4]))) for _ in range(self.steps)]
        self.messages = [
            [
                (draw.randrange(SENDERS), int(draw.random() < feasible), self._value(draw))
                for _ in range(draw.randrange(most + 1))
            ]
            for _ in range(self.steps)
        ]

    @staticmethod
    def _value(draw):
        """Return a value; often one whose quality robots hold, too."""
        return draw.choice([0, 65_535, 21_845, 43_690, 13_107, 32_768, draw.getrandbits(16)])

    def stream(self):
        """Return what drive.c reads."""
        settings, rule = self.settings, self.rule or (0, 3, 9, 10)
        parameters = settings.parameters
        numbers = [settings.exploration, settings.gain, settings.dissemination_floor, settings.quality_floor]
        listens_for = 0 if settings.listens_for is None else settings.listens_for + 1
        votes = settings.own_vote, settings.random_ties
        flags = *votes, settings.first_sight, settings.every_message, self.stubborn
        parts = [
            struct.pack("<IBB", self.steps, NAMES.index(self.strategy), self.opinion),
            struct.pack("<ddHHHH", *numbers, listens_for, settings.inbox_size or INBOX),
            struct.pack("<BBBBBHHHH", *flags, *rule),
            struct.pack(f"<B{len(parameters)}d", len(parameters), *parameters),
            struct.pack("<I", self.word),
        ]
        for sight, messages in zip(self.sights, self.messages, strict=True):
            parts.append(struct.pack("<BBB", *sight, len(messages)))
            parts += [struct.pack("<BBH", *message) for message in messages]
        return b"".join(parts)

    def states(self, whole_numbers=False):
        """Return what the controller in Python does, as drive.c writes it."""
        draws = Draws(self.word, whole_numbers)
        robot = Controller(
            dc_in_single_precision()
            if whole_numbers and self.strategy == "dc"
            else STRATEGIES[self.strategy],
            self.opinion,
            draws.duration,
            draws.choice,
            self.settings,
            stubborn=self.stubborn,
        )
        return [state(robot, draws, *each) for each in zip(self.sights, self.messages, strict=True)]


def mutated(frame, rng):
    """Return a frame that is damaged in one of several ways."""
    kind, place = rng.randrange(6), rng.randrange(len(frame))
    if kind == 0:  # one flipped bit
        return frame[:place] + bytes([frame[place] ^ 1 << rng.randrange(8)]) + frame[place + 1 :]
    if kind == 1:
        return frame[:place]
    if kind == 2:
        return frame[:place] + rng.randbytes(rng.randint(1, 8)) + frame[place:]
    if kind == 3:
        return frame[:place] + frame[place + 1 :]
    if kind == 4:
        return rng.randbytes(rng.randrange(2 * len(frame)))
    noise = rng.randbytes(rng.randint(1, len(frame) - place))
    return frame[:place] + noise + frame[place + len(noise) :]


class Draws:
    """The random draws of the programs in C: xorshift with 32 bits (Marsaglia 2003)."""

    def __init__(self, word, whole_numbers=False):
        self.last = word
        self.whole_numbers = whole_numbers
        self.mean = 0.0

    def word(self):
        """Return the next 32 bits."""
        word = self.last
        word ^= word << 13 & 0xFFFFFFFF
        word ^= word >> 17
        self.last = word ^ word << 5 & 0xFFFFFFFF
        return self.last

    def duration(self, mean):
        self.mean = mean
        word = self.word()
        if self.whole_numbers:
            return 1 + word % 16
        return min(max(1, math.ceil(-mean * math.log((word + 1) / 2**32))), 2**30)

    def choice(self):
        chance = self.word() / 2**32
        return chance, self.word() / 2**32


def state(robot, draws, sight, messages):
    """Return the state after a step."""
    listens = robot.listens
    robot.observe(*sight)
    if listens:
        for sender, opinion, value in messages:
            robot.hear(sender, Message(opinion, value, bool(value & 1)))
    said = robot.message()
    robot.end_step()
    flags = listens + 2 * (said is not None) + 4 * robot.disseminating + 8 * (robot.declared != -1)
    told, value = (said.opinion + 2 * said.declared, said.value) if said else (0, 0)
    return STATE.pack(robot.opinion + 1, flags, told, value, robot.phase_left, draws.mean)


def dc_in_single_precision():
    """Return dc as C computes it in whole numbers: it compares floats of 32 bits; values are exact."""

    def decide(mind, inbox):
        own, heard = single(mind.feasible_quality), single(inbox.heard_value)
        if inbox.heard_opinion == 0:
            heard = single(1.0 - heard)
        if mind.opinion == 0:
            own = single(1.0 - own)
        return inbox.heard_opinion if inbox.heard_opinion >= 0 and heard > own else mind.opinion

    def value(mind):
        exact = Fraction(mind.feasible_quality).limit_denominator(10**6)
        return math.floor(exact * 65_535 + Fraction(1, 2)) / 65_535

    return dataclasses.replace(STRATEGIES["dc"], decide=decide, value=value)


def single(number):
    """Return a number rounded to 32 bits."""
    return struct.unpack("f", struct.pack("f", number))[0]


def answers(command, stream):
    """Return what a program writes, given a stream."""
    return subprocess.run(command, input=stream, capture_output=True, check=True).stdout


def assert_same(command, strategy, steps, whole_numbers=False):
    """Compare what a program and the controller in Python do in random episodes, step by step."""
    for seed in range(0, steps // 500, 20):
        episodes = [Episode(strategy, each, 500) for each in range(seed, min(seed + 20, steps // 500))]
        got = answers(command, b"".join(episode.stream() for episode in episodes))
        expected = [state for episode in episodes for state in episode.states(whole_numbers)]
        assert_equal(got, b"".join(expected), STATE, (strategy, seed))


def assert_equal(got, expected, state, where):
    """Fail at the first state that differs."""
    for place in range(0, max(len(got), len(expected)) * (got != expected), state.size):
        theirs, own = (each[place : place + state.size] for each in (got, expected))
        assert theirs == own, (where, place // state.size, [*state.iter_unpack(own)], theirs)

"""The decisions of the ARGoS example, compiled without ARGoS: those of the Python controller."""

from __future__ import annotations

import ctypes
import math
import random
import re
import shutil
import subprocess
from fractions import Fraction
from pathlib import Path

import pytest

from feasibee.robot import Controller, Declare, Message, Settings
from feasibee.robot.firmware import header
from feasibee.robot.wire import Wire
from feasibee.strategies import STRATEGIES

EXAMPLE = Path(__file__).parents[2] / "examples" / "argos"
STRICT = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]
NAMES = [name for name, strategy in STRATEGIES.items() if not strategy.knowledge]
ME = 300
UNIFORM = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_void_p)
WORD = 2**32


TYPES = {
    "const char *": ctypes.c_char_p,
    "double ": ctypes.c_double,
    "int ": ctypes.c_int,
    "bool ": ctypes.c_bool,
}
(FIELDS,) = re.findall(r"struct mind_settings \{(.*?)\n\};", (EXAMPLE / "mind.h").read_text(), re.DOTALL)


class MindSettings(ctypes.Structure):
    """The struct mind_settings of mind.h."""

    _fields_ = [(name, TYPES[kind]) for kind, name in re.findall(r"\n    (.*?)(\w+);", FIELDS)]


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """Return mind.c as a library, compiled with the header."""
    if shutil.which("cc") is None:
        pytest.skip("needs a C compiler: Debian's package gcc")
    folder = tmp_path_factory.mktemp("mind")
    (folder / "feasibee.h").write_text(header())
    out = folder / "mind.so"
    options = [*STRICT, "-O1", "-fPIC", "-shared", "-I", folder]
    subprocess.run(["cc", *options, EXAMPLE / "mind.c", "-o", out, "-lm"], check=True)
    loaded = ctypes.CDLL(str(out))
    loaded.mind_new.restype = ctypes.c_void_p
    loaded.mind_new.argtypes = [ctypes.POINTER(MindSettings), ctypes.c_uint16, UNIFORM, ctypes.c_void_p]
    for name, *arguments in (
        ("free",),
        ("see", ctypes.c_int, ctypes.c_int),
        ("hear", ctypes.c_char_p, ctypes.c_size_t),
        ("say", ctypes.c_char_p),
        ("end_step",),
        ("opinion",),
        ("declared",),
    ):
        getattr(loaded, f"mind_{name}").argtypes = [ctypes.c_void_p, *arguments]
    loaded.mind_hear.restype = loaded.mind_declared.restype = ctypes.c_bool
    loaded.mind_say.restype = ctypes.c_size_t
    return loaded


class Words:
    """Draws for one robot, each one word of 32 bits."""

    def __init__(self, seed):
        self._random = random.Random(seed)

    def fraction(self):
        return self._random.getrandbits(32) / WORD

    def duration(self, mean):
        return max(1, math.ceil(-mean * math.log(1.0 - self.fraction())))


def settings_of(strategy, **changed):
    parameters = dict(STRATEGIES[strategy].parameters)
    if "k" in parameters:
        parameters["k"] = int(parameters["k"])
    if "positive_feedback" in parameters:
        parameters["positive_feedback"] = bool(parameters["positive_feedback"])
    usual = {
        "exploration": 10,
        "gain": 10,
        "id_bits": 9,
        "listens_for": -1,
        "inbox_size": 1024,
        "own_vote": True,
    }
    return MindSettings(strategy=strategy.encode(), **{**usual, **parameters, **changed})


def packed(wire, sender, message):
    frame = wire.encode(sender, message)
    return (bytes([len(frame)]) + frame).ljust(15, b"\0")


@pytest.mark.parametrize("strategy", NAMES)
def test_it_decides_and_says_what_the_python_controller_does(library, strategy):
    in_c, in_python = Words(1), Words(1)
    draw = UNIFORM(lambda context: in_c.fraction())
    settings = settings_of(
        strategy,
        inbox_size=9,
        first_sight=True,
        declare_rounds=3,
        declare_heard=2,
        declare_quorum=0.9,
    )
    mind = library.mind_new(ctypes.byref(settings), ME, draw, None)
    robot = Controller(
        STRATEGIES[strategy],
        int(in_python.fraction() >= 0.5),
        in_python.duration,
        lambda: (in_python.fraction(), in_python.fraction()),
        Settings(inbox_size=9, first_sight=True, declare=Declare(Fraction(9, 10), 3, 2)),
    )
    wire = Wire(STRATEGIES[strategy], 9, declares=True)
    world, said, opinions = random.Random(2), ctypes.create_string_buffer(15), set()
    for _ in range(3000):
        message = robot.message()
        length = library.mind_say(mind, said)
        assert (length, said.raw) == ((0, bytes(15)) if message is None else (15, packed(wire, ME, message)))
        seen = world.randrange(4), world.randrange(4)
        robot.observe(*seen)
        library.mind_see(mind, *seen)
        for _ in range(world.randrange(3)):
            sender = world.randrange(40)
            value = world.randrange(2**16) if STRATEGIES[strategy].value_bits else 0
            heard = Message(world.randrange(2), value)
            if robot.listens:
                robot.hear(sender, heard)
            assert library.mind_hear(mind, packed(wire, sender, heard), 15)
        robot.end_step()
        library.mind_end_step(mind)
        assert (library.mind_opinion(mind), library.mind_declared(mind)) == (
            robot.opinion,
            robot.declared != -1,
        )
        opinions.add(robot.opinion)
    library.mind_free(mind)
    assert len(opinions) > 1


def test_what_is_no_message_is_not_heard(library):
    settings = settings_of("dmmd")
    mind = library.mind_new(ctypes.byref(settings), ME, UNIFORM(lambda context: 0.5), None)
    good = packed(Wire(STRATEGIES["dmmd"], 9), 7, Message(1))
    assert library.mind_hear(mind, good, 15)
    assert not library.mind_hear(mind, good, 14)
    assert not library.mind_hear(mind, bytes(15), 15)
    assert not library.mind_hear(mind, b"\xff" + good[1:], 15)
    assert not library.mind_hear(mind, good[:4] + bytes([good[4] ^ 1]) + good[5:], 15)
    library.mind_free(mind)


def test_an_unknown_strategy_is_none(library):
    settings = settings_of("dmmd")
    settings.strategy = b"census"
    assert library.mind_new(ctypes.byref(settings), ME, UNIFORM(lambda context: 0.5), None) is None

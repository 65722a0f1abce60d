"""The decisions of the ARGoS example, compiled without ARGoS: those of the Python controller."""

from __future__ import annotations

import math
import random
import re
import shutil
import subprocess
from fractions import Fraction
from pathlib import Path

import pytest
from cffi import FFI

from feasibee.robot import Controller, Declare, Message, Settings
from feasibee.robot.firmware import header
from feasibee.robot.wire import Wire
from feasibee.strategies import STRATEGIES

EXAMPLE = Path(__file__).parents[2] / "examples" / "argos"
STRICT = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]
NAMES = [name for name, strategy in STRATEGIES.items() if not strategy.knowledge]
ME = 300
USUAL = {"exploration": 10, "gain": 10, "id_bits": 9, "listens_for": -1, "inbox_size": 1024, "own_vote": True}


@pytest.fixture(scope="module")
def mind(tmp_path_factory):
    """Return mind.c, compiled with the header, as a function that begins a robot's mind."""
    if shutil.which("cc") is None:
        pytest.skip("needs a C compiler: Debian's package gcc")
    folder, ffi = tmp_path_factory.mktemp("mind"), FFI()
    (folder / "feasibee.h").write_text(header())
    options = [*STRICT, "-O1", "-fPIC", "-shared", "-I", folder]
    out = folder / "mind.so"
    subprocess.run(["cc", *options, EXAMPLE / "mind.c", "-o", out, "-lm"], check=True)
    declared = re.sub(r'#.*|extern "C" \{|(?<=\n)\}\n', "", (EXAMPLE / "mind.h").read_text())
    ffi.cdef(declared)
    loaded, kept = ffi.dlopen(str(out)), []

    def begin(strategy, draw, **settings):
        name, uniform = ffi.new("char[]", strategy), ffi.callback("double(void *)", lambda context: draw())
        given = ffi.new("struct mind_settings *", {"strategy": name, **USUAL, **settings})
        kept.extend((name, uniform, given))
        return loaded, loaded.mind_new(given, ME, uniform, ffi.NULL), ffi.new("uint8_t[15]")

    return begin


class Words:
    """Draws for one robot, each one word of 32 bits."""

    def __init__(self, seed):
        self._random = random.Random(seed)

    def fraction(self):
        return self._random.getrandbits(32) / 2**32

    def duration(self, mean):
        return max(1, math.ceil(-mean * math.log(1.0 - self.fraction())))


def packed(wire, sender, message):
    frame = wire.encode(sender, message)
    return (bytes([len(frame)]) + frame).ljust(15, b"\0")


@pytest.mark.parametrize("name", NAMES)
def test_it_decides_and_says_what_the_python_controller_does(mind, name):
    strategy, in_c, in_python, declaring = (
        STRATEGIES[name],
        Words(1),
        Words(1),
        Declare(Fraction(9, 10), 3, 2),
    )
    parameters = {
        key: int(value) if key != "credence" else value for key, value in strategy.parameters.items()
    }
    settings = {"declare_rounds": 3, "declare_heard": 2, "declare_quorum": 0.9, **parameters}
    c, one, said = mind(name.encode(), in_c.fraction, inbox_size=9, first_sight=True, **settings)
    robot = Controller(
        strategy,
        int(in_python.fraction() >= 0.5),
        in_python.duration,
        lambda: (in_python.fraction(), in_python.fraction()),
        Settings(inbox_size=9, first_sight=True, declare=declaring),
    )
    wire, world, opinions = Wire(strategy, 9, declares=True), random.Random(2), set()
    for _ in range(3000):
        message = robot.message()
        length = c.mind_say(one, said)
        assert (length, bytes(said)) == (
            (0, bytes(15)) if message is None else (15, packed(wire, ME, message))
        )
        seen = world.randrange(4), world.randrange(4)
        robot.observe(*seen)
        c.mind_see(one, *seen)
        for _ in range(world.randrange(3)):
            sender = world.randrange(40)
            value = world.randrange(2**16) if strategy.value_bits else 0
            heard = Message(world.randrange(2), value)
            if robot.listens:
                robot.hear(sender, heard)
            assert c.mind_hear(one, packed(wire, sender, heard), 15)
        robot.end_step()
        c.mind_end_step(one)
        assert (c.mind_opinion(one), c.mind_declared(one)) == (robot.opinion, robot.declared != -1)
        opinions.add(robot.opinion)
    c.mind_free(one)
    assert len(opinions) > 1


def test_what_is_no_message_is_not_heard_and_an_unknown_strategy_is_none(mind):
    c, one, _ = mind(b"dmmd", lambda: 0.5)
    good = packed(Wire(STRATEGIES["dmmd"], 9), 7, Message(1))
    assert c.mind_hear(one, good, 15)
    assert not c.mind_hear(one, good, 14)
    for wrong in (bytes(15), b"\xff" + good[1:], good[:4] + bytes([good[4] ^ 1]) + good[5:]):
        assert not c.mind_hear(one, wrong, 15)
    c.mind_free(one)
    assert not mind(b"census", lambda: 0.5)[1]

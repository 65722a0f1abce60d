"""Frames in C: what Python wrote is read, and written again bit for bit; damage is rejected as in Python."""

from __future__ import annotations

import random
import struct
import subprocess
from array import array
from zlib import crc32

import pytest

from feasibee.robot import Message, Wire, WireError
from feasibee.robot.firmware import header
from feasibee.scenario.setting import setting_from
from feasibee.strategies import STRATEGIES
from tests.robot.driving import SANITIZED, built, mutated, program
from tests.robot.swarms import IN_DOUBLE, NAMES, Episode, setting_bytes

WORDS = 8192
"""FEASIBEE_MESSAGE_WORDS of stream.h."""
RADIO = """
#include "feasibee.h"

size_t put(const struct feasibee_wire *wire, struct feasibee_robot *robot, uint8_t *frame, size_t room)
{
    struct feasibee_message message;
    return feasibee_message(robot, &message) ? feasibee_encode(wire, robot->me.id, &message, frame, room) : 0;
}

void get(const struct feasibee_wire *wire, struct feasibee_robot *robot, const uint8_t *frame, size_t length)
{
    struct feasibee_message message;
    feasibee_id sender;
    if (feasibee_decode(wire, frame, length, &sender, &message) && feasibee_listens(robot))
        feasibee_hear(robot, sender, &message);
}
"""
"""A robot's radio, for a compiler."""


@pytest.fixture(scope="module")
def frames(tmp_path_factory):
    return program(tmp_path_factory.mktemp("frames"), "frames.c", NAMES, *IN_DOUBLE, *SANITIZED)


def opinions(name, draw):
    """Return a wire of opinions, its setting, whether robots declare, frames, and names of tasks."""
    id_bits, declares = draw.randint(1, 16), draw.random() < 0.5
    setting = setting_from((2, 2), (0, 0), False, id_bits, ())
    wire = Wire(STRATEGIES[name], id_bits, declares=declares)
    value_bits = STRATEGIES[name].value_bits
    said = [
        wire.encode(
            draw.getrandbits(id_bits),
            Message(draw.getrandbits(1), draw.getrandbits(value_bits), declares and draw.random() < 0.5),
        )
        for _ in range(50)
    ]
    return wire, setting, declares, said, []


def knowledge(name, seed):
    """Return the same of a strategy with knowledge."""
    episode = Episode(name, seed, 40)
    episode.states()
    return episode.wire, episode.setting, episode.declares, episode.frames or [b"\x01"], episode.names


def damaged(frame, draw):
    """Return a damaged frame; most have a checksum that fits."""
    body = mutated(draw.choice([frame, frame[:-4] or frame]), draw)
    return body if draw.random() < 0.3 else body + crc32(body).to_bytes(4, "big")


def answer(wire, frame):
    """Return what frames.c writes of a frame."""
    try:
        sender, message = wire.decode(frame)
    except WireError:
        return b"\0"
    words = array("i", message.knowledge + (0,) * (WORDS - len(message.knowledge))).tobytes()
    heard = (1, message.opinion + 1, message.declared, sender == -1, sender % 2**16, message.value)
    return struct.pack("<BBBBHHII", *heard, crc32(words), 1)


def assert_same(program, name, packets, most=2_000):
    """Compare what C and Python make of frames, whole and damaged."""
    for seed in range(-(-packets // most)):
        draw = random.Random(f"{name} {seed}")
        has_knowledge = STRATEGIES[name].knowledge
        found = knowledge(name, seed) if has_knowledge else opinions(name, draw)
        wire, setting, declares, said, names = found
        sent = [*said[:100], *(damaged(draw.choice(said), draw) for _ in range(min(packets, most)))]
        stream = setting_bytes(name, setting, declares, names) + struct.pack("<I", len(sent))
        stream += b"".join(struct.pack("<H", len(frame)) + frame for frame in sent)
        ran = subprocess.run([program], input=stream, capture_output=True, check=False)
        assert ran.returncode == 0, (name, seed, ran.stderr.decode()[-3000:])
        place = 0
        for frame in sent:
            expected = answer(wire, frame)
            assert ran.stdout[place : place + len(expected)] == expected, (name, seed, frame.hex())
            place += len(expected)
        assert place == len(ran.stdout)


@pytest.mark.quick(3)
@pytest.mark.parametrize("packets", [1_000, pytest.param(4_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", NAMES)
def test_frames_in_c_are_those_of_python(name, packets, frames):
    assert_same(frames, name, packets)


@pytest.mark.parametrize(
    "flags", [(), ("-DFEASIBEE_WORDS=40",), ("-DFEASIBEE_WORDS=40", "-DFEASIBEE_DOUBLE")]
)
@pytest.mark.parametrize(
    ("command", "package"),
    [
        (["avr-gcc", "-mmcu=atmega328p"], "gcc-avr and avr-libc"),
        (
            ["arm-none-eabi-gcc", "-mcpu=cortex-m0", "-mthumb"],
            "gcc-arm-none-eabi and libnewlib-arm-none-eabi",
        ),
    ],
)
def test_frames_compile_for_small_processors_without_warnings(command, package, flags, tmp_path):
    built(tmp_path, RADIO, header(), "-Os", *flags, "-c", command=[*command, "-std=c99"], packages=package)

"""Sketch: a census whose messages never grow, since it estimates how many names there are.

A robot keeps a HyperLogLog sketch of all robots and one of all tasks that it knows of: 128 registers of 4
bits. The hash of a name chooses a register, which keeps the largest rank seen: one more than the zeros at
the end of the rest of the hash, at most 15. The union of two sketches is the larger of each register. A
message has 1,024 bits, for any number of robots and tasks; the error is about 9 % of a large number, less
of a small one.

References
----------
Flajolet, Fusy, Gandouet, Meunier, "HyperLogLog", 2007.
"""

import math

BY_NAME = True
NEEDS_IDS = True
NEEDS_NAMES = True
ONE_CLASS = True
REGISTERS = 128
TOP = 15
SCALE = 1024
"""Estimates are counted in 1/1024."""


def words(setting):
    """Return the length of what is known: a register each."""
    return 2 * REGISTERS


def add(known, first, mark):
    """Add a hash to the sketch whose registers begin there."""
    rank, rest = 1, mark // REGISTERS
    while rank < TOP and rest % 2 == 0:
        rank += 1
        rest //= 2
    register = first + mark % REGISTERS
    known[register] = max(known[register], rank)


def start(known, me):
    """Add the robot itself."""
    add(known, 0, me.hash)


def observe(known, thing, me):
    """Add a robot or task in sight."""
    add(known, 0 if thing.is_robot else REGISTERS, thing.hash)


def merge(known, message, sender, me):
    """Unite the sketches."""
    for k in range(len(known)):
        known[k] = max(known[k], message[k])


def size_of(known, first):
    """Estimate how many names a sketch has seen: by its empty registers, if they are enough."""
    empty, sum_of_powers = 0, 0.0
    for k in range(first, first + REGISTERS):
        empty += 1 if known[k] == 0 else 0
        sum_of_powers += 1.0 / (1 << known[k])
    size = 0.7213 / (1.0 + 1.079 / REGISTERS) * REGISTERS * REGISTERS / sum_of_powers
    if size <= 2.5 * REGISTERS and empty > 0:
        return REGISTERS * math.log(REGISTERS / empty)
    return size


def count(known, counts, me):
    """Write the estimated numbers of robots and tasks."""
    counts[0] = int(size_of(known, 0) * SCALE)
    counts[1] = int(size_of(known, REGISTERS) * SCALE)


def bits(message, me):
    """Return the length of both sketches: 4 bits a register."""
    return 4 * len(message)


def decide(mind, inbox):
    """Return feasible if there are as many robots as tasks, or more."""
    return 1 if mind.feasible_quality >= 0.5 else 0

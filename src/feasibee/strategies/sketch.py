"""Sketch: a census in messages of constant size.

Instead of a set, each robot keeps a HyperLogLog sketch of each class: 128 registers of 4 bits. The hash of a
robot's id, or of a task's position, chooses a register, which keeps the largest rank seen (one more than the
zeros at the end of the rest of the hash, at most 15). The union of two sketches is their maximum, register
by register. At the end of each dissemination the robot decides on the estimated sizes: feasible if robots
>= tasks, for every set of skills. The error is about 1.04 / sqrt(128) = 9 % of a large set, less of one
smaller than 128.

A Byzantine robot notes as many invented robots as there are tasks, or invented tasks, one more than robots. A
colluding one fills all registers of robots, or of tasks.

Message: 512 bits a class of robots or tasks, so 1,024 in all without classes. Memory: the same.

References
----------
Flajolet, Fusy, Gandouet, Meunier, "HyperLogLog", 2007; the estimate: Ertl, "New cardinality estimation
algorithms for HyperLogLog sketches", 2017, algorithm 6.
"""

import math

from feasibee.strategies.census import decide

BY_NAME = True
NEEDS_IDS = True
NEEDS_NAMES = True
REGISTERS = 128
TOP = 15
RANK_BITS = 4


def words(setting):
    """Return the number of registers: a sketch for each class of robots, and then of tasks."""
    return (setting.robot_classes + setting.task_classes) * REGISTERS


def add(known, column, mark):
    """Add a hash to the sketch of a class."""
    rest = mark // REGISTERS
    rank = 1
    while rank < TOP and rest % 2 == 0:
        rest //= 2
        rank += 1
    register = column * REGISTERS + mark % REGISTERS
    known[register] = max(known[register], rank)


def start(known, me):
    """Add the robot itself to what it knows."""
    add(known, me.kind, me.hash)


def observe(known, thing, me):
    """Add a robot or task in sight to what the robot knows."""
    column = thing.kind if thing.is_robot else me.setting.robot_classes + thing.kind
    if me.setting.colluding and thing.id >= (me.setting.robots if thing.is_robot else me.setting.tasks):
        # Invented: exactly as many as the lie needs would hide in the error of the estimate.
        for register in range(column * REGISTERS, (column + 1) * REGISTERS):
            known[register] = TOP
        return
    add(known, column, thing.hash)


def merge(known, message, sender, me):
    """Unite the sketches."""
    for k in range(len(known)):
        known[k] = max(known[k], message[k])


def count(known, counts, me):
    """Estimate the sizes, in units of 2**-16, by Ertl's algorithm 6."""
    for k in range(len(counts)):
        # How many registers have each rank, at 8 bits a rank: none has more than 128.
        low, middle, high = 0, 0, 0
        for register in range(k * REGISTERS, (k + 1) * REGISTERS):
            rank = known[register]
            if rank < 7:
                low += 1 << (8 * rank)
            elif rank < 14:
                middle += 1 << (8 * (rank - 7))
            else:
                high += 1 << (8 * (rank - 14))
        unused, full = low & 255, high >> 8
        if REGISTERS in (unused, full):  # nothing was seen, or more than a sketch can count
            counts[k] = REGISTERS * 2**TOP * 65536 if full else 0
            continue
        # tau(x) = (1 - x - the sum of 2**-k (1 - x**(2**-k))**2 over k >= 1) / 3
        x = 1.0 - full / REGISTERS
        tau, weight, last = 0.0, 1.0, -1.0
        if 0.0 < x < 1.0:
            tau = 1.0 - x
            while tau != last:
                last = tau
                x = math.sqrt(x)
                weight *= 0.5
                tau -= (1.0 - x) * (1.0 - x) * weight
        z = REGISTERS * (tau / 3.0)
        for rank in range(TOP - 1, 0, -1):
            ranks = low if rank < 7 else middle if rank < 14 else high
            z = 0.5 * (z + (ranks >> (8 * (rank % 7)) & 255))
        # sigma(x) = x + the sum of 2**(k - 1) x**(2**k) over k >= 1
        x = unused / REGISTERS
        sigma, weight, last = x, 1.0, -1.0
        while sigma != last:
            last = sigma
            x *= x
            sigma += x * weight
            weight += weight
        z += REGISTERS * sigma
        counts[k] = int(0.7213475204444817 * REGISTERS * REGISTERS / z * 65536)  # 1 / (2 log 2)


def describe(known, me):
    """Return the estimated sizes in words."""
    counts = [0] * (me.setting.robot_classes + me.setting.task_classes)
    count(known, counts, me)
    robots = sum(counts[: me.setting.robot_classes]) / 65536
    return f"about {robots:.1f} robots and {sum(counts) / 65536 - robots:.1f} tasks, estimated"


def bits(message, me):
    """Return the length of all sketches: 4 bits a register."""
    return len(message) * RANK_BITS


def layout(wire, message, sender, setting):
    """Go through all registers."""
    for register in range(len(message)):
        message[register] = wire.number(message[register], RANK_BITS)
    return -1

"""Sketch: a census in messages of constant size.

Instead of a set, each robot keeps a HyperLogLog sketch of each class: 128 registers of 4 bits. The hash of a
robot's id, or of a task's position, chooses a register, which keeps the largest rank seen (one more than the
zeros at the end of the rest of the hash, at most 15). The union of two sketches is their maximum, register
by register. At the end of each dissemination the robot decides on the estimated sizes: feasible if robots
>= tasks, for every set of skills. The error is about 1.04 / sqrt(128) = 9 % of a large set, less of one
smaller than 128.

Message: 512 bits a class of robots or tasks, so 1,024 in all without classes. Memory: the same.

References
----------
Flajolet, Fusy, Gandouet, Meunier, "HyperLogLog", 2007; the estimate: Ertl, "New cardinality estimation
algorithms for HyperLogLog sketches", 2017, algorithm 6.
"""

import math

from feasibee.strategies import census

REGISTERS = 128
TOP = 15


quality = census.quality
dissemination = census.dissemination
decide = census.decide


class Knowledge:
    """A sketch of each class of robots, and then of tasks.

    Parameters
    ----------
    me : tuple of int
        Own id, class, and 32-bit mark.
    classes : tuple of int
        How many classes of robots and of tasks there are.
    """

    def __init__(self, me, classes):
        self.classes = classes
        self.registers = [[0] * REGISTERS for _ in range(sum(classes))]
        self.see_robot(*me)

    def see_robot(self, robot, kind, mark):
        """Note a robot in sight; ``mark`` is a hash of its id, 32 random bits."""
        _note(self.registers[kind], mark)

    def see_task(self, task, kind, mark):
        """Note a task in sight; ``mark`` is a hash of its position."""
        _note(self.registers[self.classes[0] + kind], mark)

    def message(self):
        """Return what to broadcast."""
        return [list(each) for each in self.registers]

    def lie(self, feasible, phantoms):
        """Return what a liar broadcasts: robots, or tasks, that there aren't, as well."""
        message = self.message()
        for _, mark in phantoms:
            _note(message[0 if feasible else self.classes[0]], mark)
        return message

    def merge(self, message):
        """Take in what was heard."""
        for known, heard in zip(self.registers, message, strict=True):
            known[:] = map(max, known, heard)

    def counted(self):
        """Return estimates of how many robots and tasks are known, by class, in units of 2**-16."""
        sizes = [int(estimate(each) * 65536) for each in self.registers]
        return sizes[: self.classes[0]], sizes[self.classes[0] :]

    def bits(self, message, id_bits):
        """Return the length of a message."""
        return len(message) * REGISTERS * 4


def estimate(registers):
    """Return the estimated number of different things that were noted."""
    counts = [registers.count(rank) for rank in range(TOP + 1)]
    if counts[0] == REGISTERS:
        return 0.0
    if counts[TOP] == REGISTERS:  # it can't tell more things from this
        return float(REGISTERS * 2**TOP)
    z = REGISTERS * _tau(1.0 - counts[TOP] / REGISTERS)
    for rank in range(TOP - 1, 0, -1):
        z = 0.5 * (z + counts[rank])
    z += REGISTERS * _sigma(counts[0] / REGISTERS)
    return 0.7213475204444817 * REGISTERS * REGISTERS / z  # 1 / (2 log 2)


def _note(registers, mark):
    place, rest = mark % REGISTERS, mark // REGISTERS
    rank = 1
    while rank < TOP and rest % 2 == 0:
        rest //= 2
        rank += 1
    registers[place] = max(registers[place], rank)


def _sigma(x):
    """Return x + the sum of 2**(k - 1) x**(2**k) over k >= 1."""
    y, z, last = 1.0, x, -1.0
    while z != last:
        last = z
        x *= x
        z += x * y
        y += y
    return z


def _tau(x):
    """Return (1 - x - the sum of 2**-k (1 - x**(2**-k))**2 over k >= 1) / 3."""
    if x in (0.0, 1.0):
        return 0.0
    y, z, last = 1.0, 1.0 - x, -1.0
    while z != last:
        last = z
        x = math.sqrt(x)
        y *= 0.5
        z -= (1.0 - x) * (1.0 - x) * y
    return z / 3.0

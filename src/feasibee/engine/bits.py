"""Bits by name: sets of robots in words of 32 bits, and labels.

Robot i is bit i % 32 of word i // 32 of a set. A label holds a robot's number or id, the opinion that it
sends, and whether it broadcasts.
"""

from __future__ import annotations

from numba import int32, int64, uint32, uint64

from feasibee.engine.compile import inlined
from feasibee.engine.intrinsics import lowest


@inlined
def bit(i):
    """Return the word in which only robot i's bit is set."""
    return uint32(uint32(1) << uint32(i & 31))


@inlined
def has_bit(word, i):
    """Return whether robot i's bit is set in its word."""
    return uint32(word >> uint32(i & 31)) & uint32(1) == uint32(1)


@inlined
def bit_if(member, i):
    """Return robot i's bit if it is a member, else the empty word."""
    return uint32(uint32(member) << uint32(i & 31))


@inlined
def without_lowest(word):
    """Return a word without its lowest set bit."""
    return uint32(word & uint32(word - uint32(1)))


@inlined
def first_bits(count):
    """Return the word of the first ``count`` robots of 32, or of all of them."""
    return uint32((uint64(1) << uint64(min(count, 32))) - uint64(1))


@inlined
def lowest_member(w, word):
    """Return the number of the first robot in word ``w`` of a set; the word isn't 0."""
    return int64(32 * w + lowest(word))


@inlined
def contains(words, i):
    """Return whether a set has robot i."""
    return has_bit(words[i >> 5], i)


@inlined
def set_member(sets, kind, i, member):
    """Put robot i in a set, or remove it."""
    if member:
        sets[kind, i >> 5] |= bit(i)
    else:
        sets[kind, i >> 5] &= ~bit(i)


@inlined
def pack_label(robot, feasible, speaks):
    """Return a label: the opinion sent is bit 1, whether it is sent bit 0, and the robot is above."""
    return int32(robot << 2) | int32(feasible) << int32(1) | int32(speaks)


@inlined
def number_of(label):
    """Return the number of a robot by its label."""
    return int64(label >> int32(2))


@inlined
def sender_of(message):
    """Return the robot, or id, in the label that a message has."""
    return int64(message >> int32(2))


@inlined
def says_feasible(label):
    """Return whether the opinion in a label is *feasible*, as 1 or 0."""
    return int64(label >> int32(1)) & 1


@inlined
def place_of(numbered):
    """Return the place of a robot in the arrays, by what stands for it in the cells."""
    return int64(numbered >> int32(1))

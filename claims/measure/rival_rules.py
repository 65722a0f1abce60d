"""Rules by which robots claim and choose tasks: ours, and those of other authors, each in few lines.

All pass on what they know of tasks, and drop a task that they know to be taken. They differ in what they say
of who shall do what.

References
----------
CBAA: Choi, Brunet, How, "Consensus-based decentralized auctions for robust task allocation", 2009. With one
task for each robot, bundles have length one, and CBBA is CBAA.
Auction: Koenig et al., "The power of sequential single-item auctions for agent coordination", 2006.
Threshold: Bonabeau, Theraulaz, Deneubourg, "Fixed response thresholds and the regulation of division of labor
in insect societies", 1998.
GRAPE: Jang, Shin, Tsourdos, "Anonymous hedonic game for task allocation in a large-scale multiple agent
system", 2018.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

TURN = 2**32
MASK = TURN - 1
FREE, TAKEN = 0, 1
NEAREST, RANK, CBAA, AUCTION, THRESHOLD, GRAPE = range(6)
RESPONSE, VERSION, PAIR = 201, 202, 256
"""Purposes of draws that the package doesn't have."""
THRESHOLD_STEPS = 20.0
"""Time for which a task that is at hand is known until half of the robots go to it in a step."""
PATIENCE = 20
"""Steps after which a robot whose task isn't there by rank goes to the nearest (model.md 6.25.9)."""
NOBODY = 2**40
UNITS = 20.0 / TURN
"""For `THRESHOLD`, the length of a unit of fixed point in units, in an arena of the paper's side."""


@njit
def philox(counter, robot, purpose, options):
    """Return the first two words of a draw (Salmon et al., SC 2011)."""
    mask = np.uint64(0xFFFFFFFF)
    a, b = np.uint64(counter), np.uint64(robot)
    c, d = np.uint64(options.run), np.uint64(purpose)
    low, high = np.uint64(options.low), np.uint64(options.high)
    for _ in range(10):
        left, right = a * np.uint64(0xD2511F53), c * np.uint64(0xCD9E8D57)
        a, b, c, d = (
            (right >> np.uint64(32)) ^ b ^ low,
            right & mask,
            (left >> np.uint64(32)) ^ d ^ high,
            left & mask,
        )
        low = (low + np.uint64(0x9E3779B9)) & mask
        high = (high + np.uint64(0xBB67AE85)) & mask
    return np.int64(a), np.int64(b)


@njit
def chance(counter, robot, purpose, options):
    """Return a random number from 0 to 1."""
    return philox(counter, robot, purpose, options)[0] / TURN


@njit
def way(a, b):
    """Return the difference of two places on the torus."""
    half = TURN // 2
    return ((b[0] - a[0] + half) & MASK) - half, ((b[1] - a[1] + half) & MASK) - half


@njit
def distance(a, b):
    """Return the distance of two places on the torus."""
    x, y = way(a, b)
    return math.sqrt(float(x) * x + float(y) * y)


@njit
def meet_task(robots, i, j, now):
    """Store when a robot first knew a task."""
    if robots.since[i, j] < 0:
        robots.since[i, j] = now


@njit
def choose(robots, tasks, i, now, options):
    """Let a robot choose its target by its rule."""
    if options.rule == NEAREST or (options.rule == RANK and now >= options.start + PATIENCE):
        robots.target[i] = nearest(robots, tasks, i, now, options)
    elif options.rule == RANK:
        robots.target[i] = of_rank(robots, i)
    elif options.rule == GRAPE:
        join(robots, tasks, i, now, options)
    else:
        keep(robots, i, options)
        if options.rule == CBAA and robots.target[i] < 0:
            claim(robots, tasks, i, now, options)
        elif options.rule == AUCTION and (now - options.start) % options.length == 0:
            bid(robots, tasks, i, now, options)
        elif options.rule == THRESHOLD and robots.target[i] < 0:
            respond(robots, tasks, i, now, options)


@njit
def nearest(robots, tasks, i, now, options):
    """Return the nearest task that a robot knows as free and may claim; -1 without."""
    best, least = -1, np.inf
    for j in range(tasks.shape[0]):
        if robots.state[i, j] == FREE:
            far = distance(robots.place[i], tasks[j])
            if far < least and may_claim(robots, i, j, far, now, options):
                best, least = j, far
    return best


@njit
def may_claim(robots, i, j, far, now, options):
    """Return whether the claims that a robot knows leave it a task at some distance."""
    if options.rule == CBAA:
        step = now + steps_for(far, options)
        return step < robots.bid[i, j] or (step == robots.bid[i, j] and i <= robots.by[i, j])
    if options.rule == AUCTION:  # a sale after which nobody came is no longer one
        return robots.bid[i, j] == NOBODY or now > options.start + (3 - robots.bid[i, j]) * options.length
    if options.rule == GRAPE:
        for k in range(robots.place.shape[0]):
            if k != i and robots.part[i, k] == j:
                return False
    return True


@njit
def steps_for(far, options):
    """Return the steps until a robot has arrived at some distance."""
    return max(1, math.ceil((far - options.reach) / options.speed))


@njit
def of_rank(robots, i):
    """Return the task after i others among those that robot i knows, if it is free; else -1."""
    before = 0
    for j in range(robots.state.shape[1]):
        if robots.state[i, j] >= FREE:
            if before == i:
                return j if robots.state[i, j] == FREE else -1
            before += 1
    return -1


@njit
def keep(robots, i, options):
    """Drop a target that is taken, or that another robot has by a better offer."""
    j = robots.target[i]
    if j >= 0 and (robots.state[i, j] == TAKEN or (options.rule != THRESHOLD and robots.by[i, j] != i)):
        robots.target[i] = -1


@njit
def claim(robots, tasks, i, now, options):
    """Offer the soonest arrival for a task (CBAA)."""
    j = nearest(robots, tasks, i, now, options)
    robots.target[i] = j
    if j >= 0:
        robots.bid[i, j] = now + steps_for(distance(robots.place[i], tasks[j]), options)
        robots.by[i, j] = i


@njit
def bid(robots, tasks, i, now, options):
    """End a round of the auction and begin the next: the least cost of all wins its task (Koenig)."""
    ended = (now - options.start) // options.length - 1
    if ended >= 0 and robots.lot[i, 0] == ended and robots.lot[i, 3] >= 0:
        winner, j = robots.lot[i, 2], robots.lot[i, 3]
        robots.bid[i, j], robots.by[i, j] = -ended, winner
        if winner == i and robots.state[i, j] == FREE:
            robots.target[i] = j
    j = nearest(robots, tasks, i, now, options) if robots.target[i] < 0 else -1
    robots.lot[i, 0], robots.lot[i, 1], robots.lot[i, 2], robots.lot[i, 3] = ended + 1, NOBODY, -1, -1
    if j >= 0:
        robots.lot[i, 1], robots.lot[i, 2] = int(distance(robots.place[i], tasks[j])), i
        robots.lot[i, 3] = j


@njit
def respond(robots, tasks, i, now, options):
    """Go to a known free task the more likely, the longer it was known and the nearer it is (Bonabeau)."""
    left = robots.state[i] == FREE
    while left.any():
        best, least = -1, np.inf
        for j in range(tasks.shape[0]):
            far = distance(robots.place[i], tasks[j])
            if left[j] and far < least:
                best, least = j, far
        left[best] = False
        stimulus = float(now - robots.since[i, best])
        far = least * UNITS
        if (
            chance(now, i, RESPONSE + PAIR * best, options) * (stimulus**2 + THRESHOLD_STEPS**2 + far**2)
            < stimulus**2
        ):
            robots.target[i] = best
            return


@njit
def join(robots, tasks, i, now, options):
    """Join the nearest free task that nobody else has in the partition (GRAPE)."""
    j = nearest(robots, tasks, i, now, options)
    if j != robots.part[i, i]:
        change(robots, i, j, options)
    robots.target[i] = j


@njit
def change(robots, i, j, options):
    """Change a robot's own task in the partition that it knows."""
    robots.part[i, i] = j
    robots.version[i, 0] += 1
    robots.version[i, 1] = chance(robots.version[i, 0], i, VERSION, options)


@njit
def hear_claims(robots, said, slot, i, k, options):
    """Merge what robot k says of who shall do what."""
    if options.rule in (CBAA, AUCTION):
        for j in range(robots.bid.shape[1]):
            told = said.bid[slot, k, j]
            better = told == robots.bid[i, j] and said.by[slot, k, j] < robots.by[i, j]
            if told < robots.bid[i, j] or better:
                robots.bid[i, j], robots.by[i, j] = told, said.by[slot, k, j]
    if options.rule == AUCTION and said.lot[slot, k, 0] == robots.lot[i, 0]:
        told, known = said.lot[slot, k, 1], robots.lot[i, 1]
        if told < known or (told == known and said.lot[slot, k, 2] < robots.lot[i, 2]):
            robots.lot[i] = said.lot[slot, k]
    if options.rule == GRAPE:
        told, known = said.version[slot, k], robots.version[i]
        if told[0] > known[0] or (told[0] == known[0] and told[1] > known[1]):
            robots.part[i], robots.version[i] = said.part[slot, k], said.version[slot, k]
            if robots.stands[i] and robots.part[i, i] != robots.task[i]:
                change(robots, i, robots.task[i], options)


@njit
def bits_of(robots, i, options):
    """Return the length of a robot's message: id, known tasks with place and status, claims."""
    count, name = robots.place.shape[0], 0
    while 2**name < count:
        name += 1
    bits = 1 + name
    for j in range(robots.state.shape[1]):
        if robots.state[i, j] >= FREE:
            bits += 34
            if options.rule in (CBAA, AUCTION):
                bits += 1 + (robots.bid[i, j] < NOBODY) * (name + (16 if options.rule == CBAA else 8))
    if options.rule == AUCTION:
        bits += 9 + (robots.lot[i, 3] >= 0) * (16 + name + 32)
    if options.rule == GRAPE:
        bits += 32
        for k in range(count):
            bits += 33 if robots.part[i, k] >= 0 else 1
    return bits

"""The worlds, walks, phases and radio of the package, in few lines, for rules that it doesn't have.

Positions, walks, phases and lost messages are drawn as the package draws them (model.md 1 to 3, 6.5, 6.25).
So a swarm of its own rules ends at the same steps. What a robot knows and says is in `Robots`. The rules by
which it claims and chooses tasks are in `claims.measure.rival_rules`.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from claims.measure.rival_rules import (
    TURN,
    bits_of,
    chance,
    choose,
    hear_claims,
    meet_task,
    philox,
    way,
)
from feasibee.model import purposes

UNKNOWN, FREE, TAKEN = -1, 0, 1
EXPLORATION = 10.0
MEAN_RUN = 10.0
WALK, PHASE, LOSS, PAIR = purposes.WALK, purposes.PHASE, purposes.LOSS, purposes.PAIR
LINK = 200
"""Purpose of the draws of links that turn bad or good, which the package doesn't have."""


class Options(NamedTuple):
    """What is the same for all robots of a swarm; lengths in units of fixed point."""

    rule: int
    start: int
    tags: bool
    tells: bool
    tolerates: int
    mind: bool
    """Whether all robots share at once what each sees: one mind."""
    length: int
    """Steps of a round of an auction."""
    delay: int
    loss: float
    burst: float
    """Mean length of a burst of losses in steps; 0 if each message is lost by itself."""
    speed: float
    reach: int
    sight: int
    radio: int
    low: int
    high: int
    run: int
    steps: int


class Robots(NamedTuple):
    """Arrays with a row for each robot."""

    place: Any
    step: Any
    left: Any
    """Steps left of its run, and of its phase."""
    drawn: Any
    """Numbers of runs and of phases that it has drawn."""
    speaks: Any
    honest: Any
    target: Any
    """Task that it goes to; -1 without."""
    task: Any
    """Task that it has taken or marked; -1 without."""
    stands: Any
    state: Any
    """What it knows of each task."""
    votes: Any
    """Who said that a task is taken, a bit for each robot, since it last saw the task."""
    bid: Any
    """Least step of arrival offered for each task, as it knows; in an auction, the round that sold it."""
    by: Any
    """Who offered it."""
    lot: Any
    """Best offer of the round that it knows: round, cost, robot, task."""
    part: Any
    """Task of each robot, as it believes."""
    version: Any
    """Number of changes of that partition, and a random number: the larger pair counts."""
    since: Any
    """Step at which it first knew each task."""


class Said(NamedTuple):
    """What robots said in the last steps."""

    speaks: Any
    state: Any
    bid: Any
    by: Any
    lot: Any
    part: Any
    version: Any


@njit
def duration(word, mean):
    """Return an exponential duration in whole steps."""
    return max(1, math.ceil(-mean * math.log((word + 1.0) / TURN)))


@njit
def turn(robots, i, options):
    """Draw a heading and how long it lasts."""
    heading, lasting = philox(robots.drawn[i, 0], i, WALK, options)
    robots.drawn[i, 0] += 1
    angle = heading * (2 * math.pi / TURN)
    robots.step[i, 0] = math.floor(options.speed * math.cos(angle) + 0.5)
    robots.step[i, 1] = math.floor(options.speed * math.sin(angle) + 0.5)
    robots.left[i, 0] = duration(lasting, MEAN_RUN)


@njit
def begin_phase(robots, i, options):
    """Draw how long the next phase lasts; both kinds last equally long on average."""
    robots.left[i, 1] = duration(philox(robots.drawn[i, 1], i, PHASE, options)[0], EXPLORATION)
    robots.drawn[i, 1] += 1


@njit
def is_near(a, b, reach):
    """Return whether two places are at most a distance apart."""
    x, y = way(a, b)
    return abs(x) <= reach and abs(y) <= reach and x * x + y * y <= reach * reach


@njit
def move(robots, tasks, i, options):
    """Move a robot towards its target, or along its run; return how far."""
    x, y = robots.step[i]
    if robots.target[i] >= 0:
        x, y = way(robots.place[i], tasks[robots.target[i]])
        far = math.sqrt(float(x) * x + float(y) * y)
        if far > 0:
            x, y = math.floor(options.speed * (x / far) + 0.5), math.floor(options.speed * (y / far) + 0.5)
    robots.place[i, 0] = (robots.place[i, 0] + x) % TURN
    robots.place[i, 1] = (robots.place[i, 1] + y) % TURN


@njit
def arrive(robots, tasks, holder, i, acts, options):
    """Let a robot take or mark its target if it has arrived; return whether it came in vain."""
    j = robots.target[i]
    if j < 0 or not is_near(robots.place[i], tasks[j], options.reach):
        return False
    robots.target[i] = -1
    robots.state[i, j] = TAKEN
    if holder[j] >= 0 and holder[j] != i:
        return True
    holder[j], robots.task[i] = i, j
    robots.stands[i] = acts
    return False


@njit
def say(robots, said, slot, options):
    """Fix what all robots say in a step; return the bits."""
    total = 0
    for i in range(robots.place.shape[0]):
        said.speaks[slot, i] = robots.speaks[i] and options.tells
        if said.speaks[slot, i]:
            said.state[slot, i] = robots.state[i]
            said.bid[slot, i], said.by[slot, i] = robots.bid[i], robots.by[i]
            said.lot[slot, i], said.part[slot, i] = robots.lot[i], robots.part[i]
            said.version[slot, i] = robots.version[i]
            total += bits_of(robots, i, options)
            if not robots.honest[i]:
                for j in range(robots.state.shape[1]):
                    said.state[slot, i, j] = UNKNOWN if robots.state[i, j] == UNKNOWN else TAKEN
    return total


@njit
def look(robots, tasks, holder, i, now, options):
    """Let a robot see the tasks in range, and whether they are taken."""
    for j in range(tasks.shape[0]):
        if is_near(robots.place[i], tasks[j], options.sight):
            robots.state[i, j] = TAKEN if holder[j] >= 0 else FREE
            robots.votes[i, j] = 0
            meet_task(robots, i, j, now)


@njit
def is_lost(i, k, now, bad, options):
    """Return whether a message is lost; in bursts, by Gilbert and Elliott, all of a bad link are."""
    if options.burst > 0:
        return bad[i, k]
    return options.loss > 0 and philox(now, i, LOSS + PAIR * k, options)[0] < options.loss * TURN


@njit
def change_links(bad, now, options):
    """Let links turn bad, for ``burst`` steps on average and a share ``loss`` of the time, and good."""
    for i in range(bad.shape[0]):
        for k in range(bad.shape[0]):
            ends = 1 / options.burst
            likely = ends if bad[i, k] else ends * options.loss / (1 - options.loss)
            if chance(now, i, LINK + PAIR * k, options) < likely:
                bad[i, k] = not bad[i, k]


@njit
def hear(robots, said, slot, i, bad, now, options):
    """Merge what a robot hears."""
    for k in range(robots.place.shape[0]):
        if k == i or not said.speaks[slot, k] or not is_near(robots.place[i], robots.place[k], options.radio):
            continue
        if is_lost(i, k, now, bad, options):
            continue
        for j in range(robots.state.shape[1]):
            told = said.state[slot, k, j]
            if told <= robots.state[i, j]:
                continue
            if told == TAKEN and options.tolerates > 0:
                robots.votes[i, j] |= 1 << k
                if count_bits(robots.votes[i, j]) <= options.tolerates:
                    continue
            robots.state[i, j] = told
            meet_task(robots, i, j, now)
        hear_claims(robots, said, slot, i, k, options)


@njit
def count_bits(word):
    """Return the number of ones."""
    found = 0
    while word:
        word &= word - 1
        found += 1
    return found


@njit
def share(robots):
    """Give all robots what each of them has seen."""
    for j in range(robots.state.shape[1]):
        robots.state[:, j] = robots.state[:, j].max()


@njit
def end_step(robots, i, walked, options):
    """Advance the timers of run and phase; a run waits while a robot goes to a task or stands."""
    if walked:
        robots.left[i, 0] -= 1
        if robots.left[i, 0] == 0:
            turn(robots, i, options)
    robots.left[i, 1] -= 1
    if robots.left[i, 1] == 0:
        robots.speaks[i] = not robots.speaks[i]
        begin_phase(robots, i, options)


@njit
def under_way(robots, holder):
    """Return how many robots go to a task, and how many of them to one that another goes to or has."""
    going, double = 0, 0
    for i in range(robots.target.size):
        j = robots.target[i]
        if j >= 0:
            going += 1
            other = holder[j] >= 0 and holder[j] != i
            for k in range(robots.target.size):
                other = other or (k != i and robots.target[k] == j)
            double += other
    return going, double


@njit
def play(robots, said, tasks, options):
    """Play a run until all tasks are taken that can be; return its step, -1 if never, and what it took."""
    count = robots.place.shape[0]
    holder, bad = np.full(tasks.shape[0], -1), np.zeros((count, count), np.bool_)
    wanted = min(tasks.shape[0], robots.honest.sum())
    if options.burst > 0:
        for i in range(count):
            for k in range(count):
                bad[i, k] = chance(0, i, LINK + PAIR * k, options) < options.loss
    for i in range(count):
        turn(robots, i, options)
        begin_phase(robots, i, options)
    found = np.zeros(6, np.int64)  # steps moved, vain arrivals, bits, steps under way, of these double, taken
    choose_all(robots, tasks, 0, options)
    for now in range(1, options.steps + 1):
        step(robots, said, tasks, holder, bad, now, options, found)
        found[5] = robots.stands.sum()
        if found[5] == wanted:
            return now, found
        choose_all(robots, tasks, now, options)
        going, double = under_way(robots, holder)
        found[3] += going
        found[4] += double
    return -1, found


@njit
def step(robots, said, tasks, holder, bad, now, options, found):
    """Play a step until its timers have advanced."""
    count, slots = robots.place.shape[0], options.delay + 1
    found[2] += say(robots, said, now % slots, options)
    walked = robots.target < 0
    for i in range(count):
        walked[i] = walked[i] and not robots.stands[i]
        if not robots.stands[i]:
            move(robots, tasks, i, options)
            found[0] += 1
    for i in range(count):
        found[1] += arrive(robots, tasks, holder, i, now > options.start, options)
    if options.burst > 0:
        change_links(bad, now, options)
    for i in range(count):
        if not robots.speaks[i]:
            look(robots, tasks, holder, i, now, options)
        if now > options.delay:
            hear(robots, said, (now - options.delay) % slots, i, bad, now, options)
    if options.mind:
        share(robots)
    for i in range(count):
        end_step(robots, i, walked[i], options)


@njit
def choose_all(robots, tasks, now, options):
    """Let all honest robots choose that act, or may mark a task; those that have marked one go back to it."""
    for i in range(robots.place.shape[0]):
        if not robots.honest[i] or robots.stands[i]:
            continue
        if now < options.start and (not options.tags or robots.task[i] >= 0):
            continue
        if robots.task[i] >= 0:
            robots.target[i] = robots.task[i]
        else:
            choose(robots, tasks, i, now, options)


def empty(places: Any, tasks: Any, honest: Any, delay: int) -> tuple[Robots, Said]:
    """Return robots at some places that know nothing, and what they said before."""
    n, m = len(places), len(tasks)
    whole, none = np.int64, np.bool_
    robots = Robots(
        place=places.copy(),
        step=np.zeros((n, 2), whole),
        left=np.zeros((n, 2), whole),
        drawn=np.zeros((n, 2), whole),
        speaks=np.zeros(n, none),
        honest=honest,
        target=np.full(n, -1),
        task=np.full(n, -1),
        stands=np.zeros(n, none),
        state=np.full((n, m), UNKNOWN, np.int8),
        votes=np.zeros((n, m), whole),
        bid=np.full((n, m), 2**40),
        by=np.full((n, m), n),
        lot=np.full((n, 4), -1),
        part=np.full((n, n), -1),
        version=np.zeros((n, 2)),
        since=np.full((n, m), -1),
    )
    kept = ("state", "bid", "by", "lot", "part", "version")
    copies = {key: np.stack([getattr(robots, key)] * (delay + 1)) for key in kept}
    return robots, Said(np.zeros((delay + 1, n), none), **copies)

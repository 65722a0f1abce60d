"""What strategies share whose robots declare by names: whom to believe, and how long to wait.

Certified propagation: a robot accepts a statement that it did not see for itself once f + 1 different direct
neighbours have sent it as accepted. Of f liars and one more neighbour, one is honest. So the first honest
robot to accept a name saw it, and no invented name is ever accepted while there are f liars or fewer.

References
----------
Koo, "Broadcast in radio networks tolerating Byzantine adversarial behavior", 2004; Pelc and Peleg,
"Broadcasting with locally bounded Byzantine faults", 2005.
"""

import math

NEVER = 2**30
"""Number of steps that stands for no end."""
QUIET_FLOODINGS = 1.5
"""Quiet time of a census in a place, in times of flooding."""
TESTED = {
    "robots": (5, 200),
    "longer side of the arena per shorter side": (1, 25),
    "mean run in steps": (1, 100),
}
"""Least and largest values with which computed quiet times were tested."""


def tolerated(setting, place):
    """Return f, the number of Byzantine robots that a parameter tolerates, at most the number of robots."""
    return int(min(max(setting.parameters[place], 0.0), float(setting.robots)))


def told_enough(known, first, tolerates, sender):
    """Return whether more than ``tolerates`` neighbours have sent a statement: this one and those listed.

    The words from ``first`` on list them, one more than their ids.
    """
    for k in range(first, first + tolerates):
        if known[k] == sender + 1:
            return False
        if known[k] == 0:
            known[k] = sender + 1
            return False
    return True


def tasks_to_invent(setting):
    """Return the number of tasks that a Byzantine robot invents (model.md 6.12, 6.16)."""
    return max(setting.robots + 1 - setting.tasks, 0) if setting.colluding else setting.robots + 1


def invented(k, name_bits):
    """Return the name of so many bits of an invented task, the same for all Byzantine robots."""
    return max(((k + 1) * 2654435761 % 2**32) >> (32 - name_bits), 1)


def steps_for(sightings, robots, setting):
    """Return the number of steps in which so many robots see a given place so often, on average.

    A robot sweeps a strip of twice its range of sight while it explores, and one of twice its range of radio
    while it disseminates; the rarer counts. Within walls robots wait twice as long. So it is where a robot is
    soon anywhere: in arenas about as wide as high, if robots walk straight for long enough. Elsewhere it must
    get to the place first, which counts in addition to most of the time of sweeping.
    """
    exploring = setting.exploration / (setting.exploration + setting.dissemination)
    return steps_with(exploring, sightings, robots, setting)


def steps_with(exploring, sightings, robots, setting):
    """Return `steps_for` for robots that explore in this share of their time.

    Where robots charge, a robot surely works for so many of these steps as it would take without.
    """
    steps = steps_at_work(exploring, sightings, robots, setting)
    if setting.charge == 0.0 or steps >= NEVER:
        return steps
    lasts = steps * (1.0 + setting.charge / setting.work) + setting.charge
    return NEVER if lasts >= NEVER else math.ceil(lasts)


def steps_at_work(exploring, sightings, robots, setting):
    """Return `steps_with` for robots that never charge.

    Late messages make it longer by the delay: at most 2 wrong runs in 1,000 for delays up to 1,000 steps. In
    a place, a census waits for 1.5 times the time of flooding, in which messages are late, too. Other times,
    such as those that tolerate Byzantine robots, have the same ratio to it as in an open arena.
    """
    steps = open_steps(exploring, sightings, robots, setting)
    if steps >= NEVER:
        return steps
    if setting.flooding == 0.0:
        return steps + math.ceil(setting.delay)
    everyone = setting.count if setting.knows_count else robots
    usual = setting.exploration / (setting.exploration + setting.dissemination)
    least = open_steps(usual, sightings_to_flood(everyone), everyone, setting)
    wait = QUIET_FLOODINGS * setting.flooding * steps / least
    return NEVER if least >= NEVER or wait >= NEVER else math.ceil(wait)


def sightings_to_flood(robots):
    """Return how often a swarm finds a given place until all robots surely know of all tasks.

    Fitted to n robots and n + 1 tasks, for n from 5 to 200: at most 2 wrong runs in 1,000.
    """
    return 5.2 + 1.6 * math.log(max(robots, 1))


def open_steps(exploring, sightings, robots, setting):
    """Return `steps_at_work` in an arena without obstacles."""
    reach = min(setting.sight * exploring, setting.radio * (1.0 - exploring))
    each_step = swept(reach, robots, setting)
    area = room(setting)
    if each_step * NEVER <= sightings * area:
        return NEVER
    sweeping = sightings * area / each_step
    rarer = 2.0 * min(exploring, 1.0 - exploring)
    steps = max(sweeping, 0.8 * sweeping + sightings * spreading(setting) / (rarer * robots))
    return NEVER if steps >= NEVER else math.ceil(steps)


def spreading(setting):
    """Return the time in which a robot comes into range of a place, wherever it began, in steps.

    A walk with turns spreads like heat: the time grows with the square of the longer side. Without turns, it
    grows with the longer side. A wall at either end makes the way at most twice as long, and the time four
    times; walls on both sides of a corridor end straight walks, which makes them shorter by its width.
    Fitted to arenas of 100 by 4 to 20 by 20 units, mean runs of 1 to 100 steps, and 5 to 60 robots that face
    one task too many: at most 5 wrong runs in 1,000.
    """
    longer, shorter = max(setting.width, setting.height), min(setting.width, setting.height)
    in_range = 2.0 * min(setting.sight, setting.radio)
    across = max(longer - in_range, 0.0) / setting.speed
    along = max(shorter - in_range, 0.0) / setting.speed
    straight = (longer - shorter) / setting.speed
    turning = 0.24 * (across * across + along * along) / max(setting.mean_run, 0.5)
    if setting.walled:
        return 4.0 * turning + 0.3 * straight * (longer + shorter) / shorter
    return turning + straight


def untested(robots, setting):
    """Return the names of `TESTED` whose values for so many robots lie outside, with these values."""
    sides = setting.width, setting.height
    values = robots, max(sides) / min(sides), setting.mean_run
    each = zip(TESTED.items(), values, strict=True)
    return {name: value for (name, (low, high)), value in each if not low <= value <= high}


def room(setting):
    """Return the area of the arena; within walls twice that, since places near them are seen more rarely."""
    return setting.width * setting.height * (2.0 if setting.walled else 1.0)


def swept(reach, robots, setting):
    """Return the area of the strips that so many robots sweep in a step, with this reach to both sides."""
    return 2.0 * reach * setting.speed * robots


def steps_given(value):
    """Return a parameter as a number of steps."""
    return math.ceil(min(value, float(NEVER)))

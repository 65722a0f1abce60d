"""Certified propagation and the time to wait: what strategies share whose robots declare by names.

A robot accepts a statement that it did not see for itself once f + 1 different direct neighbours have told it
as accepted. With f liars or fewer, one of them is honest. So the first honest robot to accept a name saw it,
and nothing invented is ever accepted.

References
----------
Koo, "Broadcast in radio networks tolerating Byzantine adversarial behavior", 2004; Pelc and Peleg,
"Broadcasting with locally bounded Byzantine faults", 2005.
"""


def tolerated(setting, place):
    """Return f, the number of liars that a parameter tolerates, at most the number of robots."""
    return int(min(max(setting.parameters[place], 0.0), float(setting.robots)))


def told_enough(known, first, tolerates, sender):
    """Return whether more than ``tolerates`` robots have told a statement; the words from ``first`` list them."""
    for k in range(first, first + tolerates):
        if known[k] == sender + 1:
            return False
        if known[k] == 0:
            known[k] = sender + 1
            return False
    return True


def sightings(steps, robots, setting):
    """Return how often so many robots see a given place in so many steps, on average.

    A robot sweeps a strip of twice its range of sight in the share of its time that it explores.
    """
    share = setting.exploration / (setting.exploration + setting.dissemination)
    swept = 2.0 * setting.sight * setting.speed * share * robots * steps
    return swept / (setting.width * setting.height)

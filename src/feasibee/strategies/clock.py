"""The clock of a robot counts steps modulo 2**32, so that steps are compared by their difference.

A word of knowledge holds the lowest 32 bits of a step. At 10 steps per second the clock begins again after
13.6 years.
"""

LAST = 2**32 - 1
"""The last step before the clock begins again; also the bits of a step."""


def steps_since(then, now):
    """Return how many steps ago a step was: 0 to 2**32 - 1."""
    return (now - then) & LAST


def has_come(then, now):
    """Return whether a step has come that was less than 2**31 steps ahead when it was stored."""
    return steps_since(then, now) < 2**31

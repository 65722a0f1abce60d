"""A robot with a roster, step by step."""

from __future__ import annotations


def step(own, *things, explores=True):
    """Let a robot see things for a step; return its opinion."""
    own.observe(things)
    opinion = own.judge()
    own.end_step(explores=explores)
    return opinion


def counted(own):
    """Return how many robots and how many tasks a robot counts."""
    (robots,), (tasks,) = own.counted()
    return robots, tasks

"""Skeletons of a user's strategy: files that run as they are, to be edited."""

from __future__ import annotations

from typing import Final

_BEGINNING: Final = '''\
"""{title}

Edit this file, then:
  feasibee check {file}                          what it needs, sends and takes, and how often it is right
  feasibee run --set decision.strategy={file}    simulate it
  feasibee header {file} > feasibee.h            its controller in C, for a robot
docs/strategy-contract.md explains each function.
"""
'''
_OPINIONS: Final = '''
PARAMETERS = {{"lead": 0.0}}  # a scenario changes it by decision.parameters.lead
# MEMORY = 1            # number of floats that a robot keeps, in mind.memory
# FORGETS = False       # count robots and tasks over a robot's life, not afresh in each exploration
# STARTS_NEUTRAL = True # begin without an opinion


def say(mind):
    """Return the opinion to broadcast, 1 feasible or 0 infeasible, or -1 to be silent."""
    return mind.opinion


def decide(mind, inbox):
    """Return the next opinion: 1 feasible, 0 infeasible. Called when a dissemination ends."""
    lead = inbox.feasible_votes - inbox.infeasible_votes
    if lead > mind.parameters[0]:
        return 1
    if -lead > mind.parameters[0]:
        return 0
    return mind.opinion


# Optional, in double precision on a robot: remove the "# " before each line.
#
# def quality(robots_seen, tasks_seen):
#     """Return how good the opinion feasible is, 0 to 1, by what was seen in an exploration."""
#     return (robots_seen + 1) / (robots_seen + tasks_seen + 2)
#
#
# def dissemination(quality, gain):
#     """Return for how many steps to broadcast, on average: longer for an opinion of better quality."""
#     return gain * quality
'''
_KNOWLEDGE: Final = '''
BY_NAME = True          # false sightings mean nothing, since things are told apart by their ids
# NEEDS_COUNT = True    # robots know how many they are: me.setting.robots; needs robots.know_count = true
# ONE_CLASS = True      # scenarios with classes of robots or tasks are rejected
# PARAMETERS = {{"quiet": 50.0}}  # me.setting.parameters[0]; a scenario changes it


def words(setting):
    """Return the length of the row of words that a robot knows: one for each robot, then for each task."""
    return setting.robot_ids + setting.task_ids


def start(known, me):
    """Write what a robot knows at first: itself."""
    known[me.id] = 1


def observe(known, thing, me):
    """Add a robot or task in sight."""
    known[thing.id if thing.is_robot else me.setting.robot_ids + thing.id] = 1


def merge(known, message, sender, me):
    """Add what a neighbour broadcast. The order of messages, and hearing one twice, must not matter."""
    for k in range(len(known)):
        known[k] = max(known[k], message[k])


def count(known, counts, me):
    """Write the numbers of robots and of tasks that are known; they are rated when a phase ends."""
    for k in range(len(known)):
        counts[0 if k < me.setting.robot_ids else 1] += known[k]


def bits(message, me):
    """Return the length of a message in bits: that of layout."""
    return len(message)


def layout(wire, message, sender, setting):
    """Write or read a message, bit by bit; return the sender's id, or -1 if it isn't sent."""
    for k in range(len(message)):
        message[k] = wire.number(message[k], 1)
    return -1


def decide(mind, inbox):
    """Return the next opinion: feasible if at least as many robots as tasks are known."""
    return 1 if mind.feasible_quality >= 0.5 else 0


# Optional: remove the "# " before each line.
#
# def declare(known, me):
#     """Return what the robot is sure of, once and for good: 1 feasible, 0 infeasible, or -1: not yet."""
#     robots = 0
#     tasks = 0
#     for k in range(len(known)):
#         if k < me.setting.robot_ids:
#             robots += known[k]
#         else:
#             tasks += known[k]
#     return 0 if robots == me.setting.robots and tasks > robots else -1
'''


def skeleton(file: str, *, knowledge: bool) -> str:
    """Return the text of a strategy that runs as it is, which mentions its file's name.

    ``knowledge`` says whether its robots pass on what they know, in addition to opinions.
    """
    titles = ("Adopt the opinion that most neighbours broadcast.", "Pass on which robots and tasks exist.")
    return (_BEGINNING + (_KNOWLEDGE if knowledge else _OPINIONS)).format(title=titles[knowledge], file=file)

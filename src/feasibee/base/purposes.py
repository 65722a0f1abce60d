"""Purposes of random numbers: the last word of each draw's Philox counter."""

from __future__ import annotations

from typing import Final

# Append only, never renumber: other numbers give other results.
PLACE_ROBOT: Final = 0  # words 0, 1: x, y
PLACE_TASK: Final = 1  # words 0, 1: x, y
FIRST_OPINION: Final = 2  # word 0: its top bit
WALK: Final = 3  # word 0: heading; word 1: duration
PHASE: Final = 4  # word 0: duration; for the decision before it, word 1: chance, word 2: the message drawn
CENTRE_ROBOT: Final = 5  # words 0, 1: x, y of a cluster's centre
CENTRE_TASK: Final = 6
CLUSTER_ROBOT: Final = 7  # word 0: which cluster
CLUSTER_TASK: Final = 8
SCATTER_ROBOT: Final = 9  # all words: the offset from a centre, twelve summands for x and twelve for y
SCATTER_TASK: Final = 10
SITE: Final = 11  # word 0: shuffles the robots over a lattice
FAULT: Final = 12  # word 0: shuffles the robots to choose the faulty ones
MISS_ROBOT: Final = 13  # word 0; of (observer, thing)
MISS_TASK: Final = 14
FALSE_ROBOT: Final = 15  # word 0: number of false sightings
FALSE_TASK: Final = 16
FALSE_ROBOT_CLASS: Final = 17  # word 0: class; word 1: hash; of (observer, number of the sighting)
FALSE_TASK_CLASS: Final = 18
LOSS: Final = 19  # word 0; of (receiver, sender)
LIE: Final = 20  # word 0: its top bit is the opinion that a random Byzantine robot broadcasts
IDENTITY: Final = 21  # word 0: a robot's random id; word 1: the hash of a robot, a task or an invented thing;
#                       word 2: that of a task under its wrong name
ARRIVAL: Final = 22  # of a step; word 0: number of tasks that appear; word 1: number of robots that join
LIFETIME: Final = 23  # word 0; of a task
FAILURE: Final = 24  # word 0; of (robot, how many have had its number before it)
VANISH: Final = 25  # word 0: which of the tasks there; of (how many by events before it in this step, step)
LEAVE: Final = 26  # word 0: which of the robots there; likewise
JOINING_CLASS: Final = 27  # word 0: the robot of the start that has the class of a number beyond these
APPEARING_CLASS: Final = 28  # word 0: the same for a task
# 29 was for robots that were released.
MISNAME: Final = 30  # word 0; of (observer, task)
BATTERY: Final = 31  # word 0: how long the first battery of a robot lasts; as for FAILURE
PAIR: Final = 256
"""A draw about a pair has the last word purpose + PAIR * (number of the second)."""

"""Quiet census: robots pass on the names of tasks, and declare when nothing new has come for long."""

BY_NAME = True
NEEDS_COUNT = True
ONE_CLASS = True
STARTS_NEUTRAL = True
MEMORY = 2
PARAMETERS = {"quiet": 100.0}


def words(setting):
    """Return the length of the row: a word for each task, at least one."""
    return max(1, setting.task_ids)


def observe(known, thing, me):
    """Add a task in sight to what the robot knows."""
    if not thing.is_robot:
        known[thing.id] = 1


def merge(known, message, sender, me):
    """Add the tasks that a neighbour knows."""
    for task in range(len(known)):
        known[task] = max(known[task], message[task])


def number_of(tasks):
    """Return the number of tasks in a row: a helper, which other functions call."""
    number = 0
    for task in range(len(tasks)):
        number += tasks[task]
    return number


def declare(known, me):
    """Return infeasible for more tasks than robots, feasible after a quiet time, and else -1: not sure."""
    number = number_of(known)
    if number > me.setting.robots:
        return 0
    if number > me.memory[0]:
        me.memory[0] = number
        me.memory[1] = me.step
    return 1 if me.step - me.memory[1] >= me.setting.parameters[0] else -1


def bits(message, me):
    """Return the length: 1 bit and a position in 32 bits for each task, and 1 bit to end the list."""
    return 33 * number_of(message) + 1


def count(known, counts, me):
    """Count the robots and the tasks."""
    counts[0] = me.setting.robots
    counts[1] = number_of(known)


def say(mind):
    """Return an opinion to broadcast with: a robot without one would be silent."""
    return max(mind.opinion, 0)


def decide(mind, inbox):
    """Return the opinion that the robot has: only declaring changes it."""
    return mind.opinion

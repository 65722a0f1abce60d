"""What the robots of a user's strategy know, to which tests add a head, a count and a judge."""

from __future__ import annotations

SIGHTINGS = """\
def decide(mind, inbox):
    return mind.opinion


def words(setting):
    return max(setting.task_ids, 1)


def observe(known, thing, me):
    if not thing.is_robot:
        known[thing.id] = int(me.setting.parameters[0])


def merge(known, message, sender, me):
    for k in range(len(known)):
        known[k] = max(known[k], message[k])


def present(row):
    number = 0
    for k in range(len(row)):
        number += row[k] > 0
    return number


def bits(message, me):
    return me.setting.id_bits + 40 * present(message)
"""
"""Robots that know which tasks they, or others, saw at most ``lasts`` steps ago, the first parameter."""

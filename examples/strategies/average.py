"""Average: gossip averaging of the log ratio of all evidence.

A robot's counts run over its whole life; l is the log of their ratio, robots to tasks, half a sighting of
each added. At the end of each dissemination, with k messages of others' x, it takes

    x <- (l + sum of x heard) / (1 + k)

and the opinion is the sign of x. As its own evidence stays in the mean, the estimates of all robots settle
about the mean of l over the swarm, whatever is lost on the way.

Message: id, opinion, x from -16 to 16 in 16 bits. Memory: two counts, two floats, and one x for each robot
heard.

References
----------
Friedkin, Johnsen, "Social influence and opinions", 1990; DeGroot, "Reaching a consensus", 1974.
"""

import math

FORGETS = False
MEMORY = 2
VALUE_BITS = 16


def quality(robots_seen, tasks_seen):
    """Return the quality of *feasible*, half a sighting of each added, so that it is never 0 or 1."""
    return (robots_seen + 0.5) / (robots_seen + tasks_seen + 1.0)


def value(mind):
    """Return x as a share of the way from -16 to 16; before the first decision, l."""
    x = mind.memory[0]
    if mind.memory[1] == 0.0:
        x = math.log(mind.feasible_quality / (1.0 - mind.feasible_quality))
    return x / 32.0 + 0.5


def decide(mind, inbox):
    """Return the sign of x; 0 keeps the opinion."""
    evidence = math.log(mind.feasible_quality / (1.0 - mind.feasible_quality))
    votes = inbox.feasible_votes + inbox.infeasible_votes
    x = (evidence + votes * (inbox.mean_value - 0.5) * 32.0) / (1 + votes)
    mind.memory[0] = x
    mind.memory[1] = 1.0
    if x == 0.0:
        return mind.opinion
    return 1 if x > 0.0 else 0

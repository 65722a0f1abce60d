"""Three-valued beliefs: a contradiction makes a robot unsure, and an unsure one adopts what it hears.

A robot broadcasts its belief, feasible, infeasible or unsure, for a time in proportion to the quality of its
opinion; if it is unsure, that is 1/2. Then it draws one of the messages that it heard. A sure message makes
an unsure robot sure of the same, and a robot that was sure of the opposite unsure. An unsure message changes
nothing.

Message: id, opinion, and 1 bit that says whether the robot is sure. Memory: two counts, and one opinion and
that bit for each robot heard.

References
----------
Crosscombe, Lawry, Hauert, Homer, "Robust distributed decision-making in robot swarms: exploiting a third
truth state", 2017. Read in khaiyichin/collective_perception, commit 04111dc2.
"""

VALUE_BITS = 1


def dissemination(quality, gain):
    """Return the mean duration of broadcasting, in steps, in proportion to the quality."""
    return gain * quality


def say(mind):
    """Return the opinion; an unsure robot is heard, too, so it says one that its value takes back."""
    return max(mind.opinion, 0)


def value(mind):
    """Return 1 if the robot is sure, else 0."""
    return 1.0 if mind.opinion >= 0 else 0.0


def decide(mind, inbox):
    """Return the belief after one random message: 1, 0, or -1 for unsure."""
    if inbox.heard_opinion < 0 or inbox.heard_value < 0.5:
        return mind.opinion
    if mind.opinion < 0 or mind.opinion == inbox.heard_opinion:
        return inbox.heard_opinion
    return -1

"""
A strategy of your own in ten lines: right at first, but it never settles
=========================================================================

*Herald*: a robot tells what its own eyes say, whatever it was persuaded of, and follows the majority. Ten
lines in a file; the engine compiles them, and they meet the paper's rule on the same worlds, of 10 tasks.
"""

import tempfile
from pathlib import Path

import feasibee
from feasibee.figures.comparison import draw_against_time
from feasibee.studies.comparison import compare, contenders_of

HERALD = """
def quality(robots_seen, tasks_seen):
    return (robots_seen + 1) / (robots_seen + tasks_seen + 2)
def dissemination(quality, gain):
    return gain * quality
def say(mind):
    return 1 if mind.feasible_quality > 0.5 else 0
def decide(mind, inbox):
    lead = inbox.feasible_votes - inbox.infeasible_votes
    return mind.opinion if lead == 0 else int(lead > 0)
"""
with tempfile.TemporaryDirectory() as folder:
    file = Path(folder, "herald.py")
    file.write_text(HERALD)
    contenders = contenders_of(feasibee.Scenario(tasks={"count": 10}), ("dmmd", str(file)))
    dmmd, herald = compare(contenders, runs=400, seed=1)

shares = {each.contender: each.right_at[None, :] / each.runs for each in (dmmd, herald)}
figure = draw_against_time(shares)

# %%
# Told evidence carries no error through the swarm; but a robot that has just seen odd things says so, and
# of those who hear it some follow. The first time that more than 90 % agree they are right; they don't stay
# so. :doc:`/add-a-strategy` mends that, and has the contract in full.

for each in (dmmd, herald):
    print(f"{each.contender}: first {each.first.estimate:.2f}, at the end {each.accuracy.estimate:.2f}")

"""
A strategy of your own in ten lines: its first decision is right, but doesn't last
==================================================================================

*Herald*: a robot broadcasts the opinion that its own sightings support, and adopts the majority. It takes
ten lines in a file, which the engine compiles. The example compares it with the paper's strategy on the same
worlds, with 10 tasks.
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
# Broadcast sightings carry no error through the swarm. But a robot with misleading sightings broadcasts them,
# and some of its neighbours follow. When more than 90 % first agree, they are right, but the agreement
# doesn't last. :doc:`/add-a-strategy` has a variant without this fault, and links the contract.

for each in (dmmd, herald):
    print(f"{each.contender}: first {each.first.estimate:.2f}, at the end {each.accuracy.estimate:.2f}")

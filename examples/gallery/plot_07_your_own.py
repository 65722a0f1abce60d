"""
A strategy of your own in ten lines: its first decision is right, but doesn't last
==================================================================================

*Herald*: a robot broadcasts the opinion that its own sightings support, and adopts the majority. It takes
ten lines in a file, which the engine compiles. The example compares it with the paper's strategy on the same
worlds, with 10 tasks.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt

import feasibee

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
found = {}
with tempfile.TemporaryDirectory() as folder:
    file = Path(folder, "herald.py")
    file.write_text(HERALD)
    for name in ("dmmd", str(file)):
        scenario = feasibee.Scenario(tasks={"count": 10}, decision={"strategy": name})
        swarms = feasibee.simulate(scenario, runs=400, seed=1, curves=True)
        found[Path(name).name] = swarms

_, ax = plt.subplots(figsize=(6.4, 3.4), layout="constrained")
for name, swarms in found.items():
    right = swarms.feasible_count > 0.9 * 20  # 10 tasks are feasible for 20 robots
    ax.plot(100 * right.mean("run"), label=name)
ax.set(xlabel="time (steps)", ylabel="right (%)", ylim=(0, 104))
ax.legend()

# %%
# Broadcast sightings carry no error through the swarm. But a robot with misleading sightings broadcasts them,
# and some of its neighbours follow. When more than 90 % first agree, they are right, but the agreement
# doesn't last. :doc:`/add-a-strategy` has a variant without this fault, and links the contract.

for name, swarms in found.items():
    first, last = (swarms.decision == 1).mean(), (swarms.feasible_at_end > 0.9 * 20).mean()
    print(f"{name}: first {float(first):.2f}, at the end {float(last):.2f}")

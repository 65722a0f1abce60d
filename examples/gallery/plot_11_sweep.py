"""
A longer range of sight makes swarms decide sooner, not more accurately
=======================================================================

A sweep from Python: five ranges of sight (and of the radio, which follows it) by seven numbers of tasks, 200
swarms each. With 100 tasks, swarms with the longest range are wrong most often. With ``out="results"``, the
same call goes on after an interruption, and more values later cost only what is new.
"""

import feasibee

vary = {"sensing.range": [1.0, 1.5, 2.0, 3.0, 4.0], "tasks.count": [4, 8, 13, 20, 31, 50, 100]}
swarms = feasibee.Scenario(run={"stop_at_decision": True})
table = feasibee.sweep(swarms, vary, runs=200, seed=1)
right = table.right.mean("run").assign_attrs(long_name="share of swarms that are right")
right.plot(x="tasks.count", y="sensing.range", xscale="log", cmap="viridis", vmin=0, vmax=1)

# %%
# The step by which half of the swarms had decided, with 100 tasks:

steps = table.decision_step.where(table.decision_step >= 0).sel({"tasks.count": 100})
print(steps.median("run").to_series())

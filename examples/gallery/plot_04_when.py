"""
Half of the swarms have decided by step 127, and those that err hardly later
============================================================================

How many of 1,000 swarms of 20 robots with 10 tasks had decided by each step, by what they decided. The
tasks are feasible: the dashed line is those that err. How soon a swarm decides doesn't tell much about
whether it is right.
"""

import matplotlib.pyplot as plt

import feasibee

swarms = feasibee.simulate(feasibee.Scenario(tasks={"count": 10}), runs=1000, seed=1)
_, ax = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
feasibee.plot_decision_steps(swarms, ax)
ax.set_xlim(0, 600)

# %%
# Quartiles over all runs, and over those that err. A run that never decides would count as later than any
# step; it isn't left out.

print(feasibee.decision_times(swarms.decision_step))
print(feasibee.decision_times(swarms.decision_step.where(swarms.decision == 0, drop=True)))

"""
Robots that search for 40 steps first do their tasks sooner
===========================================================

20 robots go to 20 tasks and stand there: at once, or after 40 steps in which they only search and tell each
other what they found. On the left is one swarm shortly after it began: free tasks are hollow, and lines lead
from robots to their tasks. On the right is the share of 200 swarms in which robots stand at all tasks. Who
stands finds no task and carries no news, so robots that begin at once take long to find the last tasks.
"""

import matplotlib.pyplot as plt
import numpy as np

import feasibee

SEED = 1
figure, (left, right) = plt.subplots(1, 2, figsize=(6.8, 4), layout="constrained")
for start, style in ((40, "-"), (0, "--")):
    scenario = feasibee.Scenario(acting={"start": start}, run={"stop_when_taken": True, "steps": 2000})
    runs = feasibee.simulate(scenario, runs=200, seed=SEED)
    steps = np.sort(runs.all_taken_step.values)
    right.plot(steps, 100 * np.arange(1, 201) / 200, style, label=f"start = {start}")
    print(f"start = {start}: half of the swarms by step {steps[99]}, 95 % by step {steps[189]}")
swarm = feasibee.Swarm(feasibee.Scenario(acting={"start": 40}), seed=SEED)
swarm.advance(43)
feasibee.plot_arena(swarm, ax=left)
right.set(xlabel="step", ylabel="swarms with all tasks taken (%)", xlim=(0, 600), ylim=(0, 100))
right.legend(loc="lower right")

"""
A roster follows tasks that come and go; a census can't forget them
===================================================================

One run of the stream of ``examples/changing.toml``: tasks appear and are finished at random. Behind the lines
is the truth, grey where the tasks are infeasible. Robots with a census only ever add to what they know. Those
with a roster report a task absent when they look for it in vain.
"""

import matplotlib.pyplot as plt
import numpy as np

import feasibee

SEED = 3
stream = {"count": 20, "arrival_rate": 0.0114, "lifetime": 1800.0}
figure, (above, below) = plt.subplots(2, 1, figsize=(6.4, 4.4), sharex=True, layout="constrained")
for strategy, style in (("roster", "-"), ("census", "--")):
    scenario = feasibee.Scenario(tasks=stream, decision={"strategy": strategy}, run={"steps": 2500})
    run = feasibee.simulate(scenario, runs=1, seed=SEED, curves=True).isel(run=0)
    below.plot(run.step, 100 * run.feasible_count / run.robots_present, style, label=strategy)
    right = float((run.held == run.truth)[1:].mean())
    print(f"{strategy}: right in {100 * right:.0f} % of the steps")
above.step(run.step, run.tasks_present, where="post", color="tab:orange", label="tasks")
above.plot(run.step, run.robots_present, color="0.3", label="robots")
for ax in (above, below):
    edges = np.flatnonzero(np.diff(run.truth.values, prepend=1, append=1) != 0)
    for first, after in edges.reshape(-1, 2).tolist():
        ax.axvspan(first, after, color="0.88", linewidth=0, zorder=0)
    ax.legend(loc="center")
above.set(ylabel="number")
below.set(xlabel="step", ylabel="robots with feasible (%)", xlim=(0, 2500), ylim=(-4, 104))

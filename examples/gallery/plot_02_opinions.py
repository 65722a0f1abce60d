"""
Opinions converge far from ratio one and split near it
======================================================

The paper's Fig. 2 for three numbers of tasks: the percentage of robots with opinion *feasible*. Lines are
medians over 400 runs; bands extend from the lower to the upper quartile. With as many tasks as robots, half
of the swarms end at 100 % and half at 0 %, so the band covers everything.
"""

import matplotlib.pyplot as plt

import feasibee

swarms = {
    f"{20 / tasks:g}": feasibee.simulate(
        feasibee.Scenario(tasks={"count": tasks}), runs=400, seed=1, curves=True
    )
    for tasks in (4, 20, 100)
}
_, ax = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
feasibee.plot_opinions(swarms, ax, until=300)
for line in ax.lines:
    place = (300, line.get_ydata()[300])
    ax.annotate(f"  robots per task: {line.get_label()}", place, va="center", annotation_clip=False)

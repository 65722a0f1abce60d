"""
Clustered tasks mislead the swarm; walls hardly do
==================================================

Twenty robots and 40 tasks, infeasible by far. Where the tasks lie in patches, presumably most robots meet
robots and few tasks, and agree on *feasible* before they have walked far.
"""

import matplotlib.pyplot as plt
import numpy as np

import feasibee
from feasibee.results.statistics import accuracy

paper = feasibee.Scenario(tasks={"count": 40})
walls = {"arena.boundary": "walls", "robots.avoid_collisions": True}
patches = {"tasks.placement": "clusters"}
worlds = {
    "as in the paper": paper,
    "walls, and robots that collide": paper.replace(walls),
    "tasks in three patches": paper.replace(patches),
    "both": paper.replace({**walls, **patches}),
}
rates = [accuracy(feasibee.simulate(world, runs=400, seed=1).decision, False) for world in worlds.values()]
middle, low, high = 100 * np.array(rates).T

_, (left, right) = plt.subplots(1, 2, figsize=(8.6, 3.8), layout="constrained", width_ratios=(1, 1.2))
feasibee.plot_arena(feasibee.Swarm(worlds["tasks in three patches"], seed=1), left)
left.get_legend().remove()
right.errorbar(middle, range(4), xerr=(middle - low, high - middle), fmt="o", color="#0072B2", capsize=3)
right.set_yticks(range(4), list(worlds))
right.set(xlabel="swarms that decide infeasible, rightly (%)", xlim=(0, 100), ylim=(3.5, -0.5))
right.axvline(50, color="0.8", zorder=0)

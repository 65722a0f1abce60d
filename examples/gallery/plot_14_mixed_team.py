"""
A team with spare robots can lack one skill
===========================================

Twenty robots have nine tasks. Each of six casualties needs two robots that lift, and each of three relays
needs one that can set it up. Porters lift; all-rounders lift or relay; the rest are scouts, who do neither.
The figure shows the ground truth and the missing skills. By Hall's theorem, infeasible tasks always have a
set of skills that more places need than there are robots with one of them.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import ListedColormap

import feasibee


def team(porters, all_rounders):
    """Return the scenario of a team of 20 with so many porters and all-rounders."""
    robots = {"porter": (porters, ["lift"]), "all-rounder": (all_rounders, ["lift", "relay"])}
    robots["scout"] = (20 - porters - all_rounders, [])
    tasks = {"casualty": (6, {"lift": 2}), "relay": (3, {"relay": 1})}
    return feasibee.Scenario(
        robots={"classes": [{"name": n, "count": c, "skills": s} for n, (c, s) in robots.items()]},
        tasks={"classes": [{"name": n, "count": c, "needs": d} for n, (c, d) in tasks.items()]},
    )


names = ["feasible", "relay", "lift, relay"]
verdicts = [[feasibee.explain(team(x, y)).violator for x in range(15)] for y in range(7)]
shown = [[0 if v is None else names.index(", ".join(v.skills)) for v in row] for row in verdicts]
_, ax = plt.subplots(figsize=(6.8, 3.4), layout="constrained")
colours = ListedColormap(["#0072B2", "#D55E00", "#F2BE9B"])
ax.pcolormesh(np.arange(16) - 0.5, np.arange(8) - 0.5, shown, cmap=colours, vmin=0, vmax=2, edgecolor="w")
handles = [plt.Rectangle((0, 0), 1, 1, color=colours(k)) for k in range(3)]
labels = ["feasible", "too few that relay", "too few that lift or relay"]
ax.legend(handles, labels, bbox_to_anchor=(1, 0.5), loc="center left")
ax.set(xlabel="porters", ylabel="all-rounders")

# %%
# With three all-rounders and eight porters:

print(verdicts[3][8])

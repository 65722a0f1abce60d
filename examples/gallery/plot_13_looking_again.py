"""
Repeated looks mislead one study in three, unless the interval allows for them
==============================================================================

Swarms whose true rate is 0.75, examined after every ten runs until the interval seems to exclude 0.75. A
Wilson interval is valid for one look. A confidence sequence is valid for all looks together. Stopping rules
(``until`` in a study file) use it.
"""

import matplotlib.pyplot as plt
import numpy as np

import feasibee

looks = np.arange(10, 1001, 10)
random = np.random.default_rng(1)
right = (random.random((400, looks[-1])) < 0.75).cumsum(axis=1)[:, looks - 1]

_, ax = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
for interval, name in ((feasibee.wilson, "Wilson"), (feasibee.confidence_sequence, "confidence sequence")):
    edges = {}
    for runs in looks.tolist():
        for successes in set(right[:, runs // 10 - 1].tolist()):
            edges[successes, runs] = interval(successes, runs)[1:]
    misled = np.array(
        [
            [not edges[k, n][0] <= 0.75 <= edges[k, n][1] for k, n in zip(study, looks.tolist(), strict=True)]
            for study in right.tolist()
        ]
    )
    ever = 100 * np.maximum.accumulate(misled, axis=1).mean(axis=0)
    ax.plot(looks, ever, label=f"{name}: {ever[-1]:.1f} % in the end")
ax.axhline(5, color="0.6", linestyle=":", linewidth=1)
ax.set(xlabel="runs so far", ylabel="studies misled so far (%)", ylim=(0, None))
ax.legend()

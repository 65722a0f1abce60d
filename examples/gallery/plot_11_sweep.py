"""
A longer range of sight makes swarms decide sooner, not more accurately
=======================================================================

A sweep from Python: five ranges of sight (and of the radio, which follows it) by seven numbers of tasks, 200
swarms each. With 100 tasks, swarms with the longest range are wrong most often. The journal is that of
``feasibee sweep``: after an interruption, the same call computes only the missing runs.
"""

import tempfile
import tomllib
from pathlib import Path

from feasibee.figures.sweep import Shown, draw_maps
from feasibee.sweeps import executors
from feasibee.sweeps.journal import Journal
from feasibee.sweeps.plan import study_of
from feasibee.sweeps.sweep import sweep
from feasibee.sweeps.table import shares_by_line, summaries

STUDY = """
runs = 200
seed = 1
[scenario]
run.stop_at_decision = true
[sweep]
"sensing.range" = [1.0, 1.5, 2.0, 3.0, 4.0]
"tasks.count" = [4, 8, 13, 20, 31, 50, 100]
"""
with tempfile.TemporaryDirectory() as folder:
    study = study_of(tomllib.loads(STUDY), Path(folder))
    done = sweep(study, folder, executors.threads())
    with Journal(folder) as journal:
        points = summaries(journal)
x, y = "tasks.count", "sensing.range"
panels = {"": shares_by_line(points, x, y, "accuracy")}
figure = draw_maps(panels, Shown(x, "accuracy", y=y))

# %%
# The step by which half of the swarms had decided, with 100 tasks:

print(f"{done.points} points, {done.runs_done} runs")
for point in points:
    if point.row.values["tasks.count"] == 100:
        print(f"range {point.row.values['sensing.range']}: step {point.found.times.median}")

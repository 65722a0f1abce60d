"""Compute the number of runs that show a share above 0.75 nine times in ten: plot_12_how_many_runs.py."""

from __future__ import annotations

import json
import runpy
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
EXAMPLE = Path(__file__).parents[2] / "examples/gallery/plot_12_how_many_runs.py"
with redirect_stdout(StringIO()):
    power = runpy.run_path(str(EXAMPLE))["power"]
runs = max(runs for runs in range(100, 1000, 10) if power(0.80, runs) < 0.9) + 10
share = next(share for share in (k / 100 for k in range(76, 100)) if power(share, 100) >= 0.9)
print(json.dumps({"runs": runs, "share": share}))

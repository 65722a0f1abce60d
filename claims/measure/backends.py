"""Measure the ratio of the reference implementation's CPU time to the engine's: feasibee.simulate."""

from __future__ import annotations

import json
import time

import feasibee

RUNS = {"engine": 500, "reference": 1}


def seconds(backend: str) -> float:
    """Return the CPU time per run of the paper's swarm."""
    start = time.process_time()
    feasibee.simulate(runs=RUNS[backend], seed=1, threads=1, backend=backend)
    return (time.process_time() - start) / RUNS[backend]


feasibee.simulate(runs=1)  # loads the engine
print(json.dumps({"ratio": seconds("reference") / seconds("engine")}))

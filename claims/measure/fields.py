"""Decisions of fields by clocks, drift and delay, and simulated ones: docs/field.md. Takes an hour.

With ``--quick``, two fields of a small swarm per case, to try the code. With ``--ros``, robots are nodes of
ROS 2, which the environment must have: docs/ros.md.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
from statistics import mean, stdev
from typing import Any

from feasibee import Scenario, simulate, wilson

SEED = 1
QUICK = "--quick" in sys.argv
SMALL = {"robots.count": 5, "arena.side": 5.0} if QUICK else {}
CHANGES = {"tasks.count": 15, "run.stop_at_decision": True, **SMALL}
DRIFTING = ("--drift", "0.1", "--jitter", "0.5")
SIMULATED: dict[str, Any] = {
    "simulated": (10_000, {}),
    "simulated, the first 100": (100, {}),
}
SIMULATED_ROS: dict[str, Any] = {"simulated, the first 30": (30, {})}
ROS: dict[str, Any] = {"nodes, 10 steps per second": (30, "--ros", "--hz", "10")}
CASES: dict[str, Any] = {
    "free, 50 steps per second": (100, "--hz", "50"),
    "the same, drift up to 10 %, jitter up to 50 %": (100, "--hz", "50", *DRIFTING),
    "lockstep, delay of 10 steps": (100, "--lockstep", "--delay", "10"),
    "lockstep, delay of 30 steps": (100, "--lockstep", "--delay", "30"),
}


def played(run: int, *options: str) -> dict[str, Any]:
    """Return the result of one field."""
    changes = [word for path, value in CHANGES.items() for word in ("--set", f"{path}={json.dumps(value)}")]
    words = ["robot", "launch", "--json", f"--seed={SEED}", f"--run={run}"]
    command = [sys.executable, "-m", "feasibee", *words]
    done = subprocess.run([*command, *changes, *options], capture_output=True, text=True, check=True)
    return dict(json.loads(done.stdout))


def simulated(case: str, runs: int, changes: dict[str, Any]) -> dict[str, Any]:
    """Return the row of simulated runs."""
    found = simulate(Scenario().replace({**CHANGES, **changes}), runs=runs, seed=SEED)
    return row(case, (found.decision == 1).to_numpy().tolist(), found.decision_step.to_numpy().tolist())


def row(case: str, decisions: list[bool], steps: list[int]) -> dict[str, Any]:
    """Return the rate of feasible and the mean step of the decision, with their 95 % intervals."""
    half = 1.96 * stdev(steps) / math.sqrt(len(steps))
    middle = mean(steps)
    rate = wilson(sum(decisions), len(decisions))._asdict()
    times = {"estimate": middle, "low": middle - half, "high": middle + half}
    return {"case": case, "runs": len(steps), "rate": rate, "steps": times}


def main() -> None:
    """Print the rows as JSON; each swarm starts as that of the same run."""
    first, then = (SIMULATED_ROS, ROS) if "--ros" in sys.argv else (SIMULATED, CASES)
    rows = [simulated(case, runs, changes) for case, (runs, changes) in first.items()]
    for case, (runs, *options) in then.items():
        results = [played(run, *options) for run in range(2 if QUICK else runs)]
        decided = [result["decision"] == "feasible" for result in results]
        rows.append(row(case, decided, [result["decision_step"] for result in results]))
    print(json.dumps({"rows": rows}))


if __name__ == "__main__":
    main()

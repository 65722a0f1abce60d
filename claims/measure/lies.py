"""Search for the worst lie against each built-in strategy, for 1 to 3 Byzantine robots of 20."""

from __future__ import annotations

import json
import sys

from feasibee.scenario.scenario import Scenario
from feasibee.strategies import STRATEGIES
from feasibee.studies.lies import worst_lie
from feasibee.sweeps.sweep import Execution

STEPS, TRIALS, RUNS, SEED = 500, 24, 20, 1


def main() -> None:
    """Print the worst lie found for each strategy and number of Byzantine robots, and its shares."""
    world = Scenario(tasks={"count": 10}, robots={"know_count": True}, run={"steps": STEPS})
    found = []
    for name in sys.argv[1:] or STRATEGIES:
        for liars in (1, 2, 3):
            worst = worst_lie(world, name, liars, TRIALS, RUNS, SEED, Execution())
            found.append({"strategy": name, "liars": liars, **worst._asdict()})
            print(name, liars, worst, file=sys.stderr, flush=True)
    print(json.dumps(found))


if __name__ == "__main__":
    main()

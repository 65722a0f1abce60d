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
    rows = []
    for name in sys.argv[1:] or STRATEGIES:
        found = [worst_lie(world, name, liars, TRIALS, RUNS, SEED, Execution()) for liars in (1, 2, 3)]
        shares = {part: [getattr(each, part)._asdict() for each in found] for part in ("own", "worst")}
        values = [each.values for each in found]
        rows.append({"strategy": name, "none": found[0].none._asdict(), **shares, "values": values})
        print(rows[-1], file=sys.stderr, flush=True)
    print(json.dumps(rows))


if __name__ == "__main__":
    main()

"""Write the chain behind `feasibee predict` as a model for the model checkers PRISM and Storm.

State 0 is the decision infeasible, the last but one the decision feasible. The last is the start, whose first
tick draws the coins. Labels: feasible, infeasible, decided. Reward: steps.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable

import numpy as np

import feasibee

EXAMPLE = "example: python research/export_prism.py --tasks 10 > ten.pm"
FASTEST = 0.9  # largest probability to leave a state in one tick


def row(state: int, chances: Iterable[float]) -> str:
    """Return the command that moves from a state to each state with a chance."""
    to = " + ".join(f"{float(chance)!r}:(x'={k})" for k, chance in enumerate(chances) if chance > 0)
    return f"  [] x={state} -> {to};"


def model_of(scenario: feasibee.Scenario) -> str:
    """Return the model of a scenario without faulty robots, with which there would be several chains."""
    chain = feasibee.predict(scenario).chain
    among, exits = chain.moves()  # rates between states, and to both decisions
    last = len(among) + 1
    ticks = max(1, math.ceil((among.sum(1) + exits.sum(1)).max() / FASTEST))
    rates = np.concatenate([exits[:, 1:], among, exits[:, :1]], axis=1) / ticks
    rates[np.arange(last - 1), np.arange(1, last)] = 1 - rates.sum(1)
    first = np.array([chain.decided[1], *chain.start, chain.decided[0]])
    lines = [
        f"// {scenario.robots.count} robots, {scenario.tasks.count} tasks, {scenario.decision.strategy}",
        f"dtmc\nconst int ticks_per_step = {ticks};",
        f"module swarm\n  x : [0..{last + 1}] init {last + 1};",
        row(last + 1, first / first.sum()),
        *(row(state, chances) for state, chances in enumerate(rates, 1)),
        f"  [] x=0|x={last} -> true;\nendmodule",
        f'label "feasible" = x={last};\nlabel "infeasible" = x=0;\nlabel "decided" = x=0|x={last};',
        f'rewards "steps"\n  x>0&x<{last} : 1/{ticks};\nendrewards',
    ]
    return "\n".join(lines)


def main() -> None:
    """Print the model."""
    parser = argparse.ArgumentParser(description=__doc__, epilog=EXAMPLE)
    parser.add_argument("--robots", type=int, default=20)
    parser.add_argument("--tasks", type=int, default=10)
    parser.add_argument("--strategy", default="dmmd", help="one that passes on opinions, such as dmvd")
    given = parser.parse_args()
    changes = {"robots.count": given.robots, "tasks.count": given.tasks, "decision.strategy": given.strategy}
    print(model_of(feasibee.Scenario().replace(changes)))


if __name__ == "__main__":
    main()

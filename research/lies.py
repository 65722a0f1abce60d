"""Search for the worst lie of Byzantine robots: the one with which swarms are right least often.

Byzantine robots know the truth, so tasks that are feasible and infeasible have a search each. Against a
built-in strategy, the lies are the values of faults.byzantine_says. Against a strategy in a file, random lies
are tried, too: they replace words of the robot's message by 0, by the largest value, or at random. The worst
lie is judged on fresh runs.
"""

from __future__ import annotations

import argparse
import json
import random
import tempfile
from pathlib import Path
from typing import Any

import feasibee

EXAMPLE = "example: python research/lies.py dmmd --liars 1"
SAYS = ("colluding", "opposite", "feasible", "infeasible", "random")
LIE = """

def toss(seed):
    bits = ((seed ^ seed >> 16) * 0x2C1B3C6D + 0x1B873593) & 0xFFFFFFFF
    bits = ((bits ^ bits >> 12) * 0x297A2D39) & 0xFFFFFFFF
    return bits ^ bits >> 15


def lie(message, feasible, me):
    own = me.setting.parameters
    kind, share, duty, most = own[FIRST], own[FIRST + 1], own[FIRST + 2], own[FIRST + 3]
    if toss(toss(me.id) ^ me.step & 0xFFFFFFFF) < duty * 4294967296.0:
        for k in range(len(message)):
            drawn = toss(toss(me.id + 977 * me.step & 0xFFFFFFFF) ^ 2 * k)
            if drawn < share * 4294967296.0:
                message[k] = 0 if kind < 1.0 else int(most) if kind < 2.0 else toss(drawn) % (int(most) + 1)
"""


def world(tasks: int, strategy: str, liars: int, changes: dict[str, Any]) -> feasibee.Scenario:
    """Return 20 robots, of which some lie."""
    scenario = feasibee.Scenario(
        robots={"know_count": True},
        tasks={"count": tasks},
        decision={"strategy": strategy},
        faults={"byzantine": {"count": liars}, "byzantine_says": "colluding"},
        run={"steps": 500, "stop_at_decision": False},
    )
    return scenario.replace(changes)


def right(scenario: feasibee.Scenario, runs: int, seed: int) -> int:
    """Return the number of swarms that are right at the end."""
    swarms = feasibee.simulate(scenario, runs, seed)
    held = swarms.feasible_at_end if feasibee.truth(scenario) else swarms.infeasible_at_end
    return int((held > scenario.decision.threshold * scenario.counted(scenario.run.steps)).sum())


def file_with_lie(strategy: Path, folder: Path, known: int) -> Path:
    """Write a strategy with a lie that four parameters describe, in place of its own."""
    own = feasibee.Scenario(robots={"know_count": True}, decision={"strategy": str(strategy)})
    parameters: dict[str, float] = dict(own.decision.parameters)
    lies = {"lie_kind": 0.0, "lie_share": 0.0, "lie_duty": 0.0, "lie_most": float(known)}
    names = f"\n\nFIRST = {len(parameters)}\nPARAMETERS = {parameters | lies!r}\n"
    path = folder / strategy.name
    text = strategy.read_text(encoding="utf-8").replace("def lie(", "def own_lie(")
    path.write_text(text + names + LIE, encoding="utf-8")
    return path


def lies_of(strategy: str, tasks: int, trials: int, chance: random.Random, folder: Path) -> list[Any]:
    """Return the lies to try, each with the strategy that tells it."""
    lies: list[Any] = [(strategy, {"faults.byzantine_says": says}) for says in SAYS]
    if strategy.endswith(".py"):
        swarm = feasibee.Swarm(world(tasks, strategy, 0, {}))
        swarm.advance(200)
        lying = str(file_with_lie(Path(strategy), folder, int(swarm.knowledge.max(initial=1))))
        for _ in range(trials):
            values = {"kind": float(chance.randrange(3)), "share": chance.random(), "duty": chance.random()}
            lies.append((lying, {f"decision.parameters.lie_{name}": each for name, each in values.items()}))
    return lies


def main() -> None:
    """Print how often swarms are right without liars, and with the worst lie on each side of the truth."""
    parser = argparse.ArgumentParser(description=__doc__, epilog=EXAMPLE)
    parser.add_argument("strategy", help="name, or a file that ends with .py")
    parser.add_argument("--liars", type=int, default=1)
    parser.add_argument("--trials", type=int, default=24, help="number of random lies on each side")
    parser.add_argument(
        "--runs", type=int, default=40, help="runs of each lie; ten times as many judge the worst"
    )
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    chance, found, fresh = random.Random(given.seed), {}, 10 * given.runs
    with tempfile.TemporaryDirectory() as folder:
        for side, tasks in (("feasible", 10), ("infeasible", 40)):
            lies = lies_of(given.strategy, tasks, given.trials, chance, Path(folder))
            worlds = [world(tasks, strategy, given.liars, changes) for strategy, changes in lies]
            counts = [right(each, given.runs, given.seed) for each in worlds]
            worst = counts.index(min(counts))
            alone, told = world(tasks, given.strategy, 0, {}), worlds[worst]
            found[side] = {
                "lie": lies[worst][1],
                "without": feasibee.wilson(right(alone, fresh, given.seed + 1), fresh)._asdict(),
                "right": feasibee.wilson(right(told, fresh, given.seed + 1), fresh)._asdict(),
            }
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()

"""Worlds drawn at random for the conformance suite: every field that the engine in C plays, and its edges."""

from __future__ import annotations

from random import Random

from feasibee import Scenario, ScenarioError

ROBOTS = (1, 2, 3, 5, 8, 15, 16, 17, 20, 31, 32, 33, 63, 64, 65, 96, 127, 128, 129, 140)
STRATEGIES = ("dmmd", "dmvd", "dc", "voter", "majority", "k-unanimity", "cross-inhibition", "bayes")
PARAMETERS = {
    "k-unanimity": {"k": (1.0, 2.0, 5.0)},
    "bayes": {"credence": (0.6, 0.99), "positive_feedback": (0.0, 1.0)},
}
OTHERS = {
    "robots.speed": (0.01, 0.37, 2.5),
    "robots.diameter": (0.5,),
    "robots.know_count": (True,),
    "walk.mean_run": (0.3, 1.0, 3.3, 50.0),
    "sensing.range": (0.05, 0.11, 0.3, 0.45, 0.5),  # in sides of the arena
    "sensing.count_self": (True,),
    "radio.range": (0.05, 0.2, 0.5),
    "decision.exploration": (1.0, 4.5, 40.0),
    "decision.gain": (0.5, 8.0, 60.0),
    "decision.dissemination_floor": (1, 7),
    "decision.quality_floor": (1, 4),
    "decision.listen": ("always", "dissemination"),
    "decision.inbox": ("latest-per-robot", "every-message"),
    "decision.own_vote": (False, True),
    "decision.ties": ("keep", "random-message"),
    "decision.start": ("first-sight",),
    "decision.threshold": (0.5, 0.77, 1.0),
    "run.stop_at_decision": (True,),
    "units.metres": (0.5,),
    "units.seconds": (0.1,),
}
"""Values of the fields that a world may change; the others are drawn for each."""


def world(number: int) -> Scenario:
    """Return one of endlessly many worlds: the same for a number at any time."""
    draw = Random(number)
    while True:
        try:
            return Scenario().replace(drawn(draw))
        except ScenarioError:  # some values don't go together
            continue


def drawn(draw: Random) -> dict[str, object]:
    """Return changes of the paper's scenario."""
    robots, strategy = draw.choice(ROBOTS), draw.choice(STRATEGIES)
    side = draw.choice((round(draw.uniform(4.0, 9.0) * robots**0.5, 2), 12.0))
    changes: dict[str, object] = {
        "robots.count": robots,
        "tasks.count": draw.choice((1, 2, robots, 2 * robots, draw.randint(1, 90))),
        "arena.side": side,
        "run.steps": draw.choice((1, 40, 90) if robots <= 40 else (1, 15)),  # the reference takes its time
        "decision.strategy": strategy,
        "decision.parameters": {
            name: draw.choice(values)
            for name, values in PARAMETERS.get(strategy, {}).items()
            if draw.random() < 0.7
        },
    }
    for path, values in OTHERS.items():
        if draw.random() < 0.3:
            value = draw.choice(values)
            changes[path] = value * side if path.endswith("range") else value
    return changes

"""The lesson: a page that one scrolls, whose figures ask for a prediction and then simulate."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final, NamedTuple

from feasibee.base.files import write_text
from feasibee.live.packet import wasm_of
from feasibee.live.page import filled
from feasibee.live.scene import simulated_of
from feasibee.scenario.feasibility import truth
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario

TITLE: Final = "Can these robots do it? A lesson with swarms"
SEED: Final = 1
DECISIONS: Final = [["feasible", 1], ["infeasible", 0], ["undecided", -1]]
"""What a swarm may decide, as its outcomes have it."""
HOW_MANY: Final = "How many of 100 such swarms decide rightly?"


class Figure(NamedTuple):
    """A question about swarms, and how long the page shows one of them."""

    asks: str
    question: str
    scenario: Scenario
    choices: list[list[Any]] = []  # noqa: RUF012  # never changed
    lasts: int = 1000
    variants: tuple[Scenario, ...] = ()


def figures() -> dict[str, Figure]:
    """Return the figures of the lesson by the ids of their places in ``lesson.html``."""
    many = Scenario(tasks={"count": 50}, run={"stop_at_decision": True})
    scarce = many.replace({"tasks.count": 22})
    few = many.replace({"tasks.count": 10, "arena.boundary": "walls"})
    walls = [[[9.9, y], [10.1, y], [10.1, y + 9.0], [9.9, y + 9.0]] for y in (0.0, 11.0)]
    named = scarce.replace({"decision.strategy": "quiet-census", "robots.know_count": True})
    lied_to = {"tasks.count": 20, "faults.byzantine": {"count": 1}, "faults.byzantine_says": "colluding"}
    bears = {**lied_to, "decision.parameters": {"tolerates": 1}}
    sight = [["fewer than 5", 4], ["5 to 15", 15], ["more than 15", 50]]
    at_once = named.replace({"tasks.count": 21, "acting.start": 0})
    return {
        "enough": Figure("decision", "What will this swarm decide?", many, DECISIONS),
        "one": Figure("sight", "How many tasks does the ringed robot see in 10 steps?", many, sight, 10),
        "near": Figure("share", HOW_MANY, scarce),
        "names": Figure("share", HOW_MANY, named),
        "lies": Figure("share", HOW_MANY, named.replace(lied_to)),
        "bears": Figure("share", HOW_MANY, named.replace(bears)),
        "hall": Figure("share", HOW_MANY, few),
        "rooms": Figure("share", HOW_MANY, few.replace({"place.walls": walls})),
        "start": Figure("share", HOW_MANY, at_once),
        "ask": Figure("share", HOW_MANY, at_once.replace({"acting.start": "safe"})),
        "free": Figure("free", "", scarce, variants=(scarce, named)),
    }


def lesson() -> str:
    """Return the lesson as HTML."""
    asked = {name: _asked(figure) for name, figure in figures().items()}
    return filled("lesson", TITLE, "lesson", {"wasm": wasm_of(Scenario()), "figures": asked})


def write_lesson(out: Path) -> None:
    """Write the lesson to a file; after an error, the previous file is unchanged."""
    write_text(out, lesson())


def _asked(figure: Figure) -> dict[str, Any]:
    """Return a figure as lesson.js takes it."""
    scenario = figure.scenario
    own = {**figure._asdict(), "right": int(truth(scenario))}
    del own["scenario"], own["variants"]
    return {**simulated_of(scenario, Runs(100, SEED, 0), figure.variants or [scenario]), **own}

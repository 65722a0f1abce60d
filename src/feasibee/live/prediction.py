"""What the theory says of a page's swarms: the curve behind theirs, where opinions tip, and sentences."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Any, Final

from feasibee.base.errors import Problem, ScenarioError
from feasibee.scenario.scenario import Scenario
from feasibee.theory.predict import Prediction, even_tasks, predict

ROBOTS_LIMIT: Final = 200
"""Most robots of a prediction, which takes about a second then."""
STEPS_LIMIT: Final = 10_000
"""Most steps of a prediction."""
CURVE_LIMIT: Final = 2000
"""Most steps of a curve."""


@lru_cache(maxsize=16)
def prediction_of(scenario: Scenario) -> dict[str, Any]:
    """Return what types.d.ts calls Prediction: what the theory says, or a text that says why it doesn't."""
    robots, steps = scenario.robots.count, min(scenario.run.steps, STEPS_LIMIT)
    try:
        if robots > ROBOTS_LIMIT:
            rule = f"pages predict up to {ROBOTS_LIMIT} robots"
            raise ScenarioError([Problem("robots.count", robots, rule, "use feasibee predict for more")])
        if any(scenario.faulty):
            rule = "pages draw no prediction of swarms with faulty robots"
            raise ScenarioError([Problem("faults", "set", rule, "use feasibee predict")])
        found = predict(scenario.replace({"run.steps": steps}))
    except ScenarioError as error:
        return {"text": f"No predicted curve: {error.problems[0]}."}
    opinions = found.opinions[: CURVE_LIMIT + 1].round(3)
    moving = (abs(opinions - opinions[-1]) > 0.001).any(1).nonzero()[0]  # a pixel is more
    return {
        "text": " ".join(_sentences(found, even_tasks(scenario))),
        "opinions": opinions[: 2 + int(max(moving, default=-1))].tolist(),
    }


def _sentences(found: Prediction, tasks: int | None) -> Iterator[str]:
    """Yield what a page says of a prediction."""
    yes, no = (f"{100 * each:.0f}" for each in (found.feasible, found.infeasible))
    yield (
        f"Theory: by step {len(found.by_step) - 1:,}, {yes} % of such swarms decide feasible and {no} % "
        f"infeasible (tested error: {100 * found.error:.2g} percentage points)."
    )
    if found.tipping is not None:
        yield f"Opinions tip where {100 * found.tipping.point:.0f} % are feasible."
    if tasks is not None:
        yield f"Up to {tasks} tasks, most swarms decide feasible."
    yield from (f"Warning: {each}." for each in found.warnings)

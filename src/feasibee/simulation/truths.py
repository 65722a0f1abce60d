"""The ground truth of a step in a world that changes."""

from __future__ import annotations

from feasibee.scenario.feasibility import Verdict, explain
from feasibee.scenario.runs import Runs, check_integer
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.ensemble import check_scenario
from feasibee.simulation.swarm import Swarm


def truth_at(scenario: Scenario, step: int, seed: int = 0, run: int = 0) -> Verdict:
    """Return the ground truth of one step of a run, with its proof.

    Parameters
    ----------
    scenario : Scenario
        The swarm and its world. If its world doesn't change, no run is simulated.
    step : int
        Step of the run, 0 to ``scenario.run.steps``.
    seed, run : int
        Seed and number of the run.

    Returns
    -------
    Verdict
        Whether the robots of the step can do the tasks of the step (model.md 6.17.3), as ``explain`` returns.

    Raises
    ------
    FeasibeeError
        If an argument is invalid.

    Examples
    --------
    >>> import feasibee
    >>> scenario = feasibee.Scenario(events=[{"step": 300, "tasks": 5}])
    >>> feasibee.truth_at(scenario, 299).feasible, feasibee.truth_at(scenario, 300).feasible
    (True, False)
    """
    scenario, which = check_scenario(scenario), Runs.single(seed, run)
    step = check_integer("step", step, 0, scenario.run.steps)
    if not scenario.dynamic:
        return explain(scenario)
    swarm = Swarm(scenario, which.seed, which.first)
    swarm.advance(step)
    return swarm.verdict

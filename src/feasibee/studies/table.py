"""A comparison of strategies as one table: the public `feasibee.compare`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from feasibee.scenario.scenario import Scenario
from feasibee.studies import comparison

if TYPE_CHECKING:
    import pandas as pd


def compare(
    scenario: Scenario,
    strategies: Sequence[str] = (),
    tasks: Sequence[int] = (),
    runs: int = 200,
    seed: int = 0,
) -> pd.DataFrame:
    """Compare strategies on the same worlds: run r starts from the same places for all of them.

    Parameters
    ----------
    scenario : Scenario
        What all strategies have in common.
    strategies : sequence of str
        Names or files; by default all built-in strategies that the scenario supports.
    tasks : sequence of int
        Numbers of tasks; by default that of the scenario.
    runs, seed : int
        Number of runs of each strategy with each number of tasks, and their seed.

    Returns
    -------
    pandas.DataFrame
        A row for each strategy (``contender``) and number of tasks. ``accuracy`` is the share of runs that
        are right at the last step, with the ends of its 95 % interval. The other columns are those of
        ``compare.csv``, which ``feasibee compare`` writes.

    Raises
    ------
    FeasibeeError
        If a strategy is unknown or named twice, or a number is invalid.

    Examples
    --------
    >>> import feasibee
    >>> table = feasibee.compare(feasibee.Scenario(), ["dmmd", "census"], tasks=[10, 40], runs=20, seed=1)
    >>> table.groupby("contender").accuracy.mean().round(2).to_dict()
    {'census': 1.0, 'dmmd': 0.78}
    """
    import pandas as pd

    found = comparison.compare(comparison.contenders_of(scenario, strategies), tasks, runs, seed)
    return pd.DataFrame(comparison.rows_of(found))

"""The page in a notebook: HTML in a frame, which also a saved notebook shows, without a kernel."""

from __future__ import annotations

from html import escape

from feasibee.live.page import page_of
from feasibee.scenario.scenario import Scenario


class Arena:
    """A page that simulates swarms, for notebooks: the last line of a cell shows it.

    Parameters
    ----------
    scenario : Scenario, optional
        Scenario to begin with; by default the paper's swarm with 20 tasks.
    seed, run : int
        Seed and number of the run; the same steps as in `Swarm` and `simulate`.
    height : int
        Height of the frame in pixels.

    Raises
    ------
    ScenarioError
        If a page can't simulate the scenario, with all reasons.
    FeasibeeError
        If seed or run is out of range.

    Examples
    --------
    >>> import feasibee
    >>> from feasibee.live.widget import Arena
    >>> arena = Arena(feasibee.Scenario(tasks={"count": 50}), seed=1)
    """

    def __init__(
        self, scenario: Scenario | None = None, seed: int = 0, run: int = 0, height: int = 800
    ) -> None:
        self._page = page_of(Scenario() if scenario is None else scenario, seed, run)
        self._height = int(height)

    def _repr_html_(self) -> str:
        """Return a frame with the page, whose scripts reach nothing of the notebook."""
        return (
            f'<iframe title="feasibee: a swarm" sandbox="allow-scripts" srcdoc="{escape(self._page)}" '
            f'style="width: 100%; height: {self._height}px; border: 0"></iframe>'
        )

"""The arena in a notebook: the page's canvas code, and the kernel in place of the server.

A view asks for each step when it needs it, and gets a frame of `feasibee.live.messages`; so nothing queues
up, and a view that nobody plays costs nothing. Needs the extra ``widget``.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Final

from feasibee.errors import FeasibeeError, Problem, how_to_install
from feasibee.live.messages import frame_of, tasks_of
from feasibee.scenario.feasibility import truth
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.swarm import Swarm

try:
    import anywidget
    import traitlets
except ModuleNotFoundError as error:
    if (error.name or "").split(".")[0] not in ("anywidget", "traitlets"):
        raise
    raise FeasibeeError(f"anywidget: not installed; {how_to_install('widget')}") from None

STATIC: Final = Path(__file__).parent / "static"
MODULES: Final = ("frames", "crowd", "arena", "player", "widget")
"""Of the page, each after those that it imports."""
SWARMS_LIMIT: Final = 8
"""Swarms that are kept: one for each view and restart. One that is asked for again is played again."""


def joined_modules() -> str:
    """Return the page's modules as one, which is what a widget is made of."""
    texts = ((STATIC / f"{name}.js").read_text("utf-8") for name in MODULES)
    return "\n".join(re.sub(r"(?m)^import [^;]+;\n|^export (?!default)", "", text) for text in texts)


class Arena(anywidget.AnyWidget):
    """The arena of one run, to play in a notebook: the last line of a cell shows it.

    Parameters
    ----------
    scenario : Scenario, optional
        By default the paper's swarm with 20 tasks.
    seed, run : int
        Which run: the same steps as of `Swarm`, which they share with `simulate`.

    Attributes
    ----------
    step : int
        Where a view begins, and where one was last at rest.
    speed : int
        Steps a second, 1 to 3000.

    Raises
    ------
    FeasibeeError
        If there is no such run.

    Examples
    --------
    >>> import feasibee
    >>> from feasibee.live.widget import Arena
    >>> arena = Arena(feasibee.Scenario(tasks={"count": 50}), seed=1)
    >>> arena.speed = 60
    """

    _esm = joined_modules()
    _world = traitlets.Dict().tag(sync=True)
    _tasks = traitlets.Bytes().tag(sync=True)
    step = traitlets.Int(0, min=0).tag(sync=True)
    speed = traitlets.Int(20, min=1, max=3000).tag(sync=True)

    def __init__(self, scenario: Scenario | None = None, seed: int = 0, run: int = 0) -> None:
        swarm = Swarm(scenario, seed, run)
        self._which = (swarm.scenario, seed, run)
        self._swarms: dict[str, Swarm] = {}
        super().__init__(_world=_world_of(swarm.scenario), _tasks=tasks_of(swarm, 0))
        self.on_msg(self._answer)

    def _answer(self, _: Arena, asked: Any, __: Any) -> None:
        """Send a view the step that it asks for."""
        last = self._which[0].run.steps
        match asked:
            case {"swarm": str(name), "step": int(step)} if 0 <= step <= last:
                self.send({"swarm": name}, [frame_of(self._swarm_at(name, step), 0, step + 1)])
            case _:
                rule = f"must be {{swarm: name, step: 0 to {last}}}"
                self.send({"problem": str(Problem("message", asked, rule, "run this cell again"))})

    def _swarm_at(self, name: str, step: int) -> Swarm:
        """Return a view's swarm at a step; time only goes forward, so one that is beyond begins anew."""
        swarm = self._swarms.pop(name, None)
        if swarm is None or swarm.step > step:
            swarm = Swarm(*self._which)
        swarm.advance(step - swarm.step)
        self._swarms[name] = swarm  # the latest is the last
        while len(self._swarms) > SWARMS_LIMIT:
            del self._swarms[next(iter(self._swarms))]
        return swarm


def _world_of(scenario: Scenario) -> dict[str, Any]:
    """Return what a view is told of the world, in the page's words."""
    return {
        "size": list(scenario.arena.size),
        "walls": scenario.arena.boundary == "walls",
        "diameter": scenario.robots.diameter,
        "sight": scenario.sensing.range,
        "radio": scenario.radio.range,
        "robots": scenario.robots.count,
        "tasks": scenario.tasks.count,
        "truth": truth(scenario),
        "last": scenario.run.steps,
    }

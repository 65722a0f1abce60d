"""The arena in a notebook: the canvas code of the page, with the kernel in place of the server.

A view requests each step when it needs it, and receives a frame of `feasibee.live.messages`. So nothing
queues up, and a view at rest costs nothing. Needs the extra ``widget``.
"""

from __future__ import annotations

from typing import Any, Final

from feasibee.errors import FeasibeeError, Problem, how_to_install
from feasibee.live.lane import ROOM, Lane
from feasibee.live.messages import encode_frame, encode_tasks, problems_of
from feasibee.live.page import joined
from feasibee.live.reasons import sentence_of
from feasibee.live.scene import scene_of
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.swarm import Swarm
from feasibee.strategies import STRATEGIES

try:
    import anywidget
    import traitlets
except ModuleNotFoundError as error:
    if (error.name or "").split(".")[0] not in ("anywidget", "traitlets"):
        raise
    raise FeasibeeError(f"anywidget: not installed; {how_to_install('widget')}") from None

SWARMS_LIMIT: Final = 8
"""Most swarms in memory, one per view and restart; a dropped one is simulated again when it is needed."""


class Arena(anywidget.AnyWidget):
    """An interactive view of one run for notebooks: the last line of a cell shows it.

    Parameters
    ----------
    scenario : Scenario, optional
        Scenario to simulate; by default the paper's swarm with 20 tasks.
    seed, run : int
        Seed and number of the run; the same steps as in `Swarm` and `simulate`.

    Attributes
    ----------
    step : int
        Step at which a view begins, and at which one last stopped.
    speed : int
        Steps per second, 1 to 3000.
    changes : dict
        What its sliders have changed, by dotted path; ``scenario.replace(arena.changes)`` has them, too.

    Raises
    ------
    FeasibeeError
        If seed or run is out of range.

    Examples
    --------
    >>> import feasibee
    >>> from feasibee.live.widget import Arena
    >>> arena = Arena(feasibee.Scenario(tasks={"count": 50}), seed=1)
    >>> arena.speed = 60
    """

    _esm = joined("widget")  # anywidget takes a single module
    _world = traitlets.Dict().tag(sync=True)
    _strategies = traitlets.List([*STRATEGIES]).tag(sync=True)
    changes = traitlets.Dict().tag(sync=True)
    step = traitlets.Int(0, min=0).tag(sync=True)
    speed = traitlets.Int(20, min=1, max=3000).tag(sync=True)

    def __init__(self, scenario: Scenario | None = None, seed: int = 0, run: int = 0) -> None:
        swarm = Swarm(scenario, seed, run)
        self._which = (swarm.scenario, seed, run)
        self._lanes: dict[str, Lane] = {}
        super().__init__(_world=scene_of(swarm.scenario) | {"last": swarm.scenario.run.steps})
        self.on_msg(self._answer)

    def _answer(self, _: Arena, asked: Any, __: Any) -> None:
        """Send a view the step that it requests, and why a robot holds its opinion; -1 is none."""
        last = self._which[0].run.steps
        match asked:
            case {"swarm": str(name), "step": int(step), "robot": int(robot)} if 0 <= step <= last:
                opens = name not in self._lanes
                try:
                    lane = self._lane_at(name, step, asked.get("changes"))
                except FeasibeeError as error:
                    self.send({"swarm": name, "problems": problems_of(error)["problems"]})
                    return
                swarm, is_there = lane.swarm, 0 <= robot < lane.swarm.present.size
                world = {"world": lane.opened()} if opens else {}
                why = {"why": [robot, sentence_of(swarm, robot, lane.history)]} if is_there else {}
                buffers = [encode_frame(swarm, 0, step + 1), *([encode_tasks(swarm, 0)] if opens else [])]
                self.send({"swarm": name, **world, **why}, buffers)
            case _:
                rule = f"must be {{swarm: name, step: 0 to {last}, robot: number}}"
                self.send({"problem": str(Problem("message", asked, rule, "run this cell again"))})

    def _lane_at(self, name: str, step: int, changes: dict[str, Any] | None) -> Lane:
        """Return the swarm of a view, of a scenario with changes, at a step."""
        scenario, seed, run = self._which
        lane = self._lanes.pop(name, None)
        if lane is None:
            lane = Lane(0, scenario.replace(changes) if changes else scenario, seed, run, ROOM)
        lane.timeline.rewind(step)
        lane.timeline.advance(step)
        self._lanes[name] = lane  # last: the first is dropped below
        while len(self._lanes) > SWARMS_LIMIT:
            del self._lanes[next(iter(self._lanes))]
        return lane

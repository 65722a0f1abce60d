"""The session of one page that watches a field: its steps come from processes instead of a simulation."""

from __future__ import annotations

from typing import Any, Final, NoReturn

import numpy as np

from feasibee.errors import FeasibeeError
from feasibee.live.fieldsteps import View
from feasibee.live.fieldview import SILENCE, FieldView
from feasibee.live.layout import TASKS
from feasibee.live.messages import Look, Open, encode_step
from feasibee.live.outlook import nothing_ahead
from feasibee.live.scene import Step
from feasibee.scenario.runs import check_integer
from feasibee.simulation.snapshot import FLAGS

NO_OUTLOOK: Final = "a field shows only what has happened"
NAMED: Final = 10
"""Most silent robots that are named."""


class FieldCatalogue:
    """What the pages of ``feasibee watch --field`` offer: one field, and nothing to choose.

    Parameters
    ----------
    view : FieldView
        The field; it has answered.
    """

    def __init__(self, view: FieldView) -> None:
        self.view = view

    def to_dict(self) -> dict[str, Any]:
        """Return the catalogue as a page receives it, in the message ``welcome``."""
        nothing: dict[str, Any] = {"strategies": [], "stream": {}, "replays": [], "found": 0, "pick": ""}
        scene = self.view.field.scene
        numbers = {"seed": str(scene["seed"]), "run": str(scene["run"]), "point": None}
        return {"title": f"field at {self.view.address}", **nothing, **numbers}

    def session(self) -> FieldSession:
        """Return the session of a page."""
        return FieldSession(self.view)


class FieldSession:
    """What one page shows of a field.

    Parameters
    ----------
    view : FieldView
        The field.
    """

    def __init__(self, view: FieldView) -> None:
        self._view = view
        self._field = view.field
        self.step = 0
        self._generation = self._jump = self._counts_sent = 0
        self._robot: int | None = None
        self._told: dict[str, Any] = {}

    def request_of(self, asked: Open) -> None:
        """Return nothing: a page can't choose another field."""

    def begin(self, request: object) -> None:
        """Wait for the field's first step, and show its newest one.

        Raises
        ------
        FeasibeeError
            If the field falls silent before.
        """
        while not (field := self._view.field).views:
            self._view.wait_for(field, 0, 0.5)
            if self._view.is_silent:
                raise FeasibeeError(f"{self._view.address}: silent for {SILENCE:g} s; start the field again")
        self._field = field
        self.step = self._field.latest
        self._generation += 1
        self._jump, self._counts_sent, self._robot, self._told = 0, self._field.first, None, {}

    @property
    def last(self) -> int:
        """The last step of the field, if it doesn't end before."""
        return min(int(self._field.scene["steps"]), 2**31 - 1)

    def advance(self, step: int, seconds: float) -> bool:
        """Stay at the step that is shown; return that it is reached."""
        return True

    def rewind(self, step: int, jump: int) -> None:
        """Go to a step that was received, or to the nearest one; number the frames anew."""
        self.step, self._jump = self._field.at(step).step, jump

    def lane(self, number: int) -> NoReturn:
        """Raise: a page finds the decision of a field among the steps received."""
        raise FeasibeeError(f"message: {NO_OUTLOOK}; reload the page")

    def inspect(self, robot: int | None) -> None:
        """Send what a robot last reported with each frame from now on.

        Raises
        ------
        FeasibeeError
            If there is no such robot.
        """
        if robot is not None:
            check_integer("robot", robot, 0, len(self._field.scene["faults"]) - 1)
        self._robot = robot

    def look(self, asked: Look, seconds: float) -> dict[str, Any]:
        """Return that a field can't be looked ahead in."""
        found = nothing_ahead(asked.robot, asked.first, asked.seen, NO_OUTLOOK)
        return {"lane": asked.lane, **found, "generation": self._generation & 0xFFFF, "jump": self._jump}

    def next_messages(self, steps: int, seconds: float) -> list[dict[str, Any] | bytes]:
        """Wait for the next step for a limited time; return its messages, or those of this one again.

        If another field has begun, return a message that says so; the page opens it then.
        """
        self._view.wait_for(self._field, self.step + 1, seconds)
        if self._view.field is not self._field and self._view.field.views:
            return [{"type": "another"}]
        self.step = max(self.step, self._field.at(self.step + steps).step)
        return self.messages()

    def messages(self) -> list[dict[str, Any] | bytes]:
        """Return the messages of the current step; the frame comes last."""
        view = self._field.at(self.step)
        found: list[dict[str, Any] | bytes] = []
        told = self._state(view)
        if told != self._told:
            self._told = told
            found.append(told)
        if self._robot is not None:
            found.append(self._robot_message(view, self._robot))
        return [*found, self._frame(view)]

    def openings(self) -> list[dict[str, Any] | bytes]:
        """Return the messages with which a page begins: the field, and the positions of the tasks."""
        places = np.array(self._field.scene["tasks"], np.uint16).reshape(-1, 2)
        x, y = places.T
        tasks = TASKS.encode(generation=self._generation & 0xFFFF, count=len(places), x=x, y=y)
        return [self._opened(), tasks]

    def _opened(self) -> dict[str, Any]:
        scene = self._field.scene
        robots, tasks, faults = scene["robots"], len(scene["tasks"]), scene["faults"]
        fields = {f"faults.{each}": faults.count(each) for each in ("stopped", "byzantine")}
        same = ("strategy", "size", "walls", "diameter", "sight", "radio", "threshold", "truth", "kinds")
        return {
            "type": "opened",
            "lane": 0,
            "swarms": 1,
            "generation": self._generation & 0xFFFF,
            "jump": self._jump,
            "field": {"address": self._view.address, "hz": scene["hz"]},
            **{name: scene[name] for name in (*same, "commits", "declares")},
            "seed": str(scene["seed"]),
            "run": str(scene["run"]),
            "last": self.last,
            "fields": {**fields, "units.seconds": scene["seconds"]},
            "toml": "",
            "proof": f"{robots:,} robots, {tasks:,} tasks",
            "changes": scene["changes"],
            "robots": robots,
            "numbers": len(faults),
            "tasks": tasks,
            "robotClasses": scene["classes"],
            "step": self.step,
        }

    def _state(self, view: View) -> dict[str, Any]:
        """Return the message that says how the field is: who is silent, and whether it goes on."""
        problems = [_silent(view.lost)] if view.lost else []
        if view.is_cut:
            problems.append("the radio is cut between the two halves of the robots")
        if self._view.is_silent:
            problems.append(
                f"the field at {self._view.address} has been silent for more than {SILENCE:g} s; "
                "this page shows the next field that starts there"
            )
        end = self._field.latest if self._field.has_ended else None
        return {
            "type": "field",
            "problems": problems,
            "silent": self._view.is_silent,
            "end": end,
            "first": self._field.views[0].step,
        }

    def _robot_message(self, view: View, robot: int) -> dict[str, Any]:
        flags = int(view.shown.flags[robot])
        having = {name for bit, name in enumerate(FLAGS) if flags >> bit & 1}
        opinion = "none" if "neutral" in having else "feasible" if "feasible" in having else "infeasible"
        phase = "disseminating" if "disseminating" in having else "exploring"
        special = [each for each in ("byzantine", "stubborn", "committed", "declared") if each in having]
        words = [["Phase", phase], ["Opinion", opinion]]
        if robot in view.lost:
            words = [["Process", "silent: the robot isn't counted, and its body stands still"]]
        elif "there" not in having:
            words = [["Phase", "not there"]]
        elif "working" not in having:
            words = [["Phase", "stopped"]]
        words += [["Special", ", ".join(special)]] if special else []
        words.append(["Knows", "the robot's own log has it: feasibee launch --out FOLDER"])
        mark = {"generation": self._generation & 0xFFFF, "jump": self._jump}
        return {"type": "robot", "lane": 0, "step": view.step, "robot": robot, "reasons": words, **mark}

    def _frame(self, view: View) -> bytes:
        first = self._counts_sent
        counts = self._field.counts(first, view.step + 1)
        self._counts_sent = first + len(counts)
        changes, tasks = self._field.scene["changes"], self._field.scene["tasks"]
        step = Step(
            view.step,
            view.shown,
            view.counts,
            view.declared,
            view.decision,
            len(view.tasks if changes else tasks),
            view.tasks,
            view.truth,
        )
        return encode_step(step, counts, self._generation, first, jump=self._jump)


def _silent(lost: tuple[int, ...]) -> str:
    """Return in words which robots are silent."""
    if len(lost) == 1:
        return f"robot {lost[0]} is silent"
    named = list(map(str, lost[:NAMED]))
    rest = f"{len(lost) - NAMED} more" if len(lost) > NAMED else named.pop()
    return f"robots {', '.join(named)} and {rest} are silent"

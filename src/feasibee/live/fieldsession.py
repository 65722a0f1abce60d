"""The session of one page that watches a field: its steps come from the log of its world."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any, Final, NoReturn

import numpy as np

from feasibee.errors import FeasibeeError
from feasibee.field.plan import numbers_in_words
from feasibee.live.lane import opening
from feasibee.live.messages import Look, Open, encode_frame, encode_tasks
from feasibee.live.scene import Logged
from feasibee.scenario.runs import check_integer
from feasibee.simulation.snapshot import FLAGS

NO_OUTLOOK: Final = "a field shows only what has happened"
SILENCE: Final = 5.0
"""Seconds without a step after which a field is silent."""
POLL: Final = 0.02
"""Seconds between two looks into the log."""


class FieldCatalogue:
    """What the pages of a field offer: the field that writes its logs in a folder, and nothing to choose."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._which = Logged(folder).which  # raises if it isn't a field's

    def to_dict(self) -> dict[str, Any]:
        """Return the catalogue as a page receives it, in the message ``welcome``."""
        nothing: dict[str, Any] = {"strategies": [], "stream": {}, "replays": [], "found": 0, "pick": ""}
        numbers = {"seed": str(self._which.seed), "run": str(self._which.first), "point": None}
        return {"title": f"field in {self.folder}", **nothing, **numbers}

    def session(self) -> FieldSession:
        """Return the session of a page."""
        return FieldSession(self.folder)


class FieldSession:
    """What one page shows of the field that writes its logs in a folder."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._field = Logged(folder)
        self._heard_at = time.monotonic()
        self._generation = self._jump = self._counts_sent = 0
        self._robot: int | None = None
        self._told: dict[str, Any] = {}

    def begin(self, asked: Open) -> int:
        """Wait for the field's first step; return the step to show, whatever the page asks for.

        It is the newest one, or the first one of a field that has ended. Raise a FeasibeeError if the log is
        damaged, or the field falls silent before.
        """
        self._field, self._heard_at = Logged(self._folder), time.monotonic()
        while self._field.last < 0:
            self._follow(0, 0.5)
            if self._is_silent:
                raise FeasibeeError(f"{self._folder}: no step for {SILENCE:g} s; start the field again")
        self._field.step = 0 if self._field.has_ended else self._field.last
        self._generation += 1
        self._jump, self._counts_sent, self._robot, self._told = 0, 0, None, {}
        return self.step

    @property
    def step(self) -> int:
        """The step that the page has reached."""
        return self._field.step

    @property
    def last(self) -> int:
        """The last step of the field, if it doesn't end before."""
        return min(self._field.scenario.run.steps, 2**31 - 1)

    def advance(self, step: int, seconds: float) -> bool:
        """Stay at the step that is shown; return that it is reached."""
        return True

    def rewind(self, step: int, jump: int) -> None:
        """Go to a step that was logged, or to the last one; number the frames anew."""
        self._field.step, self._jump = min(step, self._field.last), jump

    def lane(self, number: int) -> NoReturn:
        """Raise: a page finds the decision of a field among the steps received."""
        raise FeasibeeError(f"message: {NO_OUTLOOK}; reload the page")

    def inspect(self, robot: int | None) -> None:
        """Send what a robot last reported with each frame from now on.

        Raise a FeasibeeError if there is no such robot.
        """
        if robot is not None:
            check_integer("robot", robot, 0, self._field.scenario.most.robots - 1)
        self._robot = robot

    def look(self, asked: Look, seconds: float) -> dict[str, Any]:
        """Return that a field can't be looked ahead in."""
        return self._marked(asked.nothing(NO_OUTLOOK))

    def next_messages(self, steps: int, seconds: float) -> list[dict[str, Any] | bytes]:
        """Wait for the next step for a limited time; return its messages, or those of this one again.

        If another field has begun, return a message that says so; the page opens it then.
        """
        if not self._follow(self.step + 1, seconds):
            return [{"type": "another"}]
        self._field.step = min(self.step + steps, self._field.last)
        return self.messages()

    def _follow(self, step: int, seconds: float) -> bool:
        """Wait until a step is logged, for a limited time; return whether the field is still the same."""
        until = time.monotonic() + seconds
        while True:
            before = self._field.last
            if not self._field.grow():
                return False
            if self._field.last > before:
                self._heard_at = time.monotonic()
            if self._field.last >= step or self._field.has_ended or time.monotonic() > until:
                return True
            time.sleep(POLL)

    @property
    def _is_silent(self) -> bool:
        """Whether the field says nothing any more, though it hasn't ended."""
        return not self._field.has_ended and time.monotonic() - self._heard_at > SILENCE

    def messages(self) -> list[dict[str, Any] | bytes]:
        """Return the messages of the current step; the frame comes last."""
        found: list[dict[str, Any] | bytes] = []
        told = self._state()
        if told != self._told:
            self._told = told
            found.append(told)
        if self._robot is not None:
            found.append(self._robot_message(self._robot))
        first, self._counts_sent = self._counts_sent, max(self._counts_sent, self.step + 1)
        return [*found, encode_frame(self._field, self._generation, first, jump=self._jump)]

    def openings(self) -> list[dict[str, Any] | bytes]:
        """Return the messages with which a page begins: the field, and the positions of the tasks."""
        field = self._field
        about = {"address": str(self._folder), "hz": field.hz}
        which = (field.scenario, field.which.seed, field.which.first)
        opened = {**opening(*which, field.robot_kinds, self.last), "step": self.step, "field": about}
        return [self._marked({"lane": 0, "swarms": 1, **opened}), encode_tasks(field, self._generation)]

    def _marked(self, message: dict[str, Any]) -> dict[str, Any]:
        return {**message, "generation": self._generation & 0xFFFF, "jump": self._jump}

    def _state(self) -> dict[str, Any]:
        """Return the message that says how the field is: who is silent, and whether it goes on."""
        lost = np.flatnonzero(self._field.lost).tolist()
        problems = []
        if lost:
            one, verb = ("robot", "is") if len(lost) == 1 else ("robots", "are")
            problems.append(f"{one} {numbers_in_words(lost)} {verb} silent")
        if self._field.cuts_at(self.step):
            problems.append("the radio is cut between the two halves of the robots")
        if self._is_silent:
            problems.append(
                f"the field in {self._folder} has logged nothing for more than {SILENCE:g} s; "
                "this page shows the next one that writes there"
            )
        end = self._field.last if self._field.has_ended else None
        return {"type": "field", "problems": problems, "silent": self._is_silent, "end": end, "first": 0}

    def _robot_message(self, robot: int) -> dict[str, Any]:
        flags = int(self._field.snapshot().flags[robot])
        having = {name for bit, name in enumerate(FLAGS) if flags >> bit & 1}
        opinion = "none" if "neutral" in having else "feasible" if "feasible" in having else "infeasible"
        phase = "disseminating" if "disseminating" in having else "exploring"
        special = [each for each in ("byzantine", "stubborn", "declared") if each in having]
        words = [["Phase", phase], ["Opinion", opinion]]
        if self._field.lost[robot]:
            words = [["Process", "silent: the robot isn't counted, and its body stands still"]]
        elif "there" not in having:
            words = [["Phase", "not there"]]
        elif "working" not in having:
            words = [["Phase", "stopped"]]
        if (aim := self._field.acting.aims[robot]) >= 0:
            does = "stands at" if "standing" in having else "walks to"
            words.append(["Acts", f"{does} task {self._field.task_numbers[aim]}"])
        words += [["Special", ", ".join(special)]] if special else []
        words.append(["Knows", "the robot's own log has it"])
        return self._marked({"type": "robot", "lane": 0, "step": self.step, "robot": robot, "reasons": words})

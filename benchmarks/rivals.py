"""Other programs for the paper's swarm: a loop over all pairs in numba, Mesa, and C written by hand."""

from __future__ import annotations

import atexit
import math
import shutil
import subprocess
import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from measure import Sample, seconds
from worlds import PAPER_ROBOTS, PAPER_STEPS, PAPER_TASKS, SPACE_PER_ROBOT

SOURCE = Path(__file__).parent / "by_hand.c"


def brute_force_sample(
    runs: int, robots: int = PAPER_ROBOTS, tasks: int = PAPER_TASKS, steps: int = PAPER_STEPS
) -> Sample:
    """Return a sample of the loop over all pairs, in ns of CPU time per robot-step."""
    import brute_force  # numba takes 0.5 s, and tests of the rest don't need it

    side, robot_steps = math.sqrt(SPACE_PER_ROBOT * robots), robots * steps * runs

    def play() -> object:
        return brute_force.simulate(runs, 1, robots, tasks, steps, side)

    return Sample(
        lambda: brute_force.simulate(1, 1, 2, 2, 1, side), lambda: 1e9 * seconds(play) / robot_steps
    )


def has_mesa() -> bool:
    """Return whether Mesa is installed."""
    return find_spec("mesa") is not None


def mesa_sample(robots: int = PAPER_ROBOTS, tasks: int = PAPER_TASKS, steps: int = PAPER_STEPS) -> Sample:
    """Return a sample of the steps of one run in Mesa, in ns of CPU time per robot-step."""
    import mesa_model

    def take() -> float:
        model = mesa_model.FeasibilityModel(robots, tasks, math.sqrt(SPACE_PER_ROBOT * robots), seed=1)
        model.step()  # builds the arrays of the space
        return 1e9 * seconds(lambda: [model.step() for _ in range(steps)]) / (robots * steps)

    return Sample(lambda: mesa_model.play(steps=1), take)


class Played(NamedTuple):
    """What `by_hand.c` prints of some runs."""

    ns: float
    feasible: int
    infeasible: int
    quartiles: tuple[int, int, int]


class ByHand:
    """The program in C, compiled for this machine; ``why`` says why it isn't, if so."""

    def __init__(self) -> None:
        folder = tempfile.TemporaryDirectory()
        atexit.register(folder.cleanup)
        self.program = Path(folder.name) / "by_hand"
        self.why = self._compile()

    def _compile(self) -> str:
        compiler = shutil.which("cc")
        if compiler is None:
            return "there is no C compiler (cc)"
        command = [compiler, "-O3", "-march=native", "-o", self.program, SOURCE, "-lm"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            lines = [line for line in done.stderr.splitlines() if "error" in line]
            return f"it doesn't compile here: {lines[0].partition('error')[2] if lines else done.stderr}"
        return "" if self._output(PAPER_TASKS, 1, 1) else "this processor can't run it"

    def _output(self, tasks: int, runs: int, seed: int) -> str:
        line = f"{tasks} {runs} {seed}\n"
        return subprocess.run([self.program], input=line, capture_output=True, text=True, check=False).stdout

    def play(self, tasks: int, runs: int, seed: int = 1) -> Played:
        """Simulate some runs of the paper's swarm."""
        ns, feasible, infeasible, *quartiles = self._output(tasks, runs, seed).split()
        low, median, high = map(int, quartiles)
        return Played(float(ns), int(feasible), int(infeasible), (low, median, high))

    def sample(self, runs: int) -> Sample:
        """Return a sample of the program, in ns of CPU time per robot-step."""
        return Sample(lambda: self.play(PAPER_TASKS, 1), lambda: self.play(PAPER_TASKS, runs).ns)

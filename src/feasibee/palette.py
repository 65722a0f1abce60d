"""The colours of robots, tasks and opinions everywhere: Okabe and Ito's, for colour-blind people too."""

from __future__ import annotations

from typing import Final

COLOURS: Final = {"feasible": "#0072B2", "infeasible": "#D55E00", "undecided": "#7F7F7F"}
TASK: Final = "#E69F00"

"""The outcomes of a run: the one table that records, datasets, sweeps, exports and docs derive from.

To add an outcome, add a row to `OUTCOMES` and the name of its column below. Compute it in the reference and
the engine. Folders of runs get a column, so raise ``FORMAT`` in ``feasibee.simulation.store``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final, NamedTuple

from feasibee.base.codes import CERTAIN, DECISIONS, FEASIBLE, INFEASIBLE, UNDECIDED


class Need(NamedTuple):
    """What a scenario must have for an outcome."""

    words: str
    """What that is, in Markdown."""
    is_met: Callable[[Any], bool]
    """Returns whether a scenario has it."""


class Column(NamedTuple):
    """A column of results: an integer per run, or per run and step."""

    name: str
    """Name in records, datasets, sweeps and exports."""
    words: str
    """What it is, as a phrase that stands alone."""
    unit: str = "robots"
    """Unit of the values; empty for codes."""
    dtype: str = "int64"
    """Type of the values in records and datasets."""
    fill: int = 0
    """Value before a run, and of a run without such an outcome."""
    missing: str = ""
    """What the fill value means at the end of a run; empty if it is a number like any other."""
    codes: Mapping[int, str] | None = None
    """Meanings of the values, if they are codes."""
    needs: Need | None = None
    """What a scenario must have for this outcome; None if all scenarios have it."""

    @property
    def meaning(self) -> str:
        """The phrase with the meaning of its codes or of its fill value."""
        if self.codes:
            return f"{self.words}; {', '.join(f'{code}: {name}' for code, name in self.codes.items())}"
        return f"{self.words}; {self.fill}: {self.missing}" if self.missing else self.words


DECLARES: Final = Need("`decision.declare` or a strategy's own `declare`", lambda scenario: scenario.declares)
CHANGES: Final = Need("a world that changes", lambda scenario: scenario.dynamic)
STOPS: Final = Need(
    "`run.stop_at_declarations` or `run.stop_when_taken`",
    lambda scenario: scenario.run.stop_at_declarations or scenario.run.stop_when_taken,
)
SAYS: Final = Need("a strategy's own `probability`", lambda scenario: scenario.gives_probability)
ACTS: Final = Need("`acting.start`", lambda scenario: scenario.acts)
WORKS: Final = Need("`tasks.work`", lambda scenario: scenario.tasks.work is not None)
OUTCOMES: Final = (
    Column(
        "decision",
        "collective decision of the honest robots that still work",
        *("", "int8", UNDECIDED),
        codes=DECISIONS,
    ),
    Column(
        "decision_step",
        "first step at which the swarm had decided",
        *("step", "int32", -1),
        missing="undecided",
    ),
    Column("bits_sent", "total length of all messages sent", "bit", "int64", 0),
    Column(
        "declare_step",
        "first step at which more than the threshold's share of the robots had declared",
        *("step", "int64", -1),
        missing="never",
        needs=DECLARES,
    ),
    Column(
        "declared_feasible",
        "honest working robots that had declared feasible by the end of the run",
        needs=DECLARES,
    ),
    Column(
        "declared_infeasible",
        "honest working robots that had declared infeasible by the end of the run",
        needs=DECLARES,
    ),
    Column("feasible_at_end", "honest working robots with opinion feasible at the end of the run"),
    Column("infeasible_at_end", "honest working robots with opinion infeasible at the end of the run"),
    Column("last_step", "last step of the run", *("step", "int64", 0), needs=STOPS),
    Column(
        "said_at_end",
        "sum of the probabilities that the honest working robots give to feasible at the end of the run",
        f"1/{CERTAIN}",
        needs=SAYS,
    ),
    Column(
        "first_taken_step",
        "first step at which a robot stood at a task",
        *("step", "int64", -1),
        missing="never",
        needs=ACTS,
    ),
    Column(
        "all_taken_step",
        "first step at which robots stood at all tasks, or at as many as honest working robots could take",
        *("step", "int64", -1),
        missing="never",
        needs=ACTS,
    ),
    Column("tasks_taken", "tasks at which robots stood at the end of the run", "tasks", needs=ACTS),
    Column(
        "distance_walked",
        "steps that all robots walked up to and including all_taken_step, or in the whole run",
        *("robot-steps", "int64", 0),
        needs=ACTS,
    ),
    Column("vain_arrivals", "arrivals of robots at tasks that they didn't get", "arrivals", needs=ACTS),
    Column("starts_in_vain", "robots that took a task although the tasks were infeasible", needs=ACTS),
    Column(
        "all_done_step",
        "first step at whose beginning all tasks were done that an honest working robot could do",
        *("step", "int64", -1),
        missing="never",
        needs=WORKS,
    ),
)
"""Outcomes per run, in the order of a table's columns: append only."""

CURVES: Final = (
    Column(
        "feasible_count",
        "honest working robots with opinion feasible",
        *("robots", "int32", -1),
        missing="after the end of the run",
    ),
    Column(
        "infeasible_count",
        "honest working robots with opinion infeasible",
        *("robots", "int32", -1),
        missing="after the end of the run",
    ),
)
"""Outcomes per run and step, from step 0 on, kept if asked for."""

TRACES: Final = (
    Column(
        "truth",
        "ground truth for the robots and tasks present at the step",
        *("", "int8", -1),
        codes={FEASIBLE: DECISIONS[FEASIBLE], INFEASIBLE: DECISIONS[INFEASIBLE]},
        needs=CHANGES,
    ),
    Column(
        "held",
        "opinion of more than the threshold's share of the honest working robots",
        *("", "int8", UNDECIDED),
        codes=DECISIONS,
        needs=CHANGES,
    ),
    Column(
        "robots_present",
        "robots present at the step, whether they work or not",
        *("robots", "int32", -1),
        missing="after the end of the run",
        needs=CHANGES,
    ),
    Column(
        "tasks_present",
        "tasks present at the step, whether seen or not",
        *("tasks", "int32", -1),
        missing="after the end of the run",
        needs=CHANGES,
    ),
)
"""Outcomes per run and step, from step 0 on, always kept of worlds that change."""

ACCOUNT: Final = tuple(each for each in OUTCOMES if each.dtype == "int64")
"""Outcomes that a record holds as columns of one array, in their order there."""
FILLS: Final = tuple(each.fill for each in ACCOUNT)
"""Values of these columns before a run."""
(
    BITS_SENT,
    DECLARE_STEP,
    DECLARED_FEASIBLE,
    DECLARED_INFEASIBLE,
    FEASIBLE_AT_END,
    INFEASIBLE_AT_END,
    LAST_STEP,
    SAID_AT_END,
    FIRST_TAKEN_STEP,
    ALL_TAKEN_STEP,
    TASKS_TAKEN,
    DISTANCE_WALKED,
    VAIN_ARRIVALS,
    STARTS_IN_VAIN,
    ALL_DONE_STEP,
) = range(len(ACCOUNT))
"""Numbers of the columns, by which the engine fills them in."""

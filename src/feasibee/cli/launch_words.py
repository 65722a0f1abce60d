"""What feasibee launch prints while it runs and at its end."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from contextlib import nullcontext
from typing import TYPE_CHECKING, Any

import click

from feasibee.field.plan import fault_in_words

if TYPE_CHECKING:
    from feasibee.scenario.scenario import Scenario


class Told:
    """Prints what happens, as lines on standard error, with a progress bar.

    Parameters
    ----------
    scenario : Scenario
        What the field runs.
    quiet : bool
        Whether to print nothing.
    """

    def __init__(self, scenario: Scenario, quiet: bool) -> None:
        self._steps = scenario.run.steps
        self._quiet = quiet
        self._bar: Any = nullcontext()

    def __enter__(self) -> None:
        from rich.progress import Progress

        from feasibee.simulation.loading import stderr_console

        console = stderr_console()
        hidden = self._quiet or not sys.stderr.isatty()
        self._bar = Progress(console=console, transient=True, disable=hidden)
        self._task = self._bar.add_task("Running", total=self._steps)
        self._bar.start()

    def __exit__(self, *error: object) -> None:
        self._bar.stop()

    def tell(self, event: Mapping[str, Any]) -> None:
        """Print an event, or advance the bar."""
        if event["event"] == "step":
            self._bar.update(self._task, completed=event["step"])
            return
        texts = {
            "listening": lambda: f"The world is at {event['address']}.",
            "joined": lambda: f"{event['robots']} robots have joined.",
            "fault": lambda: f"Step {event['step']}: {fault_in_words(event)}.",
            "comes": lambda: f"Step {event['step']}: robot {event['robot']} comes.",
            "leaves": lambda: f"Step {event['step']}: robot {event['robot']} leaves.",
            "lost": lambda: f"Step {event['step']}: robot {event['robot']} is silent; it doesn't count.",
            "back": lambda: f"Step {event['step']}: robot {event['robot']} is back.",
        }
        if event["event"] in texts and not self._quiet:
            click.echo(texts[event["event"]](), err=True)


def in_words(result: Mapping[str, Any]) -> str:
    """Return a field's result as lines."""
    decided = result["decision_step"]
    lines = [f"Decision: {result['decision']}" + ("." if decided is None else f", at step {decided}.")]
    undecided = result["robots"] - len(result["lost"]) - result["feasible"] - result["infeasible"]
    lines.append(
        f"After {result['steps']:,} steps in {result['seconds']:.1f} s: {result['feasible']} robots hold "
        f"feasible, {result['infeasible']} infeasible, {max(0, undecided)} neither or not counted."
    )
    if "right_share" in result:
        changes = result["detection_delay"]["changes"]
        missed = f"; it missed {result['missed']['estimate']:.0%} of {changes} changes" if changes else ""
        lines.append(f"Right: in {result['right_share']['estimate']:.1%} of the steps{missed}.")
    if result["lost"]:
        lines.append(f"Lost: {', '.join(map(str, result['lost']))}.")
    for why, count in result["dropped"].items():
        lines.append(f"Dropped packets, {why}: {count:,}.")
    return "\n".join(lines)

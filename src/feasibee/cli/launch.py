"""feasibee launch: a swarm as processes, and what is printed while it runs and at its end."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from feasibee.cli.options import FiniteRange, Given, command, folder_type, named, option, progress
from feasibee.cli.robots import read_key
from feasibee.errors import FeasibeeError
from feasibee.field.plan import (
    RESTART,
    Fault,
    Plan,
    fault_in_words,
    parse_fault,
    parse_length,
    schedule,
)
from feasibee.scenario.runs import Runs

if TYPE_CHECKING:
    from feasibee.scenario.scenario import Scenario

EVENTS = {
    "listening": "The world is at {address}.",
    "joined": "{robots} robots have joined.",
    "fault": "Step {step}: {fault}.",
    "comes": "Step {step}: robot {robot} comes.",
    "leaves": "Step {step}: robot {robot} leaves.",
    "lost": "Step {step}: robot {robot} is silent; it doesn't count.",
    "back": "Step {step}: robot {robot} is back.",
}
"""What is printed of events."""


@command()
def launch(
    *,
    given: Given,
    seed: int,
    run: int,
    lockstep: bool = option("Wait for all robots in each step; the result is that of the run.", is_flag=True),
    hz: float = option("Steps per second of a robot's clock.", FiniteRange(0.01, 1000), 10.0),
    drift: float = option(
        "Largest error of a robot's clock, as a share: 0.01 is 1 %.", FiniteRange(0, 0.5), 0.0
    ),
    jitter: float = option("Largest deviation of a step's duration, as a share.", FiniteRange(0, 1), 0.0),
    delay: str = option(
        "Delay of each message, such as 200ms.", default="0", show_default=False, metavar="TIME"
    ),
    kill: tuple[str, ...] = option("Kill robots at a step; repeatable.", multiple=True, metavar="COUNT@STEP"),
    pause: tuple[str, ...] = option(
        "Stop robots' processes at a step, for a time or for good; repeatable.",
        multiple=True,
        metavar="COUNT@STEP[:TIME]",
    ),
    partition: tuple[str, ...] = option(
        "Cut the radio between two halves of the robots at a step, for a time; repeatable.",
        multiple=True,
        metavar="TIME@STEP",
    ),
    restart_world: tuple[int, ...] = option(
        "Kill the world's process at a step, and start it again; repeatable.",
        int,
        multiple=True,
        metavar="STEP",
    ),
    out: Path | None = option(
        "Write the world's log and one log per robot, which feasibee replay replays.",
        folder_type,
        metavar="FOLDER",
    ),
    host: str = option(
        "Address to listen on; 0.0.0.0 is reachable from outside.", default="127.0.0.1", callback=named
    ),
    port: int = option("Port; by default a free one.", click.IntRange(0, 65535), 0, show_default=False),
    key_file: Path | None,
    no_robots: bool = option("Start no robots; wait for those that feasibee robot starts.", is_flag=True),
    wait: float = option("Seconds that robots have to join.", FiniteRange(0.1, 86_400), 60.0),
    patience: float = option(
        "Seconds of silence after which a robot is lost.", FiniteRange(0.1, 86_400), 5.0
    ),
    as_json: bool,
) -> None:
    """Run a swarm as processes: one world, and one process for each robot with its own clock.

    FILE is a scenario in TOML; without it, the paper's swarm of 20 robots and 20 tasks. A TIME is a number of
    steps, or a time in seconds or milliseconds of the robots' clock: 20, 2s or 200ms.

    \b
    Examples:
      feasibee launch --lockstep --json
      feasibee launch mine.toml --hz 50 --drift 0.01 --delay 200ms
      feasibee launch --kill 3@50 --pause 1@80:5s --partition 5s@100 --out logs
      feasibee launch --host 0.0.0.0 --port 7400 --no-robots --key-file key.txt
    """
    from feasibee.field.connections import is_loopback
    from feasibee.field.supervisor import Field, Network

    if not hasattr(os, "fork"):
        raise FeasibeeError("feasibee launch: needs a system with fork; use Linux, macOS or WSL")
    scenario = given.read()
    one = Runs.single(seed, run)
    options = {"kill": kill, "pause": pause, "partition": partition}
    faults = _faults(options, restart_world, hz, scenario, starts_robots=not no_robots)
    late = parse_length("--delay", delay, hz)
    clocks = (lockstep, hz, drift, jitter, late)
    plan = Plan(scenario, one.seed, one.first, *clocks, faults, patience, wait)
    key = read_key(key_file)
    if not (key or is_loopback(host)):
        click.echo("feasibee: anyone who can reach this machine can take part; use --key-file FILE", err=True)
    with _telling(scenario.run.steps, as_json) as tell:
        result = Field(plan, Network(host, port, key), out, tell, starts_robots=not no_robots).run()
    result = {
        **result,
        "lockstep": plan.lockstep,
        "hz": None if plan.lockstep else plan.hz,
        "faults": [fault_in_words(fault._asdict()) for fault in plan.faults],
        "seed": plan.seed,
        "run": plan.run,
        "scenario_hash": plan.scenario.hash,
    }
    click.echo(json.dumps(result, indent=2) if as_json else _in_words(result))


def _faults(
    options: Mapping[str, tuple[str, ...]],
    restarts: tuple[int, ...],
    hz: float,
    scenario: Scenario,
    *,
    starts_robots: bool,
) -> tuple[Fault, ...]:
    """Return the faults of the options, in their order."""
    faults = [Fault(step, RESTART) for step in restarts]
    for kind, texts in options.items():
        faults += [fault for text in texts for fault in parse_fault(kind, text, hz)]
    if not starts_robots and any(fault.robots_hit for fault in faults):
        raise FeasibeeError(
            "--no-robots with --kill or --pause: robots from elsewhere can't be; leave one out"
        )
    return tuple(schedule(faults, scenario.robots.count, scenario.run.steps))


@contextmanager
def _telling(steps: int, quiet: bool) -> Iterator[Callable[[Mapping[str, Any]], None]]:
    """Give the function that prints an event on standard error, or advances the bar there."""
    with progress("Running", hidden=quiet) as advance:

        def tell(event: Mapping[str, Any]) -> None:
            kind = event["event"]
            if kind == "step":
                advance(event["step"] / steps)
            elif kind in EVENTS and not quiet:
                fault = fault_in_words(event) if kind == "fault" else ""
                click.echo(EVENTS[kind].format(**{**event, "fault": fault}), err=True)

        yield tell


def _in_words(result: Mapping[str, Any]) -> str:
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

"""feasibee robot: the controller in C, a swarm as processes, one robot, and what robots did."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, nullcontext, suppress
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from feasibee.base.errors import FeasibeeError, one_line
from feasibee.cli.options import (
    ANIMATIONS,
    Film,
    FiniteRange,
    GivenScenario,
    argument,
    command,
    complete_strategy,
    exclude,
    file_type,
    folder_type,
    named,
    only,
    option,
    outputs_option,
    own_strategy,
    path_type,
    print_json,
    progress,
    with_flooding,
)
from feasibee.field.plan import Fault, FieldPlan, fault_in_words, parse_fault, parse_length, schedule
from feasibee.scenario.runs import Runs

if TYPE_CHECKING:
    from feasibee.scenario.scenario import Scenario
    from feasibee.strategies.contract import Strategy


EVENTS = {
    "listening": "The world is at {address}.",
    "joined": "{robots} robots have joined.",
    "fault": "Step {step}: {fault}.",
    "comes": "Step {step}: robot {robot} comes.",
    "leaves": "Step {step}: robot {robot} leaves.",
    "lost": "Step {step}: robot {robot} is silent; it doesn't count.",
    "died": "Step {step}: robot {robot} has ended; it doesn't count.",
    "back": "Step {step}: robot {robot} is back.",
}
"""What is printed of events."""


def _loaded(context: click.Context, parameter: click.Parameter, path: Path | None) -> Strategy | None:
    return None if path is None else own_strategy(str(path))


_strategy = option(
    "The robots' strategy, if it is a file of yours.", file_type, metavar="FILE", callback=_loaded
)


@click.group()
def robot() -> None:
    """Run robots as processes or real ones, replay their logs, or print their controller in C.

    \b
    Examples:
      feasibee robot launch --lockstep
      feasibee robot header mine.py > feasibee.h
    """


@command(make=robot.command)
def launch(
    *,
    given: GivenScenario,
    steps: int | None,
    seed: int,
    run: int,
    lockstep: bool = option("Wait for all robots in each step; the result is that of the run."),
    hz: float = option("Steps per second of a robot's clock.", FiniteRange(0.01, 1000), 10.0),
    drift: float = option("Largest error of a robot's clock: 0.01 is 1 %.", FiniteRange(0, 0.5), 0.0),
    jitter: float = option("Largest deviation of a step's duration, as a share.", FiniteRange(0, 1), 0.0),
    delay: str = option("Delay of each message, such as 200ms.", default="0", metavar="TIME"),
    kill: tuple[str, ...] = option("Kill robots at a step; repeatable.", metavar="COUNT@STEP"),
    pause: tuple[str, ...] = option(
        "Stop robots at a step, for a time or for good; repeatable.", metavar="COUNT@STEP[:TIME]"
    ),
    partition: tuple[str, ...] = option(
        "Cut the radio between two halves of the robots for a time; repeatable.", metavar="TIME@STEP"
    ),
    out: Path | None = option(
        "Write the logs of the world and of each robot.", folder_type, metavar="FOLDER"
    ),
    no_robots: bool = option("Start no robots; wait for those that feasibee robot join starts."),
    in_c: bool = option("Let the robots run the program in C that feasibee robot header gives.", name="--c"),
    ros: bool = option("Let world and robots be nodes of ROS 2; needs feasibee_ros."),
    wait: float = option("Seconds that robots have to join.", FiniteRange(0.1, 86_400), 60.0),
    patience: float = option("Seconds of silence until a robot is lost.", FiniteRange(0.1, 86_400), 5.0),
    as_json: bool,
) -> None:
    """Run a swarm as processes: one world, and one process for each robot with its own clock.

    FILE is a scenario in TOML; without it, the paper's swarm of 20 robots and 20 tasks. A TIME is a number of
    steps, or a time in seconds or milliseconds of the robots' clock: 20, 2s or 200ms.

    \b
    Examples:
      feasibee robot launch --lockstep --c --json
      feasibee robot launch mine.toml --hz 50 --drift 0.01 --delay 200ms
      feasibee robot launch --kill 3@50 --pause 1@80:5s --partition 5s@100 --out logs
    """
    from feasibee.field.supervisor import Field

    if not hasattr(os, "killpg"):
        raise FeasibeeError("feasibee robot launch: needs groups of processes; use Linux, macOS or WSL")
    scenario = with_flooding(given.read({"run.steps": steps}))
    one = Runs.single(seed, run)
    options = {"kill": kill, "pause": pause, "partition": partition}
    faults = _faults(options, hz, scenario, starts_robots=not no_robots)
    clocks = (lockstep, hz, drift, jitter, parse_length("--delay", delay, hz))
    plan = FieldPlan(scenario, one.seed, one.first, *clocks, faults, patience, wait)
    if ros and not all(map(find_spec, ("rclpy", "feasibee_ros"))):
        raise FeasibeeError("--ros: needs ROS 2 and feasibee_ros; see ros2/README.md in the repository")
    package = "feasibee_ros.field" if ros else "feasibee.field"
    with _brain(scenario) if in_c else nullcontext() as brain, _telling(scenario.run.steps, as_json) as tell:
        result = Field(plan, out, tell, starts_robots=not no_robots, brain=brain, package=package).run()
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


@contextmanager
def _brain(scenario: Scenario) -> Iterator[Path]:
    """Compile the robots' program in C, for as long as they run."""
    from feasibee.field.brain import compiled
    from feasibee.scenario.plugins import strategy_of

    if scenario.acts:
        raise FeasibeeError("--c with [acting]: frames in C say nothing of tasks; leave one out")
    with tempfile.TemporaryDirectory() as folder:
        yield compiled(strategy_of(scenario.manifest), scenario.setting, Path(folder))


def _faults(
    options: Mapping[str, tuple[str, ...]], hz: float, scenario: Scenario, *, starts_robots: bool
) -> tuple[Fault, ...]:
    """Return the faults of the options, in their order."""
    faults = [parse_fault(kind, text, hz) for kind, texts in options.items() for text in texts]
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
    if acting := result.get("acting"):
        when, taken = acting["all_taken_step"], acting["tasks_taken"]
        end = f"all that could be by step {when}" if when >= 0 else "robots could have taken more"
        lines.append(f"Tasks taken at the end: {taken}; {end}.")
    if result["lost"]:
        lines.append(f"Lost: {', '.join(map(str, result['lost']))}.")
    return "\n".join(lines)


@command(make=robot.command)
def join(
    *,
    given: GivenScenario,
    connect: Path | None = option(
        "Where the world of a field on this machine is, as feasibee robot launch prints.",
        file_type,
        metavar="FILE",
    ),
    senses: str | None = option(
        "Without a world: named pipe, or udp:HOST:PORT, that your driver writes to.",
        metavar="SOURCE",
        callback=named,
    ),
    number: int = option("The robot's number, from 0.", click.IntRange(0, 65534), name="--id", required=True),
    seed: int | None = option(
        "With --senses: seed of the robot's random numbers, 0 to 2**64 - 1; by default a new one.",
        int,
        metavar="INTEGER",
    ),
    outputs: dict[str, Path] = outputs_option(
        "Write the robot's log, .jsonl, for feasibee robot replay.", log=(".jsonl",)
    ),
    strategy: Strategy | None = _strategy,
) -> None:
    """Run one robot: of a field, or a real one whose driver writes what it senses.

    FILE is the scenario of a real robot; in a field, the world has the scenario.

    \b
    Examples:
      feasibee robot join --connect /tmp/feasibee-field-x1/world.json --id 3
      feasibee robot join mine.toml --id 3 --senses senses.pipe --out robot-3.jsonl
    """
    if (connect is None) == (senses is None):
        raise FeasibeeError("feasibee robot join: needs either a world or senses; give --connect or --senses")
    if connect is not None:
        only("--connect", "the world has scenario and seed", "connect", "number", "outputs", "strategy")
    log = outputs.get("log")
    if senses is not None:
        _drive(with_flooding(given.read()), number, seed, senses, log)
        return
    from feasibee.field.logs import LineLog
    from feasibee.field.robot import GONE, take_part

    with closing(LineLog(log)) if log is not None else nullcontext() as lines:
        status, why = take_part({"connect": str(connect), "number": number, "brain": ""}, lines, strategy)
    if why:
        raise FeasibeeError(f"--id {number}: {one_line(why)}")
    if status == GONE:
        raise FeasibeeError("the world has ended before its field has; start the field again")


def _drive(scenario: Scenario, number: int, seed: int | None, senses: str, log: Path | None) -> None:
    """Run a real robot until its driver ends."""
    from feasibee.field.logs import LineLog
    from feasibee.field.senses import drive, open_senses, real_robot

    with closing(LineLog(log)) if log is not None else nullcontext() as lines:
        node = real_robot(scenario, number, seed, lines.write if lines is not None else None)
        with suppress(KeyboardInterrupt):
            drive(node, number, open_senses(senses), lambda line: click.echo(json.dumps(line)))
    for why, count in node.dropped.items():
        if count:
            click.echo(f"feasibee: dropped, {why}: {count:,}", err=True)


@command(make=robot.command)
def replay(
    *,
    logs: tuple[Path, ...] = argument(path_type, metavar="LOG...", nargs=-1, required=True),
    strategy: Strategy | None = _strategy,
    outputs: dict[str, Path] = outputs_option(
        "Draw the field whose folder LOG is, instead: .gif, .webp, .mp4, or .png for the last frame.",
        animation=(*ANIMATIONS, ".png"),
    ),
    look: Film,
    as_json: bool,
) -> None:
    """Replay logs of robots, and check that each decision is the same to the bit.

    LOG is a robot's log, or the folder of a field with those of all robots.

    \b
    Examples:
      feasibee robot replay logs
      feasibee robot replay logs/robot-3.jsonl --json
      feasibee robot replay logs --out field.gif
    """
    if outputs:
        _animate(logs, outputs["animation"], look)
        return
    exclude("no animation", "only animations, such as --out field.gif, have it", *look._fields)
    from feasibee.field.node import replay as replay_log

    replays = [(log, replay_log(log, strategy)) for path in logs for log in _logs(path)]
    if as_json:
        print_json([{"log": str(path), **found._asdict()} for path, found in replays])
        return
    for _, found in replays:
        cut = "; the last line is incomplete and left out" if found.cut else ""
        decisions = "1 decision" if found.decisions == 1 else f"{found.decisions} decisions"
        click.echo(
            f"Robot {found.number}: {found.steps:,} steps and {decisions} replayed, "
            f"equal to the log; {found.opinion} at the end{cut}."
        )


def _animate(folders: Sequence[Path], out: Path, look: Film) -> None:
    """Draw a field from its world's log."""
    from feasibee.figures.animation import animate_field

    only("--out", "it draws the log", "logs", "outputs", *look._fields)
    if len(folders) > 1:
        raise FeasibeeError(f"--out {out}: shows one field; name one folder")
    look.draw(animate_field, folders[0], out)
    click.echo(f"Wrote {out}")


def _logs(path: Path) -> list[Path]:
    """Return a robot's log, or those of a folder by the robots' numbers."""
    if not path.is_dir():
        return [path]
    found = sorted(path.glob("robot-*.jsonl"), key=lambda each: (len(each.name), each.name))
    if not found:
        raise FeasibeeError(f"{path}: has no logs of robots; run feasibee robot launch --out {path}")
    return found


@command(make=robot.command)
def header(
    *,
    strategies: tuple[str, ...] = argument(
        str, nargs=-1, metavar="[STRATEGY]...", shell_complete=complete_strategy
    ),
    inbox: int | None = option("Number of senders whose message a robot keeps; by default 64.", int),
    acting: bool = option("Print acting.h instead: which task a robot that acts goes to."),
) -> None:
    """Print the controller of one robot in C99, as one header file.

    STRATEGY is a name, or a file of your own if it ends in .py, which is translated; by default all built-in
    strategies. The comments in the file say how to use it.

    \b
    Examples:
      feasibee robot header > feasibee.h
      feasibee robot header mine.py > feasibee.h
      feasibee robot header dmmd dc --inbox 32 > feasibee.h
      feasibee robot header --acting > acting.h
    """
    from feasibee.robot.firmware import acting_header, header

    if acting:
        only("--acting", "acting.h has no strategy and no inbox", "acting")
        click.echo(acting_header(), nl=False)
        return
    click.echo(header([_in_c(name) for name in strategies] or None, inbox), nl=False)


def _in_c(name: str) -> str | Strategy:
    """Return a strategy for the header: a user's is loaded."""
    from feasibee.scenario.plugins import registered

    return own_strategy(name) if name.endswith(".py") or name in registered() else name

"""feasibee launch, robot, replay, header: a swarm as processes, one robot, and what robots did."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager, nullcontext, suppress
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from feasibee.cli.options import (
    FiniteRange,
    Given,
    argument,
    command,
    complete_strategy,
    file_type,
    folder_type,
    named,
    option,
    outputs_option,
    own_strategy,
    path_type,
    print_json,
    progress,
    with_flooding,
)
from feasibee.errors import FeasibeeError, one_line
from feasibee.field.plan import (
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
    out: Path | None = option(
        "Write the world's log and one log per robot, which feasibee replay replays.",
        folder_type,
        metavar="FOLDER",
    ),
    no_robots: bool = option("Start no robots; wait for those that feasibee robot starts.", is_flag=True),
    in_c: bool = option(
        "Let the robots run the program in C that feasibee header gives.", name="--c", is_flag=True
    ),
    ros: bool = option("Let world and robots be nodes of ROS 2; needs feasibee_ros.", is_flag=True),
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
      feasibee launch --lockstep --c --json
      feasibee launch mine.toml --hz 50 --drift 0.01 --delay 200ms
      feasibee launch --kill 3@50 --pause 1@80:5s --partition 5s@100 --out logs
    """
    from feasibee.field.supervisor import Field

    if not hasattr(os, "killpg"):
        raise FeasibeeError("feasibee launch: needs groups of processes; use Linux, macOS or WSL")
    scenario = with_flooding(given.read())
    one = Runs.single(seed, run)
    options = {"kill": kill, "pause": pause, "partition": partition}
    faults = _faults(options, hz, scenario, starts_robots=not no_robots)
    clocks = (lockstep, hz, drift, jitter, parse_length("--delay", delay, hz))
    plan = Plan(scenario, one.seed, one.first, *clocks, faults, patience, wait)
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


@command()
def robot(
    *,
    given: Given,
    connect: Path | None = option(
        "Where the world of a field on this machine is, as feasibee launch prints.", file_type, metavar="FILE"
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
        "Write the robot's log, .jsonl, for feasibee replay.", log=(".jsonl",)
    ),
    strategy: Path | None = option(
        "The swarm's strategy, if it is a file of yours.", file_type, metavar="FILE"
    ),
) -> None:
    """Run one robot: of a field, or a real one whose driver writes what it senses.

    FILE is the scenario of a real robot; in a field, the world has the scenario.

    \b
    Examples:
      feasibee robot --connect /tmp/feasibee-field-x1/world.json --id 3
      feasibee robot mine.toml --id 3 --senses senses.pipe --out robot-3.jsonl
    """
    if (connect is None) == (senses is None):
        raise FeasibeeError("feasibee robot: needs either a world or senses; give --connect or --senses")
    if connect is not None and any(given):
        raise FeasibeeError("--connect with a scenario: the world has the scenario; leave out FILE and --set")
    if connect is not None and seed is not None:
        raise FeasibeeError("--connect with --seed: the world has the seed; leave out --seed")
    log = outputs.get("log")
    if senses is not None:
        _drive(with_flooding(given.read()), number, seed, senses, log)
        return
    from feasibee.field.logs import LineLog
    from feasibee.field.robot import GONE, take_part

    own = _strategy(strategy)
    with closing(LineLog(log)) if log is not None else nullcontext() as lines:
        status, why = take_part({"connect": str(connect), "number": number, "brain": ""}, lines, own)
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


@command()
def replay(
    *,
    logs: tuple[Path, ...] = argument(path_type, metavar="LOG...", nargs=-1, required=True),
    strategy: Path | None = option(
        "The robots' strategy, if it is a file of yours.", file_type, metavar="FILE"
    ),
    as_json: bool,
) -> None:
    """Replay logs of robots, and check that each decision is the same to the bit.

    LOG is a robot's log, or the folder of a field with those of all robots.

    \b
    Examples:
      feasibee replay logs
      feasibee replay logs/robot-3.jsonl --json
    """
    from feasibee.field.replay import replay as replay_log

    own = _strategy(strategy)
    replays = [(log, replay_log(log, own)) for path in logs for log in _logs(path)]
    if as_json:
        print_json([{"log": str(path), **found._asdict()} for path, found in replays])
        return
    for _, found in replays:
        cut = "; the last line is incomplete and left out" if found.cut else ""
        click.echo(
            f"Robot {found.number}: {found.steps:,} steps and {found.decisions} decisions replayed, "
            f"equal to the log; {found.opinion} at the end{cut}."
        )


def _strategy(path: Path | None) -> Strategy | None:
    """Return a user's strategy."""
    return None if path is None else own_strategy(str(path))


def _logs(path: Path) -> list[Path]:
    """Return a robot's log, or those of a folder by the robots' numbers."""
    if not path.is_dir():
        return [path]
    found = sorted(path.glob("robot-*.jsonl"), key=lambda each: (len(each.name), each.name))
    if not found:
        raise FeasibeeError(f"{path}: has no logs of robots; run feasibee launch --out {path}")
    return found


@command()
def header(
    *,
    strategies: tuple[str, ...] = argument(
        str, nargs=-1, metavar="[STRATEGY]...", shell_complete=complete_strategy
    ),
    more: tuple[str, ...] = option(
        "Include this strategy, as STRATEGY does; repeatable.",
        name="--strategy",
        multiple=True,
        metavar="STRATEGY",
    ),
    inbox: int | None = option("Number of senders whose message a robot keeps; by default 64.", int),
    acting: bool = option("Print acting.h instead: which task a robot that acts goes to.", is_flag=True),
) -> None:
    """Print the controller of one robot in C99, as one header file.

    STRATEGY is a name, or a file of your own if it ends in .py, which is translated; by default all built-in
    strategies. The comments in the file say how to use it.

    \b
    Examples:
      feasibee header > feasibee.h
      feasibee header mine.py > feasibee.h
      feasibee header dmmd dc --inbox 32 > feasibee.h
      feasibee header --acting > acting.h
    """
    from feasibee.robot.firmware import acting_header, header

    if acting:
        if strategies or more or inbox is not None:
            raise FeasibeeError("--acting: acting.h has no strategy and no inbox; leave them out")
        click.echo(acting_header(), nl=False)
        return
    click.echo(header([_in_c(name) for name in (*strategies, *more)] or None, inbox), nl=False)


def _in_c(name: str) -> str | Strategy:
    """Return a strategy for the header: a user's is loaded."""
    from feasibee.scenario.plugins import registered

    return own_strategy(name) if name.endswith(".py") or name in registered() else name

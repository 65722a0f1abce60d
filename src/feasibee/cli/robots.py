"""feasibee robot, replay and header: one robot of a field, what robots did, and their controller in C."""

from __future__ import annotations

import json
import os
import random
from collections.abc import Iterator
from contextlib import closing, nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from feasibee.cli.options import (
    FiniteRange,
    Given,
    argument,
    command,
    file_type,
    named,
    option,
    outputs_option,
    path_type,
    print_json,
)
from feasibee.errors import FeasibeeError, one_line
from feasibee.scenario.runs import Runs

if TYPE_CHECKING:
    from feasibee.scenario.scenario import Scenario
    from feasibee.strategies.contract import Strategy

LEAST_KEY = 16
"""Least length of a shared key."""


@command()
def robot(
    *,
    given: Given,
    connect: str | None = option("Address of the world of a field, HOST:PORT.", metavar="ADDRESS"),
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
    key_file: Path | None,
    outputs: dict[str, Path] = outputs_option(
        "Write the robot's log, .jsonl, for feasibee replay.", log=(".jsonl",)
    ),
    strategy: Path | None = option(
        "The swarm's strategy, if it is a file of yours.", file_type, metavar="FILE"
    ),
    patience: float = option(
        "Seconds of silence after which the world is gone.", FiniteRange(0.1, 86_400), 20.0
    ),
) -> None:
    """Run one robot: of a field, or a real one whose driver writes what it senses.

    FILE is the scenario of a real robot; in a field, the world has the scenario.

    \b
    Examples:
      feasibee robot --connect 192.0.2.7:7400 --id 3 --key-file key.txt
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
        _drive(given.read(), number, seed, senses, log)
        return
    from feasibee.field.robot import GONE, take_part

    key, own = read_key(key_file).encode(), _strategy(strategy)
    options: dict[str, Any] = {"log": log, "patience": patience}
    status, why = take_part(str(connect), number, key=key, strategy=own, **options)
    if why:
        raise FeasibeeError(f"{connect}: {one_line(why)}")
    if status == GONE:
        remedy = "start the field, or check the address and that --key-file gives its key"
        raise FeasibeeError(f"{connect}: silent for {patience:g} s; {remedy}")


def _drive(scenario: Scenario, number: int, seed: int | None, senses: str, log: Path | None) -> None:
    """Run a real robot until its driver ends; without a seed, each start has random numbers of its own."""
    from feasibee.field.bodies import Bodies
    from feasibee.field.logs import LineLog
    from feasibee.field.node import Node
    from feasibee.field.senses import drive, open_senses

    one = Runs.single(random.SystemRandom().getrandbits(64) if seed is None else seed, 0)
    bodies = Bodies(scenario, one.seed, one.first)
    count = scenario.robots.count
    if number >= count:
        raise FeasibeeError(f"--id {number}: must be below robots.count, {count}; use 0 or more")
    with closing(LineLog(log)) if log is not None else nullcontext() as lines:
        orders = bodies.orders(bodies.everyone[number])
        orders["settings"] = json.loads(json.dumps(orders["settings"]))
        node = Node(orders, lines.write if lines is not None else None, strategy=scenario.strategy)
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
    replays = [(path, replay_log(path, own)) for path in _log_files(logs)]
    if as_json:
        print_json([{"log": str(path), **found._asdict()} for path, found in replays])
        return
    for _, found in replays:
        cut = "; the last line is incomplete and left out" if found.cut else ""
        click.echo(
            f"Robot {found.number}: {found.steps:,} steps and {found.decisions} decisions replayed, "
            f"equal to the log; {found.opinion} at the end{cut}."
        )


def read_key(path: Path | None) -> str:
    """Return the shared key: that of a file, or of the environment."""
    from feasibee.field.robot import KEY_VARIABLE
    from feasibee.files import read_text

    if path is None:
        name, key = KEY_VARIABLE, os.environ.get(KEY_VARIABLE, "").strip()
        if not key:
            return ""
    else:
        name, key = f"--key-file {path}", read_text(path, "a file with the shared key").strip()
    if len(key) < LEAST_KEY:
        rule = f"must have at least {LEAST_KEY}; take that many random ones"
        raise FeasibeeError(f"{name}: has {len(key)} characters, {rule}")
    return key


def _strategy(path: Path | None) -> Strategy | None:
    """Return a user's strategy."""
    if path is None:
        return None
    from feasibee.scenario.plugins import load

    return load(str(path))


def _log_files(paths: tuple[Path, ...]) -> Iterator[Path]:
    """Yield robots' logs, those of a folder by the robots' numbers."""
    for path in paths:
        if not path.is_dir():
            yield path
            continue
        found = sorted(path.glob("robot-*.jsonl"), key=lambda each: (len(each.name), each.name))
        if not found:
            raise FeasibeeError(f"{path}: has no logs of robots; run feasibee launch --out {path}")
        yield from found


@command()
def header(
    *,
    strategies: tuple[str, ...] = option(
        "Include this strategy, repeatable; by default all that exist in C.",
        name="--strategy",
        multiple=True,
        metavar="NAME",
    ),
    inbox: int | None = option("Number of senders whose message a robot keeps; by default 64.", int),
) -> None:
    """Print the controller of one robot in C99, as one header file.

    The comments in the file say how to use it.

    \b
    Examples:
      feasibee header > feasibee.h
      feasibee header --strategy dmmd --inbox 32 > feasibee.h
      feasibee header --strategy dmmd --strategy average > feasibee.h
    """
    from feasibee.robot.firmware import header

    click.echo(header(strategies or None, inbox), nl=False)

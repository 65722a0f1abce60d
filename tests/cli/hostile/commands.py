"""Commands with one option or argument that they must refuse: all options there are, by their types."""

from __future__ import annotations

from collections.abc import Iterator

import click

from feasibee.cli import main
from hostile.words import LENGTHS, NAMES, NUMBERS, THINGS, WORDS

NEEDED = {
    "sweep": ["study.toml"],
    "results status": ["results"],
    "results plot": ["results", "--x", "tasks.count"],
    "results export": ["results"],
    "robot join": ["--connect", "study.toml", "--id", "0"],
}
"""What a command must have beside, to be right."""

SUFFIXES = {
    ("run", "--out"): (".nc", ".csv", ".png", ".gif", ".html"),
    ("assess", "--out"): (".html",),
    ("size", "--out"): (".svg",),
    ("robot join", "--out"): (".jsonl",),
    ("new", "FILE"): (".toml", ".py"),
    ("results export", "--out"): (".csv", ".nc"),
    ("results plot", "--out"): (".svg",),
}
"""With which the names of files are tried, beside none."""

MADE = {"nowhere", "no text", "a folder", "root"}
"""Folders that a command may write to, or make: these it would."""
LOGS = {"no text", "right to left", "bytes", "zeros", "full", "memory"}
"""Where a log may be written to: what is a device or a file is no harm there."""
BESIDE = {"no text", "right to left"}
"""Names that a file may have, odd as they are."""

TEXTS = {"empty", "dot", "dunder", "format", "markup"}
"""Words that may stand in a figure."""

LINES = {
    "no value": ["show", "truth", "--set", "tasks.count="],
    "a comment": ["show", "truth", "--set", "tasks.count=1 # 2"],
    "two values": ["show", "truth", "--set", "tasks.count=1, x = 2"],
    "a field of 3,000 parts": ["show", "truth", "--set", ".".join("a" * 3000) + "=1"],
    "a field in a list": ["show", "truth", "--set", "robots.classes.-1.count=1"],
    "deep brackets": ["show", "truth", "--set", "tasks.count=" + "[" * 20_000],
    "a date": ["show", "truth", "--set", "run.steps=1979-05-27"],
    "shard of digits": ["sweep", "study.toml", "--shard", f"1/{'9' * 5000}"],
    "shard 0": ["sweep", "study.toml", "--shard", "0/3"],
    "shard with a sign": ["sweep", "study.toml", "--shard", "+1/3"],
    "dask without a port": ["sweep", "study.toml", "--dask", "tcp://127.0.0.1"],
    "dask at a huge port": ["sweep", "study.toml", "--dask", "tcp://127.0.0.1:65536"],
    "dask and workers": ["sweep", "study.toml", "--dask", "127.0.0.1:1", "--workers", "2"],
    "host elsewhere": ["watch", "--no-open", "--host", "192.0.2.1"],
    "a field without a port": ["watch", "--no-open", "--field", "localhost"],
    "a field with a scenario": ["watch", "--no-open", "--field", "localhost:7400", "--seed", "1"],
    "steps backwards": ["run", "--out", "a.gif", "--frames", "7:3"],
    "steps of digits": ["run", "--out", "a.gif", "--frames", "9" * 5000],
    "a billion frames": ["run", "--out", "a.gif", "--set", "run.steps=1000000000", "--frames", "1000000000"],
    "steps beyond": ["run", "--out", "a.gif", "--frames", "5000"],
    "speed of no GIF": ["run", "--out", "a.gif", "--fps", "3"],
    "tasks of letters": ["compare", "--tasks", "a,b"],
    "strategies and presets": ["compare", "--strategies", "dmmd", "--presets", "default"],
    "a range that overflows": ["predict", "--over", "decision.gain=1:1e999"],
    "a range of words": ["predict", "--over", "decision.strategy=a|b"],
    "a field without a range": ["predict", "--over", "radio.loss"],
    "runs of a sweep": ["sweep", "study.toml", "--runs", "4294967297"],
    "runs and first": ["run", "--runs", "2", "--run", "4294967295"],
    "no parts": ["results", "merge", "merged"],
    "a sweep with changes": ["watch", "results", "--set", "tasks.count=5"],
    "an unknown command": ["nope"],
    "a command of control characters": ["\x1b[2J"],
    "an unknown option": ["--nope"],
    "an unknown option of a command": ["run", "--nope"],
    "an option of lines": ["run", "--a\nfeasibee: b"],
    "very many arguments": ["show", "truth", *["x" * 50] * 5000],
    "a value for a flag": ["run", "--json=5"],
    "half an option": ["run", "--s", "5"],
}
"""By hand."""


def cases() -> Iterator[tuple[str, list[str]]]:
    """Yield names and words of commands."""
    yield from LINES.items()
    for name, command in commands():
        for parameter in command.params:
            for kind, word in _words(name, parameter):
                yield f"{name} {parameter.opts[0]}: {kind}", _line(name, parameter, word)


def commands(group: click.Group = main, before: str = "") -> Iterator[tuple[str, click.Command]]:
    """Yield all commands with their names, those of groups as "results status"."""
    for name, command in group.commands.items():
        if isinstance(command, click.Group):
            yield from commands(command, f"{before}{name} ")
        else:
            yield before + name, command


def _line(name: str, parameter: click.Parameter, word: str) -> list[str]:
    """Return a command that is right but for one word."""
    needed = NEEDED.get(name, [])
    words = name.split()
    if isinstance(parameter, click.Argument):
        own = needed if needed[:1] and needed[0].startswith("-") else needed[1:]
        return [*words, *own, "--", word]
    if parameter.opts[0] in needed:
        place = needed.index(parameter.opts[0])
        needed = needed[:place] + needed[place + 2 :]
    return [*words, *needed, f"{parameter.opts[0]}={word}"]


def _words(name: str, parameter: click.Parameter) -> Iterator[tuple[str, str]]:
    option, kind = parameter.opts[0], parameter.type.name
    if isinstance(parameter, click.Option) and parameter.is_flag:
        yield "a value", "yes"
    elif isinstance(parameter.type, click.Path):
        yield from _paths(name, parameter)
    elif kind.startswith("integer"):
        yield from NUMBERS.items()
    elif kind.startswith("float"):
        free = {("robot launch", "--drift"), ("robot launch", "--jitter")}
        fine = {"zero", "minus zero"} if (name, option) in free else set()
        yield from ((each, word) for each, word in LENGTHS.items() if each not in fine)
    else:
        fine = TEXTS if option in ("--title", "--xlabel", "--ylabel") else set()
        yield from ((each, word) for each, word in WORDS.items() if each not in fine)


def _paths(name: str, parameter: click.Parameter) -> Iterator[tuple[str, str]]:
    option = parameter.opts[0]
    either = parameter.name == "outputs" and name in ("size", "assess")
    makes = either or (not parameter.type.file_okay and option == "--out")
    fine = LOGS if option == "--log" else MADE | BESIDE if makes else set()
    yield "empty", ""
    yield from ((kind, path) for kind, path in {**NAMES, **THINGS}.items() if kind not in fine)
    for suffix in SUFFIXES.get((name, option), ()):
        for kind, path in NAMES.items():
            if kind not in BESIDE and kind != "a loop":
                yield f"{kind}{suffix}", f"{path}{suffix}"
        for kind in ("a loop", "a pipe", "a folder"):
            yield f"{kind}, {suffix}", f"{kind.split()[-1]}{suffix}"

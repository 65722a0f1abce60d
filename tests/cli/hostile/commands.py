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
    "robot": ["--connect", "study.toml", "--id", "0"],
}
"""What a command must have beside, to be right."""

SUFFIXES = {
    ("run", "--out"): (".nc", ".csv", ".png"),
    ("animate", "--out"): (".gif", ".png"),
    ("assess", "--out"): (".html",),
    ("size", "--out"): (".svg",),
    ("robot", "--out"): (".jsonl",),
    ("new", "FILE"): (".toml",),
    ("results export", "--out"): (".csv", ".nc"),
    ("results plot", "--out"): (".svg",),
}
"""With which the names of files are tried, beside none."""

MADE = {"nowhere", "no text", "a folder", "here", "root"}
"""Folders that a command may write to, or make: these it would."""
LOGS = {"no text", "right to left", "bytes", "zeros", "noise", "nothing", "full", "memory", "a terabyte"}
"""Where a log may be written to: what is a device or a file is no harm there."""
BESIDE = {"no text", "right to left"}
"""Names that a file may have, odd as they are."""

TEXTS = {"empty", "blank", "unknown", "dot", "dunder", "private", "model", "format", "markup"}
"""Words that may stand in a figure."""

LINES = {
    "two of a kind": ["run", "--set", "tasks.count"],
    "no field": ["run", "--set", "=5"],
    "no value": ["truth", "--set", "tasks.count="],
    "a second line": ["run", "--set", "tasks.count=1\nx=2"],
    "a comment": ["truth", "--set", "tasks.count=1 # 2"],
    "two values": ["truth", "--set", "tasks.count=1, x = 2"],
    "a brace": ["truth", "--set", "tasks.count=1 } #"],
    "a field of 3,000 parts": ["truth", "--set", ".".join("a" * 3000) + "=1"],
    "a field in a list": ["truth", "--set", "robots.classes.-1.count=1"],
    "a superscript in a list": ["truth", "--set", "robots.classes.².count=1"],
    "5,000 digits in a list": ["truth", "--set", f"robots.classes.{'9' * 5000}.count=1"],
    "deep brackets": ["truth", "--set", "tasks.count=" + "[" * 20_000],
    "a date": ["truth", "--set", "run.steps=1979-05-27"],
    "many changes": ["truth", *[word for i in range(2000) for word in ("--set", f"x.y{i}=1")]],
    "a long change": ["truth", "--set", "tasks.count=" + "x" * 100_000],
    "shard of superscripts": ["sweep", "study.toml", "--shard", "²/³"],
    "shard of digits": ["sweep", "study.toml", "--shard", f"1/{'9' * 5000}"],
    "shard of Arabic digits": ["sweep", "study.toml", "--shard", "\u0661/\u0663"],
    "shard 0": ["sweep", "study.toml", "--shard", "0/3"],
    "shard 4/3": ["sweep", "study.toml", "--shard", "4/3"],
    "shard of lines": ["sweep", "study.toml", "--shard", "1/3\n"],
    "shard with a sign": ["sweep", "study.toml", "--shard", "+1/3"],
    "shard with an underscore": ["sweep", "study.toml", "--shard", "1/1_0"],
    "dask without a port": ["sweep", "study.toml", "--dask", "tcp://127.0.0.1"],
    "dask at port 0": ["sweep", "study.toml", "--dask", "127.0.0.1:0"],
    "dask at a huge port": ["sweep", "study.toml", "--dask", "tcp://127.0.0.1:99999999"],
    "dask by another protocol": ["sweep", "study.toml", "--dask", "http://127.0.0.1:8786"],
    "dask at a name of accents": ["sweep", "study.toml", "--dask", "é" * 300 + ":8786"],
    "dask and workers": ["sweep", "study.toml", "--dask", "127.0.0.1:1", "--workers", "2"],
    "dask and processes": ["sweep", "study.toml", "--dask", "127.0.0.1:1", "--processes"],
    "host of accents": ["watch", "--no-open", "--host", "é" * 300],
    "host elsewhere": ["watch", "--no-open", "--host", "192.0.2.1"],
    "host of dots": ["watch", "--no-open", "--host", "..."],
    "a field without a port": ["watch", "--no-open", "--field", "localhost"],
    "a field with a scenario": ["watch", "--no-open", "--field", "localhost:7400", "--seed", "1"],
    "host of digits": ["watch", "--no-open", "--host", "9" * 5000],
    "steps backwards": ["animate", "--frames", "7:3"],
    "steps of digits": ["animate", "--frames", "9" * 5000],
    "steps of superscripts": ["animate", "--frames", "²"],
    "a billion frames": ["animate", "--set", "run.steps=1000000000", "--frames", "1000000000"],
    "steps beyond": ["animate", "--frames", "5000"],
    "speed of no GIF": ["animate", "--fps", "3"],
    "tasks of letters": ["compare", "--tasks", "a,b"],
    "tasks of digits": ["compare", "--tasks", "9" * 5000],
    "tasks below 0": ["compare", "--tasks", "-5"],
    "twice the same": ["compare", "--strategies", "dmmd,dmmd"],
    "strategies and presets": ["compare", "--strategies", "dmmd", "--presets", "default"],
    "a range that overflows": ["predict", "--over", "decision.gain=1:1e999"],
    "a range backwards": ["predict", "--over", "decision.gain=9:1"],
    "a range of nan": ["predict", "--over", "decision.gain=nan:nan"],
    "a range of words": ["predict", "--over", "decision.strategy=a|b"],
    "a range without values": ["predict", "--over", "tasks.count=|"],
    "a field without a range": ["predict", "--over", "radio.loss"],
    "runs of a sweep": ["sweep", "study.toml", "--runs", "4294967297"],
    "runs and first": ["run", "--runs", "2", "--run", "4294967295"],
    "no parts": ["results", "merge", "merged"],
    "a sweep with changes": ["watch", "results", "--set", "tasks.count=5"],
    "a sweep with a run": ["watch", "results", "--run", "5"],
    "an unknown command": ["nope"],
    "a command of control characters": ["\x1b[2J"],
    "a long command": ["x" * 100_000],
    "an unknown option": ["--nope"],
    "an unknown option of a command": ["run", "--nope"],
    "a long option": ["run", "--" + "x" * 100_000],
    "an option of lines": ["run", "--a\nfeasibee: b"],
    "too many arguments": ["truth", *"abcdefgh"],
    "very many arguments": ["truth", *["x" * 50] * 5000],
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
    if name == "results merge":
        return [*words, "--", *(["merged", word] if parameter.name == "parts" else [word, "results"])]
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
        free = {("launch", "--drift"), ("launch", "--jitter")}
        fine = {"zero", "minus zero"} if (name, option) in free else set()
        yield from ((each, word) for each, word in LENGTHS.items() if each not in fine)
    else:
        fine = TEXTS if option in ("--title", "--xlabel", "--ylabel") else set()
        yield from ((each, word) for each, word in WORDS.items() if each not in fine)


def _paths(name: str, parameter: click.Parameter) -> Iterator[tuple[str, str]]:
    option = parameter.opts[0]
    either = parameter.name == "outputs" and name in ("size", "assess")
    makes = either or (
        not parameter.type.file_okay and (option == "--out" or (name, option) == ("results merge", "folder"))
    )
    fine = LOGS if option == "--log" else MADE | BESIDE if makes else set()
    yield "empty", ""
    yield from ((kind, path) for kind, path in {**NAMES, **THINGS}.items() if kind not in fine)
    for suffix in SUFFIXES.get((name, option), ()):
        for kind, path in NAMES.items():
            if kind not in BESIDE and kind != "a loop":
                yield f"{kind}{suffix}", f"{path}{suffix}"
        for kind in ("a loop", "a pipe", "a folder"):
            yield f"{kind}, {suffix}", f"{kind.split()[-1]}{suffix}"

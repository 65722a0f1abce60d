"""What stands in files: scenarios, studies, points and designs that are wrong, by combination and by hand."""

from __future__ import annotations

from collections.abc import Iterator

from feasibee.scenario.fields import fields
from feasibee.sweeps.plan import KEYS

SECTIONS = (*dict.fromkeys(path.partition(".")[0] for path in fields()), "preset", "events")
NINES = "9" * 4000

VALUES = {
    "nothing": '""',
    "word": '"nope"',
    "long word": '"' + "x" * 50_000 + '"',
    "escapes": r'"\u001b[31m\n\u0000"',
    "nan": "nan",
    "minus infinity": "-inf",
    "huge": NINES,
    "minus huge": "-1e308",
    "tiny": "5e-324",
    "overflow": "1e999",
    "true": "true",
    "date": "1979-05-27",
    "time": "07:32:00",
    "list": "[]",
    "lists": "[[[[[[]]]]]]",
    "mixed": '[1, "a", {b = 2}, 1979-05-27]',
    "long list": "[" + "1," * 20_000 + "]",
    "quantity": '"-1e999 km/h"',
    "table": "{}",
    "tables": "{a = {b = {c = {}}}}",
    "named": '{name = "a", count = 1}',
}
"""TOML of all kinds; each is wrong for nearly every field."""

FINE = {
    *(f"{field} tiny" for field in ("robots.diameter", "tasks.lifetime", "walk.mean_run", "decision.gain")),
    *(f"sensing.{field} tiny" for field in ("range", "miss", "false_robots", "false_tasks")),
    *(f"faults.{field} tiny" for field in ("stopped", "byzantine", "stubborn")),
    *(f"{section}.spread tiny" for section in ("robots", "tasks")),
    *(f"{section}.{field} list" for section in ("robots", "tasks") for field in ("points", "classes")),
    *(f"robots.{field} true" for field in ("avoid_collisions", "know_count")),
    *(f"{field} true" for field in ("sensing.count_self", "decision.own_vote")),
    *(f"radio.{field} tiny" for field in ("range", "loss")),
    *(f"sensing.{field} tiny" for field in ("view", "position_error", "gate")),
    "place.walls list",
    "place.zones table",
    "robots.speed tiny",
    "decision.exploration tiny",
    *(f"run.{field} true" for field in ("stop_at_decision", "stop_at_declarations")),
    "decision.parameters table",
    "decision.declare table",
    *(f"{section} table" for section in SECTIONS if section not in ("preset", "events")),
    "events list",
}
"""Values that are right for a field."""

POINTS_TEXT = "[" + "[1.0, 1.0]," * 2000 + "]"
BY_HAND = {
    "2,000 equal points that collide": (
        f'[robots]\nplacement = "points"\navoid_collisions = true\npoints = {POINTS_TEXT}'
    ),
    "2,000 equal points of tiny robots": (
        f'[robots]\nplacement = "points"\navoid_collisions = true\ndiameter = 5e-324\npoints = {POINTS_TEXT}'
    ),
    "points outside": '[tasks]\nplacement = "points"\npoints = [' + "[-1.0, 1e300]," * 20_000 + "]",
    "a point of nines": f'[tasks]\nplacement = "points"\npoints = [[{NINES}, 1]]',
    "points that are a number": '[tasks]\nplacement = "points"\npoints = nan',
    "a side of nines": f"arena.side = [{NINES}, 1]",
    "a tiny arena": "arena.side = [5e-324, 1e6]",
    "60,000 parameters": "[decision.parameters]\n" + "".join(f"p{i} = 1.0\n" for i in range(60_000)),
    "60,000 wrong parameters": "[decision.parameters]\n" + "".join(f'p{i} = ""\n' for i in range(60_000)),
    "60,000 keys": "".join(f"k{i} = 1\n" for i in range(60_000)),
    "60,000 fields": "[robots]\n" + "".join(f"k{i} = 1\n" for i in range(60_000)),
    "20,000 classes": '[[robots.classes]]\nname = "a"\n' * 20_000,
    "a long key": "x" * 900_000 + " = 1",
    "a long field": "[robots]\n" + "x" * 900_000 + " = 1",
    "a key of 3,000 parts": ".".join("a" * 3000) + " = 1",
    "a key of 500,000 parts": ".".join("a" * 500_000) + " = 1",
    "a table of 500,000 parts": "[" + ".".join("a" * 500_000) + "]",
    "quoted parts": ".".join(['"a"'] * 200_000) + " = 1",
    "deep lists": "a = " + "[" * 100_000,
    "deep lists, closed": "a = " + "[" * 500 + "]" * 500,
    "deep tables": "a = " + "{a = " * 100_000,
    "a million blanks": " " * 1_000_000 + "=",
    "a million dots": "a" + "." * 1_000_000,
    "a million quotes": "'" * 1_000_000,
    "2 MB": "#" * 2_000_000,
    "5,000 digits": f"tasks.count = {'9' * 5000}",
    "hexadecimal": f"tasks.count = 0x{'f' * 5000}",
    "binary": f"tasks.count = 0b{'1' * 20_000}",
    "an exponent": f"arena.side = 1e{'9' * 5000}",
    "wrong classes": 'robots.classes = [1, "a", [], {}, {name = 1}, {name = "a"}, {name = "", count = -1}]',
    "wrong skills": 'robots.classes = [{name="a",count=1,skills=[1]}, {name="b",count=1,skills="abc"}]',
    "wrong needs": 'tasks.classes = [{name="a",count=1,needs={}}, {name="b",count=1,needs={a=-1}}]',
    "needs of nines": f'tasks.classes = [{{name="a", count=1, needs={{a={NINES}}}}}]',
    "names of control characters": r'robots.classes = [{name="a\nb", count=1}, {name="\u001b[31m", count=2}]',
    "a name of NUL": r'robots.classes = [{name="\u0000", count=1}]',
    "a skill of NUL": r'robots.classes = [{name="b", count=1, skills=["\u0000"]}]',
    "a parameter of NUL": r'decision.parameters = {"\u0000" = 1.0}',
    "a key of control characters": r'"a\nfeasibee: b\u001b" = 1',
    "an empty key": '"" = 1',
    "a quoted field": '"tasks.count" = 5',
    "a strategy of NUL": r'decision.strategy = "a\u0000.py"',
    "a strategy too long": f'decision.strategy = "{"x" * 300}.py"',
    "a strategy far too long": f'decision.strategy = "{"x" * 30_000}.py"',
    "a strategy that is a folder": 'decision.strategy = "folder.py"',
    "a strategy that is a pipe": 'decision.strategy = "pipe.py"',
    "a strategy that is a loop": 'decision.strategy = "loop.py"',
    "a strategy that is a device": 'decision.strategy = "/dev/zero"',
    "points of NUL": r'tasks.points = "a\u0000"',
    "points too long": f'tasks.points = "{"x" * 3000}"',
    "points that are zeros": 'tasks.points = "/dev/zero"',
    "points that are noise": 'robots.points = "/dev/urandom"',
    "points that are a pipe": 'tasks.points = "pipe"',
    "points that are a folder": 'tasks.points = "folder"',
    "points that are a loop": 'tasks.points = "loop"',
    "points of a terabyte": 'tasks.points = "sparse"',
    "quantities without sizes": 'robots.speed = "1 m/s"\nsensing.range = "1 m"\nrun.steps = "1 s"',
    "quantities of wrong sizes": 'units = {metres = nan, seconds = "1 s"}\nrobots.speed = "1 m/s"',
    "a quantity of nines": f'units.metres = 1e-9\nsensing.range = "{NINES} km"',
    "a unit that is long": f'sensing.range = "1 {"m" * 50_000}"',
    "20,000 quantities": "arena.side = [" + '"1 s",' * 20_000 + "]",
    "no points": 'tasks = {placement = "points", points = []}',
    "shares of faults above 1": "faults = {stopped = 0.6, byzantine = 0.6}",
    "shares of faults that round up": "robots.count = 3\nfaults = {stopped = 0.5, byzantine = 0.5}",
    "a share just above 1": "faults = {stopped = 1.0, byzantine = 5e-324}",
    "too much to remember": 'robots.count = 1000000\ntasks.count = 10000000\nsensing.observation = "unique"',
    "too much to know": 'robots.count = 1000000\ntasks.count = 10000000\ndecision.strategy = "census"',
    "a listen of two": "decision.listen = {last = 1, first = 2}",
    "a listen of nines": f"decision.listen = {{last = {NINES}}}",
    "a wrong commit": "decision.declare = {quorum = 2, rounds = 0, heard = -1, x = 1}",
    "a long quorum": "decision.declare = {quorum = 0.12345678901234}",
    "an unknown preset": 'preset = "nope"',
    "a section twice": "[[robots]]\ncount = 1",
    "a field with fields": "[robots.count.x]\ny = 1",
    "the same twice": "a = 1\na = 2",
    "an open bracket": "[robots",
    "nothing before =": "=",
    "marks of order": "\ufeff\ufeff[robots]",
    "a carriage return": "[robots]\rcount=x",
    "control characters": "\x01\x02",
    "YAML": "robots:\n  count: 5\n",
    "JSON": '{"robots": {"count": 5}}',
    "Python": 'import os\nos.system("x")',
    "HTML": "<html>" * 1000,
    "NUL": "\0" * 100,
    "no date": "a = 1979-13-45",
}
"""Scenarios."""

RANGES = (
    "[0, 1, 1e-320]",
    "[0, 1, 0]",
    "[0, 1]",
    "[]",
    "[nan, 1, 2]",
    "[0, inf, 2]",
    "[0, 1, inf]",
    "[1, 1e308, 1]",
    "[0, 1, -1]",
    f"[0, 1, {NINES}]",
    '["a", "b", "c"]',
    "[[0], 1, 2]",
    "[true, 1, 2]",
    "5",
    "{}",
    "[1, 0, 1e-300]",
    "[1e15, -1e15, -1e-320]",
)
FINE_KEYS = {"curves true", "scenario table", "sweep table"}

STUDIES = {
    "two kinds of range": '[sweep]\n"tasks.count" = {range = [0, 1, 1], linspace = [1, 2, 3]}',
    "1e1200 points": "[sweep]\n" + "".join(f'"x.a{i}" = {{linspace = [0, 1, 1000]}}\n' for i in range(400)),
    "2,000 long fields": 'combine = "zip"\n[sweep]\n'
    + "".join(f'"x.a{i}" = {{linspace = [0, 1, 500000]}}\n' for i in range(2000)),
    "5,000 short fields": "[sweep]\n" + "".join(f'"x.a{i}" = [1]\n' for i in range(5000)),
    "100,000 wrong points": '[sweep]\n"radio.loss" = {linspace = [2, 3, 100000]}',
    "itself": 'file = "hostile.toml"',
    **{
        f"{key} that is {kind}": f'{key} = "{name}"'
        for key in ("file", "design")
        for kind, name in {
            "NUL": r"a\u0000",
            "zeros": "/dev/zero",
            "noise": "/dev/urandom",
            "a folder": "folder",
            "too long": "x" * 3000,
            "a pipe": "pipe",
            "a loop": "loop",
            "a terabyte": "sparse",
            "elsewhere": "../../../../../../etc/shadow-",
        }.items()
    },
    "until 0": "until = {width = 0}",
    "until nan": "until = {decided = nan}",
    "until most of nines": f"until = {{width = 0.1, most = {NINES}}}",
    "until most": "until = {most = 5}",
    "60,000 keys": "".join(f"k{i} = 1\n" for i in range(60_000)),
    "a long key": "x" * 900_000 + " = 1",
    "a key of control characters": r'"a\nfeasibee: b\u001b" = 1',
    "a field of control characters": "[sweep]\n" + r'"a\nfeasibee: b\u001b.c" = [1]',
    "a field of NUL": "[sweep]\n" + r'"\u0000" = [1]',
    "an empty field": '[sweep]\n"" = [1]',
    "a field of dots": '[sweep]\n"..." = [1]',
    "a field of 3,000 parts": f'[sweep]\n"{".".join("a" * 3000)}" = [1]',
    "tables of 3,000 parts": f"[sweep.{'.'.join('a' * 3000)}]\nb = [1]",
    "an attribute": '[sweep]\n"decision.__class__" = [1]',
    "a private attribute": "[sweep]\n_strategy = [1]",
    "a place before the first": '[sweep]\n"robots.classes.-1.count" = [1]',
    "a place that isn't there": '[sweep]\n"robots.classes.0.count" = [1]',
    "an unknown preset": '[sweep]\npreset = ["nope"]',
    "wrong classes": '[sweep]\n"robots.classes" = [[1], ["a"], [{}]]',
    "wrong strategies": '[sweep]\n"decision.strategy" = ["nope", 1, "/dev/zero", "a.py", ""]',
    "points that are devices": '[sweep]\n"tasks.points" = ["/dev/zero", "pipe", "."]',
    "a wrong scenario": "[scenario]\ntasks.count = -1\nradio.loss = 2\n",
    "a seed of 65 bits": "seed = 18446744073709551616",
    "runs of 33 bits": "runs = 4294967297",
    "no values": '[sweep]\n"tasks.count" = []',
}

TABLES = {
    "nothing": "",
    "blank lines": "\n\n\n",
    "NUL": "tasks.count\n\0\n",
    "an open quote": 'tasks.count\n"1\n',
    "a quote within": 'tasks.count\n"1"2"x\n',
    "a long value": "tasks.count\n" + "1" * 200_000,
    "100,000 columns": "tasks.count" + ",1" * 100_000 + "\n1\n",
    "unknown fields": ",".join(f"x.a{i}" for i in range(500)) + "\n" + ",".join("1" * 500) + "\n",
    "nan": "radio.loss\nnan\n",
    "5,000 digits": "tasks.count\n" + "9" * 5000 + "\n",
    "overflow": "decision.gain\n1e999\n",
    "a comment": "tasks.count\n1 # x\n",
    "a second line": 'tasks.count\n"1\nx=2"\n',
    "a list": 'tasks.count\n"[1,2]"\n',
    "a date": "tasks.count\n1979-05-27\n",
    "nothing in a row": "tasks.count,radio.loss\n,\n",
    "nothing in line 1": ",\n1,2\n",
    "control characters": "a\x1b.b\n1\n",
    "an attribute": "decision.__class__\n1\n",
    "3,000 parts": ".".join("a" * 3000) + "\n1\n",
    "20,000 wrong rows": "tasks.count\n" + "".join(f"x{i}\n" for i in range(20_000)),
    "a formula": "tasks.count\n=1+1\n",
    "devices": "tasks.points\n/dev/zero\n",
    "deep brackets": "tasks.count\n" + "[" * 5000 + "\n",
    "below 0": "tasks.count\n-1\n",
    "UTF-16": "tasks.count\n5\n".encode("utf-16"),
}
"""Designs."""

POINTS = {
    "a header only, of other columns": "lat,lon\n",
    "three columns": "1,2,3\n",
    "one column": "1\n" * 100_000,
    "words": "a,b\n" * 100_000,
    "nan": "nan,1\n",
    "infinity": "inf,-inf\n",
    "overflow": "1e999,1\n",
    "5,000 digits": "9" * 5000 + ",x\n",
    "semicolons": "1;2\n",
    "decimal commas": "1,5;2,5\n",
    "an open quote": '"1,2\n',
    "a long value": "1" * 200_000 + ",2\n",
    "control characters": "\x1b[31m,1\n",
    "a line that lies": "1,\u2028feasibee: all is well\n",
    "NUL": "1,\0\n",
    "bytes": b"1,\xff\n",
    "outside": "-1,5\n" * 100_000,
    "nothing": "",
    "a header only": "x,y\n",
    "JSON": "[[1, 2]]",
}
"""Points of tasks, placed at them."""


def scenarios() -> Iterator[tuple[str, str]]:
    """Yield names and texts of scenarios: each field with each kind of value, and by hand."""
    for path in fields():
        section, _, field = path.partition(".")
        for kind, value in VALUES.items():
            if f"{path} {kind}" not in FINE:
                yield f"{path}: {kind}", f"[{section}]\n{field} = {value}\n"
    for section in SECTIONS:
        for kind, value in VALUES.items():
            if f"{section} {kind}" not in FINE:
                yield f"{section}: {kind}", f"{section} = {value}\n"
    yield from BY_HAND.items()


def studies() -> Iterator[tuple[str, str]]:
    """Yield names and texts of studies."""
    for key in KEYS:
        for kind, value in VALUES.items():
            if f"{key} {kind}" not in FINE_KEYS:
                yield f"{key}: {kind}", f"{key} = {value}\n"
    for kind, value in VALUES.items():
        if kind != "long list":  # 20,000 times one task
            yield f"sweep.tasks.count: {kind}", f'[sweep]\n"tasks.count" = {value}'
        if kind != "tiny":
            yield f"sweep.radio.loss: {kind}", f'[sweep]\n"radio.loss" = [{value}]'
    for kind in ("range", "linspace", "logspace"):
        for numbers in RANGES:
            yield f"{kind}: {numbers[:20]}", f'[sweep]\n"decision.gain" = {{{kind} = {numbers}}}'
    yield from STUDIES.items()

"""What stands in files: scenarios, studies, points and designs that are wrong, by combination and by hand."""

from __future__ import annotations

from collections.abc import Iterator

from feasibee.simulation.plan import KEYS

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
"""TOML of all kinds; each is wrong for nearly every key."""

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
    "60,000 parameters": "[decision.parameters]\n" + "".join(f"p{i} = 1.0\n" for i in range(60_000)),
    "60,000 keys": "".join(f"k{i} = 1\n" for i in range(60_000)),
    "20,000 classes": '[[robots.classes]]\nname = "a"\n' * 20_000,
    "a long key": "x" * 900_000 + " = 1",
    "a key of 500,000 parts": ".".join("a" * 500_000) + " = 1",
    "a table of 500,000 parts": "[" + ".".join("a" * 500_000) + "]",
    "deep lists": "a = " + "[" * 100_000,
    "deep tables": "a = " + "{a = " * 100_000,
    "a million quotes": "'" * 1_000_000,
    "5,000 digits": f"tasks.count = {'9' * 5000}",
    "an exponent": f"arena.side = 1e{'9' * 5000}",
    "names of control characters": r'robots.classes = [{name="a\nb", count=1}, {name="\u001b[31m", count=2}]',
    "a parameter of NUL": r'decision.parameters = {"\u0000" = 1.0}',
    "a key of control characters": r'"a\nfeasibee: b\u001b" = 1',
    "a strategy of NUL": r'decision.strategy = "a\u0000.py"',
    "a strategy far too long": f'decision.strategy = "{"x" * 30_000}.py"',
    "a strategy that is a pipe": 'decision.strategy = "pipe.py"',
    "a strategy that is a device": 'decision.strategy = "/dev/zero"',
    "points that are zeros": 'tasks.points = "/dev/zero"',
    "points that are a pipe": 'tasks.points = "pipe"',
    "points of a terabyte": 'tasks.points = "sparse"',
    "a quantity of nines": f'units.metres = 1e-9\nsensing.range = "{NINES} km"',
    "20,000 quantities": "arena.side = [" + '"1 s",' * 20_000 + "]",
    "too much to remember": 'robots.count = 1000000\ntasks.count = 10000000\nsensing.observation = "unique"',
    "a section twice": "[[robots]]\ncount = 1",
    "a field with fields": "[robots.count.x]\ny = 1",
    "marks of order": "\ufeff\ufeff[robots]",
    "control characters": "\x01\x02",
    "HTML": "<html>" * 1000,
    "NUL": "\0" * 100,
}
"""Scenarios."""

RANGES = (
    "[0, 1, 1e-320]",
    "[0, 1, 0]",
    "[0, 1]",
    "[nan, 1, 2]",
    "[0, 1, -1]",
    f"[0, 1, {NINES}]",
    "[[0], 1, 2]",
    "[true, 1, 2]",
    "5",
    "[1e15, -1e15, -1e-320]",
)
FINE_KEYS = {"curves true", "scenario table", "sweep table"}

STUDIES = {
    "two kinds of range": '[sweep]\n"tasks.count" = {range = [0, 1, 1], linspace = [1, 2, 3]}',
    "1e1200 points": "[sweep]\n" + "".join(f'"x.a{i}" = {{linspace = [0, 1, 1000]}}\n' for i in range(400)),
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
    "until nan": "until = {decided = nan}",
    "until most": "until = {most = 5}",
    "a field of control characters": "[sweep]\n" + r'"a\nfeasibee: b\u001b.c" = [1]',
    "a field of 3,000 parts": f'[sweep]\n"{".".join("a" * 3000)}" = [1]',
    "tables of 3,000 parts": f"[sweep.{'.'.join('a' * 3000)}]\nb = [1]",
    "an attribute": '[sweep]\n"decision.__class__" = [1]',
    "a place before the first": '[sweep]\n"robots.classes.-1.count" = [1]',
    "a place that isn't there": '[sweep]\n"robots.classes.0.count" = [1]',
    "wrong strategies": '[sweep]\n"decision.strategy" = ["nope", 1, "/dev/zero", "a.py", ""]',
    "a seed of 65 bits": "seed = 18446744073709551616",
    "runs of 33 bits": "runs = 4294967297",
}

TABLES = {
    "nothing": "",
    "NUL": "tasks.count\n\0\n",
    "a long value": "tasks.count\n" + "1" * 200_000,
    "100,000 columns": "tasks.count" + ",1" * 100_000 + "\n1\n",
    "5,000 digits": "tasks.count\n" + "9" * 5000 + "\n",
    "a comment": "tasks.count\n1 # x\n",
    "nothing in a row": "tasks.count,radio.loss\n,\n",
    "control characters": "a\x1b.b\n1\n",
    "3,000 parts": ".".join("a" * 3000) + "\n1\n",
    "20,000 wrong rows": "tasks.count\n" + "".join(f"x{i}\n" for i in range(20_000)),
    "UTF-16": "tasks.count\n5\n".encode("utf-16"),
}
"""Designs."""

POINTS = {
    "three columns": "1,2,3\n",
    "infinity": "inf,-inf\n",
    "5,000 digits": "9" * 5000 + ",x\n",
    "an open quote": '"1,2\n',
    "a long value": "1" * 200_000 + ",2\n",
    "control characters": "\x1b[31m,1\n",
    "bytes": b"1,\xff\n",
    "outside": "-1,5\n" * 100_000,
    "a header only": "x,y\n",
}
"""Points of tasks, placed at them."""


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

"""Translated functions do in C what they do in Python, and what can't be translated is an error."""

from __future__ import annotations

import subprocess
from typing import NamedTuple

import pytest

from feasibee.base.errors import FeasibeeError
from feasibee.robot.firmware import header
from feasibee.robot.language import BOOL, INT, LONG, REAL, ROW, WORD
from feasibee.robot.translate import Translation
from tests.robot.driving import SANITIZED

DOUBLE = "-DFEASIBEE_DOUBLE"


# --- Numbers ---

SMALL = [0, 1, -1, 2, -2, 3, -3, 7, -7, 8, -8, 31, 63, 255, 1000, -1000]
INTS = [*SMALL, 2**15, -(2**15), 2**16 - 1, 46_340, 2**30, -(2**30), 2**31 - 1, -(2**31), -(2**31) + 1]
LONGS = [*INTS, 2**31, 2**32 - 1, 2**32, -(2**32), 2**53 + 1, 2**62, 2**63 - 1, -(2**63) + 1]
WORDS = [0, 1, 2, 3, 127, 128, 2**16, 2**31 - 1, 2**31, 2**31 + 1, 2**32 - 2, 2**32 - 1]
REALS = [0.0, 0.5, -0.5, 1.0, -1.0, 1.5, -1.5, 2.0, -2.0, 1000.25, -1000.25, 1048575.5, -1048576.0]
SHIFTS = [0, 1, 2, 7, 15, 16, 29, 30]
EDGES = {INT: INTS, LONG: LONGS, WORD: WORDS, REAL: REALS, BOOL: [0, 1]}
"""Numbers to try, by their type in C."""
PAIRS = "a // b", "a % b", "min(a, b)", "max(a, b)", "a + b", "a - b", "a * b", "a & b", "a | b", "a ^ b"
ORDERS = "a < b", "a <= b", "a == b", "a != b", "a > b", "a >= b", "a < b < 7", "a in (b, 3)"
ONES = (
    "abs(a)",
    "-a",
    "~a",
    "+a",
    "not a",
    "a.bit_length()",
    "a.bit_count()",
    "int(a)",
    "bool(a)",
    "a // 4",
    "a % 8",
)
MORE = (
    "a // 3",
    "a % 3",
    "a // -3",
    "a % -3",
    "a >> 1",
    "a & 0xFFFFFFFF",
    "a & 255",
    "a % 2**32",
    "a if a else 5",
)
MODULAR = "a + b & 0xFFFFFFFF", "a - b & 0xFFFFFFFF", "a * b & 0xFFFFFFFF", "(a ^ b) & 0xFFFFFFFF"


class Case(NamedTuple):
    """An expression, the types of its arguments, and what to try for the second one, if not the edges."""

    expression: str
    types: tuple[str, ...]
    second: list[int] | None = None


CASES = [
    *(Case(each, (kind, kind)) for kind in (INT, LONG) for each in (*PAIRS, *ORDERS, *MODULAR)),
    *(Case(each, (kind,)) for kind in (INT, LONG) for each in (*ONES, *MORE)),
    *(
        Case(each, (WORD, WORD))
        for each in (*ORDERS, *MODULAR, "min(a, b)", "max(a, b)", "a ^ b", "a - b", "a + b")
    ),
    *(
        Case(each, (WORD,))
        for each in ("a.bit_length()", "a.bit_count()", "a // 8", "a % 128", "a >> 7", "-a", "~a")
    ),
    *(Case(each, types) for types in ((WORD, INT), (INT, WORD)) for each in (*ORDERS, *PAIRS)),
    *(Case(each, (INT,), SHIFTS) for each in ("2**a", "1 << a", "3**a")),
    *(Case(each, (INT, INT), SHIFTS) for each in ("a << b", "a >> b")),
    Case("a >> b", (WORD, INT), SHIFTS),
    Case("a << b", (LONG, INT), SHIFTS),
    Case("2**b - 1 - a", (INT, INT), [31, 40, 61]),
    Case("a * b // c", (INT, INT, INT)),
    *(
        Case(each, (REAL,))
        for each in ("math.floor(a)", "math.ceil(a)", "int(a)", "abs(a)", "-a", "a * 2", "a > 1")
    ),
    *(Case(each, (REAL, REAL)) for each in ("min(a, b)", "max(a, b)", "a + b", "a < b", "a == b")),
    Case("min(a, b)", (REAL, INT), SMALL),
    Case("a + b", (BOOL, BOOL)),
    *(Case(each, (INT,)) for each in ("a in TABLE", "min(a % 9, max(TABLE)) + TABLE[-1]")),
    *(Case(each, (INT,)) for each in ("helper(a)", "helper(b=a % 7, a=9)")),
]
MODES = {"double": (DOUBLE,), "32 bits": (DOUBLE, "-DFEASIBEE_INT32"), "whole": ()}


def functions_of(cases):
    """Return a function for each expression, and the text of their module."""
    lines = ["import math", "TABLE = (7, -3)", "def helper(a, b=3):", "    return a % 5 - b", ""]
    for number, case in enumerate(cases):
        lines += [
            f"def f{number}({', '.join('abc'[: len(case.types)])}):",
            f"    return {case.expression}",
            "",
        ]
    text = "\n".join(lines)
    names = {"__name__": "snippets"}
    exec(compile(text, "snippets.py", "exec"), names)
    return [names[f"f{number}"] for number in range(len(cases))], text


def tries_of(case, wide):
    """Yield arguments."""
    edges = [
        case.second if case.second and place == len(case.types) - 1 else EDGES[kind]
        for place, kind in enumerate(case.types)
    ]
    if len(edges) == 1:
        yield from ((a,) for a in edges[0])
    elif len(edges) == 2:
        yield from ((a, b) for a in edges[0] for b in edges[1])
    else:
        yield from ((a, b, c) for a in edges[0] for b in edges[1] for c in edges[2])


def fits(value, kind, wide):
    """Return whether a number has a type in C."""
    limits = {INT: (2**63 if wide else 2**31), LONG: 2**63}
    if kind in limits:
        return -limits[kind] <= value < limits[kind]
    return kind == REAL or 0 <= value < 2**32


def expected(function, case, result, arguments, wide):
    """Return what Python computes, None if it fails, or the result has no place in C."""
    try:
        value = function(*arguments)
    except ZeroDivisionError:
        return None
    if case.expression == "a % b" and not fits(arguments[0] // arguments[1], case.types[0], wide):
        return None  # C can't divide the least number by -1, and so doesn't have the rest
    if not fits(value, result, wide) or (case.expression == "3**a" and value > 2**30):
        return None
    return float(value) if result == REAL else int(value)


def main_of(signatures):
    """Return a program in C that reads numbers of functions and their arguments, and prints the results."""
    lines = ["#include <stdio.h>", "int main(void)", "{", "    int number;", "    double x[3] = {0};"]
    lines += [
        "    long long n[3] = {0};",
        '    while (scanf("%d %lld %lld %lld %lf %lf", &number, n, n + 1, n + 2, x, x + 1) == 6)',
    ]
    lines += ["        switch (number) {"]
    for number, each in enumerate(signatures):
        given = ", ".join(
            f"({kind}){'x' if kind == REAL else 'n'}[{k}]" for k, kind in enumerate(each.arguments)
        )
        form, kind = ("%.17g", "double") if each.result == REAL else ("%lld", "long long")
        lines += [f'        case {number}: printf("{form}\\n", ({kind}){each.name}({given})); break;']
    return "\n".join([*lines, "        }", "    return 0;", "}", ""])


def line_of(number, case, arguments):
    """Return what the program reads of a call."""
    whole = [0 if kind == REAL else each for each, kind in zip(arguments, case.types, strict=True)]
    real = [each if kind == REAL else 0.0 for each, kind in zip(arguments, case.types, strict=True)]
    whole, real = (*whole, 0, 0)[:3], (*real, 0.0, 0.0)[:2]
    return " ".join(map(str, (number, *whole, *real)))


@pytest.mark.parametrize("mode", MODES)
def test_numbers_are_those_of_python(mode, tmp_path):
    functions, text = functions_of(CASES)
    translation = Translation(texts={"snippets": ("", text)})
    signatures = [
        translation.function(function, case.types) for function, case in zip(functions, CASES, strict=True)
    ]
    code = "\n".join(['#include "feasibee.h"', *translation.functions, main_of(signatures)])
    (tmp_path / "feasibee.h").write_text(header("tally"))
    (tmp_path / "program.c").write_text(code)
    command = [
        "cc",
        "-std=c99",
        *MODES[mode],
        *SANITIZED,
        tmp_path / "program.c",
        "-lm",
        "-o",
        tmp_path / "program",
    ]
    subprocess.run(command, check=True)
    wide, calls = mode == "double", []
    for number, (case, function, made) in enumerate(zip(CASES, functions, signatures, strict=True)):
        for arguments in tries_of(case, wide):
            value = expected(function, case, made.result, arguments, wide)
            if value is not None:
                calls.append((number, case, arguments, value))
    given = "\n".join(line_of(*call[:3]) for call in calls)
    ran = subprocess.run([tmp_path / "program"], input=given, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr[-3000:]
    printed = ran.stdout.split()
    assert len(printed) == len(calls) > 10_000
    for (_, case, arguments, value), said in zip(calls, printed, strict=True):
        assert type(value)(said) == value, (case.expression, case.types, arguments)


# --- What the language of strategies doesn't have ---

WRONG = [
    ("return [1, 2]", 2, "[1, 2]; write it with numbers, rows and calls of functions"),
    ("return sum([k for k in known])", 2, "sum(...); write a loop"),
    ("numbers = [k for k in known]", 2, "[k for k in known]; write it with numbers"),
    ("known[0] = 'one'", 2, "known[0] is given a value of another type; write int(...)"),
    ("return {1: 2}", 2, "{1: 2}; write it with numbers, rows and calls of functions"),
    ("return known[1:2]", 2, "known[1:2]; write a loop over the places"),
    (
        "while known[0] > 1:\n        pass\n    else:\n        return 1",
        2,
        "a loop with else; write if after it",
    ),
    (
        "for k in known:\n        pass",
        2,
        "a loop over known; write for k in range(number), and take what is at k",
    ),
    ("for a, b in range(2):\n        pass", 2, "(a, b) in a range; use one name"),
    (
        "for k in (1, 2):\n        break",
        2,
        "a loop over numbers written out, with break or continue; use range",
    ),
    ("return f(known, me)", 1, "f calls itself; write a loop"),
    ("return unknown", 2, "the name unknown; use arguments, own variables, and constants of the file"),
    ("return max(1, 2, key=abs)", 2, "max(1, 2, key=abs); give the arguments in their order, one by one"),
    ("x = 1\n    x = (1, 2)\n    return x[0]", 3, "x is now one type, now another; use two names"),
    ("return me.speed", 2, "me.speed; use one of id, kind, hash, step, explores, setting, memory, x, y"),
    ("return me.setting.colour", 2, "me.setting.colour; use one of robots, count, tasks"),
    ("return math.gamma(1.0)", 2, "math.gamma; use one of sqrt, log"),
    ("return round(2.5)", 2, "round(...); write math.floor(number + 0.5)"),
    ("print(known[0])", 2, "print(...); leave it out"),
    (
        "try:\n        return 1\n    except ValueError:\n        return 2",
        2,
        "a statement of the kind 'try'; write assignments",
    ),
    ("return lambda: 1", 2, "lambda: 1; write it with numbers, rows and calls of functions"),
    ("return known[0.5]", 2, "known[0.5]; take one number out of a row, by a whole number"),
    ("known[0] = 0.5", 2, "known[0] is given a value of another type; write int(...)"),
    ("return 1 if known else 0", 2, "known as a condition; compare it with a number"),
    ("return known + 1", 2, "known as a number; compute with numbers, one by one"),
    ("return 1.5 & 1", 2, "1.5 & 1; use whole numbers, or math.floor and math.fmod"),
    ("me.id = 1", 2, "an assignment to me.id; assign to a name, or to row[place]"),
    ("return known[0] is None", 2, "known[0] is None; compare numbers with ==, !=, <, <=, > or >="),
    ("a, b = (1, 2, 3)\n    return a + b", 2, "2 names for another number of values; give each one"),
    ("return helper(1)", 2, "helper(1); give the arguments of helper, all of them"),
    ("x = nothing()\n    return 1", 2, "x is given nothing; call a function that returns a number"),
    ("return None", 2, "None; write a number"),
    ("return (1, 2)[2]", 2, "(1, 2)[2]; write a number from 0 to 1"),
    ("return abs(*known)", 2, "abs(*known); give the arguments in their order, one by one"),
    ("return len(1)", 2, "len(1); take the length of a row"),
    ("return known.index(1)", 2, "known.index(1); use functions of numbers"),
]
"""Bodies of a function, the line that is wrong, and the error."""
FILE = """def f(known, me):
    {body}


def helper(a, b):
    return a + b


def nothing():
    pass


import math
"""


@pytest.mark.parametrize(("body", "line", "error"), WRONG, ids=[body for body, *_ in WRONG])
def test_what_cannot_be_translated_is_an_error_that_says_where_and_what_to_write(body, line, error):
    text, names = FILE.format(body=body), {"__name__": "mine"}
    exec(compile(text, "some/folder/mine.py", "exec"), names)
    with pytest.raises(FeasibeeError) as caught:
        Translation(texts={"mine": ("", text)}).function(names["f"], (ROW, "me"))
    assert str(caught.value).startswith(f"mine.py, line {line}: {error}")

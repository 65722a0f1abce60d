"""Names, numbers and words that no option takes."""

from __future__ import annotations

NAMES = {
    "nul": "a\0b",
    "far too long": "x" * 5000,
    "a loop": "loop",
    "below a file": "plain/a",
    "nowhere": "no/such/place",
    "no text": "\udcff\udcfe",
    "lines": "a\nfeasibee: all is well\nb",
    "a terminal's": "\x1b[2J\x1b]0;owned\x07",
    "right to left": "\u202egnp.a",
}
"""Names of files that aren't there or can't be."""

THINGS = {
    "zeros": "/dev/zero",
    "full": "/dev/full",
    "a pipe": "pipe",
    "a folder": "folder",
    "root": "/",
    "memory": "/proc/self/mem",
    "bytes": "bytes",
    "a socket": "socket",
}
"""What is there and is no text."""

NUMBERS = {
    "empty": "",
    "minus": "-1",
    "huge": "9" * 30,
    "exponent": "1e3",
    "half": "1.5",
    "superscript": "²",
    "nan": "nan",
    "inf": "inf",
    "nul": "1\x00",
    "lines": "1\n2",
    "long": "x" * 100_000,
    "surrogate": "\udcff",
}
"""What no whole number from 1 on looks like."""

LENGTHS = {
    name: text
    for name, text in {**NUMBERS, "overflow": "1e999", "minus zero": "-0.0", "zero": "0"}.items()
    if name not in ("exponent", "half")
}
"""What no length looks like."""

WORDS = {
    "empty": "",
    "nul": "a\0b",
    "lines": "a\nb",
    "escape": "\x1b[31m",
    "long": "x" * 100_000,
    "many": ",".join(f"x{i}" for i in range(20_000)),
    "dot": ".",
    "dunder": "decision.__class__",
    "surrogate": "\udcff",
    "format": "%s%n{0}",
    "markup": "[bold]x[/bold]",
}
"""What no field, strategy or preset is called."""

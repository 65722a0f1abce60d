"""Names, numbers and words that no option takes."""

from __future__ import annotations

NAMES = {
    "nul": "a\0b",
    "too long": "x" * 300,
    "far too long": "x" * 5000,
    "too many folders": "a/" * 3000 + "a",
    "a loop": "loop",
    "below a loop": "loop/a",
    "below a file": "plain/a",
    "nowhere": "no/such/place",
    "no text": "\udcff\udcfe",
    "no character": "\ud800",
    "lines": "a\nfeasibee: all is well\nb",
    "a terminal's": "\x1b[2J\x1b]0;owned\x07",
    "right to left": "\u202egnp.a",
}
"""Names of files that aren't there or can't be."""

THINGS = {
    "zeros": "/dev/zero",
    "noise": "/dev/urandom",
    "nothing": "/dev/null",
    "full": "/dev/full",
    "a pipe": "pipe",
    "a link to a pipe": "link-to-pipe",
    "a folder": "folder",
    "here": ".",
    "root": "/",
    "memory": "/proc/self/mem",
    "bytes": "bytes",
    "a terabyte": "sparse",
    "a socket": "socket",
}
"""What is there and is no text."""

NUMBERS = {
    "empty": "",
    "blank": " ",
    "word": "many",
    "minus": "-1",
    "minus huge": "-" + "9" * 30,
    "huge": "9" * 30,
    "digits": "9" * 5000,
    "exponent": "1e3",
    "half": "1.5",
    "superscript": "²",
    "fraction": "½",
    "roman": "Ⅷ",
    "nan": "nan",
    "inf": "inf",
    "nul": "1\x00",
    "two": "1 2",
    "lines": "1\n2",
    "hex": "0x10",
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
    "blank": " ",
    "unknown": "nope",
    "nul": "a\0b",
    "lines": "a\nb",
    "escape": "\x1b[31m",
    "long": "x" * 100_000,
    "many": ",".join(f"x{i}" for i in range(20_000)),
    "dots": ".".join(["a"] * 3000),
    "dot": ".",
    "dunder": "decision.__class__",
    "private": "decision._strategy",
    "model": "decision.model_fields",
    "surrogate": "\udcff",
    "format": "%s%n{0}",
    "brackets": "[" * 2000,
    "markup": "[bold]x[/bold]",
}
"""What no field, strategy or preset is called."""

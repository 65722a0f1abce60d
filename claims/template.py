"""A sentence of a page with its numbers marked: ``right in {fifty.accuracy:.2f} of the runs``."""

from __future__ import annotations

import builtins
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import feasibee.results.statistics
from claims.values import MINUS, SPEC, mean, median, number, printed, show

NUMBER = rf"[+{MINUS}]?\d+(?:,\d{{3}})*(?:\.\d+)?"
VALUE = rf"(?:\d{{4}}-\d\d-\d\d|{NUMBER}(?:\s+\({NUMBER}\s+to\s+{NUMBER}\))?|never)"
GAP = r"(?:\s+>)*\s+"
"""The gap between two words; a line may end there, in a quotation, too."""
SLOT = re.compile(r"\{([^{}]+)\}")
NAMES = (
    "abs",
    "all",
    "any",
    "enumerate",
    "len",
    "list",
    "max",
    "min",
    "range",
    "round",
    "sorted",
    "str",
    "sum",
    "zip",
)
ALLOWED = {name: getattr(builtins, name) for name in NAMES}
HELPERS = {
    "mean": mean,
    "median": median,
    "printed": printed,
    "prod": math.prod,
    "stats": feasibee.results.statistics,
}


@dataclass(frozen=True)
class Slot:
    """A number of a page: a Python expression for its value, and its format."""

    expression: str
    spec: str

    @classmethod
    def parse(cls, text: str) -> Slot:
        """Return the slot between two braces; a valid format after the last colon is its format."""
        expression, _, spec = text.rpartition(":")
        if not expression or not SPEC.fullmatch(spec):
            expression, spec = text, ""
        return cls(expression.strip(), spec)

    @property
    def is_word(self) -> bool:
        """Whether the slot holds words, not a number."""
        return self.spec.startswith("s")

    def measured(self, outcomes: Mapping[str, Any]) -> str:
        """Return the measured value, as the page writes it."""
        return show(evaluate(self.expression, outcomes), self.spec)

    def agrees(self, stated: str, measured: str) -> bool:
        """Return whether the stated value equals the measured one, within the tolerance."""
        tolerance = SPEC.fullmatch(self.spec)[4]
        if tolerance == "±" or stated.split() == measured.split():
            return True
        if not tolerance:
            return False
        share = float(tolerance.strip("±%")) / 100
        return math.isclose(number(stated), number(measured), rel_tol=share)


@dataclass(frozen=True)
class Template:
    """A text with slots."""

    text: str

    @cached_property
    def slots(self) -> list[Slot]:
        """The slots of the text, in order."""
        return [Slot.parse(text) for text in SLOT.findall(self.text)]

    @cached_property
    def literals(self) -> list[str]:
        """The texts between the slots; one more than the number of slots."""
        return SLOT.split(self.text.strip())[::2]

    def pattern(self, value: str = VALUE) -> re.Pattern[str]:
        """Return a pattern that finds the text with any numbers; slots of words have the format ``s``."""
        parts = [_literal(self.literals[0])]
        for slot, literal in zip(self.slots, self.literals[1:], strict=True):
            parts += [f"({r'[^|]+?' if slot.is_word else value})", _literal(literal)]
        return re.compile("".join(parts))

    def filled(self, outcomes: Mapping[str, Any]) -> str:
        """Return the text with the measured values."""
        values = [slot.measured(outcomes) for slot in self.slots]
        return self.literals[0] + "".join(
            value + literal for value, literal in zip(values, self.literals[1:], strict=True)
        )


def evaluate(expression: str, outcomes: Mapping[str, Any]) -> Any:
    """Return the value of an expression over the outcomes of commands.

    Files of claims, with their commands, are code of this repository, not input from outside.
    """
    return eval(f"({expression})", {"__builtins__": ALLOWED, **HELPERS, **outcomes})


def _literal(text: str) -> str:
    """Return a pattern that finds a text with any line breaks."""
    return "".join(GAP if part.isspace() else re.escape(part) for part in re.split(r"(\s+)", text) if part)

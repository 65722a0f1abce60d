"""Why a user's strategy fails in C, as numbers that C and Python share."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum
from typing import Final


class Failing(IntEnum):
    """Why a strategy fails, as ``checked.h`` names it."""

    PLACE = 1
    WHOLE_DIVISION = 2
    WHOLE_MODULO = 3
    DIVISION = 4
    REAL_DIVISION = 5
    REAL_MODULO = 6
    LEFT_SHIFT = 7
    RIGHT_SHIFT = 8
    SUM = 9
    DIFFERENCE = 10
    PRODUCT = 11
    QUOTIENT = 12
    POWER = 13
    SHIFT = 14
    NEGATION = 15
    SIZE = 16
    WHOLE = 17
    FLOOR = 18
    CEIL = 19
    ROUND = 20
    WHOLE_OF_NAN = 21
    WHOLE_OF_INFINITY = 22
    ZERO_POWER = 23
    ROOT = 24
    REAL_POWER = 25
    NEGATIVE_EXPONENT = 26
    STEP = 27
    NO_VALUE = 28
    NO_RESULT = 29
    ASSERTION = 30
    RATIO = 31
    ENDLESS = 32


PASSES: Final = 2**30
"""Most passes of one loop: about a second."""
OF_MATH: Final[Mapping[str, int]] = {
    **dict.fromkeys(("acos", "acosh", "asin", "asinh", "atan", "atanh", "cbrt", "cos", "cosh"), 1),
    **dict.fromkeys(("degrees", "erf", "erfc", "exp", "exp2", "expm1", "fabs", "log", "log10", "log1p"), 1),
    **dict.fromkeys(("log2", "radians", "sin", "sinh", "sqrt", "tan", "tanh"), 1),
    **dict.fromkeys(("atan2", "copysign", "fmod", "hypot", "pow"), 2),
}
"""Functions of ``math`` that return a real number, and their numbers of arguments."""
DOMAIN: Final = 100
RANGE: Final = 200
RESULT: Final = 300
"""To these the number of the function is added that fails so: one of `OF_MATH`, or of the contract."""


def enumeration() -> str:
    """Return the failures as an enumeration in C."""
    named = {each.name: each.value for each in Failing} | {"PASSES": PASSES}
    for number, name in enumerate(OF_MATH):
        named |= {f"DOMAIN_{name}": DOMAIN + number, f"RANGE_{name}": RANGE + number}
    lines = [f"    {name} = {value}," for name, value in named.items()]
    return "\n".join(["enum failing {", *lines, "};\n"])

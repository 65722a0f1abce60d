"""Why a user's strategy fails in C, as numbers that C and Python share."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum
from typing import Final

PASSES: Final = 2**30
"""Most passes of one loop: about a second."""
_LARGE: Final = "compute with real numbers, such as float(...)"
_BY_ZERO: Final = "test that it isn't 0 before"


class Failing(IntEnum):
    """Why a strategy fails, as ``checked.h`` names it, numbered from 1.

    Each has Python's error, empty if it raises none; what failed, with places for two numbers; and a remedy.
    """

    words: tuple[str, str, str]

    def __new__(cls, kind: str, what: str, remedy: str) -> Failing:
        """Return the next failure."""
        made = int.__new__(cls, len(cls.__members__) + 1)
        made._value_ = int(made)
        made.words = kind, what, remedy
        return made

    PLACE = "IndexError", "place {0} in a row of {1}", "take one from 0 on that is below its length"
    WHOLE_DIVISION = "ZeroDivisionError", "{0} // 0", _BY_ZERO
    WHOLE_MODULO = "ZeroDivisionError", "{0} % 0", _BY_ZERO
    DIVISION = "ZeroDivisionError", "{0!r} / 0", _BY_ZERO
    REAL_DIVISION = "ZeroDivisionError", "{0!r} // 0", _BY_ZERO
    REAL_MODULO = "ZeroDivisionError", "{0!r} % 0", _BY_ZERO
    LEFT_SHIFT = "ValueError", "{0} << {1}", "shift by 0 places or more"
    RIGHT_SHIFT = "ValueError", "{0} >> {1}", "shift by 0 places or more"
    SUM = "OverflowError", "{0} + {1} leaves 64 bits", _LARGE
    DIFFERENCE = "OverflowError", "{0} - {1} leaves 64 bits", _LARGE
    PRODUCT = "OverflowError", "{0} * {1} leaves 64 bits", _LARGE
    QUOTIENT = "OverflowError", "{0} // {1} leaves 64 bits", _LARGE
    POWER = "OverflowError", "{0} ** {1} leaves 64 bits", _LARGE
    SHIFT = "OverflowError", "{0} << {1} leaves 64 bits", _LARGE
    NEGATION = "OverflowError", "-({0}) leaves 64 bits", _LARGE
    SIZE = "OverflowError", "abs({0}) leaves 64 bits", _LARGE
    WHOLE = "OverflowError", "int({0!r}) leaves 64 bits", "limit the number before, with min and max"
    FLOOR = "OverflowError", "math.floor({0!r}) leaves 64 bits", "limit the number before"
    CEIL = "OverflowError", "math.ceil({0!r}) leaves 64 bits", "limit the number before"
    ROUND = "OverflowError", "round({0!r}) leaves 64 bits", "limit the number before"
    WHOLE_OF_NAN = "ValueError", "a float that is no number has no whole one", "test with math.isnan"
    WHOLE_OF_INFINITY = "OverflowError", "{0!r} has no whole number", "test with math.isinf before"
    ZERO_POWER = "ZeroDivisionError", "{0!r} ** {1!r}", _BY_ZERO
    ROOT = "ValueError", "{0!r} ** {1!r} is complex", "take the power of a number of 0 or more"
    REAL_POWER = "OverflowError", "{0!r} ** {1!r} is too large", "limit the exponent before"
    NEGATIVE_EXPONENT = "ValueError", "{0} ** {1} is no whole number", "write float(base) ** exponent"
    STEP = "ValueError", "range from {0} to {1} by 0", "step by another number"
    NO_VALUE = "UnboundLocalError", "a variable has no value yet", "give it one at the beginning"
    NO_RESULT = "TypeError", "a function returns nothing", "return a number in each case"
    ASSERTION = "AssertionError", "what is asserted doesn't hold", "remove it, or what is wrong"
    RATIO = "ZeroDivisionError", "{0} / 0", _BY_ZERO
    ENDLESS = "", "a loop has passed {0:,} times", "end it sooner"


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

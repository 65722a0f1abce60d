"""Expressions and functions of strategies that use all that Python has for numbers, for tests."""

from __future__ import annotations

import math

from feasibee.engine.failing import OF_MATH

PAIRS = ("a", "b"), ("x", "y"), ("a", "x"), ("x", "a")
OF_ONE = [name for name, number in OF_MATH.items() if number == 1 and hasattr(math, name)]
COMPUTED = [
    *(f"{one} {sign} {other}" for sign in ("+", "-", "*", "/", "//", "%", "**") for one, other in PAIRS),
    *(f"{one} {sign} {other}" for sign in ("<", "<=", ">", ">=", "==", "!=") for one, other in PAIRS),
    *(f"a {sign} b" for sign in ("&", "|", "^", "<<", ">>")),
    *(f"{sign}{one}" for sign in ("-", "+", "not ") for one in "ax"),
    *(f"{name}({one})" for name in ("abs", "int", "float", "round", "bool") for one in "ax"),
    *(f"{name}({one}, {other})" for name in ("min", "max") for one, other in PAIRS),
    *(f"math.{name}(x)" for name in (*OF_ONE, "floor", "ceil", "trunc", "isnan", "isinf", "isfinite")),
    *(f"math.{name}({one})" for name, number in OF_MATH.items() if number == 2 for one in ("a, b", "x, y")),
]
"""Each operation of numbers on whole and real ones."""
EXPRESSIONS = (
    COMPUTED
    + """
a ** (b % 70)
2 ** b
a << (b % 80)
a >> (b % 80)
a | b ^ c
~a
a.bit_length() + b.bit_count()
x ** 0.5
x ** 2
-x ** 2
(-x) ** 2
int(x * 1e12)
round(x * 0.5)
min(x, y, a)
max(x, math.nan)
max(math.nan, x)
min((a, b, c))
max(TABLE)
a if x > y else b
a if x else y
a or x
a and b and c
a or b or x
(a and x) or y
not (a or x) and not y
(a < b) + (b < c)
a < b < c
a < x <= b
x != x
a in (1, 2, b)
a not in (0, 1.0, x)
a in TABLE
a % 3 in (0, 1)
LEAST + a
MOST - a
MOST + a
LEAST % a
LEAST * a
abs(LEAST + (a > 0))
-LEAST + (a * 0)
TABLE[a]
TABLE[-1] + WHOLE[2]
WHOLE[a]
WHOLE[b % 3] * x
ROWS[1][2]
ROWS[1][a % 3]
mind.memory[a]
mind.memory[0] + mind.memory[-1]
mind.memory[b % 3]
mind.parameters[a]
len(TABLE) + len(mind.memory) + len(mind.parameters)
math.sqrt(a)
math.log(a)
math.log(x, y)
math.log(x, 2)
math.exp(math.exp(x))
pow(x, y)
pow(a, b % 9)
math.floor(a)
math.gcd(a, b)
math.inf - math.inf + x
math.pi * math.e + x
log(x) if x > 0 else sqrt(y)
helper(a, b)
helper(b=a, a=b)
halves(a)[0] + halves(b)[1]
fails(a) + fails(b)
fails(b) + 1 / a
1 / a + fails(b)
fails(a) < fails(b)
write(mind, a) + write(mind, b)
write(mind, a) - mind.memory[0]
mind.memory[0] - write(mind, a)
write(mind, x) * 3 - write(mind, y) + write(mind, a)
helper(write(mind, a) > 1, write(mind, b) > write(mind, x))
write(mind, 0) < write(mind, a) < write(mind, b)
write(mind, a) in (write(mind, b), 1.0)
write(mind, a) or write(mind, b)
mixed(a)
sums(a, b)
steps(a, b, c)
counted(a)
early(a)
wandering(a)
weighed(x)
paired(a)
unset(a)
unset_late(a)
nothing(a)
never(a)
asserted(a)
shadowed(a)
augmented(mind, a)
swapped(mind, a)
chained(a)
nested(a)
long(a)
größe(a)
1e308 * x
5e-324 * x
1e-310 / x
a * 0.1 + b * 0.2
(a + 0.5) // 1
(a * 3 + b) % 7 - c
a * b % 1000003
a * b + c - a * b
int(a / b) if b else 0
a // 2 ** 3
-7 // a
7 % -b
True + a
(a > 0) * x - (b > 0)
(a > 0) & (b > 0) | (c > 0)
""".strip().splitlines()
)
"""Expressions of whole numbers a, b, c and real ones x, y."""

HELPERS = """
import math
from math import log, sqrt as root

TABLE = (0.5, 2, -3.25, 1e10)
WHOLE = (7, -2, 9_007_199_254_740_993)
ROWS = ((1, 2, 3), (4.5, 5, 6))
LEAST = -9_223_372_036_854_775_807 - 1
MOST = 2**62 - 1 + 2**62
SCALE = math.sqrt(2.0) * max(1, 2)
sqrt = root


def helper(a, b=3):
    return a % 5 - b % 7


def halves(a):
    return a // 2, a / 2


def fails(a):
    return 10 // (a % 3)


def write(mind, a):
    mind.memory[0] = mind.memory[0] * 0.5 + a
    mind.memory[1] += 1
    return mind.memory[0]


def mixed(a):
    total = 0
    if a > 2:
        total = 0.5
    return total + a // 2


def sums(a, b):
    total = 0
    for k in range(a % 10, b % 20):
        if k == 7:
            continue
        if total > 100:
            break
        total += k * k
    return total


def steps(a, b, c):
    total = 0
    for k in range(a % 10, b % 20, c % 5 - 2):
        total = total * 3 + k
    return total


def counted(a):
    n = 0
    while True:
        n += 1
        if n * n > a % 1000:
            return n


def early(a):
    last = -1
    for w in (3, 1, 4):
        if w > a % 6:
            last = w
            break
    return last


def wandering(a):
    k = 5
    for k in range(a % 3):
        k += 10
    return k


def weighed(x):
    total = 0.0
    for w in TABLE:
        total = total * 0.5 + w * x
    for w in (1, 2.5):
        total += w
    return total


def paired(a):
    total = 0
    for one, other in ((1, 2), (3, a % 7)):
        total += one * other
    for one, two, three in ROWS:
        total += one * two - three
    return total


def unset(a):
    if a % 2 == 0:
        found = a // 2
    return found


def unset_late(a):
    for k in range(a % 3):
        last = k
    return last


def nothing(a):
    if a % 2 == 0:
        return a


def never(a):
    return None if a % 2 == 0 else a


def asserted(a):
    assert a % 3 != 1
    return a


def shadowed(a):
    log = a // 3
    double, int_, max_ = log, log + 1, log + 2
    return double + int_ * max_


def augmented(mind, a):
    mind.memory[next_of(mind)] += 1 + a
    mind.memory[-1] *= 2
    n = a
    n -= 3
    n //= 2
    return n + mind.memory[0] + mind.memory[1] * 3 + mind.memory[2] * 5


def next_of(mind):
    mind.memory[2] += 1
    return int(mind.memory[2]) % 2


def swapped(mind, a):
    mind.memory[0], mind.memory[1] = mind.memory[1] + a, mind.memory[0]
    one = other = mind.memory[0]
    one, other = other + 1, one - 1
    return one * 2 - other + mind.memory[1]


def chained(a):
    m = a % 4
    return 1 if m == 0 else 2.5 if m == 1 else -3 if m == 2 else 0


def nested(a):
    found = 0
    for i in range(3):
        for j in range(i, 4):
            if (i + j) % 2 == a % 2:
                found += 10 * i + j
            elif j > 2:
                break
        else_ = found
    return found + else_


def größe(naïve):
    if naïve > 2:
        übrig = naïve
    return übrig


def long(
    a,
):
    return (
        a
        + 1 //
        (a % 2)
    )
"""


def text_of(expressions: list[str]) -> str:
    """Return the text of a strategy whose value is that of the expression which a parameter chooses."""
    lines = [
        HELPERS,
        "MEMORY = 3",
        "",
        "",
        "def decide(mind, inbox):",
        "    return mind.opinion",
        "",
        "",
        "def value(mind):",
        "    a = (int(mind.parameters[1]) << 32) + int(mind.parameters[2])",
        "    b = (int(mind.parameters[3]) << 32) + int(mind.parameters[4])",
        "    c = int(mind.parameters[5])",
        "    x, y = mind.parameters[6], mind.parameters[7]",
    ]
    for number, expression in enumerate(expressions):
        lines += [f"    if mind.parameters[0] == {number}:", f"        return {expression}"]
    return "\n".join([*lines, "    return 0.0", ""])

"""Strategies in the engine's C: what they return is what Python returns, and they fail where Python fails."""

from __future__ import annotations

import ast
import inspect
import math
import os
import shutil
import subprocess
import sys
from copy import deepcopy
from pathlib import Path
from traceback import extract_tb

import pytest

import feasibee
from feasibee import FeasibeeError
from feasibee.engine import own as own_module
from feasibee.engine.failing import DOMAIN, OF_MATH, RANGE, RESULT, Failing
from feasibee.engine.generate import ALWAYS, RETURNING, RULES, own_strategy
from feasibee.engine.own import Failure, compiled, explained, kind_of, load
from feasibee.robot import compiler as compiler_module
from feasibee.scenario import trial
from feasibee.scenario.setting import setting_from
from feasibee.strategies import STRATEGIES
from feasibee.strategies.contract import ARGUMENTS, Manifest, Mind
from feasibee.strategies.overflow import NAMES, checked
from tests.engine.compiled import SANITIZED, Draws, Rules, bits, library
from tests.engine.odd import EXPRESSIONS, text_of

OPINIONS = [name for name, each in STRATEGIES.items() if not each.knowledge]
SETTING = setting_from((20, 30), (0, 0), False, None, (), plan=bytes(range(12)), columns=4)


@pytest.mark.parametrize("name", OPINIONS)
def test_built_in_rules_are_those_of_python(calls, built_in, name):
    strategy, draws = STRATEGIES[name], Draws(50)
    rules = Rules(*calls, built_in.feasibee_rules(name.encode()))
    assert [each for each in RULES if each in rules] == [
        each for each in RULES if each in strategy.functions or each in ALWAYS
    ]
    for rule in RULES:
        if rule not in rules:
            continue
        for _ in range(2000):
            given = [
                draws.random.choice([each, each, draws.random.uniform(0, 5)])
                for each in strategy.parameters.values()
            ]
            arguments = draws.arguments(rule, strategy.memory, given, SETTING)
            own = deepcopy(arguments)
            expected = inspect.unwrap(getattr(strategy, rule))(*own)
            compiled = rules(rule, arguments)
            assert bits(compiled) == bits(type(compiled)(expected)), (rule, arguments)
            assert repr(arguments) == repr(own)


# --- A user's strategy ---

MINE = Manifest(name="folder/odd.py", source=text_of(EXPRESSIONS), memory=3)
STRICTER = {
    *("a ** b", "2 ** b"),  # a negative exponent makes a float of whole numbers
    *("round(x)", "round(x * 0.5)", "math.floor(x)", "math.ceil(x)", "math.trunc(x)", "math.gcd(a, b)"),
    "pow(a, b % 9)",
}
"""Expressions whose results may be another type than before, or leave 64 bits unchecked: failures in C."""


def outcome_in_python(names, mind):
    """Return what Python's function returns, or its error and line; as the reference, it checks 64 bits."""
    try:
        result = names["value"](mind)
    except Exception as error:
        lines = [each.lineno for each in extract_tb(error.__traceback__) if each.filename == "odd.py"]
        return type(error).__name__, lines[-1]
    if isinstance(result, complex):
        return "ValueError", None
    if result is None:
        return "TypeError", None
    return bits(float(result)) if trial.RULES["value"][1](result) else ("", None)


def outcome_in_c(rules, mind):
    """Return what the compiled function returns, or Python's error and line."""
    result = rules("value", (mind,))
    return (kind_of(result), result.line) if isinstance(result, Failure) else bits(result)


@pytest.fixture(scope="module")
def odd(calls, tmp_path_factory):
    """Return the odd functions, in Python and in C with a sanitizer."""
    names = dict(NAMES)
    exec(compile(checked(ast.parse(MINE.source)), "odd.py", "exec"), names)
    ffi, loaded = calls
    text = own_strategy("odd.py", MINE.source)
    own = ffi.dlopen(str(library(tmp_path_factory.mktemp("odd"), "odd", text, *SANITIZED)))
    own.feasibee_bind(ffi.addressof(loaded, "feasibee_fail"))
    return names, own, Rules(*calls, own.feasibee_rules(b""))


@pytest.mark.parametrize("number", range(len(EXPRESSIONS)), ids=EXPRESSIONS)
def test_an_expression_is_what_python_computes_or_fails_alike(odd, number):
    names, _, rules = odd
    draws = Draws(number)
    for _ in range(100):
        given = [float(number), *draws.wide(), *draws.wide(), draws.wide()[1], draws.real(), draws.real()]
        memory = [float(draws.random.randint(0, 3)), draws.real(), float(draws.random.randint(0, 3))]
        one, other = (Mind(1, 0.5, 0.5, 1, list(memory), tuple(given)) for _ in range(2))
        expected, found = outcome_in_python(names, one), outcome_in_c(rules, other)
        if EXPRESSIONS[number] in STRICTER and isinstance(found, tuple):
            continue
        if isinstance(expected, tuple) and expected[1] is None:
            expected = expected[0], found[1]
        assert found == expected, (EXPRESSIONS[number], given, memory)
        assert isinstance(found, tuple) or repr([float(each) for each in one.memory]) == repr(other.memory)


RULES_OF = {
    "quality": ("return robots_seen / 4", [(0, 0), (1, 0), (5, 0)]),
    "dissemination": ("return gain * (1 - 2 * quality)", [(0.0, 10.0), (1.0, 10.0), (0.0, 2.0**31)]),
    "decide": ("return inbox.feasible_votes / 2", None),
    "say": ("return mind.own_vote + mind.opinion", None),
    "value": ("return mind.quality * 1e300 * mind.parameters[0]", None),
    "lasting": ("return gain - 5", None),
    "probability": ("return mind.quality * setting.robots + len(known) + known_plan(setting)", None),
}
MORE = """


def known_plan(setting):
    total = 0
    for k in range(len(setting.plan)):
        total += setting.plan[k] * setting.columns * setting.knows_count
    return total * setting.parameters[0] - setting.work
"""


@pytest.mark.parametrize("rule", RULES)
def test_a_result_that_breaks_its_rule_is_a_failure(calls, tmp_path, rule):
    body, _ = RULES_OF[rule]
    given = ", ".join(ARGUMENTS[rule])
    text = f"def {rule}({given}):\n    {body}\n{MORE}"
    text += "" if rule == "decide" else "\n\ndef decide(mind, inbox):\n    return mind.opinion\n"
    names: dict = {}
    exec(text, names)
    own = calls[0].dlopen(str(library(tmp_path, f"own-{rule}", own_strategy("mine.py", text), *SANITIZED)))
    own.feasibee_bind(calls[0].addressof(calls[1], "feasibee_fail"))
    rules, draws, failures = Rules(*calls, own.feasibee_rules(b"")), Draws(7), 0
    setting = SETTING._replace(parameters=(0.0,), work=draws.random.choice([0.0, 3.0]))
    for _ in range(400):
        arguments = draws.arguments(rule, 0, [draws.real()], setting)
        try:
            expected = names[rule](*arguments)
        except OverflowError:
            continue
        found = rules(rule, arguments)
        if isinstance(found, Failure):
            failures += 1
            assert found.first == expected or found.first != found.first
            assert found.line == 1
            assert f"mine.py, line 1: {rule} returns" in explained(Manifest(name="mine.py"), found)
        assert isinstance(found, Failure) == (not trial.RULES[rule][1](expected)), (arguments, expected)
        assert isinstance(found, Failure) or bits(found) == bits(type(found)(expected))
    assert 0 < failures < 400


FAILING = {
    "mind.memory[5]": "IndexError: place 5 in a row of 3; take one from 0 on that is below its length",
    "1 / (mind.opinion - 1)": "ZeroDivisionError: 1 / 0; test that it isn't 0 before",
    "2**62 * (mind.opinion + 1)": "OverflowError: 4611686018427387904 * 2 leaves 64 bits; compute with real",
    "1 << (mind.opinion - 3)": "ValueError: 1 << -2; shift by 0 places or more",
    "math.log(mind.quality - 0.5)": "ValueError: math.log(0.0): math domain error; test the number before",
    "math.exp(mind.quality * 2000)": "OverflowError: math.exp(1000.0) is too large; limit the number before",
    "math.floor(mind.quality * math.inf)": "OverflowError: inf has no whole number; test with math.isinf",
    "(mind.quality - 1) ** 0.5": "ValueError: -0.5 ** 0.5 is complex; take the power of a number of 0 or",
}


@pytest.mark.parametrize("expression", FAILING)
def test_a_failure_has_file_line_values_and_remedy(calls, monkeypatch, tmp_path, expression):
    monkeypatch.setenv("FEASIBEE_CACHE", str(tmp_path / "cache"))
    text = f"import math\nMEMORY = 3\n\n\ndef decide(mind, inbox):\n    x = {expression}\n    return int(x)\n"
    mine = Manifest(name="folder/mine.py", source=text)
    own = load(mine, *calls)
    failure = Rules(*calls, own.rules)("decide", (Mind(1, 0.5, 0.5, 1, [0.0] * 3, ()), Draws(1).inbox()))
    assert explained(mine, failure).startswith(f"mine.py, line 6: fails: {FAILING[expression]}")


def test_all_failures_have_words():
    kinds = [each.value for each in Failing] + [
        first + number for first in (DOMAIN, RANGE) for number in range(len(OF_MATH))
    ]
    kinds += [RESULT + number for number in range(len(RETURNING))]
    told = {explained(Manifest(name="mine.py"), Failure(each, 3, 7.0, 2.0)) for each in kinds}
    assert len(told) == len(kinds)
    assert all(each.startswith("mine.py, line 3: ") and "; " in each for each in told)
    assert "nan" in explained(Manifest(name="mine.py"), Failure(RESULT, 3, math.nan, 0.0))


REFUSED = {
    "x = [k for k in range(3)]": "write it with numbers",
    "x = {1: 2}": "write it with numbers",
    "x = sum((1, 2))": "write a loop",
    "x = divmod(7, 2)": "write // and %",
    "x = math.lgamma(2.0)": "write a loop of products or logarithms",
    "x = 'a'": "write it where a number of it is taken",
    "x = TABLE": "write it where a number of it is taken",
    "x = unknown": "use arguments, own variables, and constants of the file",
    "x = mind.name": "use one of opinion",
    "mind.parameters[0] = 1.0": "write to mind.memory only",
    "mind.opinion = 1": "assign to a name, or to row[place]",
    "x = mind.memory[0.5]": "give its place as a whole number",
    "x = 1.5 << 2": "use whole numbers",
    "x = 0.5 & 1": "use whole numbers",
    "x = decide(mind, inbox)": "write a loop",
    "x = mind.opinion is None": "compare numbers",
    "for x in mind.memory:\n        pass": "write for k in range(number)",
    "x = {0} if False else 1": "write it with numbers",
    "x = (lambda: 1)()": "call a function by its name",
}


@pytest.mark.parametrize("statement", REFUSED)
def test_what_has_no_c_is_told_with_what_to_write(statement):
    text = f"import math\nTABLE = (1, 2)\n\n\ndef decide(mind, inbox):\n    {statement}\n    return 1\n"
    with pytest.raises(FeasibeeError, match=r"^mine\.py, line [56]: ") as caught:
        own_strategy("mine.py", text)
    assert REFUSED[statement] in str(caught.value)
    assert ": decide doesn't compile: " in str(caught.value)


def test_the_text_is_not_run():
    text = "import math\nX = open('no') if 0 else 1\nY = print\n\n\ndef decide(mind, inbox):\n    return {}\n"
    assert "own_decide" in own_strategy("mine.py", text.format("1"))
    with pytest.raises(FeasibeeError, match=r"mine\.py, line 2: .* write the value of the constant out"):
        own_strategy("mine.py", text.format("X"))


# --- The cache ---


@pytest.fixture
def compilations(monkeypatch):
    """Count how often the compiler runs."""
    count: list = []
    run = own_module.run_compiler
    monkeypatch.setattr(own_module, "run_compiler", lambda *each: (count.append(each), run(*each)))
    return count


def test_a_library_is_compiled_once(monkeypatch, tmp_path, compilations):
    monkeypatch.setenv("FEASIBEE_CACHE", str(tmp_path))
    mine = Manifest(name="mine.py", source="def decide(mind, inbox):\n    return 1\n")
    first = compiled(mine)
    assert compiled(mine) == first
    assert len(compilations) == 1
    first.write_bytes(first.read_bytes()[:-1] + b"x")
    assert compiled(mine).read_bytes()[-1:] != b"x"
    assert len(compilations) == 2
    compiled(Manifest(name="mine.py", source="def decide(mind, inbox):\n    return 0\n"))
    assert len(compilations) == 3
    assert [each for each in (tmp_path / "strategies").iterdir() if each.name.startswith(".")] == []


def test_a_library_runs_where_there_is_no_compiler(monkeypatch, tmp_path, compilations):
    mine = Manifest(name="mine.py", source="def decide(mind, inbox):\n    return 1 - 1\n")
    for folder in ("own", "shipped"):
        (tmp_path / folder).mkdir()
    monkeypatch.setenv("FEASIBEE_CACHE", str(tmp_path / "own"))
    made = compiled(mine)
    shutil.copytree(tmp_path / "own", tmp_path / "shipped", dirs_exist_ok=True)
    monkeypatch.setenv("FEASIBEE_CACHE", str(tmp_path / "shipped"))
    monkeypatch.setattr("shutil.which", lambda _: None)
    monkeypatch.setattr(compiler_module, "find_spec", lambda _: None)
    assert compiled(mine).read_bytes() == made.read_bytes()
    assert len(compilations) == 1


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="Windows has no such rights")
def test_a_library_that_others_may_write_is_not_loaded(monkeypatch, tmp_path):
    monkeypatch.setenv("FEASIBEE_CACHE", str(tmp_path))
    mine = Manifest(name="mine.py", source="def decide(mind, inbox):\n    return 1\n")
    compiled(mine).chmod(0o777)
    with pytest.raises(FeasibeeError, match="can be written by others"):
        compiled(mine)


def test_without_a_compiler_the_error_names_both(monkeypatch, tmp_path):
    monkeypatch.setenv("FEASIBEE_CACHE", str(tmp_path))
    monkeypatch.setattr("shutil.which", lambda _: None)
    monkeypatch.setattr(compiler_module, "find_spec", lambda _: None)
    with pytest.raises(FeasibeeError, match=r"install gcc or clang, or .*\[c\]"):
        compiled(Manifest(name="mine.py", source="def decide(mind, inbox):\n    return 1\n"))


def test_no_other_name_has_rules(built_in):
    for name in ("", "dmm", "dmmd ", "censu", "no"):
        assert not built_in.feasibee_rules(name.encode())


def test_the_generator_needs_no_package():
    root = Path(feasibee.__file__).parents[1]
    code = (
        f"import sys; sys.path.insert(0, {str(root)!r}); sys.modules['importlib.metadata'] = None\n"
        "from feasibee.engine.generate import built_in_strategies; print(len(built_in_strategies()))"
    )
    told = subprocess.run(
        [sys.executable, "-S", "-I", "-c", code], capture_output=True, text=True, check=True
    )
    assert int(told.stdout) > 1000

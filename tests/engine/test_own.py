"""Strategies in the engine's C: what they return is what Python returns, and they fail where Python fails."""

from __future__ import annotations

import inspect
import subprocess
import sys
from copy import deepcopy
from pathlib import Path

import pytest

import feasibee
from feasibee.engine.generate import ALWAYS, RULES, built_in_strategies
from feasibee.scenario.setting import setting_from
from feasibee.strategies import STRATEGIES
from tests.engine.compiled import SANITIZED, Draws, Rules, bits, declarations, library

OPINIONS = [name for name, each in STRATEGIES.items() if not each.knowledge]
SETTING = setting_from((20, 30), (0, 0), False, None, (), plan=bytes(range(12)), columns=4)


@pytest.fixture(scope="module")
def built_in(tmp_path_factory):
    """Return the declarations of engine.h, and the built-in strategies in C."""
    ffi = declarations()
    return ffi, ffi.dlopen(str(library(tmp_path_factory.mktemp("c"), built_in_strategies(), *SANITIZED)))


@pytest.mark.parametrize("name", OPINIONS)
def test_built_in_rules_are_those_of_python(built_in, name):
    strategy, rules, draws = STRATEGIES[name], Rules(*built_in, name), Draws(50)
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


def test_no_other_name_has_rules(built_in):
    _, loaded = built_in
    for name in ("", "dmm", "dmmd ", "census", "no"):
        assert not loaded.feasibee_rules(name.encode())


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

"""The rules of the house, each with its guard."""

from __future__ import annotations

import ast
import importlib
import inspect
import pkgutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import feasibee
from feasibee import strategies

PACKAGE = Path(feasibee.__file__).parent

PUBLIC = [
    "FeasibeeError",
    "STRATEGIES",
    "Scenario",
    "ScenarioError",
    "Swarm",
    "assess",
    "compare",
    "confidence_sequence",
    "decision_counts",
    "decision_rates",
    "decision_times",
    "explain",
    "open_results",
    "plot_arena",
    "plot_decision_steps",
    "plot_decisions",
    "plot_opinions",
    "predict",
    "save_results",
    "scenario_of",
    "simulate",
    "size",
    "sweep",
    "truth",
    "truth_at",
    "wilson",
]


def modules():
    return [
        info.name
        for info in pkgutil.walk_packages([str(PACKAGE)], "feasibee.")
        if not info.name.endswith("__main__")
    ]


def loaded_by(code):
    """Return the modules that a fresh interpreter has loaded after some code."""
    script = f"import sys\n{code}\nprint(*sys.modules)"
    return {*subprocess.check_output([sys.executable, "-c", script], text=True).split()}


def test_the_public_names_are_these_and_no_others():
    assert sorted(feasibee.__all__) == PUBLIC == dir(feasibee)
    assert len(PUBLIC) <= 30
    assert all(getattr(feasibee, name).__doc__ for name in PUBLIC)


def test_no_public_name_is_a_modules_name():
    """Importing a submodule sets it as an attribute of the package, over a function of the same name."""
    assert not {f"feasibee.{name}" for name in PUBLIC} & set(modules())


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'simulte'"):
        feasibee.simulte  # noqa: B018


HEAVY = {"numpy", "xarray", "matplotlib", "pydantic", "pandas", "rich", "scipy", "yaml"}


@pytest.mark.parametrize(
    ("code", "unneeded"),
    [
        ("import feasibee", HEAVY),
        ("from feasibee.cli import main", HEAVY),
        ("import feasibee.__main__", {"click", "importlib.metadata"}),  # its loading Ctrl-C may interrupt
        ("import feasibee.robot, feasibee.robot.firmware, feasibee.strategies", HEAVY),
        ("import feasibee.field.robot", HEAVY | {"click"}),
        ("from feasibee import Scenario, truth; truth(Scenario())", {"scipy", "yaml"}),
    ],
)
def test_importing_loads_nothing_that_isnt_needed(code, unneeded):
    assert not unneeded & loaded_by(code)


def test_the_program_handles_signals_before_it_loads_any_package():
    project = tomllib.loads((PACKAGE.parents[1] / "pyproject.toml").read_text("utf-8"))["project"]
    assert project["scripts"] == {"feasibee": "feasibee.__main__:main"}


def modules_imported(node):
    """Return the modules that a statement imports, or names from."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if isinstance(node, ast.ImportFrom) and node.module == "feasibee.strategies":
        return [f"{node.module}.{alias.name}" for alias in node.names]
    return [node.module] if isinstance(node, ast.ImportFrom) else []


def test_strategies_import_nothing_but_math():
    """Or another strategy that they build on, or what several share."""
    files = {path.stem: path for path in (PACKAGE / "strategies").glob("*.py")}
    own = {name.replace("-", "_") for name in strategies.STRATEGIES}
    shared = {"certified", "clock", "gossip", "layout", "sight"}
    assert set(files) == own | shared | {"__init__", "contract", "overflow", "words"}
    for stem in own | shared:
        tree = ast.parse(files[stem].read_text())
        imported = {name for node in ast.walk(tree) for name in modules_imported(node)}
        assert imported <= {"math", *(f"feasibee.strategies.{each}" for each in own | shared)}, stem
    assert all(strategy.name == name for name, strategy in strategies.STRATEGIES.items())


def uses_of_a_strategys_name(path):
    """Yield where a strategy's name is compared or a key, in a list there or by itself."""
    tree = ast.parse(path.read_text())
    parents = {child: node for node in ast.walk(tree) for child in ast.iter_child_nodes(node)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and node.value in strategies.STRATEGIES:
            below, above = node, parents[node]
            while isinstance(above, ast.Tuple | ast.List | ast.Set):
                below, above = above, parents[above]
            key = isinstance(above, ast.Dict) and below in above.keys
            if key or isinstance(above, ast.Compare | ast.MatchValue):
                yield f"{path.name}, line {node.lineno}: {node.value}"


def test_nothing_outside_a_strategys_file_tests_for_its_name():
    files = [path for path in PACKAGE.rglob("*.py") if path.parent.name != "strategies"]
    assert len(files) > 100
    assert [found for path in files for found in uses_of_a_strategys_name(path)] == []


@pytest.mark.parametrize(
    "line", ['x = name == "census"', 'x = name in ("tally", "census")', 'x = {"tally": 1}']
)
def test_a_test_for_a_strategys_name_is_found(line, tmp_path):
    (tmp_path / "code.py").write_text(line)
    assert len(list(uses_of_a_strategys_name(tmp_path / "code.py"))) >= 1


def test_a_strategy_says_its_rule_its_message_and_its_source():
    for name in strategies.STRATEGIES:
        text = importlib.import_module(f"feasibee.strategies.{name.replace('-', '_')}").__doc__
        assert "References\n----------\n" in text, name
        assert "Message: " in text or "the messages and the memory are those of" in text, name
        assert "Memory: " in text or "the messages and the memory are those of" in text, name


def test_no_generator_with_state_in_the_model():
    for path in [
        *PACKAGE.glob("engine/*.py"),
        *PACKAGE.glob("reference/*.py"),
        *PACKAGE.glob("robot/*.py"),
        *PACKAGE.glob("strategies/*.py"),
    ]:
        imported = [name for node in ast.walk(ast.parse(path.read_text())) for name in modules_imported(node)]
        assert "random" not in imported, path
        assert "np.random" not in path.read_text(), path


@pytest.mark.parametrize("name", modules())
def test_modules_are_short_and_documented(name):
    module = importlib.import_module(name)
    lines = inspect.getsource(module).splitlines()
    assert module.__doc__
    assert len(lines) <= 700
    for function in [
        node for node in ast.walk(ast.parse("\n".join(lines))) if isinstance(node, ast.FunctionDef)
    ]:
        length = function.end_lineno - function.body[0].lineno + 1
        assert length <= 40, f"{name}.{function.name} has a body of {length} lines"


def test_no_two_files_of_tests_have_one_name():
    """Pytest imports them by name alone, and leaves out the second one with an error."""
    names = [path.name for path in Path(__file__).parent.rglob("test_*.py")]
    assert not {name for name in names if names.count(name) > 1}

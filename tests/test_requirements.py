"""Each package that is imported is declared, with a lowest version that `make test-lowest` tries."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from itertools import chain
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
CORE = PROJECT["project"]["dependencies"]
EXTRAS = PROJECT["project"]["optional-dependencies"]
GROUPS = PROJECT["dependency-groups"]
DISTRIBUTIONS = {"PIL": "pillow"}
"""Names on the registry, by import name, where the two differ."""
OWN = {"feasibee", "claims", *(path.stem for path in (ROOT / "benchmarks").glob("*.py"))}
PLACES = {
    "src": [*chain(*EXTRAS.values())],
    "tests": GROUPS["test"],
    "benchmarks": GROUPS["bench"],
    "claims": GROUPS["bench"] + GROUPS["test"],
    "docs": GROUPS["docs"],
    "examples": [],
}
"""What a folder may import in addition to the dependencies."""


def name_of(requirement):
    return re.match(r"[\w-]+", requirement)[0].replace("_", "-").lower()


def imported_by(folder):
    """Return the packages that a folder's files import, each with a file that imports it."""
    files = [path for path in (ROOT / folder).rglob("*.py") if "_build" not in path.parts]
    local = {path.stem for path in files} | {path.name for path in (ROOT / folder).rglob("*") if path.is_dir()}
    found = {}
    for path in files:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and not node.level:
                names = [node.module]
            else:
                continue
            found |= {name.split(".")[0]: path for name in names}
    return {name: path for name, path in found.items() if name not in sys.stdlib_module_names | local | OWN}


@pytest.mark.parametrize("folder", PLACES)
def test_what_is_imported_is_declared(folder):
    declared = {name_of(each) for each in chain(CORE, PLACES[folder])}
    used = {
        DISTRIBUTIONS.get(name, name.replace("_", "-")): path for name, path in imported_by(folder).items()
    }
    assert not {name: path for name, path in used.items() if name not in declared}


def test_a_requirement_is_the_same_wherever_it_stands():
    stated = {}
    for each in chain(CORE, *EXTRAS.values(), *GROUPS.values()):
        stated.setdefault(name_of(each), set()).add(each)
    assert not {name: each for name, each in stated.items() if len(each) > 1}


def test_each_requirement_has_a_lowest_version_and_no_highest():
    """`make test-lowest` installs the lowest; a highest would keep users from versions that may work."""
    for each in chain(CORE, *EXTRAS.values(), *GROUPS.values()):
        assert re.fullmatch(r"[\w-]+>=[\d.]+", each), each

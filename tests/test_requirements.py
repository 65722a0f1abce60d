"""Each package that is imported is declared, with a lowest version that `make test-lowest` tries."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from itertools import chain
from pathlib import Path

import pytest

from feasibee.base.errors import how_to_install

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
CORE = PROJECT["project"]["dependencies"]
EXTRAS = PROJECT["project"]["optional-dependencies"]
GROUPS = PROJECT["dependency-groups"]
DISTRIBUTIONS = {"_cffi_backend": "cffi", "PIL": "pillow", "yaml": "pyyaml"}
"""Names on the registry, by import name, where the two differ."""
FIXED = {"ziglang"}
"""Packages at one fixed version: a compiler whose bytes are compared."""
OWN = {
    "feasibee",
    "claims",
    "benchmarks",
    "research",
    *(path.stem for path in (ROOT / "benchmarks").glob("*.py")),
}
ON_BOARDS = {"espnow", "network"}
"""Modules of MicroPython on an ESP32, which examples/micropython imports."""
OF_IRSIM = {"shapely"}
"""What IR-SIM brings along, which examples/irsim imports."""
OF_ROS = {"rclpy", "std_msgs"}
"""What claims/measure/links.py imports with --ros; the wheels are in ros2/setup.py."""
OF_ROBOTS = {"cflib", "rps"}
"""What examples/recipes imports: libraries of robots."""
PLACES = {
    "src": [*chain(*EXTRAS.values())],
    "tests": GROUPS["test"],
    "benchmarks": GROUPS["bench"],
    "claims": GROUPS["bench"] + GROUPS["test"],
    "docs": GROUPS["docs"],
    "research": GROUPS["test"],
    "examples": GROUPS["docs"],  # the gallery runs when the docs are built
}
"""What a folder may import in addition to the dependencies."""


def name_of(requirement):
    return re.match(r"[\w-]+", requirement)[0].replace("_", "-").lower()


def imported_by(folder):
    """Return the packages that a folder's files import, each with a file that imports it."""
    files = [path for path in (ROOT / folder).rglob("*.py") if "_build" not in path.parts]
    local = {name for path in files for name in (path.stem, path.parent.name)}
    local |= {path.stem for path in (ROOT / "benchmarks").glob("*.py")} if folder == "tests" else set()
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
    optional = {"examples": ON_BOARDS | OF_IRSIM | OF_ROBOTS, "claims": OF_ROS}.get(folder, set())
    known = sys.stdlib_module_names | local | OWN | optional
    return {name: path for name, path in found.items() if name not in known}


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
        bound = "==" if name_of(each) in FIXED else ">="
        assert re.fullmatch(rf"[\w-]+{bound}[\d.]+", each), each


def test_a_missing_package_is_answered_with_an_extra_that_exists():
    named = set()
    for path in (ROOT / "src").rglob("*.py"):
        text = path.read_text()
        assert "feasibee[" not in text, f"{path}: no registry has this package; use errors.how_to_install"
        named |= set(re.findall(r"how_to_install\('(\w+)'\)", text))
    assert named == set(EXTRAS)
    assert how_to_install("dask") == 'in a checkout of feasibee, run: python -m pip install ".[dask]"'


def test_the_live_page_needs_no_extra():
    live = {path.stem: path.read_text() for path in (ROOT / "src/feasibee/live").glob("*.py")}
    used = {
        name for text in live.values() for name in re.findall(r"^(?:from|import) (\w+)", text, re.MULTILINE)
    }
    assert used - set(sys.stdlib_module_names) - OWN <= {name_of(each) for each in CORE}

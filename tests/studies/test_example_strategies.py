"""The strategies of users in examples/strategies: equal in engine, Python and C, and right where they say."""

from __future__ import annotations

from pathlib import Path

import pytest

from feasibee.studies.check import check

FOLDER = Path(__file__).parents[2] / "examples" / "strategies"


@pytest.mark.slow
@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.py")), ids=lambda path: path.stem)
def test_feasibee_check_finds_each_example_right(path):
    found = check(str(path), runs=1, seed=1)
    assert (found.engine, found.c, found.in_c) == ("agree", "agree", "")
    far = [each for each in found.outcomes if each.contender == path.name and each.tasks in (10, 40)]
    assert far
    assert path.stem == "witness" or all(each.right.all() for each in far)

"""The measurements of docs/field.md run from start to end, with small numbers."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

MEASURES = Path(__file__).parents[2] / "claims" / "measure"

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="needs fork, and reads memory from /proc"),
]


def measured(name):
    command = [sys.executable, MEASURES / name, "--quick"]
    return json.loads(subprocess.run(command, capture_output=True, check=True, text=True).stdout)


def test_each_case_of_the_decisions_of_fields_is_played():
    rows = measured("fields.py")["rows"]
    assert [row["runs"] for row in rows] == [10_000, 100, *[2] * 4]
    assert all(row["rate"]["low"] <= row["rate"]["estimate"] <= row["rate"]["high"] for row in rows)
    assert all(row["steps"]["estimate"] > 0 for row in rows)


def test_what_robots_take_is_measured():
    found = measured("links.py")
    assert all(found[name] > 0 for name in ("joined", "percent", "megabytes", "achieved_hz"))

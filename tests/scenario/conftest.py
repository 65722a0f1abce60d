"""What several files of tests of scenarios need."""

from __future__ import annotations

import pytest


@pytest.fixture
def write(tmp_path):
    """Write a strategy's file; return its path."""

    def to(text, name="mine.py"):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return path

    return to

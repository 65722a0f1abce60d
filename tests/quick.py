"""Which of the cases of a test run in `make test`; `make test-all` has them all."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

import pytest


def quick(cases: Iterable[Any], chosen: int | Collection[Any]) -> list[Any]:
    """Mark all cases slow but the first so many, or those that are chosen."""
    kept = cases = list(cases)
    kept = cases[:chosen] if isinstance(chosen, int) else chosen
    return [each if each in kept else pytest.param(each, marks=pytest.mark.slow) for each in cases]

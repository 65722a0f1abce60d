"""Compare two rows of one run: its outcome is the same, whoever computed it."""

from __future__ import annotations

from typing import Any

import numpy as np

from feasibee.model.outcomes import CURVES, TRACES
from feasibee.sweeps.encoding import curve_of
from feasibee.sweeps.schema import COLUMNS, PLACES, Kind


def difference(
    kind: Kind, ours: tuple[Any, ...], theirs: tuple[Any, ...]
) -> tuple[str, object, object] | None:
    """Return the column in which two rows of a run differ, and both values; None if they agree."""
    if ours == theirs:
        return None
    if kind is Kind.RUNS:
        return next(each for each in zip(PLACES, ours, theirs, strict=True) if each[1] != each[2])
    types = [each.dtype for each in (CURVES if kind is Kind.CURVES else TRACES)]
    for name, dtype, mine, other in zip(COLUMNS[kind], types, ours[1:], theirs[1:], strict=True):
        here, there = curve_of(mine, dtype), curve_of(other, dtype)  # another zlib may give other bytes
        if here.size != there.size:
            return "its number of steps", here.size - 1, there.size - 1
        for step in np.flatnonzero(here != there)[:1]:
            what = f"the count of {name} opinions" if kind is Kind.CURVES else name
            return f"{what} at step {step}", int(here[step]), int(there[step])
    return None

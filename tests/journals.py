"""Write to a journal from records, and read the rows of a point: sweeps do neither."""

from __future__ import annotations

from feasibee.sweeps import content
from feasibee.sweeps.schema import encode


def write(journal, parts):
    """Write runs of some points, given as pairs of point and record."""
    journal.enter_runs((point, encode(record)) for point, record in parts)


def rows_in(journal, point):
    """Return the runs of a point: int64, shape (runs, columns of `feasibee.sweeps.schema.PLACES`)."""
    return content.runs_of(journal._database, point)

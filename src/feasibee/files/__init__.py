"""Files that people name: read with a limit, written whole or not at all; and the cache of compiled code."""

from feasibee.files.reading import (
    TABLE_LIMIT,
    TEXT_LIMIT,
    UnreadableError,
    is_file,
    lines_of,
    named,
    read_text,
    why_not,
)
from feasibee.files.writing import (
    FIGURES,
    RESULTS,
    atomic_write,
    check_output,
    make_folder,
    write_csv,
    write_table,
)

__all__ = [
    "FIGURES",
    "RESULTS",
    "TABLE_LIMIT",
    "TEXT_LIMIT",
    "UnreadableError",
    "atomic_write",
    "check_output",
    "is_file",
    "lines_of",
    "make_folder",
    "named",
    "read_text",
    "why_not",
    "write_csv",
    "write_table",
]

"""Logs of robots in bags that ``ros2 bag record`` has written: MCAP or SQLite, a file or a folder."""

from __future__ import annotations

import sqlite3
from collections import defaultdict
from contextlib import closing
from pathlib import Path
from typing import Final

from feasibee.errors import FeasibeeError, how_to_install, one_line
from feasibee.field.logs import LOG_LIMIT
from feasibee.files import named

SUFFIXES: Final = (".mcap", ".db3")
"""File suffixes of bags."""
_TOPIC, _TYPE = "/log", "std_msgs/msg/String"
_REMEDY: Final = "name an intact bag"


def is_bag(path: Path) -> bool:
    """Return whether a path names a bag: a file with its suffix, or a folder with its metadata."""
    return path.suffix.lower() in SUFFIXES or (path / "metadata.yaml").exists()


def logs_in(path: Path) -> dict[str, list[str]]:
    """Return the lines of each topic of a bag that ends with ``/log`` and has strings, in the bag's order.

    Definitions of types in the bag aren't used, because rosbags would make code of them. Raise a
    FeasibeeError if the bag can't be read or has no such topic.
    """
    try:
        from rosbags.rosbag2 import Reader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise FeasibeeError(f"{named(path)}: reading bags needs rosbags; {how_to_install('bag')}") from None
    if not all(each.is_file() for each in (path.iterdir() if path.is_dir() else [path])):
        raise FeasibeeError(f"{named(path)}: can't be read: it isn't plain files; {_REMEDY}")
    for file in path.glob("*.db3") if path.is_dir() else [path] if path.suffix == ".db3" else ():
        _check_tables(file)
    store, found, size = get_typestore(Stores.LATEST), defaultdict[str, list[str]](list), 0
    try:
        with Reader(path) as reader:
            logs = [
                each for each in reader.connections if each.topic.endswith(_TOPIC) and each.msgtype == _TYPE
            ]
            for connection, _, raw in reader.messages(logs) if logs else ():
                size += len(raw)
                if size > LOG_LIMIT:
                    raise FeasibeeError(f"it has more than {LOG_LIMIT // 2**20} MiB of logs")
                text: str = store.deserialize_cdr(raw, _TYPE).data  # type: ignore[attr-defined]
                found[connection.topic].append(text)
    except Exception as error:  # of rosbags, apsw, zstd or lz4: whatever they meet in damaged bytes
        why = one_line(str(error).rstrip("."), 100) or type(error).__name__
        raise FeasibeeError(f"{named(path)}: can't be read: {why}; {_REMEDY}") from None
    if not found:
        raise FeasibeeError(
            f"{named(path)}: has no messages of {_TYPE} on a topic that ends with {_TOPIC}; "
            "record the logs of robots, too"
        )
    return dict(found)


def _check_tables(file: Path) -> None:
    """Raise an error if a database has views or triggers, whose queries reading it could run."""
    uri = f"{file.absolute().as_uri()}?immutable=1"
    try:
        with closing(sqlite3.connect(uri, uri=True)) as base:
            (strange,) = base.execute(
                "SELECT count(*) FROM sqlite_master WHERE type NOT IN ('table', 'index')"
            ).fetchone()
    except sqlite3.Error as error:
        raise FeasibeeError(f"{named(file)}: can't be read: {one_line(str(error), 100)}; {_REMEDY}") from None
    if strange:
        raise FeasibeeError(f"{named(file)}: can't be read: it has views or triggers; {_REMEDY}")

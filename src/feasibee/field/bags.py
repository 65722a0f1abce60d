"""Logs of robots in bags that ``ros2 bag record`` has written: MCAP or SQLite, a file or a folder."""

from __future__ import annotations

import sqlite3
from collections import defaultdict
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

from feasibee.errors import FeasibeeError, how_to_install, one_line
from feasibee.files import named

_TOPIC, _TYPE = "/log", "std_msgs/msg/String"


def files_of(path: Path) -> list[Path]:
    """Return the files of a bag, a file or a folder, in their order; none if the path isn't one."""
    files = path.iterdir() if path.is_dir() else [path]
    found = (each for each in files if each.suffix in (".mcap", ".db3") and each.is_file())
    return sorted(found, key=lambda each: (len(each.name), each))


def logs_in(path: Path) -> dict[str, list[str]]:
    """Return the lines of each topic of a bag that ends with ``/log`` and has strings, in the bag's order.

    The definitions of types in the bag aren't used, because rosbags would make code of them. Its metadata
    aren't read. Raise a FeasibeeError if the bag can't be read or has no such topic.
    """
    found = defaultdict[str, list[str]](list)
    try:
        for file in files_of(path):
            for topic, text in _texts(file):
                found[topic].append(text)
    except ImportError:
        raise FeasibeeError(f"{named(path)}: reading bags needs rosbags; {how_to_install('bag')}") from None
    except Exception as error:  # whatever rosbags, SQLite, zstd or lz4 meet in damaged bytes
        why = one_line(str(error).rstrip("."), 100) or type(error).__name__
        raise FeasibeeError(f"{named(path)}: can't be read: {why}; name an intact bag") from None
    if not found:
        rule = f"has no {_TYPE} on a topic that ends with {_TOPIC}; record the robots' logs, too"
        raise FeasibeeError(f"{named(path)}: {rule}")
    return found


def _texts(file: Path) -> Iterator[tuple[str, str]]:
    """Yield the topic and the text of each line of a log."""
    from rosbags.rosbag2 import Reader
    from rosbags.typesys import Stores, get_typestore

    store: Any = get_typestore(Stores.LATEST)
    if file.suffix == ".db3":  # reading it could run the queries of views
        with closing(sqlite3.connect(f"{file.absolute().as_uri()}?immutable=1", uri=True)) as base:
            found = base.execute("SELECT count(*) FROM sqlite_master WHERE type NOT IN ('table', 'index')")
            if found.fetchone() != (0,):
                raise FeasibeeError("it has views or triggers")
    with Reader(file) as reader:
        of_strings = (each for each in reader.connections if each.msgtype == _TYPE)
        logs = [each for each in of_strings if each.topic.endswith(_TOPIC)]
        for connection, _, raw in reader.messages(logs) if logs else ():
            yield connection.topic, store.deserialize_cdr(raw, _TYPE).data

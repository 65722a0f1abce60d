"""Files that take long to make: once for all workers of a session."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable
from pathlib import Path


def made_once(folder: Path, name: str, make: Callable[[Path], object]) -> Path:
    """Return a file that the first worker to need it makes, while others wait.

    ``folder`` is a worker's own, made by pytest's ``tmp_path_factory``: the folder above is the session's.
    """
    session = folder.parent.parent if folder.parent.name.startswith("popen-") else folder.parent
    path, begun = session / name, session / f"{name} begun"
    while not path.exists():
        try:
            begun.mkdir()
        except FileExistsError:
            time.sleep(0.02)
            continue
        try:
            make(begun / name)
            (begun / name).replace(path)
        finally:
            shutil.rmtree(begun)
    return path

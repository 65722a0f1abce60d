"""The page's JavaScript modules as one, for a notebook or a file, which can't import."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Final

STATIC: Final = Path(__file__).parent / "static"


def joined(paths: Iterable[Path]) -> str:
    """Return modules as one text, each after those that it imports; a default export stays."""
    texts = (path.read_text("utf-8") for path in paths)
    return "\n".join(re.sub(r"(?m)^import [^;]+;\n|^export (?!default)", "", text) for text in texts)

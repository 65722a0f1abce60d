"""The page's JavaScript modules as one, for a notebook or a file, which can't import."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

STATIC: Final = Path(__file__).parent / "static"
IMPORTED: Final = re.compile(r'(?m)^import [^;]+ from "\./(\w+)\.js";\n')


def joined(name: str) -> str:
    """Return a module and all that it imports as one text; its default export stays."""
    return "\n".join(_texts(name, set()))


def _texts(name: str, seen: set[str]) -> list[str]:
    """Return the texts of modules not seen before, each after those that it imports."""
    seen.add(name)
    text = (STATIC / f"{name}.js").read_text("utf-8")
    before = [part for each in IMPORTED.findall(text) if each not in seen for part in _texts(each, seen)]
    return [*before, re.sub(r"(?m)^export (?!default)", "", IMPORTED.sub("", text))]

"""What a robot knows, or a message holds: a row of words."""

from __future__ import annotations

from operator import index
from typing import Any


class Words(list[int]):
    """A row of words in Python: whole numbers from -2**31 to 2**31 - 1, which wrap as in the engine."""

    def __setitem__(self, place: Any, value: Any) -> None:
        """Set a word, or a stretch of words to as many others."""
        if isinstance(place, slice):
            words = list(map(_wrapped, value))
            if len(words) != len(self[place]):
                raise ValueError(f"{len(words)} words don't fit {len(self[place])}")
            super().__setitem__(place, words)
        else:
            super().__setitem__(place, _wrapped(value))


def _wrapped(value: Any) -> int:
    """Return a whole number as a word; other numbers are a TypeError."""
    return (index(value) + 2**31) % 2**32 - 2**31

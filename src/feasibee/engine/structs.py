"""Arrays and numbers that compiled code takes as one pointer.

numba passes a tuple of arrays as all the numbers that these consist of: 270 for a swarm. Each function that
takes it and each call of one then has as many instructions more, which took a third of the time to compile.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Annotated, Any, NamedTuple, get_args, get_origin, get_type_hints

import numpy as np


class Axes(NamedTuple):
    """The kind of a contiguous array: what it holds, and its number of axes."""

    dtype: np.dtype[Any]
    count: int  # type: ignore[assignment]  # hides tuple.count


@cache
def fields_of(cls: Any) -> dict[str, Any]:
    """Return the fields of a class by name: the `Axes` of an annotated array, ``int``, or such a class."""
    return {name: _kind_of(each) for name, each in get_type_hints(cls, include_extras=True).items()}


def _kind_of(annotation: Any) -> Any:
    if get_origin(annotation) is not Annotated:
        return annotation
    array, *axes = get_args(annotation)
    return Axes(np.dtype(get_args(get_args(array)[1])[0]), len(axes))


class Struct:
    """Base of frozen dataclasses of arrays, ints and tuples of these.

    Compiled code reads a table of 64-bit words, in the order of the fields: an int, or an array's address and
    then its length along each axis. So fields can't be replaced, and their arrays must be of their type.
    """

    def __post_init__(self) -> None:
        table = np.array([*_words_of(type(self), self)], np.int64)
        object.__setattr__(self, "_table", table)
        object.__setattr__(self, "address", table.ctypes.data)


def _words_of(cls: Any, value: Any) -> Iterator[int]:
    for name, kind in fields_of(cls).items():
        each = getattr(value, name)
        if kind is int:
            yield each
        elif not isinstance(kind, Axes):
            yield from _words_of(kind, each)
        elif (each.dtype, each.ndim, each.flags.c_contiguous) == (kind.dtype, kind.count, True):
            yield each.ctypes.data
            yield from each.shape
        else:
            raise TypeError(
                f"{cls.__name__}.{name} must be a contiguous array of {kind.dtype}, {kind.count} axes"
            )

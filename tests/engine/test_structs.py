"""What compiled code takes as one pointer has the fields that Python has, and no others."""

from __future__ import annotations

from dataclasses import FrozenInstanceError, dataclass
from typing import Annotated, NamedTuple

import numpy as np
import pytest
from feasibee.engine.compile import entry
from feasibee.engine.signatures import type_of
from numba import types
from numpy.typing import NDArray

from feasibee.engine.params import Struct


class Inner(NamedTuple):
    """A tuple in a struct."""

    flags: Annotated[NDArray[np.bool_], "flag"]
    grid: Annotated[NDArray[np.int32], "plane", "row", "column"]


@dataclass(frozen=True, eq=False)
class Outer(Struct):
    """A struct with a field of each kind."""

    before: int
    numbers: Annotated[NDArray[np.float64], "number"]
    inner: Inner
    after: int


@entry(types.UniTuple(types.float64, 8)(type_of(Outer)))
def read(outer):
    grid = outer.inner.grid
    return (
        outer.before,
        outer.numbers[1],
        outer.numbers.size,
        outer.inner.flags[0],
        grid[1, 2, 3],
        grid[1][2][3],
        grid.size,
        outer.after,
    )


@entry(types.void(type_of(Outer)))
def write(outer):
    outer.inner.grid[:, 1, :] = 7


def outer(numbers=None, grid=None):
    """Return a struct of some arrays."""
    inner = Inner(np.array([True]), np.arange(24, dtype=np.int32).reshape(2, 3, 4) if grid is None else grid)
    return Outer(-5, np.array([0.5, 1.5]) if numbers is None else numbers, inner, 9)


def test_compiled_code_reads_and_writes_the_fields_that_python_has():
    """Catches a field or an axis taken for another."""
    struct = outer()
    assert read(struct) == (-5, 1.5, 2, True, 23, 23, 24, 9)
    write(struct)
    assert (struct.inner.grid[:, 1] == 7).all()
    assert (struct.inner.grid[:, 2] != 7).all()


@pytest.mark.parametrize(
    "wrong",
    [
        {"numbers": np.zeros(2, np.float32)},
        {"numbers": np.zeros((2, 2))},
        {"numbers": np.zeros(4)[::2]},
        {"grid": np.zeros((2, 3, 4), np.int32).transpose(0, 2, 1)},
    ],
)
def test_arrays_of_another_kind_are_refused(wrong):
    """Compiled code would read what lies behind them."""
    with pytest.raises(TypeError, match="must be a contiguous array"):
        outer(**wrong)


def test_fields_cant_be_replaced():
    """Compiled code would go on with the old array."""
    with pytest.raises(FrozenInstanceError):
        outer().numbers = np.zeros(2)

"""Several threads that simulate one swarm: each the robots of some words of the sets.

All do the same steps and wait for each other where one reads what another has written. What a thread writes
for others goes to its row of `Part.shared`, so that no result depends on who comes first.
"""

from __future__ import annotations

import ctypes
import sys
from functools import cache
from typing import Any

import numpy as np
from llvmlite import ir
from numba import int64, types

from feasibee.engine.compile import called, inlined
from feasibee.engine.intrinsics import ARRAY, LONG, instruction
from feasibee.engine.layout import WORD, Alone, Part, Share
from feasibee.engine.params import Params

SPINS = 4000
"""How often a waiting thread looks before it lets other threads run: about 10 us."""
LINE_OF_CACHE = 16
"""Numbers in two lines of a processor's cache, which it may fetch together."""


@instruction(types.int64, ARRAY, types.int64, types.int64)
def add_shared(builder: Any, array: Any, place: Any, value: Any) -> Any:
    """Add to a number that other threads add to as well; return what it was before."""
    return builder.atomic_rmw("add", builder.gep(array, [place]), value, "acq_rel")


@instruction(types.int64, ARRAY, types.int64)
def read_shared(builder: Any, array: Any, place: Any) -> Any:
    """Return a number that other threads write."""
    return builder.load_atomic(builder.gep(array, [place]), "acquire", 8)


@instruction(types.int64, types.int64)
def call_at(builder: Any, address: Any) -> Any:
    """Call a function without arguments by its address."""
    kind = ir.FunctionType(ir.IntType(32), [])
    builder.call(builder.inttoptr(address, kind.as_pointer()), [])
    return LONG(0)


@inlined
def wait_for_all(part):
    """Wait until all threads have come here."""
    if comes_last(part):
        let_go(part)


@inlined
def comes_last(part):
    """Wait until all threads have come here, and one of them has done what one must do for all.

    That is the last to come. It gets True, does not wait, and lets the others go when it is done.
    """
    return part.threads == 1 or not has_waited(part)


@inlined
def let_go(part):
    """Let the other threads go, which wait for the one that came last."""
    if part.threads > 1:
        add_shared(part.shared[part.threads], int64(Share.TURN), int64(1))


@called
def has_waited(part):
    """Wait until one of several threads lets the others go; return False at once if all others wait."""
    common = part.shared[part.threads]
    turn = read_shared(common, int64(Share.TURN))
    if add_shared(common, int64(Share.ARRIVED), int64(1)) == part.threads - 1:
        add_shared(common, int64(Share.ARRIVED), -part.threads)
        return False
    spins = int64(0)
    while read_shared(common, int64(Share.TURN)) == turn:
        spins += 1
        if spins > SPINS and part.give_way != 0:
            call_at(part.give_way)
    return True


def parts_of(params: Params, threads: int = 1) -> list[Part]:
    """Return the parts of the threads that simulate a swarm together."""
    words = -(-params.robots.count // WORD)
    shared = np.zeros((threads + 1, LINE_OF_CACHE), np.int64)
    bounds = np.arange(threads + 1)
    shared[:threads, Share.ROW] = params.robots.grid.rows * bounds[:-1] // threads
    bounds = words * bounds // threads
    return [
        Part(thread, threads, int(bounds[thread]), int(bounds[thread + 1]), give_way(), shared)
        for thread in range(threads)
    ]


@inlined
def alone(part):
    """Return the part of one thread whose robots fill one word, in constants, so that no waits remain."""
    return Alone(int64(0), int64(1), int64(0), int64(1), int64(0), part.shared)


@cache
def give_way() -> int:
    """Return the address of the system's function that lets other threads run, or 0."""
    library = ctypes.CDLL("kernel32" if sys.platform == "win32" else None)
    function = getattr(library, "SwitchToThread" if sys.platform == "win32" else "sched_yield", None)
    return ctypes.cast(function, ctypes.c_void_p).value or 0 if function else 0


@inlined
def first_word(words, thread, threads):
    """Return the first word of a thread's robots."""
    return words * thread // threads


@inlined
def total(part, column):
    """Return the sum of a column of what the threads share."""
    result = part.shared[0, column]
    for thread in range(1, part.threads):
        result += part.shared[thread, column]
    return result

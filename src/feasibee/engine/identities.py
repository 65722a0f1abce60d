"""The ids of robots, which may collide, and the hashes of robots and tasks."""

from __future__ import annotations

from numba import int32, int64, uint32

from feasibee.engine.compile import called
from feasibee.engine.draws import draw, draw_words
from feasibee.engine.layout import Clock, Robot
from feasibee.model.purposes import IDENTITY


@called
def assign_identities(params, state):
    """Give robots their ids, and robots and tasks their hashes."""
    for i in range(params.robots.count):
        state.robots[Robot.IDENTITY, i] = int32(i)
    if params.radio.random_ids:
        find_equal_ids(params, state)
    for thing in range(state.hashes.size):
        holder = int64(state.robots[Robot.IDENTITY, thing]) if thing < params.robots.count else int64(thing)
        words = draw_words(params, state.clock[Clock.RUN], holder, 0, IDENTITY)
        state.hashes[thing] = words[1]


@called
def find_equal_ids(params, state):
    """Find for each robot the first that has the same id, by a hash table in the room of the counts."""
    ids, table = state.robots[Robot.ORDER], state.counts
    size = 4 * table.shape[1]
    table[:] = 0
    for i in range(params.robots.count):
        word = draw(params, state.clock[Clock.RUN], i, 0, IDENTITY)
        ids[i] = int32(word >> uint32(32 - params.radio.id_bits))
        place = int64(uint32(uint32(ids[i]) * uint32(0x9E3779B1))) % size
        holder = table[place & 3, place >> 2]
        while holder > 0 and ids[holder - 1] != ids[i]:
            place = (place + 1) % size
            holder = table[place & 3, place >> 2]
        if holder == 0:
            table[place & 3, place >> 2] = i + 1
        else:
            state.robots[Robot.IDENTITY, i] = int32(holder - 1)

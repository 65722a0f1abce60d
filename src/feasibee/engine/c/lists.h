/* The tasks that may be in sight of each cell of a grid, as places of 16 bits an axis. */

#ifndef LISTS_H
#define LISTS_H

#include "decisions.h"

/* Cells have 2**bits a side; with 0 bits there is one list of all tasks. Each list fills whole vectors. */
struct lists {
    uint32_t *places; /* y above x */
    int32_t *first, *last;
    uint32_t *x, *y; /* of each task */
    int count, bits, shift, far; /* a task may be in sight of cells up to so many columns away */
    uint64_t limit;
};

ALWAYS uint32_t packed_place(uint32_t x, uint32_t y, int shift) { return (x >> shift & 0xFFFF) | y >> shift << 16; }

/* Return how many columns away a cell may be, of which a point is in range of one in another cell. */
static inline int columns_in_range(uint64_t limit, int bits)
{
    int far = 1;
    if (bits == 0)
        return 0;
    for (uint64_t width = UINT64_C(1) << (32 - bits); (far * width) * (far * width) < limit;)
        far++;
    return far;
}

static inline size_t places_needed(const struct lists *lists)
{
    size_t around = 2 * (size_t)lists->far + 1, cells = (size_t)1 << 2 * lists->bits;
    return around * around * (size_t)lists->count + LANES * cells + LANES;
}

/* Return the squares of the least distances along an axis from a task within its cell to cells around. */
static inline void squared_ways(uint64_t *squares, int64_t inside, int64_t width, int far)
{
    for (int k = -far; k <= far; k++) {
        int64_t way = k == 0 ? 0 : k < 0 ? inside - (k + 1) * width : k * width - inside;
        squares[k + far] = (uint64_t)(way * way);
    }
}

#define FAR 7 /* at most: seven cells each way and its own are fifteen of at least sixteen, none twice */

/* Count tasks into the lists of the cells that they may be in sight of, or write them there. */
static inline void spread_task(struct lists *lists, int task, bool writes)
{
    const int bits = lists->bits, far = lists->far, side = 1 << bits, around = 2 * far + 1;
    const int64_t width = INT64_C(1) << (32 - bits);
    const uint32_t x = lists->x[task], y = lists->y[task], place = packed_place(x, y, lists->shift);
    const int column = (int)(x >> (32 - bits)) - far, row = (int)(y >> (32 - bits)) - far;
    uint64_t across[2 * FAR + 1], along[2 * FAR + 1];
    squared_ways(across, x & (width - 1), width, far);
    squared_ways(along, y & (width - 1), width, far);
    for (int b = 0; b < around; b++) {
        int32_t *line = lists->last + (((row + b) & (side - 1)) << bits);
        for (int a = 0; a < around; a++) {
            int32_t *end = line + ((column + a) & (side - 1));
            if (writes)
                lists->places[*end] = place; /* no branch: the next task overwrites one that is out of range */
            *end += across[a] + along[b] < lists->limit;
        }
    }
}

/* Fill the rest of a cell's last vector with a place that is out of range of the whole cell: opposite to it. */
static inline void pad_list(struct lists *lists, int cell)
{
    const int bits = lists->bits, side = 1 << bits;
    const uint32_t half = UINT32_C(1) << (31 - bits), away = UINT32_C(1) << (lists->shift + 15);
    const uint32_t x = (uint32_t)(2 * (cell & (side - 1)) + 1) * half, y = (uint32_t)(2 * (cell >> bits) + 1) * half;
    const uint32_t place = packed_place(x + away, y + away, lists->shift);
    int32_t end = lists->last[cell];
    while (end == lists->first[cell] || end % LANES != 0)
        lists->places[end++] = place;
    lists->last[cell] = end;
}

static inline void fill_lists(struct lists *lists)
{
    const int cells = 1 << 2 * lists->bits;
    int32_t room = 0;
    if (lists->bits == 0) {
        for (int task = 0; task < lists->count; task++)
            lists->places[task] = packed_place(lists->x[task], lists->y[task], 16);
        return;
    }
    memset(lists->last, 0, sizeof *lists->last * (size_t)cells);
    for (int task = 0; task < lists->count; task++)
        spread_task(lists, task, false);
    for (int cell = 0; cell < cells; cell++) {
        int32_t count = lists->last[cell];
        lists->first[cell] = lists->last[cell] = room;
        room += (count + LANES) & -LANES; /* and a place for a task that is overwritten */
    }
    for (int task = 0; task < lists->count; task++)
        spread_task(lists, task, true);
    for (int cell = 0; cell < cells; cell++)
        pad_list(lists, cell);
}

/* --- Looking --- */

APART uint32_t count_exactly(const struct lists *lists, uint32_t x, uint32_t y)
{
    uint32_t found = 0;
    for (int task = 0; task < lists->count; task++) {
        int64_t way_x = (int32_t)(lists->x[task] - x), way_y = (int32_t)(lists->y[task] - y);
        found += (uint64_t)(way_x * way_x) + (uint64_t)(way_y * way_y) < lists->limit;
    }
    return found;
}

/* Count the tasks in sight of a place where one list has them all: ranges of a quarter of the torus and more. */
APART uint32_t count_in_all(const struct lists *lists, struct band band, uint32_t x, uint32_t y)
{
    const u32 here = spread(packed_place(x, y, 16)), low = spread(band.low), width = spread(band.width);
    uint32_t found = 0;
    for (int k = 0; k < lists->count; k += LANES) {
        u32 places, beyond;
        memcpy(&places, lists->places + k, sizeof places);
        beyond = squared(subtract_halves(places, here)) - low;
        uint32_t valid = first_bits(lists->count - k);
        if (RARELY((below(beyond, width) & valid) != 0))
            return count_exactly(lists, x, y);
        found += (uint32_t)members(signs(beyond) & valid);
    }
    return found;
}

/* Count the tasks in sight of a place. */
ALWAYS uint32_t count_tasks(const struct lists *lists, struct band band, uint32_t x, uint32_t y)
{
    const int back = 32 - lists->bits;
    if (RARELY(lists->bits == 0))
        return count_in_all(lists, band, x, y);
    const uint32_t cell = y >> back << lists->bits | x >> back;
    const u32 here = spread(packed_place(x, y, lists->shift)), low = spread(band.low);
    const u32 *piece = (const u32 *)(lists->places + lists->first[cell]);
    const u32 *end = (const u32 *)(lists->places + lists->last[cell]);
    u32 least = spread(UINT32_MAX);
    uint32_t found = 0;
    do {
        u32 beyond = squared(subtract_halves(*piece, here)) - low; /* below 0 if surely in sight */
        least = least_of(least, beyond);
        found += (uint32_t)members(signs(beyond));
    } while (RARELY(++piece < end));
    return RARELY(below(least, spread(band.width)) != 0) ? count_exactly(lists, x, y) : found;
}

#endif

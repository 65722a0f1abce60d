/* Points in cells: which of many points lie near a place, at a cost that doesn't grow with their number.
 *
 * A half cell is at least the range. So all points in range of a place lie in the nearest block of two by two
 * cells. Points are sorted by row and then by column, and each row repeats its first column at its end. So a
 * block is two stretches of consecutive points, one per row, without a wrap.
 *
 * A point's place has 16 bits an axis, of which a block spans less than half: the bits above them tell
 * nothing within a block. Where the bits below them leave in doubt whether a point is in range, all bits
 * decide. */

#ifndef CELLS_H
#define CELLS_H

#include "engine.h"
#include "vec.h"

#define GROUP \
    (LANES < 8 ? 8 : LANES) /* points that are looked at together, in vectors: most stretches have fewer */
#define VECTORS (GROUP / LANES)

struct cells {
    uint32_t *places, *numbers; /* of the points: y above x, and which point it is */
    uint32_t *labels;           /* of robots: what they are and say */
    int32_t *start;             /* first point of each cell, and the point after the last */
    const uint32_t *x, *y;      /* of the points by their numbers, with all bits */
    uint32_t side, half;        /* cells along an axis, and the length of half a cell */
    int32_t
        after_last; /* from a cell of the last row to that of the row after it, in the order of the cells */
    int shift;      /* bits of a coordinate below those of a place */
};

/* What is in range: what is near for sure, and what may be, in the units of places. */
struct reach {
    uint64_t limit; /* in range if the squared distance is below this */
    struct band band;
};

struct stretch {
    int32_t first, last; /* the last excluded */
};

struct block {
    struct stretch one, other;
};

static inline size_t starts_of(const struct cells *cells)
{
    return ((size_t)cells->side + 1) * (cells->side + 1) + 1;
}

/* Return the grid of cells that params give for a square torus, without memory for points. */
static inline struct cells empty_cells(const struct grid *grid)
{
    const uint32_t side = (uint32_t)grid->columns;
    const int32_t line = (int32_t)side + 1, rows = side == 1 ? 1 : 1 - (int32_t)side;
    struct cells cells = {.side = side, .half = (uint32_t)grid->half_width, .after_last = rows * line};
    while (cells.shift < 16 && (UINT64_C(1) << (15 + cells.shift)) < (UINT64_C(3) << 31) / side + 2)
        cells.shift++; /* a point is up to one and a half cells away */
    return cells;
}

/* Return a range in the units of places.
 *
 * A rounded coordinate is off by less than 1, a difference likewise, and a distance by less than 1.5. */
static inline struct reach reach_of(uint64_t limit, int shift)
{
    uint64_t root = 0;
    for (uint64_t next = UINT64_C(1) << 31; next; next >>= 1)
        if ((root | next) * (root | next) <= limit)
            root |= next;
    root >>= shift;
    if (root <= 2)
        return (struct reach){limit, {0, UINT32_MAX}}; /* all are in doubt */
    const uint64_t low = (root - 2) * (root - 2), high = (root + 3) * (root + 3);
    return (struct reach){limit, {(uint32_t)low, (uint32_t)(high - low)}};
}

/* --- Sorting --- */

ALWAYS uint32_t column_of(const struct cells *cells, uint32_t coordinate)
{
    return (uint32_t)((uint64_t)coordinate * cells->side >> 32);
}

ALWAYS uint32_t cell_at(const struct cells *cells, uint32_t x, uint32_t y)
{
    return column_of(cells, y) * (cells->side + 1) + column_of(cells, x);
}

/* Begin to count the points of some rows; the last row is excluded. */
ALWAYS void clear_rows(struct cells *cells, uint32_t low, uint32_t high)
{
    const size_t line = cells->side + 1;
    memset(cells->start + low * line + 1, 0, sizeof *cells->start * line * (high - low));
}

ALWAYS void count_point(struct cells *cells, uint32_t cell) { cells->start[cell + 1]++; }

/* Return how many points of some rows are repeated. */
ALWAYS int32_t repeated(const struct cells *cells, uint32_t low, uint32_t high)
{
    int32_t points = 0;
    if (cells->side > 1)
        for (uint32_t row = low; row < high; row++)
            points += cells->start[row * (cells->side + 1) + 1];
    return points;
}

/* Replace the numbers of points of the cells of some rows by the places where these points begin. */
ALWAYS void sum_up(struct cells *cells, uint32_t low, uint32_t high, int32_t begin)
{
    for (uint32_t row = low; row < high; row++) {
        int32_t *line = cells->start + row * (cells->side + 1) + 1;
        if (cells->side > 1)
            line[cells->side] = line[0];
        for (uint32_t k = 0; k <= cells->side; k++) {
            int32_t count = line[k];
            line[k] = begin;
            begin += count;
        }
    }
}

/* Append a point to a cell; return its place. In the end a cell begins where the one before it ends. */
ALWAYS int32_t append(struct cells *cells, uint32_t cell, uint32_t place, uint32_t number)
{
    const int32_t at = cells->start[cell + 1]++;
    cells->places[at] = place;
    cells->numbers[at] = number;
    return at;
}

/* Append the points of the first column of some rows to the cells that repeat it.
 *
 * The first row begins at `begin`, which another thread may just be writing to the cell before it. */
ALWAYS void repeat_columns(struct cells *cells, uint32_t low, uint32_t high, int32_t begin)
{
    if (cells->side == 1) {
        if (low < high)
            cells->start[4] = cells->start[2]; /* a second row, without points: that of the second stretch */
        return;
    }
    for (uint32_t row = low; row < high; row++) {
        const uint32_t cell = row * (cells->side + 1);
        for (int32_t k = begin; k < cells->start[cell + 1]; k++) {
            const int32_t at = append(cells, cell + cells->side, cells->places[k], cells->numbers[k]);
            if (cells->labels)
                cells->labels[at] = cells->labels[k];
        }
        begin = cells->start[cell + cells->side + 1];
    }
}

/* --- Looking --- */

/* Where the stretches of the blocks of several points begin, in the order of the cells; and the points'
 * places. */
#define BATCH 512

struct blocks {
    uint32_t one[BATCH], other[BATCH], places[BATCH];
};

ALWAYS void find_blocks(const struct cells *cells, struct blocks *restrict blocks, const uint32_t *restrict x,
                        const uint32_t *restrict y, uint32_t count)
{
    const uint32_t side = cells->side, half = cells->half, line = side + 1,
                   back = (uint32_t)cells->after_last;
    const int shift = cells->shift;
    for (uint32_t k = 0; k < count; k++) {
        const uint32_t column = (uint32_t)((uint64_t)(x[k] - half) * side >> 32);
        const uint32_t row = (uint32_t)((uint64_t)(y[k] - half) * side >> 32), one = row * line + column;
        blocks->one[k] = one;
        blocks->other[k] = one + (row + 1 == side ? back : line);
        blocks->places[k] = (x[k] >> shift & 0xFFFF) | y[k] >> shift << 16;
    }
}

ALWAYS struct block block_of(const struct cells *cells, const struct blocks *blocks, uint32_t k)
{
    const int32_t *one = cells->start + blocks->one[k], *other = cells->start + blocks->other[k];
    return (struct block){{one[0], one[2]}, {other[0], other[2]}};
}

ALWAYS uint32_t place_at(const struct cells *cells, uint32_t x, uint32_t y)
{
    return (x >> cells->shift & 0xFFFF) | y >> cells->shift << 16;
}

/* Return as many bits as there are points, at most GROUP. */
ALWAYS uint32_t bits_up_to(int32_t points) { return (UINT32_C(1) << points) - 1; }

/* Return the signs of a vector of a group. Clang would pack the vectors of a group first, in three times as
 * many instructions. */
ALWAYS uint32_t signs_apart(u32 lanes)
{
    uint32_t word = signs(lanes);
#if defined AVX2
    __asm__("" : "+r"(word));
#endif
    return word;
}

ALWAYS int32_t length_of(struct stretch stretch) { return stretch.last - stretch.first; }
ALWAYS bool is_long(struct stretch stretch) { return length_of(stretch) > GROUP; }

/* Return which of a group's points from `first` on are in range, by all bits of their coordinates. */
APART uint32_t near_exactly(const struct cells *cells, uint64_t limit, int32_t first, int32_t last,
                            uint32_t x, uint32_t y)
{
    uint32_t found = 0;
    for (int k = 0; k < GROUP && first + k < last; k++) {
        const uint32_t number = cells->numbers[first + k];
        const int64_t way_x = (int32_t)(cells->x[number] - x), way_y = (int32_t)(cells->y[number] - y);
        found |= (uint32_t)((uint64_t)(way_x * way_x) + (uint64_t)(way_y * way_y) < limit) << k;
    }
    return found;
}

/* Return which of a group's points from `first` on are in range. */
ALWAYS uint32_t near(const struct cells *cells, struct reach reach, int32_t first, int32_t last, uint32_t x,
                     uint32_t y)
{
    const u32 here = spread(place_at(cells, x, y)), low = spread(reach.band.low),
              width = spread(reach.band.width);
    const uint32_t valid = first_bits(last - first);
    uint32_t found = 0, doubtful = 0;
    UNROLL for (int k = 0; k < VECTORS; k++) {
        u32 beyond = squared(subtract_halves(vector_at(cells->places + first + k * LANES), here)) - low;
        found |= signs(beyond) << k * LANES;
        doubtful |= below(beyond, width) << k * LANES;
    }
    if (RARELY((doubtful & valid) != 0))
        return near_exactly(cells, reach.limit, first, last, x, y);
    return found & valid;
}

APART uint32_t count_near_many(const struct cells *cells, struct reach reach, struct block block, uint32_t x,
                               uint32_t y)
{
    uint32_t found = 0;
    for (int32_t k = block.one.first; k < block.one.last; k += GROUP)
        found += (uint32_t)members(near(cells, reach, k, block.one.last, x, y));
    for (int32_t k = block.other.first; k < block.other.last; k += GROUP)
        found += (uint32_t)members(near(cells, reach, k, block.other.last, x, y));
    return found;
}

/* Return the number of points in range of a place. */
ALWAYS uint32_t count_near(const struct cells *cells, struct reach reach, struct block block, uint32_t place,
                           uint32_t x, uint32_t y)
{
    const u32 here = spread(place), width = spread(reach.band.width);
    uint32_t found = 0;
    u32 doubtful = {0};
    if (RARELY(is_long(block.one) || is_long(block.other)))
        return count_near_many(cells, reach, block, x, y);
    UNROLL for (int k = 0; k < 2 * VECTORS; k++) {
        const int32_t first = k < VECTORS ? block.one.first + k * LANES
                                          : block.other.first + (k - VECTORS) * LANES;
        const u32 beyond = squared(subtract_halves(vector_at(cells->places + first), here)) - reach.band.low;
        found |= signs_apart(beyond) << k * LANES;
        doubtful |= (u32)(beyond < width);
    }
    if (RARELY(signs(doubtful) != 0))
        return count_near_many(cells, reach, block, x, y);
    found &= bits_up_to(length_of(block.one)) | bits_up_to(length_of(block.other)) << GROUP;
    return (uint32_t)members(found);
}

#endif

/* Points in cells: which of many points lie near a place, at a cost that doesn't grow with their number.
 *
 * A half cell of the grid is at least the range. So all points in range of a place lie in the nearest block of
 * two by two cells. Points are sorted by row and then by column, and each row repeats its first column at its
 * end. So a block is two stretches of consecutive points, one per row, without a wrap. */

#ifndef NEAR_H
#define NEAR_H

#include "queue.h"

#define GROUP 8 /* points of a stretch that are looked at together: most stretches have fewer */
#define VECTORS (2 * GROUP / LANES) /* of two groups */
#define FAR_COLUMNS 256 /* of a grid that doesn't fit into a processor's nearest caches */

/* Return a difference on a torus the short way round. */
ALWAYS int64_t shortest(int64_t difference, int64_t side)
{
    difference -= 2 * difference >= side ? side : 0;
    return difference + (2 * difference < -side ? side : 0);
}

/* Return the way along an axis, on the torus the short one. */
ALWAYS int64_t short_way(int32_t here, int32_t there, int64_t side, bool walls)
{
    const int64_t way = (int64_t)(uint32_t)there - (uint32_t)here;
    return (int32_t)(walls ? way : shortest(way, side)); /* which tells compilers that it fits in 32 bits */
}

/* --- Which points are near a place --- */

/* Return ways along an axis without sign, on the torus the short ones: where no difference has to be corrected
 * they wrap in 32 bits. */
ALWAYS u32 ways(u32 there, u32 here, uint32_t side, const bool wraps)
{
    if (wraps)
        return least_of(there - here, here - there);
    const u32 straight = there + here - 2 * least_of(there, here);
    return least_of(straight, side - straight);
}

/* Points within two limits, of both groups of which one begins at `first` and one at `second`. */
struct found {
    uint32_t one, other;
};

/* Return a vector of the words of two groups. */
ALWAYS u32 words_of(const int32_t *from, int64_t first, int64_t second, int k)
{
#if defined AVX512
    (void)k; /* one vector has both */
    return halves_at(from + first, from + second);
#else
    const int at = k * LANES;
    return vector_at(from + (at < GROUP ? first + at : second + at - GROUP));
#endif
}

/* Return which of a vector of points are closer than a limit, by squared distances of each second one. */
ALWAYS uint32_t closer(u64 even, u64 odd, uint64_t limit)
{
    const u64 lower = spread_long(0xFFFFFFFFu);
    return signs((u32)(((u64)(even < limit) & lower) | ((u64)(odd < limit) & ~lower)));
}

ALWAYS struct found find_in(const struct arena *arena, const int32_t *xs, const int32_t *ys, int64_t first,
                            int64_t second, int32_t x, int32_t y, uint64_t one, uint64_t other, const bool wraps)
{
    struct found found = {0, 0};
    UNROLL for (int k = 0; k < VECTORS; k++) {
        const u32 there_x = words_of(xs, first, second, k), there_y = words_of(ys, first, second, k);
        const u64 way_x = (u64)ways(there_x, spread((uint32_t)x), (uint32_t)arena->width, wraps);
        const u64 way_y = (u64)ways(there_y, spread((uint32_t)y), (uint32_t)arena->height, wraps);
        const u64 even = product(way_x, way_x) + product(way_y, way_y);
        const u64 odd = product(way_x >> 32, way_x >> 32) + product(way_y >> 32, way_y >> 32);
        found.one |= closer(even, odd, one) << k * LANES;
        found.other |= closer(even, odd, other) << k * LANES;
    }
    return found;
}

/* Find the points of two groups that are within limits of a place; valid or not, arrays are padded. */
ALWAYS struct found find_within(const struct arena *arena, int32_t *const *points, int64_t first, int64_t second,
                                int32_t x, int32_t y, uint64_t one, uint64_t other)
{
    return arena->wraps ? find_in(arena, points[POINT_X], points[POINT_Y], first, second, x, y, one, other, true)
                        : find_in(arena, points[POINT_X], points[POINT_Y], first, second, x, y, one, other, false);
}

/* Return which of up to 32 points, `first` to `last` (excluded), are near. */
static inline uint32_t near_word(const struct params *p, const int32_t *xs, const int32_t *ys, int64_t first,
                                 int64_t last, int32_t x, int32_t y, uint64_t limit)
{
    int32_t *const points[] = {(int32_t *)xs, (int32_t *)ys};
    uint32_t close = 0;
    UNROLL for (int k = 0; k < WORD; k += 2 * GROUP)
        close |= find_within(&p->arena, points, first + k, first + k + GROUP, x, y, limit, limit).one << k;
    return close & first_bits((int)(last - first));
}

/* Return which points of a word are less than a length away along each axis. */
static inline uint32_t beside_word(const struct arena *arena, const int32_t *xs, const int32_t *ys, int64_t first,
                                   int32_t x, int32_t y, uint32_t length)
{
    uint32_t beside = 0;
    UNROLL for (int k = 0; k < WORD; k += LANES) {
        const u32 there_x = vector_at(xs + first + k), there_y = vector_at(ys + first + k);
        const u32 way_x = ways(there_x, spread((uint32_t)x), (uint32_t)arena->width, arena->wraps);
        const u32 way_y = ways(there_y, spread((uint32_t)y), (uint32_t)arena->height, arena->wraps);
        beside |= (below(way_x, spread(length)) & below(way_y, spread(length))) << k;
    }
    return beside;
}

/* --- Cells --- */

/* Return the column of an x or the row of a y, by the scale of that axis. */
ALWAYS int64_t cell_along(int64_t coordinate, uint64_t scale) { return (int64_t)((uint64_t)coordinate * scale >> 52); }

ALWAYS int64_t cell_at(const struct grid *grid, int32_t x, int32_t y)
{
    return cell_along((uint32_t)y, grid->scale_y) * (grid->columns + 1) + cell_along((uint32_t)x, grid->scale_x);
}

/* Append a point to a cell; in the end each cell begins where the one before it ends. */
ALWAYS void append(struct grid_cells *cells, int64_t cell, int32_t x, int32_t y, int32_t number)
{
    const int32_t at = cells->start[cell + 1]++;
    cells->points[POINT_X][at] = x;
    cells->points[POINT_Y][at] = y;
    cells->points[NUMBER][at] = number;
}

/* Replace the numbers of points of the cells by the places where these points begin. */
static inline void sum_up(int32_t *start, const struct grid *grid)
{
    int32_t begin = 0;
    for (int64_t row = 0; row < grid->rows; row++) {
        int32_t *line = start + row * (grid->columns + 1) + 1;
        if (grid->columns > 1)
            line[grid->columns] = line[0];
        for (int64_t k = 0; k <= grid->columns; k++) {
            const int32_t count = line[k];
            line[k] = begin;
            begin += count;
        }
    }
}

/* Append the points of the first column of each row to the cell that repeats it. */
static inline void repeat_columns(struct grid_cells *cells, const struct grid *grid)
{
    for (int64_t row = 0; row < grid->rows && grid->columns > 1; row++) {
        const int64_t cell = row * (grid->columns + 1);
        for (int32_t k = cells->start[cell]; k < cells->start[cell + 1]; k++)
            append(cells, cell + grid->columns, cells->points[POINT_X][k], cells->points[POINT_Y][k],
                   cells->points[NUMBER][k]);
    }
}

/* Sort those of some points that are members of a set into cells: count, sum up, store. */
static inline void sort_into_cells(struct grid_cells *cells, const struct grid *grid, const int32_t *xs,
                                   const int32_t *ys, const int32_t *numbers, const uint32_t *members, int64_t count)
{
    struct grid_cells own = *cells; /* copies, which no store can change */
    const struct grid over = *grid;
    memset(own.start, 0, sizeof *own.start * (size_t)((over.columns + 1) * over.rows + 1));
    for (int64_t i = 0; i < count; i++)
        own.start[cell_at(&over, xs[i], ys[i]) + 1] += has(members, i);
    sum_up(own.start, &over);
    for (int64_t i = 0; i < count; i++)
        if (LIKELY(has(members, i)))
            append(&own, cell_at(&over, xs[i], ys[i]), xs[i], ys[i], numbers[i]);
    repeat_columns(&own, &over);
}

/* --- Blocks of cells --- */

/* The points of a block of cells; each last one is excluded. */
struct stretches {
    int64_t first, last, other_first, other_last;
};

/* Return a coordinate that may be negative on the torus. */
ALWAYS int64_t wrapped(int64_t coordinate, int64_t side) { return coordinate + (side & (coordinate >> 63)); }

/* Where the cells of the nearest block begin, in its lower row and in the other one. */
struct corners {
    const int32_t *one, *other;
};

ALWAYS struct corners corners_at(const struct grid_cells *cells, const struct grid *grid, int32_t x, int32_t y)
{
    const int64_t left = wrapped((uint32_t)x - grid->half_width, grid->width);
    const int64_t low = wrapped((uint32_t)y - grid->half_height, grid->height);
    const int64_t column = cell_along(left, grid->scale_x), row = cell_along(low, grid->scale_y);
    const int64_t next_row = row + 1 == grid->rows ? 0 : row + 1, line = grid->columns + 1;
    return (struct corners){cells->start + row * line + column, cells->start + next_row * line + column};
}

/* Return the nearest block of cells. */
ALWAYS struct stretches block_at(const struct grid_cells *cells, const struct grid *grid, int32_t x, int32_t y)
{
    const struct corners at = corners_at(cells, grid, x, y);
    return (struct stretches){at.one[0], at.one[2], at.other[0], at.other[grid->rows > 1 ? 2 : 0]};
}

/* Two groups of points. */
struct groups {
    int64_t first, second;
    uint32_t valid; /* those that belong to the block */
};

ALWAYS bool has_more(const struct stretches *left)
{
    return left->first < left->last || left->other_first < left->other_last;
}

/* Take points from a block: both stretches if they are short, else up to two groups of one of them. */
ALWAYS struct groups take_groups(struct stretches *left)
{
    const int64_t length = left->last - left->first, other = left->other_last - left->other_first;
    struct groups taken = {left->first, left->other_first, 0};
    if (LIKELY(length <= GROUP && other <= GROUP)) {
        taken.valid = (bit((int)length) - 1) | (bit((int)other) - 1) << GROUP;
        *left = (struct stretches){0, 0, 0, 0};
    } else if (length > 0) {
        taken = (struct groups){left->first, left->first + GROUP, first_bits((int)length)};
        left->first += length < 2 * GROUP ? length : 2 * GROUP;
    } else {
        taken = (struct groups){left->other_first, left->other_first + GROUP, first_bits((int)other)};
        left->other_first += other < 2 * GROUP ? other : 2 * GROUP;
    }
    return taken;
}

/* Queue a robot with the chosen points of two groups; return how many are queued.
 *
 * Without compression two are queued without a branch, since few robots have more. */
ALWAYS int64_t queue_chosen(struct part *part, int64_t queued, int64_t i, const int32_t *numbers, struct groups of,
                            uint32_t chosen)
{
#if defined AVX512
    const u32 itself = spread((uint32_t)i), packed = compressed(words_of(numbers, of.first, of.second, 0), chosen);
    memcpy(part->who + queued, &itself, sizeof itself);
    memcpy(part->other + queued, &packed, sizeof packed);
    return queued + members(chosen);
#else
    int32_t *who = part->who + queued, *other = part->other + queued;
    const int32_t *first = numbers + of.first, *second = numbers + of.second - GROUP;
    const int count = members(chosen);
    for (int n = 0; n < 2 || RARELY(n < count); n++) {
        const int k = lowest(chosen | bit(2 * GROUP - 1));
        who[n] = (int32_t)i;
        other[n] = (k < GROUP ? first : second)[k];
        chosen = without_lowest(chosen);
    }
    return queued + count;
#endif
}

/* Return which points of two groups stand for a robot, whether or not it broadcasts. */
ALWAYS uint32_t those_of(const int32_t *numbers, struct groups of, int32_t robot)
{
    uint32_t same = 0;
    UNROLL for (int k = 0; k < VECTORS; k++) {
        const i32 number = (i32)words_of(numbers, of.first, of.second, k);
        same |= equal((u32)(number >> 1), spread((uint32_t)robot)) << k * LANES;
    }
    return same;
}

/* Return which points of two groups stand for robots that broadcast. */
ALWAYS uint32_t those_loud(const int32_t *numbers, struct groups of)
{
    uint32_t loud = 0;
    UNROLL for (int k = 0; k < VECTORS; k++)
        loud |= signs(words_of(numbers, of.first, of.second, k) << 31) << k * LANES;
    return loud;
}

/* What robots look through: copies, which no store can change. */
struct lens {
    struct grid_cells cells;
    struct grid grid;
    struct arena arena;
    uint64_t sight, radio;
    const int32_t *x, *y;
};

ALWAYS struct lens lens_of(const struct state *s, const struct grid_cells *cells, const struct grid *grid)
{
    return (struct lens){*cells, *grid, s->params->arena, s->params->sensing.limit, s->params->radio.limit,
                         s->robots[X], s->robots[Y]};
}

/* Let the processor fetch what is around the robots of the next words: in a large swarm it is far away. */
ALWAYS void fetch_ahead(const struct lens *lens, int64_t w, int64_t words)
{
    if (lens->grid.columns < FAR_COLUMNS || w + 2 >= words)
        return;
    for (int64_t i = WORD * (w + 1); i < WORD * (w + 2); i++) {
        const struct corners later = corners_at(&lens->cells, &lens->grid, lens->x[i + WORD], lens->y[i + WORD]);
        const struct corners at = corners_at(&lens->cells, &lens->grid, lens->x[i], lens->y[i]);
        __builtin_prefetch(later.one);
        __builtin_prefetch(later.other);
        for (int row = 0; row < POINTS; row++) {
            __builtin_prefetch(lens->cells.points[row] + *at.one);
            __builtin_prefetch(lens->cells.points[row] + *at.other);
        }
    }
}

/* Queue what is near a robot, robots or tasks; return how many are queued.
 *
 * A robot is near itself: it is left out as `but`, or -1 is. */
ALWAYS int64_t queue_near(struct part *part, const struct lens *lens, int64_t i, uint64_t limit, int64_t queued,
                          int32_t but)
{
    const int32_t x = lens->x[i], y = lens->y[i], *numbers = lens->cells.points[NUMBER];
    struct stretches left = block_at(&lens->cells, &lens->grid, x, y);
    do {
        const struct groups of = take_groups(&left);
        const struct found found = find_within(&lens->arena, lens->cells.points, of.first, of.second, x, y, limit, 0);
        queued = queue_chosen(part, queued, i, numbers, of, found.one & of.valid & ~those_of(numbers, of, but));
    } while (RARELY(has_more(&left)));
    return queued;
}

/* --- The robots of a larger swarm, and what is around each of them --- */

/* Sort the robots that are there into cells: one thread for all.
 *
 * What stands for a robot in the cells is its number, and as the lowest bit whether it broadcasts. */
static inline void fill_cells(struct state *s)
{
    int32_t *restrict numbers = s->robots[ORDER]; /* which only the start needs */
    const int32_t *restrict labels = s->robots[LABEL];
    for (int64_t i = 0; i < s->padded; i++)
        numbers[i] = (int32_t)i << 1 | (labels[i] & 1);
    sort_into_cells(&s->robot_cells, &s->params->robots.grid, s->robots[X], s->robots[Y], numbers, s->sets[THERE],
                    s->params->robots.count);
}

/* Return which robots of a word explore. */
ALWAYS uint32_t exploring_in(const struct state *s, int64_t w)
{
    return ~s->sets[DISSEMINATING][w] & s->sets[WORKING][w];
}

/* Count the robots in sight of a robot, itself included; queue those that it hears. Return how many are queued. */
ALWAYS int64_t scan(struct part *part, const struct lens *lens, int64_t i, bool listens, int64_t queued, int64_t *seen)
{
    const int32_t x = lens->x[i], y = lens->y[i], *numbers = lens->cells.points[NUMBER];
    struct stretches left = block_at(&lens->cells, &lens->grid, x, y);
    do {
        const struct groups of = take_groups(&left);
        const struct found found = find_within(&lens->arena, lens->cells.points, of.first, of.second, x, y,
                                               lens->sight, lens->radio);
        const uint32_t loud = those_loud(numbers, of) & ~those_of(numbers, of, (int32_t)i) & -(uint32_t)listens;
        *seen += members(found.one & of.valid);
        queued = queue_chosen(part, queued, i, numbers, of, found.other & of.valid & loud);
    } while (RARELY(has_more(&left)));
    return queued;
}

/* Count the tasks in sight of exploring robots. */
static inline void count_tasks(struct state *s, const struct part *part)
{
    const struct lens lens = lens_of(s, &s->task_cells, &s->params->tasks.grid);
    for (int64_t w = part->first; w < part->last; w++) {
        fetch_ahead(&lens, w, s->words);
        for (uint32_t rest = exploring_in(s, w); rest; rest = without_lowest(rest)) {
            const int64_t i = lowest_member(w, rest);
            const int32_t x = lens.x[i], y = lens.y[i];
            struct stretches left = block_at(&lens.cells, &lens.grid, x, y);
            do {
                const struct groups of = take_groups(&left);
                s->counts[TASKS_SEEN][i] += members(of.valid & find_within(&lens.arena, lens.cells.points, of.first,
                                                                           of.second, x, y, lens.sight, 0).one);
            } while (RARELY(has_more(&left)));
        }
    }
}

#endif

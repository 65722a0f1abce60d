/* The ways around walls to tasks, in a place (model.md 6.25.15 to 6.25.17).
 *
 * The ways to a task are found when they are first asked for: a cell takes about 25 ns. Cells wait in two
 * queues, those reached over a side and over a corner. In each of them ways never decrease: no heap is needed. */

#ifndef WAY_H
#define WAY_H

#include "place.h"

enum length { OVER_SIDE = 5, OVER_CORNER = 7 }; /* fifths of a cell's side between the centres of two cells */

/* What stands in place of a way from a passable cell without one, and from a cell that isn't passable. */
enum missing { NO_WAY = 1 << 30, CLOSED = -1 };

/* Cells that wait, as numbers row by row. */
struct waiting {
    int32_t *cells;
    int64_t first, last;
};

ALWAYS int64_t cell_count(const struct state *s)
{
    return s->params->arena.place.columns * s->params->arena.place.rows;
}

/* Return the ways from all cells to a task; or a queue, after those of all tasks. */
ALWAYS int32_t *ways_to(const struct state *s, int64_t task) { return s->ways + task * cell_count(s); }

/* Let no ways be found: of each task in the first cell, which is never passable. */
static inline void clear_ways(struct state *s)
{
    const bool finds = s->params->arena.place.exists && s->params->arena.place.arrived >= 0;
    for (int64_t task = 0; finds && task < s->params->tasks.count; task++)
        *ways_to(s, task) = 0;
}

/* Return the passable cell from which robots reach a task in a cell, or -1 (model.md 6.20.9). */
static inline int64_t reached_from(const struct state *s, int64_t column, int64_t row)
{
    const struct place *place = &s->params->arena.place;
    if (is_open(s, column, row))
        return row * place->columns + column;
    int64_t best = -1, least = place->near + 1;
    const int64_t around = (int64_t)__builtin_sqrt((double)place->near) + 2;
    const int64_t last_row = lesser(row + around + 1, place->rows);
    const int64_t last_column = lesser(column + around + 1, place->columns);
    for (int64_t y = greater(row - around, 0); y < last_row; y++)
        for (int64_t x = greater(column - around, 0); x < last_column; x++) {
            const int64_t across = greater(distance(x, column) - 1, 0), along = greater(distance(y, row) - 1, 0);
            const int64_t gap = across * across + along * along;
            if (gap < least && is_open(s, x, y)) {
                best = y * place->columns + x;
                least = gap;
            }
        }
    return best;
}

/* Shorten the way from a cell, if it is shorter by another one, and let it wait. */
ALWAYS void come_from(int32_t *way, struct waiting *queue, int64_t here, int64_t there, int32_t length)
{
    if (way[here] + length < way[there]) {
        way[there] = way[here] + length;
        queue->cells[queue->last++] = (int32_t)there;
    }
}

/* Take the cell with the shorter way of those that wait first in two queues; return -1 if none waits. */
ALWAYS int64_t take_nearer(const int32_t *way, struct waiting *one, struct waiting *other)
{
    if (other->first < other->last &&
        (one->first == one->last || way[one->cells[one->first]] > way[other->cells[other->first]]))
        one = other;
    return one->first < one->last ? one->cells[one->first++] : -1;
}

/* Shorten the ways from the cells around one. */
ALWAYS void spread_from(int32_t *way, int64_t columns, int64_t here, struct waiting *sides, struct waiting *corners)
{
    const int64_t beside[] = {-columns, -1, 1, columns};
    for (int k = 0; k < 4; k++)
        come_from(way, sides, here, here + beside[k], OVER_SIDE);
    for (int64_t dy = -columns; dy <= columns; dy += 2 * columns)
        for (int64_t dx = -1; dx <= 1; dx += 2)
            if (way[here + dy] > CLOSED && way[here + dx] > CLOSED)
                come_from(way, corners, here, here + dy + dx, OVER_CORNER);
}

/* Find the ways from all cells to a task. */
APART void find_ways(struct state *s, int64_t task)
{
    const struct place *place = &s->params->arena.place;
    int32_t *way = ways_to(s, task);
    struct waiting sides = {.cells = ways_to(s, s->params->tasks.count)}, corners = {.cells = sides.cells + cell_count(s)};
    for (int64_t row = 0; row < place->rows; row++)
        for (int64_t column = 0; column < place->columns; column++)
            way[row * place->columns + column] = is_open(s, column, row) ? NO_WAY : CLOSED;
    int64_t here = reached_from(s, at_x(s->tasks, task) >> place->bits, at_y(s->tasks, task) >> place->bits);
    if (here >= 0)
        way[here] = 0;
    for (; here >= 0; here = take_nearer(way, &sides, &corners))
        spread_from(way, place->columns, here, &sides, &corners);
}

/* Return the ways from all cells to a task, which are found unless they have been. */
ALWAYS const int32_t *found_ways(struct state *s, int64_t task)
{
    const int32_t *way = ways_to(s, task);
    if (way[0] == 0)
        find_ways(s, task);
    return way;
}

/* Return the number of the cell of a position, row by row. */
ALWAYS int64_t cell_at_place(const struct state *s, int64_t x, int64_t y)
{
    const struct place *place = &s->params->arena.place;
    return (y >> place->bits) * place->columns + (x >> place->bits);
}

/* Return the way from a robot's cell to a task, in fifths of a cell's side, or NO_WAY. */
static inline int64_t way_around(struct state *s, int64_t i, int64_t task)
{
    return found_ways(s, task)[cell_at_place(s, at_x(s->robots, i), at_y(s->robots, i))];
}

/* --- Steps --- */

struct leg {
    int64_t x, y;
};

/* Return the way from a position to the middle of a cell. */
ALWAYS struct leg leg_to(const struct state *s, int64_t cell, int64_t x, int64_t y)
{
    const struct place *place = &s->params->arena.place;
    const int64_t half = INT64_C(1) << (place->bits - 1);
    return (struct leg){(cell % place->columns << place->bits) + half - x,
                        (cell / place->columns << place->bits) + half - y};
}

ALWAYS double length_of(struct leg leg) { return __builtin_sqrt((double)(leg.x * leg.x + leg.y * leg.y)); }

/* Return the step along a leg, as long as other steps at most. */
ALWAYS struct leg step_along(const struct state *s, struct leg leg)
{
    const double length = length_of(leg), reach = s->params->robots.reach;
    if (length <= reach)
        return leg;
    return (struct leg){(int64_t)__builtin_floor(reach * ((double)leg.x / length) + 0.5),
                        (int64_t)__builtin_floor(reach * ((double)leg.y / length) + 0.5)};
}

/* Return which of the cells around a cell is next on the way: the lowest, and the first of equals. */
static inline int64_t next_cell(const struct state *s, const int32_t *way, int64_t cell)
{
    const int64_t columns = s->params->arena.place.columns;
    int64_t best = cell;
    for (int64_t dy = -columns; dy <= columns; dy += columns)
        for (int64_t dx = -1; dx <= 1; dx++) {
            const int64_t there = cell + dy + dx;
            if (way[there] < way[best] && way[there] > CLOSED && way[cell + dx] > CLOSED && way[cell + dy] > CLOSED)
                best = there;
        }
    return best;
}

/* Return the number of the first cell on a way that is farther than a step, or of the task's cell. */
static inline int64_t cells_ahead(const struct state *s, const int32_t *way, int64_t cell, int64_t x, int64_t y)
{
    int64_t number = 0;
    while (way[cell] > 0 && way[cell] < NO_WAY) {
        cell = next_cell(s, way, cell);
        number++;
        if (length_of(leg_to(s, cell, x, y)) > s->params->robots.reach)
            break;
    }
    return number;
}

/* Find a robot's step on its way to a task. */
static inline void step_around(struct state *s, int64_t i, int64_t task, int32_t *u, int32_t *v)
{
    const int32_t *way = found_ways(s, task);
    const int64_t x = at_x(s->robots, i), y = at_y(s->robots, i), here = cell_at_place(s, x, y);
    struct leg step;
    for (int64_t number = cells_ahead(s, way, here, x, y);; number >>= 1) {
        int64_t cell = here;
        for (int64_t k = 0; k < number; k++)
            cell = next_cell(s, way, cell);
        step = step_along(s, leg_to(s, cell, x, y));
        if (number <= 1 || (passable_ends(s, x, y, step.x, step.y) == QUARTERS &&
                            way[cell_at_place(s, x + step.x, y + step.y)] < way[here]))
            break;
    }
    *u = (int32_t)step.x;
    *v = (int32_t)step.y;
}

#endif

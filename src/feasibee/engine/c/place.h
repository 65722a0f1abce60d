/* Places: which steps avoid walls, and how many walls are between two things (model.md 6.20, 6.21).
 *
 * A byte says how many cells around a cell, or around 4 x 4 cells, are free of walls. If such squares around
 * both ends and the middle cover a line, no wall is on it. Otherwise the line is walked from cell to cell: one
 * in ten, among obstacles. */

#ifndef PLACE_H
#define PLACE_H

#include "motion.h"

#define MOST_WALLS 8 /* feasibee.base.codes */
#define QUARTERS 4   /* parts of a step whose ends must be in passable cells */

enum sense { SIGHT, RADIO }; /* parts of the limits of a place */

/* Return a coordinate of a robot or task: they have them in the same rows. */
ALWAYS int64_t at_x(int32_t *const *points, int64_t i) { return (uint32_t)points[POINT_X][i]; }
ALWAYS int64_t at_y(int32_t *const *points, int64_t i) { return (uint32_t)points[POINT_Y][i]; }

/* --- Cells --- */

ALWAYS bool has_cell(const struct place *place, const uint64_t *cells, uint32_t column, uint32_t row)
{
    return cells[row * (uint32_t)place->row_words + (column >> 6)] >> (column & 63) & 1;
}

ALWAYS bool is_wall(const struct state *s, int64_t column, int64_t row)
{
    return has_cell(&s->params->arena.place, s->tables.ground.walls, (uint32_t)column, (uint32_t)row);
}

ALWAYS bool is_open(const struct state *s, int64_t column, int64_t row)
{
    return has_cell(&s->params->arena.place, s->tables.ground.passable, (uint32_t)column, (uint32_t)row);
}

/* Return whether a position is in a passable cell. Those at the edges never are, so they stand for all beyond:
 * a negative coordinate is a large unsigned one. */
ALWAYS bool is_passable(const struct state *s, uint32_t x, uint32_t y)
{
    const struct place *place = &s->params->arena.place;
    const uint32_t last_column = (uint32_t)(place->columns - 1), last_row = (uint32_t)(place->rows - 1);
    const uint32_t column = x >> place->bits, row = y >> place->bits;
    return is_open(s, column < last_column ? column : last_column, row < last_row ? row : last_row);
}

/* Return how many cells from a cell on, in each direction, are surely free of walls. */
ALWAYS int64_t open_around(const struct state *s, int64_t column, int64_t row)
{
    const struct place *place = &s->params->arena.place;
    return s->tables.ground.open_around[(row >> place->blur) * place->blurred_columns + (column >> place->blur)];
}

ALWAYS int64_t open_at(const struct state *s, int64_t x, int64_t y)
{
    return open_around(s, x >> s->params->arena.place.bits, y >> s->params->arena.place.bits);
}

/* --- Steps --- */

/* Return how many of the four quarters of a step end in passable cells (model.md 6.20.4). */
ALWAYS int passable_ends(const struct state *s, int64_t x, int64_t y, int64_t u, int64_t v)
{
    const uint32_t x0 = (uint32_t)x, y0 = (uint32_t)y;
    const uint32_t quarter_u = (uint32_t)(u >> 2), quarter_v = (uint32_t)(v >> 2);
    const uint32_t half_u = (uint32_t)(u >> 1), half_v = (uint32_t)(v >> 1);
    return is_passable(s, x0 + quarter_u, y0 + quarter_v) + is_passable(s, x0 + half_u, y0 + half_v) +
           is_passable(s, x0 + half_u + quarter_u, y0 + half_v + quarter_v) +
           is_passable(s, x0 + (uint32_t)u, y0 + (uint32_t)v);
}

/* Return how many quarters of a robot's step would end in passable cells if the step were another one. */
ALWAYS int ends_of(const struct state *s, int64_t i, int64_t u, int64_t v)
{
    return passable_ends(s, s->robots[X][i], s->robots[Y][i], u, v);
}

/* Return which robots of a set in a word have steps that the place blocks. */
static inline uint32_t find_blocked_by_place(const struct state *s, uint32_t tried, int64_t w)
{
    uint32_t found = 0;
    for (; tried; tried = without_lowest(tried)) {
        const int64_t i = lowest_member(w, tried);
        found |= bit_if(ends_of(s, i, s->robots[STEP_X][i], s->robots[STEP_Y][i]) < QUARTERS, i);
    }
    return found;
}

/* Find which robots of a word have the place that blocks them on their left, and on their right. */
static inline void find_place_beside(const struct state *s, uint32_t blocked, int64_t w, uint32_t *left,
                                     uint32_t *right)
{
    *left = *right = 0;
    for (; blocked; blocked = without_lowest(blocked)) {
        const int64_t i = lowest_member(w, blocked), u = s->robots[STEP_X][i], v = s->robots[STEP_Y][i];
        if (ends_of(s, i, u, v) == QUARTERS)
            continue;
        const int on_left = ends_of(s, i, (int32_t)shortened(u - v), (int32_t)shortened(u + v));
        const int on_right = ends_of(s, i, (int32_t)shortened(u + v), (int32_t)shortened(v - u));
        *left |= bit_if(on_right > on_left, i);
        *right |= bit_if(on_left > on_right, i);
    }
}

/* --- Walls in between --- */

ALWAYS int64_t distance(int64_t a, int64_t b) { return a < b ? b - a : a - b; }
ALWAYS int64_t lesser(int64_t a, int64_t b) { return a < b ? a : b; }
ALWAYS int64_t greater(int64_t a, int64_t b) { return a > b ? a : b; }

/* Return how many borders of the shorter side a line has crossed right after some of the longer one. */
ALWAYS int64_t crossed_aside(int64_t crossed, int64_t longer, int64_t shorter)
{
    return ((2 * crossed - 1) * shorter + longer) / (2 * longer);
}

/* Return in how many stretches the line between two positions' cells touches walls, at most `most`.
 *
 * The line joins the cells' centres; `x` and `y` count the borders that it has crossed. It leaps as far as no
 * wall is around. Else `ahead` says which border comes next: at 0 both, at a corner. */
ALWAYS int64_t walls_between(const struct state *s, int64_t ax, int64_t ay, int64_t bx, int64_t by, int64_t most)
{
    const int64_t bits = s->params->arena.place.bits, first_column = ax >> bits, first_row = ay >> bits;
    const int64_t across = distance(first_column, bx >> bits), along = distance(first_row, by >> bits);
    const int64_t step_x = bx >= ax ? 1 : -1, step_y = by >= ay ? 1 : -1;
    bool inside = is_wall(s, first_column, first_row);
    int64_t x = 0, y = 0, found = inside;
    while (x + y < across + along && found < most) {
        const int64_t column = first_column + step_x * x, row = first_row + step_y * y;
        const int64_t leap = open_around(s, column, row) - 1;
        if (leap > 1 && across >= along) {
            x = lesser(x + leap, across);
            y = crossed_aside(x, across, along);
        } else if (leap > 1) {
            y = lesser(y + leap, along);
            x = crossed_aside(y, along, across);
        } else {
            const int64_t ahead = (2 * x + 1) * along - (2 * y + 1) * across;
            const bool over_x = ahead <= 0, over_y = ahead >= 0;
            const bool corner =
                over_x && over_y && (is_wall(s, column + step_x, row) || is_wall(s, column, row + step_y));
            const bool now = is_wall(s, column + (over_x ? step_x : 0), row + (over_y ? step_y : 0));
            found += !inside && (now || corner);
            inside = now;
            x += over_x;
            y += over_y;
        }
    }
    return found;
}

/* Return whether open squares around both ends and the middle of a line cover it: so no wall is on it. */
ALWAYS bool is_surely_free(const struct state *s, int64_t ax, int64_t ay, int64_t bx, int64_t by)
{
    const int64_t bits = s->params->arena.place.bits;
    const int64_t a_column = ax >> bits, a_row = ay >> bits, b_column = bx >> bits, b_row = by >> bits;
    const int64_t length = greater(distance(a_column, b_column), distance(a_row, b_row));
    const int64_t start = open_around(s, a_column, a_row), end = open_around(s, b_column, b_row);
    /* Up to half a cell from the line's middle. */
    const int64_t middle = open_around(s, (a_column + b_column) >> 1, (a_row + b_row) >> 1);
    return (start + end > length + 1) | (2 * (lesser(start, end) + middle) > length + 3); /* one branch */
}

/* Return whether as many walls as are between two positions make them too far apart. */
APART bool is_behind_walls(const struct state *s, enum sense sense, int64_t ax, int64_t ay, int64_t bx, int64_t by)
{
    const uint64_t *limits = s->tables.ground.limits + sense * (MOST_WALLS + 1);
    const int64_t walls = walls_between(s, ax, ay, bx, by, limits[1] > 0 ? MOST_WALLS : 1);
    const int64_t way_x = bx - ax, way_y = by - ay;
    return walls > 0 && (uint64_t)(way_x * way_x) + (uint64_t)(way_y * way_y) >= limits[walls];
}

/* Return whether walls between two positions in range cut them off (model.md 6.20.11, 6.21). */
ALWAYS bool is_cut(const struct state *s, enum sense sense, int64_t ax, int64_t ay, int64_t bx, int64_t by)
{
    return !is_surely_free(s, ax, ay, bx, by) && is_behind_walls(s, sense, ax, ay, bx, by);
}

/* Leave the robots of listed pairs out of each other's sets if walls are between them. */
static inline void drop_listed_cut(struct state *s, const struct part *part, enum sense sense, int64_t listed)
{
    uint32_t *links = s->links[IN_SIGHT];
    for (int64_t k = 0; k < listed; k++) {
        const int64_t i = part->who[k], j = part->other[k];
        if (!is_cut(s, sense, at_x(s->robots, i), at_y(s->robots, i), at_x(s->robots, j), at_y(s->robots, j)))
            continue;
        links[(j >> 5) * s->padded + i] &= ~bit((int)(j & 31));
        links[(i >> 5) * s->padded + j] &= ~bit((int)(i & 31));
    }
}

/* Leave those robots out of each other's sets in IN_SIGHT between which walls are.
 *
 * A robot without walls within `reach` cells lists nobody. Pairs are listed and then tested in one loop. */
APART void drop_cut(struct state *s, struct part *part, enum sense sense, int64_t reach)
{
    int64_t listed = 0;
    for (int64_t i = 0; i < s->params->robots.count; i++) {
        if (open_at(s, at_x(s->robots, i), at_y(s->robots, i)) > reach)
            continue;
        for (int64_t other = 0; other <= i >> 5; other++) {
            const uint32_t before = first_bits((int)(i - WORD * other));
            uint32_t left = s->links[IN_SIGHT][other * s->padded + i] & before;
            for (; left; left = without_lowest(left), listed++) {
                part->who[listed] = (int32_t)i;
                part->other[listed] = (int32_t)lowest_member(other, left);
            }
        }
        if (listed > QUEUE_ROOM) {
            drop_listed_cut(s, part, sense, listed);
            listed = 0;
        }
    }
    drop_listed_cut(s, part, sense, listed);
}

/* Return which tasks of a word, all in range of a position, aren't hidden by walls. */
static inline uint32_t visible_tasks(const struct state *s, uint32_t tasks, int64_t w, int64_t x, int64_t y)
{
    for (uint32_t left = tasks; left; left = without_lowest(left)) {
        const int64_t task = lowest_member(w, left);
        if (is_cut(s, SIGHT, (uint32_t)x, (uint32_t)y, at_x(s->tasks, task), at_y(s->tasks, task)))
            tasks &= ~bit((int)(task & 31));
    }
    return tasks;
}

#endif

/* Places: which steps avoid walls, and how many walls are between two things (model.md 6.20, 6.21).
 *
 * Boxes of cells hold all walls, so that a line is compared with many cells at once. Where walls only weaken the
 * radio, a line that touches some is walked from cell to cell, to count them. */

#ifndef PLACE_H
#define PLACE_H

#include "motion.h"

#define MOST_WALLS 8 /* feasibee.base.codes */
#define QUARTERS 4   /* parts of a step whose ends must be in passable cells */
#define TILE 6       /* tiles have 64 x 64 cells */

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

/* The line between the centres of two cells. */
struct line {
    int64_t column, row, last_column, last_row;
};

ALWAYS struct line line_of(const struct state *s, int64_t ax, int64_t ay, int64_t bx, int64_t by)
{
    const int64_t bits = s->params->arena.place.bits;
    return (struct line){ax >> bits, ay >> bits, bx >> bits, by >> bits};
}

/* Return in how many stretches a line touches walls, at most `most`.
 *
 * `x` and `y` count the borders that it has crossed; `ahead` says which comes next: at 0 both, at a corner. */
APART int64_t walls_on(const struct state *s, struct line line, int64_t most)
{
    const int64_t across = distance(line.column, line.last_column), along = distance(line.row, line.last_row);
    const int64_t step_x = line.last_column >= line.column ? 1 : -1, step_y = line.last_row >= line.row ? 1 : -1;
    bool inside = is_wall(s, line.column, line.row);
    int64_t x = 0, y = 0, found = inside;
    while (x + y < across + along && found < most) {
        const int64_t column = line.column + step_x * x, row = line.row + step_y * y;
        const int64_t ahead = (2 * x + 1) * along - (2 * y + 1) * across;
        const bool over_x = ahead <= 0, over_y = ahead >= 0;
        const bool corner = over_x && over_y && (is_wall(s, column + step_x, row) || is_wall(s, column, row + step_y));
        const bool now = is_wall(s, column + (over_x ? step_x : 0), row + (over_y ? step_y : 0));
        found += !inside && (now || corner);
        inside = now;
        x += over_x;
        y += over_y;
    }
    return found;
}

/* Return whether a line touches one of the boxes in lanes, corners included.
 *
 * It does unless the box is beyond its ends, or all of the box on one side of it: its middle is then farther from
 * the line than half its sides reach. */
ALWAYS bool touches(const int32_t *boxes, int64_t stride, struct line line)
{
    const i32 left = (i32)vector_at(boxes), right = (i32)vector_at(boxes + stride);
    const i32 top = (i32)vector_at(boxes + 2 * stride), bottom = (i32)vector_at(boxes + 3 * stride);
    const int32_t u = (int32_t)(line.last_column - line.column), v = (int32_t)(line.last_row - line.row);
    const int32_t start = 2 * (u * (int32_t)line.row - v * (int32_t)line.column);
    const i32 aside = u * (top + bottom) - v * (left + right) - start;
    const i32 reach = (v < 0 ? -v : v) * (right - left + 1) + (u < 0 ? -u : u) * (bottom - top + 1);
    const i32 apart = (aside > reach) | (-aside > reach) |
                      (left > (int32_t)greater(line.column, line.last_column)) |
                      (right < (int32_t)lesser(line.column, line.last_column)) |
                      (top > (int32_t)greater(line.row, line.last_row)) |
                      (bottom < (int32_t)lesser(line.row, line.last_row));
    return signs((u32)apart) != first_bits(LANES);
}

/* Return whether a line touches walls: those of the tiles around it are looked at, many at once. */
ALWAYS bool touches_walls(const struct state *s, struct line line)
{
    const struct place *place = &s->params->arena.place;
    const int64_t first = lesser(line.column, line.last_column) >> TILE, last = greater(line.column, line.last_column) >> TILE;
    const int64_t last_row = greater(line.row, line.last_row) >> TILE;
    for (int64_t row = lesser(line.row, line.last_row) >> TILE; row <= last_row; row++) {
        const int32_t *starts = s->tables.ground.tiles + row * place->tile_columns;
        for (int64_t k = starts[first]; k < starts[last + 1]; k += LANES)
            if (touches(s->tables.ground.boxes + k, place->boxes, line))
                return true;
    }
    return false;
}

/* Return whether walls between two positions in range cut them off (model.md 6.20.11, 6.21). */
ALWAYS bool is_cut(const struct state *s, enum sense sense, int64_t ax, int64_t ay, int64_t bx, int64_t by)
{
    const struct line line = line_of(s, ax, ay, bx, by);
    if (!touches_walls(s, line))
        return false;
    const uint64_t *limits = s->tables.ground.limits + sense * (MOST_WALLS + 1);
    const int64_t walls = limits[1] > 0 ? walls_on(s, line, MOST_WALLS) : 1, way_x = bx - ax, way_y = by - ay;
    return (uint64_t)(way_x * way_x) + (uint64_t)(way_y * way_y) >= limits[walls];
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

/* Leave robots out of each other's sets in IN_SIGHT if walls are between them, one is of `ends`, and the other of
 * `others`. Pairs are listed and then tested in one loop. */
APART void drop_cut(struct state *s, struct part *part, enum sense sense, const uint32_t *ends, const uint32_t *others)
{
    int64_t listed = 0;
    for (int64_t i = 0; i < s->params->robots.count; i++) {
        const bool is_end = has(ends, i), is_other = has(others, i);
        for (int64_t word = 0; word <= i >> 5; word++) {
            const uint32_t asked = (is_end ? others[word] : 0) | (is_other ? ends[word] : 0);
            const uint32_t before = first_bits((int)(i - WORD * word));
            uint32_t left = s->links[IN_SIGHT][word * s->padded + i] & before & asked;
            for (; left; left = without_lowest(left), listed++) {
                part->who[listed] = (int32_t)i;
                part->other[listed] = (int32_t)lowest_member(word, left);
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

/* The place in a page: passable cells, pieces, lines across walls (docs/model.md 6.20, 6.21), as reference/place.py has them.
 *
 * The page writes world_place() and world_cells(), as place_of in lowering.py has them; without a place, zeros.
 */
#ifndef FEASIBEE_PAGE_PLACE_H
#define FEASIBEE_PAGE_PLACE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include "limits.h"

#define PIECES 256
#define MOST_WALLS 8

/* Bits of a cell, as CELL_BITS in lowering.py; a test compares them. The last is added for strategies that read the
 * plan (strategies/sight.py). */
enum cell { WALL = 1, PASSABLE = 2, ROBOTS_ZONE = 4, TASKS_ZONE = 8, TASKS_THERE = 16 };

/* Numbers of the place. From BEYOND on, for each number of walls from 1 on, both halves of the least squared distance
 * that is out of range of radio. */
enum place_number { COLUMNS, ROWS, CELL_BITS, BEYOND, PLACE_NUMBERS = BEYOND + 2 * MOST_WALLS };

/* The cells in which robots or tasks are placed, piece after piece, and where those of each piece begin. */
struct stands {
    uint32_t cells[WORLD_CELLS], first[PIECES + 1];
};

static double place_numbers[PLACE_NUMBERS];
static int64_t columns, rows, cell_bits; /* of a coordinate; columns is 0 without a place */
static uint8_t cells[2 * WORLD_CELLS];   /* bits of each cell, then the piece of each, from 1 on */
static struct stands robots_stand, tasks_stand;

/* Return the bits of the cell of a position. Cells at the edges aren't passable: so positions beyond them aren't. */
static int cell_at(int64_t x, int64_t y)
{
    int64_t column = x >> cell_bits, row = y >> cell_bits;
    column = column < 0 ? 0 : column < columns ? column : columns - 1;
    row = row < 0 ? 0 : row < rows ? row : rows - 1;
    return cells[row * columns + column];
}

/* Return whether a step avoids the place: its four quarters end in passable cells (model.md 6.20.4). */
static bool goes(int64_t x, int64_t y, int64_t u, int64_t v)
{
    int64_t half_u = u >> 1, half_v = v >> 1, quarter_u = u >> 2, quarter_v = v >> 2;
    return cell_at(x + quarter_u, y + quarter_v) & cell_at(x + half_u, y + half_v) &
           cell_at(x + half_u + quarter_u, y + half_v + quarter_v) & cell_at(x + u, y + v) & PASSABLE;
}

static bool is_wall(int64_t column, int64_t row)
{
    return cells[row * columns + column] & WALL;
}

/* Return in how many stretches the line between the centres of two positions' cells touches walls, at most some.
 *
 * ahead says which border of a cell the line meets first: at 0 both, at a corner.
 */
static int walls_between(int64_t from_x, int64_t from_y, int64_t to_x, int64_t to_y, int most)
{
    int64_t column = from_x >> cell_bits, row = from_y >> cell_bits;
    int64_t across = (to_x >> cell_bits) - column, along = (to_y >> cell_bits) - row;
    int64_t step_x = across < 0 ? -1 : 1, step_y = along < 0 ? -1 : 1;
    across *= step_x;
    along *= step_y;
    bool inside = is_wall(column, row);
    int found = inside;
    for (int64_t ahead = along - across, left = across + along; left > 0 && found < most;) {
        bool corner = ahead == 0 && (is_wall(column + step_x, row) || is_wall(column, row + step_y));
        bool turns_x = ahead <= 0, turns_y = ahead >= 0;
        column += turns_x ? step_x : 0;
        row += turns_y ? step_y : 0;
        ahead += 2 * ((turns_x ? along : 0) - (turns_y ? across : 0));
        left -= turns_x + turns_y;
        bool wall = is_wall(column, row);
        found += !inside && (wall || corner);
        inside = wall;
    }
    return found;
}

/* Return the piece of a cell in which things of a zone are placed; 0 if they aren't. */
static uint8_t piece_for(enum cell zone, int64_t cell)
{
    return cells[cell] & PASSABLE && cells[cell] & zone ? cells[columns * rows + cell] : 0;
}

/* List the cells of a zone in which things are placed, piece after piece, row by row. */
static void list_stands(struct stands *stands, enum cell zone)
{
    uint32_t next[PIECES] = {0};
    for (int64_t k = 0; k < columns * rows; k++)
        next[piece_for(zone, k)]++;
    stands->first[0] = stands->first[1] = 0;
    for (int piece = 1; piece < PIECES; piece++) {
        stands->first[piece + 1] = stands->first[piece] + next[piece];
        next[piece] = stands->first[piece];
    }
    for (int64_t k = 0; k < columns * rows; k++)
        if (piece_for(zone, k) > 0)
            stands->cells[next[piece_for(zone, k)]++] = (uint32_t)k;
}

static void read_grid(void)
{
    columns = (int64_t)place_numbers[COLUMNS];
    rows = (int64_t)place_numbers[ROWS];
    cell_bits = (int64_t)place_numbers[CELL_BITS];
    list_stands(&robots_stand, ROBOTS_ZONE);
    list_stands(&tasks_stand, TASKS_ZONE);
}

/* Give robots or tasks their pieces: each goes to the one farthest behind its share of the cells (model.md 6.20.7).
 *
 * Tasks go to pieces with robots, of which held has the numbers, if there are any in their zone. Without a place all
 * are in piece 0.
 */
static void share(uint8_t *piece_of, uint32_t count, const struct stands *stands, const uint32_t *held)
{
    int64_t cells_of[PIECES] = {0}, given[PIECES] = {0}, total = 0;
    for (int piece = 0; piece < PIECES; piece++) {
        cells_of[piece] = held && !held[piece] ? 0 : stands->first[piece + 1] - stands->first[piece];
        total += cells_of[piece];
    }
    if (held && total == 0) {
        share(piece_of, count, stands, NULL);
        return;
    }
    for (uint32_t k = 0; k < count; k++) {
        int best = 0;
        for (int piece = 1; piece < PIECES; piece++)
            if (cells_of[piece] * (k + 1) - given[piece] * total > cells_of[best] * (k + 1) - given[best] * total)
                best = piece;
        given[best]++;
        piece_of[k] = (uint8_t)best;
    }
}

#endif

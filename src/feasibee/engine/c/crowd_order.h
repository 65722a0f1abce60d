/* Robots in cells, and in the order of the cells. */

#ifndef CROWD_ORDER_H
#define CROWD_ORDER_H

#include "crowd_state.h"

/* Move robots, and find their cells and places: several at once, so apart from what counts them. */
ALWAYS void move_rows(const struct rows *rows, const struct cells *cells, uint32_t *restrict cell_of,
                      uint32_t *restrict place_of, uint32_t first, uint32_t last)
{
    uint32_t *restrict xs = rows->x, *restrict ys = rows->y;
    const uint32_t *restrict steps_x = rows->step_x, *restrict steps_y = rows->step_y;
    for (uint32_t i = first; i < last; i++) {
        const uint32_t x = xs[i] + steps_x[i], y = ys[i] + steps_y[i];
        xs[i] = x;
        ys[i] = y;
        cell_of[i] = cell_at(cells, x, y);
        place_of[i] = place_at(cells, x, y);
    }
}

/* Move a thread's robots (model.md 3.1), and find their cells: count those in its rows, list the others. */
static void move(struct crowd *s, struct worker *own)
{
    const struct rows rows = s->rows;
    struct cells cells = s->robots;
    uint32_t *cell_of = s->spare, *leaving = s->spare + s->room, *place_of = s->spare + 2 * s->room;
    own->last_row = own + 1 < s->workers + s->team.threads ? own[1].row : cells.side;
    const uint32_t line = cells.side + 1, first_cell = own->row * line;
    const uint32_t cells_of_rows = (own->last_row - own->row) * line;
    uint32_t left = own->first;
    clear_rows(&cells, own->row, own->last_row);
    for (uint32_t chunk = own->first; chunk < own->last; chunk += CHUNK) {
        const uint32_t end = own->last - chunk < CHUNK ? own->last : chunk + CHUNK;
        move_rows(&rows, &cells, cell_of, place_of, chunk, end);
        for (uint32_t i = chunk; i < end; i++)
            if (LIKELY(cell_of[i] - first_cell < cells_of_rows))
                count_point(&cells, cell_of[i]);
            else
                leaving[left++] = i;
    }
    own->leaving = left - own->first;
    own->inside = own->last - left;
    own->points = own->inside + (uint32_t)repeated(&cells, own->row, own->last_row);
}

/* Count the robots in a thread's cells that others have listed as leaving.
 *
 * Return how many places such robots take in the cells of the threads before. */
static uint32_t count_arriving(struct crowd *s, struct worker *own, uint32_t first_cell, uint32_t last_cell)
{
    const uint32_t *cell_of = s->spare, *leaving = s->spare + s->room, line = s->robots.side + 1;
    uint32_t before = 0;
    for (int64_t thread = 0; thread < s->team.threads; thread++) {
        const struct worker *other = &s->workers[thread];
        for (uint32_t k = other->first; k < other->first + other->leaving; k++) {
            const uint32_t cell = cell_of[leaving[k]];
            if (cell < first_cell)
                before += s->robots.side > 1 && cell % line == 0 ? 2 : 1;
            else if (cell < last_cell) {
                count_point(&s->robots, cell);
                own->inside++;
            }
        }
    }
    return before;
}

ALWAYS void place_robot(struct cells *cells, const struct rows *rows, uint32_t cell, uint32_t place,
                        uint32_t i)
{
    const int32_t at = append(cells, cell, place, i);
    cells->labels[at] = rows->labels[i];
}

/* Sort the robots in a thread's rows into their cells. */
static void fill_cells(struct crowd *s, struct worker *own)
{
    const uint32_t *cell_of = s->spare, *leaving = s->spare + s->room, *place_of = s->spare + 2 * s->room;
    const uint32_t line = s->robots.side + 1;
    const uint32_t first_cell = own->row * line, last_cell = own->last_row * line;
    const struct rows rows = s->rows;
    struct cells cells = s->robots;
    uint32_t begin = count_arriving(s, own, first_cell, last_cell);
    for (const struct worker *other = s->workers; other < own; other++)
        begin += other->points;
    sum_up(&cells, own->row, own->last_row, (int32_t)begin);
    for (uint32_t i = own->first; i < own->last; i++)
        if (LIKELY(cell_of[i] - first_cell < last_cell - first_cell))
            place_robot(&cells, &rows, cell_of[i], place_of[i], i);
    for (int64_t thread = 0; thread < s->team.threads; thread++) {
        const struct worker *other = &s->workers[thread];
        for (uint32_t k = other->first; k < other->first + other->leaving; k++)
            if (cell_of[leaving[k]] - first_cell < last_cell - first_cell)
                place_robot(&cells, &rows, cell_of[leaving[k]], place_of[leaving[k]], leaving[k]);
    }
    repeat_columns(&cells, own->row, own->last_row, (int32_t)begin);
}

/* Number the robots anew by the order of the cells, and store where each was. */
static void number_by_cells(struct crowd *s, const struct worker *own)
{
    const struct cells cells = s->robots;
    uint32_t next = 0;
    for (const struct worker *other = s->workers; other < own; other++)
        next += other->inside;
    for (uint32_t row = own->row; row < own->last_row; row++) {
        const int32_t *line = cells.start + row * (cells.side + 1);
        for (int32_t k = line[0]; k < line[cells.side]; k++) {
            s->order[next] = cells.numbers[k];
            cells.numbers[k] = next++;
        }
        for (int32_t k = 0; k < line[cells.side + 1] - line[cells.side]; k++)
            cells.numbers[line[cells.side] + k] = cells.numbers[line[0] + k];
    }
}

/* Derive from the blocks where each thing is. */
static void find_rows(struct crowd *s)
{
    uint32_t *rows = s->blocks[STATE];
    const size_t room = s->room;
    s->lines = (union line *)(void *)s->blocks[LINES];
    s->values = s->blocks[VALUES];
    s->rows = (struct rows){rows,
                            rows + room,
                            rows + 2 * room,
                            rows + 3 * room,
                            rows + 4 * room,
                            rows + 5 * room,
                            rows + 6 * room,
                            rows + 7 * room};
    s->tallies = (struct tally *)(void *)s->blocks[COUNTS];
    s->own = (struct own *)(void *)(s->tallies + room);
    s->robots.x = s->rows.x;
    s->robots.y = s->rows.y;
}

static void gather_lines(struct crowd *s, const union line *lines, uint32_t first, uint32_t last)
{
    union line *gathered = (union line *)(void *)s->spare;
    for (uint32_t i = first; i < last; i++)
        gathered[i] = lines[s->order[i]];
}

static void gather_rows(struct crowd *s, uint32_t first, uint32_t last)
{
    for (size_t row = 0; row < ROWS; row++) {
        const uint32_t *restrict from = s->blocks[STATE] + row * s->room, *restrict order = s->order;
        uint32_t *restrict to = s->spare + row * s->room;
        for (uint32_t i = first; i < last; i++)
            to[i] = from[order[i]];
    }
}

static void gather_counts(struct crowd *s, struct worker *own, uint32_t first, uint32_t last)
{
    struct tally *tallies = (struct tally *)(void *)s->spare;
    struct own *others = (struct own *)(void *)(tallies + s->room);
    for (uint32_t i = first; i < last; i++) {
        const struct tally tally = s->tallies[s->order[i]];
        own->counted |= tally.robots | tally.tasks | tally.votes | tally.feasible_votes;
        tallies[i] = tally;
        others[i] = s->own[s->order[i]];
    }
}

/* Gather a thread's part of a block into the spare one, which then takes its place, and the block that of the
 * spare one. Return false if the run is cancelled meanwhile. */
static bool sort_block(const struct job *job, struct crowd *s, struct worker *own, enum block_kind kind)
{
    for (uint32_t first = own->first; first < own->last && !is_cancelled(job->control); first += CHUNK) {
        const uint32_t last = own->last - first < CHUNK ? own->last : first + CHUNK;
        if (kind == STATE)
            gather_rows(s, first, last);
        else if (kind == COUNTS)
            gather_counts(s, own, first, last);
        else
            gather_lines(s, (const union line *)(const void *)s->blocks[kind], first, last);
    }
    if (comes_last(&s->team)) {
        uint32_t *sorted = s->spare;
        s->spare = s->blocks[kind];
        s->blocks[kind] = sorted;
        find_rows(s);
        s->cancelled = is_cancelled(job->control);
        let_go(&s->team);
    }
    return !s->cancelled;
}

/* Put the robots in the order of the cells; return false if the run is cancelled meanwhile. */
static bool sort_in_space(const struct job *job, struct crowd *s, struct worker *own)
{
    number_by_cells(s, own);
    bool goes = goes_on(job, s) && sort_block(job, s, own, STATE);
    own->counted = 0;
    if (goes && own > s->workers)
        own->row = column_of(&s->robots, s->rows.y[own->first]);
    if (s->lines)
        goes = goes && sort_block(job, s, own, LINES);
    if (s->values)
        goes = goes && sort_block(job, s, own, VALUES);
    return goes && sort_block(job, s, own, COUNTS);
}

/* Carry large counts of a thread's robots to numbers of 64 bits. */
APART void carry(struct crowd *s, struct worker *own)
{
    for (uint32_t i = own->first; i < own->last; i++) {
        struct tally *tally = &s->tallies[i];
        struct counts *carried = &s->carried[s->rows.labels[i] >> NUMBER_BITS];
        if ((tally->robots | tally->tasks | tally->votes | tally->feasible_votes) < ENOUGH)
            continue;
        *carried = counts_of(s, i);
        s->rows.labels[i] |= CARRIED;
        *tally = (struct tally){.votes = tally->votes, .feasible_votes = tally->feasible_votes};
        if (s->lines) /* they have these votes, of which no robot has more than others there are */
            carried->votes = carried->feasible_votes = 0;
        else
            tally->votes = tally->feasible_votes = 0;
    }
    own->counted = 0;
}

#endif

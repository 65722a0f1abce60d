/* The paper's world with more than 128 robots (model.md 1 to 4): sorted in space, sight and radio through cells.
 *
 * Robots that meet should lie close together in memory. So what is stored of each robot is sorted by cells, in rows;
 * between two sorts robots move only a few cells. Place i of a row then holds another robot than number i, and its
 * label has its number. Draws are coordinates of that number, so the order changes no result.
 *
 * Each thread has some of the robots, and sorts the points of some rows of cells: those of its own robots that are in
 * these rows, and those that others have listed as leaving. What a robot is and says stands in the cells, too. So
 * threads wait for each other three times a step, and five times more where they sort the robots. */

#include "crowd.h"

#include <stdlib.h>

#include "cells.h"
#include "draws.h"
#include "failures.h"
#include "inbox.h"
#include "team.h"

#define INTERVAL 8  /* steps between two sorts */
#define CHUNK BATCH /* robots for which a thread does a whole step, while what is stored of them is in its cache */
#define QUEUE 1024  /* messages that wait until they are received */
#define PADDING 64  /* numbers that vectors may read, or write, behind the last one */
#define ENOUGH 0x80000000u /* what a count of 32 bits reaches before it is carried to one of 64 */

/* A label has the number of a robot above these bits. From SAYS_FEASIBLE on it is the robot's message. */
enum label { SPEAKS = 1, DISSEMINATES = 2, HOLDS_FEASIBLE = 4, NEUTRAL = 8, JOINS = 16, CARRIED = 32, SAYS_FEASIBLE = 128 };
#define NUMBER_BITS 8
#define MESSAGE_BITS 7

/* What a robot has seen in its exploration, and has heard since its last decision. */
struct tally {
    uint32_t robots, tasks, votes, feasible_votes;
};

struct counts {
    int64_t robots, tasks, votes, feasible_votes;
};

/* What a robot needs where a phase ends only. */
struct own {
    double quality;  /* of feasible, by the last exploration */
    uint32_t phases; /* phases drawn */
};

/* Rows of 32 bits by place: what is sorted in space. */
struct rows {
    uint32_t *x, *y, *step_x, *step_y, *turns_at, *ends_at; /* steps at which heading and phase end */
    uint32_t *labels, *walks;                               /* headings drawn */
};

#define ROWS (sizeof(struct rows) / sizeof(uint32_t *))

/* What is sorted in space, in blocks of 32 bytes a robot: rows, counts, and the lines of inboxes if there are any. */
enum block_kind { STATE, COUNTS, LINES, VALUES, BLOCKS };

/* What a thread has, and what it tells the others. */
struct worker {
    uint32_t first, last;      /* its robots: the last excluded */
    uint32_t row, last_row;    /* of cells that it sorts, likewise */
    uint32_t leaving;          /* its robots that other threads sort */
    uint32_t inside, points;   /* robots in its rows, and places that its own robots and those repeated take there */
    int64_t feasible, neutral, speaking; /* robots: the sums over all threads count, since robots change threads */
    int64_t said;
    uint32_t counted; /* all bits of its robots' counts at the last sort */
    bool ends, lacks_memory;
    struct failure failure;
    struct tables tables;
    bool in_step; /* whether the others wait for it at the end of a step */
    struct source walk, phase;
    uint32_t queued, receivers[QUEUE + PADDING], messages[QUEUE + PADDING];
    uint32_t turning[CHUNK], exploring[CHUNK], deciding[CHUNK]; /* robots of a chunk whose heading or phase ends */
    struct blocks blocks; /* of its present chunk of robots */
    char apart[CACHE_LINE];
};

struct crowd {
    struct params params;
    struct job job; /* without outcome and control, which are those of a run */
    struct team team;
    uint32_t count;
    size_t room; /* of a row */
    uint32_t *blocks[BLOCKS], *spare;
    struct rows rows;  /* what lies in the blocks, from here on */
    union line *lines; /* NULL if every message counts */
    uint32_t *values;  /* in lines, as their messages; NULL if messages have none */
    struct tally *tallies;
    struct own *own;
    uint32_t *sent;         /* values in messages, by the number of a robot: that of a sender is read at its messages */
    double *memory;         /* of the strategy, by number as well, since it may have any length */
    struct counts *carried; /* by number: what tallies have no room for; NULL if that can't be */
    uint32_t *order, *task_x, *task_y;
    struct cells robots, tasks;
    struct reach sight, radio, tasks_in_sight;
    int64_t now, speaking, spoken, feasible, neutral;
    struct verdict verdict;
    bool ended, cancelled;
    int64_t result;
    struct worker workers[];
};
/* Wait for all threads; return whether the run goes on, the same to all of them: if not, it is cancelled. */
static bool goes_on(const struct job *job, struct crowd *s)
{
    if (comes_last(&s->team)) {
        s->cancelled = is_cancelled(job->control);
        let_go(&s->team);
    }
    return !s->cancelled;
}

/* --- A run begins (model.md 1.2, 1.3, 2.1, 4.1) --- */

ALWAYS struct source source_of(const struct params *params, int64_t run, uint32_t purpose)
{
    return (struct source){params->seed.low, params->seed.high, (uint32_t)run, purpose};
}

/* Draw the next heading of listed robots. */
APART void turn(struct crowd *s, const struct worker *own, const uint32_t *listed, uint32_t count, uint32_t now)
{
    const double reach = s->params.robots.reach, mean = s->params.walk.mean_run;
    const struct rows rows = s->rows;
    for (uint32_t k = 0; k < count; k += PAIRS) {
        const uint32_t most = count - k < PAIRS ? count - k : PAIRS;
        u64 counter = {0}, number = {0};
        for (uint32_t q = 0; q < most; q++) {
            const uint32_t i = listed[k + q];
            counter[q] = rows.walks[i]++;
            number[q] = rows.labels[i] >> NUMBER_BITS;
        }
        const struct headings drawn = draw_headings(own->walk, counter, number, reach, mean);
        for (uint32_t q = 0; q < most; q++) {
            const uint32_t i = listed[k + q];
            rows.step_x[i] = (uint32_t)drawn.x[q];
            rows.step_y[i] = (uint32_t)drawn.y[q];
            rows.turns_at[i] =
                now + (RARELY(drawn.doubtful[q]) ? (uint32_t)duration((uint32_t)drawn.word[q], mean) : (uint32_t)drawn.lasts[q]);
        }
    }
}

/* The draws of a phase in each lane: see `fill_phases`. */
struct phases {
    f64 length;
    u64 word, chance, tie;
};

/* Draw the next phase of up to PAIRS listed robots. */
ALWAYS struct phases draw_phases(struct crowd *s, const struct worker *own, const uint32_t *listed, uint32_t count)
{
    u64 counter = {0}, number = {0};
    for (uint32_t q = 0; q < count; q++) {
        number[q] = s->rows.labels[listed[q]] >> NUMBER_BITS;
        counter[q] = s->own[listed[q]].phases++;
    }
    const struct many drawn = philox_many(own->phase, counter, number);
    return (struct phases){exponentials(drawn.word[0]), drawn.word[0], drawn.word[1], drawn.word[2]};
}

ALWAYS uint32_t phase_lasts(const struct phases *drawn, uint32_t q, double mean)
{
    return (uint32_t)lasting(drawn->length[q], (uint32_t)drawn->word[q], mean);
}

static void begin_robot(struct crowd *s, struct worker *own, int64_t run, uint32_t i)
{
    const struct params *params = &s->params;
    const struct words place = philox(source_of(params, run, PLACE_ROBOT), 0, i);
    const uint32_t coin = philox(source_of(params, run, FIRST_OPINION), 0, i).word[0] >> 31;
    const bool neutral = params->strategy.starts_neutral, feasible = coin && !neutral;
    s->rows.x[i] = place.word[0];
    s->rows.y[i] = place.word[1];
    s->rows.labels[i] = i << NUMBER_BITS | (feasible ? HOLDS_FEASIBLE : 0) | (neutral ? NEUTRAL : 0) |
                        (params->decision.first_sight ? JOINS : 0);
    s->rows.walks[i] = 0;
    s->tallies[i] = (struct tally){0};
    s->own[i] = (struct own){.quality = 0.5};
    own->feasible += feasible;
    own->neutral += neutral;
}

/* Place a thread's share of the tasks. */
static void place_tasks(const struct job *job, struct crowd *s, const struct worker *own, int64_t run)
{
    const struct source from = source_of(&s->params, run, PLACE_TASK);
    const int64_t threads = s->team.threads, thread = own - s->workers, tasks = s->params.tasks.count;
    const uint32_t first = (uint32_t)(tasks * thread / threads), last = (uint32_t)(tasks * (thread + 1) / threads);
    for (uint32_t task = first; task < last && !(task % CHUNK == 0 && is_cancelled(job->control)); task++) {
        const struct words drawn = philox(from, 0, task);
        s->task_x[task] = drawn.word[0];
        s->task_y[task] = drawn.word[1];
    }
}

/* Sort the tasks into their cells, unless the run is cancelled, which then ends. */
static void sort_tasks(const struct job *job, struct crowd *s)
{
    struct cells cells = s->tasks;
    const uint32_t tasks = (uint32_t)s->params.tasks.count;
    clear_rows(&cells, 0, cells.side);
    for (uint32_t task = 0; task < tasks && !(task % CHUNK == 0 && is_cancelled(job->control)); task++)
        count_point(&cells, cell_at(&cells, s->task_x[task], s->task_y[task]));
    if (is_cancelled(job->control))
        return;
    sum_up(&cells, 0, cells.side, 0);
    for (uint32_t task = 0; task < tasks && !(task % CHUNK == 0 && is_cancelled(job->control)); task++) {
        const uint32_t x = s->task_x[task], y = s->task_y[task];
        append(&cells, cell_at(&cells, x, y), place_at(&cells, x, y), task);
    }
    if (!is_cancelled(job->control))
        repeat_columns(&cells, 0, cells.side, 0);
}

/* Put a thread's robots at the start of a run. */
static void begin(const struct job *job, struct crowd *s, struct worker *own, int64_t run)
{
    const int64_t threads = s->team.threads, thread = own - s->workers;
    clear_arena(&own->tables);
    own->queued = own->counted = 0;
    own->row = (uint32_t)(s->robots.side * thread / threads);
    own->walk = source_of(&s->params, run, WALK);
    own->phase = source_of(&s->params, run, PHASE);
    own->feasible = own->neutral = own->speaking = own->said = 0;
    own->ends = own->lacks_memory = false;
    for (uint32_t chunk = own->first; chunk < own->last && !is_cancelled(job->control); chunk += CHUNK) {
        uint32_t count = own->last - chunk < CHUNK ? own->last - chunk : CHUNK;
        for (uint32_t k = 0; k < count; k++) {
            own->turning[k] = chunk + k;
            begin_robot(s, own, run, chunk + k);
        }
        turn(s, own, own->turning, count, 0);
        for (uint32_t k = 0; k < count; k += PAIRS) {
            const uint32_t most = count - k < PAIRS ? count - k : PAIRS;
            const struct phases drawn = draw_phases(s, own, own->turning + k, most);
            for (uint32_t q = 0; q < most; q++)
                s->rows.ends_at[chunk + k + q] = phase_lasts(&drawn, q, s->params.decision.exploration);
        }
    }
    if (s->memory)
        memset(s->memory + own->first * s->job.memory, 0, sizeof *s->memory * (own->last - own->first) * (size_t)s->job.memory);
    place_tasks(job, s, own, run);
    if (comes_last(&s->team)) {
        sort_tasks(job, s);
        s->now = s->speaking = s->spoken = 0;
        s->verdict = (struct verdict){UNDECIDED, -1};
        let_go(&s->team);
    }
}

/* --- Cells --- */

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

/* Move a thread's robots (model.md 3.1), and find their cells; count those in its rows, and list the others. */
static void move(struct crowd *s, struct worker *own)
{
    const struct rows rows = s->rows;
    struct cells cells = s->robots;
    uint32_t *cell_of = s->spare, *leaving = s->spare + s->room, *place_of = s->spare + 2 * s->room;
    own->last_row = own + 1 < s->workers + s->team.threads ? own[1].row : cells.side;
    const uint32_t first_cell = own->row * (cells.side + 1), cells_of_rows = (own->last_row - own->row) * (cells.side + 1);
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

ALWAYS void place_robot(struct cells *cells, const struct rows *rows, uint32_t cell, uint32_t place, uint32_t i)
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

/* --- Counts --- */

/* Return a robot's counts, with what has been carried. */
ALWAYS struct counts counts_of(const struct crowd *s, uint32_t i)
{
    const struct tally tally = s->tallies[i];
    struct counts counts = {tally.robots, tally.tasks, tally.votes, tally.feasible_votes};
    if (RARELY(s->rows.labels[i] & CARRIED)) {
        const struct counts carried = s->carried[s->rows.labels[i] >> NUMBER_BITS];
        counts = (struct counts){counts.robots + carried.robots, counts.tasks + carried.tasks,
                                 counts.votes + carried.votes, counts.feasible_votes + carried.feasible_votes};
    }
    return counts;
}

/* --- Order in space --- */

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
    s->rows = (struct rows){rows, rows + room, rows + 2 * room, rows + 3 * room,
                            rows + 4 * room, rows + 5 * room, rows + 6 * room, rows + 7 * room};
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

/* Gather a thread's part of a block into the spare one, which then takes its place, and the block that of the spare
 * one. Return false if the run is cancelled meanwhile. */
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

/* Carry large counts of a thread's robots to numbers of 64 bits: the next sort after that they may be too large. */
APART void carry(struct crowd *s, struct worker *own)
{
    for (uint32_t i = own->first; i < own->last; i++) {
        struct tally *tally = &s->tallies[i];
        if ((tally->robots | tally->tasks | tally->votes | tally->feasible_votes) < ENOUGH)
            continue;
        s->carried[s->rows.labels[i] >> NUMBER_BITS] = counts_of(s, i);
        s->rows.labels[i] |= CARRIED;
        *tally = (struct tally){0};
    }
    own->counted = 0;
}

/* --- Sight and radio (model.md 4.2, 4.5) --- */

/* What a thread looks for, and where: copies, which no store can change. */
struct lens {
    struct cells cells;
    struct rows rows;
    struct reach sight, radio;
};

/* Points that a robot sees, those whose messages it hears, and those of them that are for feasible. */
struct found {
    uint32_t seen, heard, said;
};

/* What a vector of points is for a robot, whether or not they belong to its block. */
struct looked {
    uint32_t seen, close, loud, said;
    u32 doubtful;
};

ALWAYS struct lens lens_of(const struct crowd *s) { return (struct lens){s->robots, s->rows, s->sight, s->radio}; }

ALWAYS struct looked look_at(const struct lens *lens, int32_t first, u32 here, u32 itself, const bool as_sight,
                             const bool every)
{
    const u32 square = squared(subtract_halves(vector_at(lens->cells.places + first), here));
    const u32 labels = vector_at(lens->cells.labels + first), beyond = square - lens->sight.band.low;
    struct looked looked = {.seen = signs_apart(beyond), .doubtful = (u32)(beyond < lens->sight.band.width)};
    looked.close = looked.seen;
    if (!as_sight) {
        const u32 far = square - lens->radio.band.low;
        looked.close = signs_apart(far);
        looked.doubtful |= (u32)(far < lens->radio.band.width);
    }
    looked.loud = signs_apart(labels << 31 & ~(u32)(labels == itself));
    looked.said = every ? signs_apart(labels << (31 - MESSAGE_BITS)) : 0;
    return looked;
}

/* Find the points of a group from `first` on, exactly where places leave them in doubt. */
ALWAYS struct found find(const struct lens *lens, int32_t first, int32_t last, uint32_t i, const bool as_sight,
                         const bool every)
{
    const uint32_t x = lens->rows.x[i], y = lens->rows.y[i], valid = first_bits(last - first);
    const u32 here = spread(place_at(&lens->cells, x, y)), itself = spread(lens->rows.labels[i]);
    uint32_t seen = 0, close = 0, loud = 0, said = 0, doubtful = 0;
    UNROLL for (int k = 0; k < VECTORS; k++) {
        const struct looked looked = look_at(lens, first + k * LANES, here, itself, as_sight, every);
        seen |= looked.seen << k * LANES;
        close |= looked.close << k * LANES;
        loud |= looked.loud << k * LANES;
        said |= looked.said << k * LANES;
        doubtful |= signs(looked.doubtful) << k * LANES;
    }
    if (RARELY((doubtful & valid) != 0)) {
        seen = near_exactly(&lens->cells, lens->sight.limit, first, last, x, y);
        close = as_sight ? seen : near_exactly(&lens->cells, lens->radio.limit, first, last, x, y);
    }
    const uint32_t heard = close & loud & valid;
    return (struct found){seen & valid, heard, heard & said};
}

APART struct found find_doubtful(const struct crowd *s, struct block block, uint32_t i, bool as_sight)
{
    const struct lens lens = lens_of(s);
    const struct found one = find(&lens, block.one.first, block.one.last, i, as_sight, true);
    const struct found other = find(&lens, block.other.first, block.other.last, i, as_sight, true);
    return (struct found){one.seen | other.seen << GROUP, one.heard | other.heard << GROUP,
                          one.said | other.said << GROUP};
}

/* Find the points of a block whose stretches are no longer than a group. */
ALWAYS struct found find_both(const struct crowd *s, const struct lens *lens, struct block block, uint32_t place,
                              uint32_t i, const bool as_sight, const bool every)
{
    const u32 here = spread(place), itself = spread(lens->rows.labels[i]);
    const uint32_t valid = bits_up_to(length_of(block.one)) | bits_up_to(length_of(block.other)) << GROUP;
    uint32_t seen = 0, close = 0, loud = 0, said = 0;
    u32 doubtful = {0};
    UNROLL for (int k = 0; k < 2 * VECTORS; k++) {
        const int32_t first = k < VECTORS ? block.one.first + k * LANES : block.other.first + (k - VECTORS) * LANES;
        const struct looked looked = look_at(lens, first, here, itself, as_sight, every);
        seen |= looked.seen << k * LANES;
        close |= looked.close << k * LANES;
        loud |= looked.loud << k * LANES;
        said |= looked.said << k * LANES;
        doubtful |= looked.doubtful;
    }
    if (RARELY(signs(doubtful) != 0))
        return find_doubtful(s, block, i, as_sight);
    const uint32_t heard = close & loud & valid;
    return (struct found){seen & valid, heard, heard & said};
}

/* Keep a message that doesn't fit in the line of an inbox. */
APART void keep_in_table(struct crowd *s, struct worker *own, uint32_t i, uint32_t message, uint32_t value)
{
    struct tally *tally = &s->tallies[i];
    const uint32_t *values = s->values ? s->values + (size_t)LINE * i : NULL;
    struct table *table = table_of(&own->tables, &s->lines[i], values, tally->votes);
    if (!table) {
        own->lacks_memory = true;
        return;
    }
    const uint32_t slot = slot_of(table, message), known = table->messages[slot];
    tally->feasible_votes += (message & 1) - (known == NOBODY ? 0 : known & 1);
    tally->votes += known == NOBODY;
    table->messages[slot] = message;
    if (own->tables.values)
        table->messages[table->slots + slot] = value;
}

/* Let robots receive the queued messages. */
ALWAYS void receive(struct crowd *s, struct worker *own, const bool values)
{
    for (uint32_t q = 0; q < own->queued; q++) {
        const uint32_t i = own->receivers[q], message = own->messages[q];
        const uint32_t value = values ? s->sent[sender_of(message)] : 0;
        struct tally *tally = &s->tallies[i];
        uint32_t *line = s->lines[i].messages, same = 0;
        UNROLL for (int k = 0; k < VECTORS; k++)
            same |= equal(vector_at(line + k * LANES) | 1, spread(message | 1)) << k * LANES;
        same &= first_bits((int)tally->votes);
        if (RARELY(tally->votes >= LINE + (same != 0))) {
            keep_in_table(s, own, i, message, value);
            continue;
        }
        const uint32_t k = same ? (uint32_t)lowest(same) : tally->votes;
        tally->feasible_votes += (message & 1) - (same ? line[k] & 1 : 0);
        tally->votes += same == 0;
        line[k] = message;
        if (values)
            s->values[(size_t)LINE * i + k] = value;
    }
    own->queued = 0;
}

APART void receive_messages(struct crowd *s, struct worker *own) { receive(s, own, false); }
APART void receive_values(struct crowd *s, struct worker *own) { receive(s, own, true); }

static void receive_queued(struct crowd *s, struct worker *own)
{
    if (s->values)
        receive_values(s, own);
    else
        receive_messages(s, own);
}

/* Queue the messages that a robot hears from the points of a group, or count them. */
ALWAYS void hear(struct crowd *s, struct worker *own, const struct lens *lens, uint32_t i, int32_t first,
                 struct found found)
{
    if (s->params.decision.every_message) {
        s->tallies[i].votes += (uint32_t)members(found.heard);
        s->tallies[i].feasible_votes += (uint32_t)members(found.said);
        return;
    }
    for (uint32_t left = found.heard; left; left &= left - 1) {
        own->receivers[own->queued] = i;
        own->messages[own->queued++] = lens->cells.labels[first + lowest(left)] >> MESSAGE_BITS;
    }
    if (own->queued > QUEUE)
        receive_queued(s, own);
}

/* Look and listen in one stretch of a robot's block, whatever its length; return how many robots are in sight. */
APART uint32_t look_along(struct crowd *s, struct worker *own, struct stretch stretch, uint32_t i, bool listens,
                          bool as_sight)
{
    const struct lens lens = lens_of(s);
    uint32_t seen = 0;
    for (int32_t first = stretch.first; first < stretch.last; first += GROUP) {
        const struct found found = find(&lens, first, stretch.last, i, as_sight, true);
        seen += (uint32_t)members(found.seen);
        if (listens)
            hear(s, own, &lens, i, first, found);
    }
    return seen;
}

/* Return the message at a bit of both groups of a block. */
ALWAYS uint32_t message_at(const struct lens *lens, struct block block, int k)
{
    const int32_t across = (block.other.first - GROUP - block.one.first) & -(k / GROUP);
    return lens->cells.labels[block.one.first + k + across] >> MESSAGE_BITS;
}

/* Queue the messages that a robot hears from a block; return how many are queued.
 *
 * The first is queued without a branch, since most robots hear none or one. */
ALWAYS uint32_t queue(struct worker *own, uint32_t queued, const struct lens *lens, struct block block, uint32_t i,
                      uint32_t heard)
{
    own->receivers[queued] = i;
    own->messages[queued] = message_at(lens, block, lowest(heard | bit(2 * GROUP - 1)));
    queued += heard != 0;
    for (heard &= heard - 1; RARELY(heard != 0); heard &= heard - 1) {
        own->receivers[queued] = i;
        own->messages[queued++] = message_at(lens, block, lowest(heard));
    }
    return queued;
}

/* Let robots from `first` on look for robots and listen. Masks take the place of branches, which half of the robots
 * would take. */
ALWAYS void look(const struct job *job, struct crowd *s, struct worker *own, uint32_t first, uint32_t last,
                 const bool as_sight, const bool every)
{
    const struct lens lens = lens_of(s);
    struct tally *tallies = s->tallies;
    const uint32_t always = s->params.decision.listens_for < 0 ? UINT32_MAX : 0;
    const uint32_t but = 1 - (uint32_t)s->params.sensing.count_self;
    uint32_t queued = 0;
    find_blocks(&lens.cells, &own->blocks, lens.rows.x + first, lens.rows.y + first, last - first);
    for (uint32_t i = first; i < last; i++) {
        const uint32_t disseminates = -(lens.rows.labels[i] / DISSEMINATES & 1), listens = always | disseminates;
        const struct block block = block_of(&lens.cells, &own->blocks, i - first);
        uint32_t seen;
        if (RARELY(is_long(block.one) || is_long(block.other))) {
            if (is_cancelled(job->control))
                break;
            own->queued = queued;
            seen = look_along(s, own, block.one, i, listens, as_sight);
            seen += look_along(s, own, block.other, i, listens, as_sight);
            queued = own->queued;
        } else {
            const struct found found = find_both(s, &lens, block, own->blocks.places[i - first], i, as_sight, every);
            seen = (uint32_t)members(found.seen);
            if (every) {
                tallies[i].votes += (uint32_t)members(found.heard & listens);
                tallies[i].feasible_votes += (uint32_t)members(found.said & listens);
            } else
                queued = queue(own, queued, &lens, block, i, found.heard & listens);
        }
        tallies[i].robots += (seen - but) & ~disseminates;
        if (RARELY(queued > QUEUE)) {
            own->queued = queued;
            receive_queued(s, own);
            queued = 0;
        }
    }
    own->queued = queued;
}

#define LOOK(name, as_sight, every)                                                                              \
    APART void look_##name(const struct job *job, struct crowd *s, struct worker *own, uint32_t first, uint32_t last) \
    { look(job, s, own, first, last, as_sight, every); }
LOOK(latest, true, false)
LOOK(every, true, true)
LOOK(latest_apart, false, false)
LOOK(every_apart, false, true)

static void look_around(const struct job *job, struct crowd *s, struct worker *own, uint32_t first, uint32_t last)
{
    const bool every = s->params.decision.every_message;
    if (s->sight.limit == s->radio.limit)
        (every ? look_every : look_latest)(job, s, own, first, last);
    else
        (every ? look_every_apart : look_latest_apart)(job, s, own, first, last);
    receive_queued(s, own);
}

/* Count the tasks in sight of those robots of a chunk that explore. */
APART void count_tasks(struct crowd *s, struct worker *own, uint32_t first, uint32_t last)
{
    const struct cells cells = s->tasks;
    const struct reach reach = s->tasks_in_sight;
    const struct rows rows = s->rows;
    uint32_t listed[CHUNK + 1], count = 0;
    for (uint32_t i = first; i < last; i++) { /* without branches, which half of the robots would take */
        listed[count] = i;
        count += !(rows.labels[i] & DISSEMINATES);
    }
    find_blocks(&cells, &own->blocks, rows.x + first, rows.y + first, last - first);
    for (uint32_t k = 0; k < count; k++) {
        const uint32_t i = listed[k], place = own->blocks.places[i - first];
        const struct block block = block_of(&cells, &own->blocks, i - first);
        s->tallies[i].tasks += count_near(&cells, reach, block, place, rows.x[i], rows.y[i]);
    }
}

/* --- Phases end (model.md 4.3 to 4.6) --- */

ALWAYS int opinion_of(uint32_t label) { return label & NEUTRAL ? NO_OPINION : label & HOLDS_FEASIBLE ? FEASIBLE : INFEASIBLE; }

/* Return a robot's label with another opinion. */
ALWAYS uint32_t with_opinion(struct worker *own, uint32_t label, int64_t opinion)
{
    const bool feasible = opinion == FEASIBLE, neutral = opinion != FEASIBLE && opinion != INFEASIBLE;
    own->feasible += feasible - ((label & HOLDS_FEASIBLE) != 0);
    own->neutral += neutral - ((label & NEUTRAL) != 0);
    return (label & ~(uint32_t)(HOLDS_FEASIBLE | NEUTRAL)) | (feasible ? HOLDS_FEASIBLE : 0) | (neutral ? NEUTRAL : 0);
}

ALWAYS struct mind mind_in(const struct job *job, const struct crowd *s, uint32_t i, uint32_t label)
{
    const uint32_t number = label >> NUMBER_BITS;
    return mind_of(job, opinion_of(label), s->own[i].quality, s->memory + number * (size_t)job->memory);
}

/* Return after how many steps the robot disseminates no longer. */
ALWAYS uint32_t end_exploration(const struct job *job, struct crowd *s, struct worker *own, uint32_t i,
                                const struct phases *drawn, uint32_t q)
{
    const struct counts counts = counts_of(s, i);
    uint32_t label = s->rows.labels[i];
    struct own *kept = &s->own[i];
    kept->quality = rated(job, counts.robots, counts.tasks);
    if (label & JOINS) { /* a tie keeps its opinion (model.md 6.10) */
        label = kept->quality == 0.5 ? label : with_opinion(own, label, kept->quality > 0.5);
        label &= ~(uint32_t)JOINS;
    }
    struct mind mind = mind_in(job, s, i, label);
    const struct broadcast made = broadcast_of(job, &mind);
    if (s->values)
        s->sent[label >> NUMBER_BITS] = (uint32_t)made.value;
    own->speaking += made.speaks;
    s->rows.labels[i] = label | DISSEMINATES | (made.speaks ? SPEAKS : 0) | (made.says_feasible ? SAYS_FEASIBLE : 0);
    return phase_lasts(drawn, q, made.mean) + (uint32_t)job->params->decision.dissemination_floor;
}

/* Return the number of messages for an opinion, of senders below a number. */
static int64_t count_messages(const uint32_t *messages, uint32_t slots, uint32_t opinion, uint32_t senders)
{
    int64_t found = 0;
    for (uint32_t k = 0; k < slots; k++)
        found += (messages[k] & 1) == opinion && sender_of(messages[k]) < senders;
    return found;
}

/* Read the value of the message drawn, which is the k-th of its opinion by sender, and the mean of all values. */
APART void read_values(const struct job *job, const struct crowd *s, uint32_t i, int64_t drawn, struct inbox *inbox)
{
    const double scale = job->params->strategy.value_scale;
    const int64_t votes = inbox->feasible_votes + inbox->infeasible_votes;
    const bool in_line = votes <= LINE;
    const uint32_t *messages = in_line ? s->lines[i].messages : s->lines[i].table->messages;
    const uint32_t slots = in_line ? (uint32_t)votes : s->lines[i].table->slots;
    const uint32_t *values = in_line ? s->values + (size_t)LINE * i : messages + slots;
    uint32_t low = 0, high = s->count - 1, value = 0;
    uint64_t total = 0;
    if (votes == 0)
        return;
    while (low < high) { /* the least sender up to which more than `drawn` messages have this opinion */
        const uint32_t middle = (low + high) / 2;
        if (count_messages(messages, slots, inbox->heard_opinion == FEASIBLE, middle + 1) > drawn)
            high = middle;
        else
            low = middle + 1;
    }
    for (uint32_t k = 0; k < slots; k++)
        if (messages[k] != NOBODY) {
            total += values[k];
            value = sender_of(messages[k]) == low ? values[k] : value;
        }
    inbox->heard_value = value / scale;
    inbox->mean_value = (double)total / scale / (double)votes;
}

ALWAYS struct inbox read_inbox(const struct job *job, const struct crowd *s, uint32_t i, const struct counts *counts,
                               const struct phases *drawn, uint32_t q)
{
    struct inbox inbox = {
        .feasible_votes = counts->feasible_votes,
        .infeasible_votes = counts->votes - counts->feasible_votes,
        .heard_opinion = NO_OPINION,
        .chance = (double)drawn->chance[q] * (1.0 / 4294967296.0),
    };
    int64_t k = 0;
    if (counts->votes > 0) {
        k = choose((uint32_t)drawn->tie[q], counts->votes);
        inbox.heard_opinion = k < counts->feasible_votes;
        k -= inbox.heard_opinion == FEASIBLE ? 0 : counts->feasible_votes;
    }
    if (s->values)
        read_values(job, s, i, k, &inbox);
    return inbox;
}

/* Empty a robot's inbox, and its counts unless evidence is kept (model.md 4.6). */
ALWAYS void forget(const struct job *job, struct crowd *s, struct worker *own, uint32_t i, const struct counts *counts)
{
    struct tally *tally = &s->tallies[i];
    if (s->lines && counts->votes > LINE)
        give_table(&own->tables, s->lines[i].table);
    tally->votes = tally->feasible_votes = 0;
    if (job->params->strategy.forgets)
        *tally = (struct tally){0};
    if (RARELY(s->rows.labels[i] & CARRIED)) {
        struct counts *carried = &s->carried[s->rows.labels[i] >> NUMBER_BITS];
        carried->votes = carried->feasible_votes = 0;
        if (job->params->strategy.forgets)
            s->rows.labels[i] &= ~(uint32_t)CARRIED;
    }
}

ALWAYS uint32_t end_dissemination(const struct job *job, struct crowd *s, struct worker *own, uint32_t i,
                                  const struct phases *drawn, uint32_t q)
{
    const struct counts counts = counts_of(s, i);
    const struct inbox inbox = read_inbox(job, s, i, &counts, drawn, q);
    struct mind mind = mind_in(job, s, i, s->rows.labels[i]);
    const int64_t decided = job->rules->decide(&mind, &inbox);
    forget(job, s, own, i, &counts);
    const uint32_t label = with_opinion(own, s->rows.labels[i], decided);
    own->speaking -= (label & SPEAKS) != 0;
    s->rows.labels[i] = label & ~(uint32_t)(SPEAKS | SAYS_FEASIBLE | DISSEMINATES);
    return phase_lasts(drawn, q, job->params->decision.exploration);
}

/* End the phase of listed robots, all of which explore, or all of which disseminate. */
ALWAYS void end_phases(const struct job *job, struct crowd *s, struct worker *own, const uint32_t *listed,
                       uint32_t count, uint32_t now, const bool disseminate)
{
    for (uint32_t k = 0; k < count; k += PAIRS) {
        const uint32_t most = count - k < PAIRS ? count - k : PAIRS;
        const struct phases drawn = draw_phases(s, own, listed + k, most);
        for (uint32_t q = 0; q < most; q++) {
            const uint32_t i = listed[k + q];
            s->rows.ends_at[i] = now + (disseminate ? end_dissemination(job, s, own, i, &drawn, q)
                                                    : end_exploration(job, s, own, i, &drawn, q));
        }
    }
}

/* --- A step (model.md 3) --- */

/* List the robots of a word, of which the first has place `first`. */
ALWAYS uint32_t list(uint32_t *listed, uint32_t count, uint32_t word, uint32_t first)
{
    for (; word; word &= word - 1)
        listed[count++] = first + (uint32_t)lowest(word);
    return count;
}

/* Do a step for robots from `first` on, whose cells are filled. */
static void step_chunk(const struct job *job, struct crowd *s, struct worker *own, uint32_t first, uint32_t last,
                       uint32_t now)
{
    const struct rows rows = s->rows;
    uint32_t turning = 0, exploring = 0, deciding = 0;
    look_around(job, s, own, first, last);
    count_tasks(s, own, first, last);
    for (uint32_t i = first; i < last; i += 32) {
        uint32_t turns = 0, ends = 0, disseminate = 0;
        UNROLL for (int k = 0; k < 32; k += LANES) {
            turns |= equal(vector_at(rows.turns_at + i + k), spread(now)) << k;
            ends |= equal(vector_at(rows.ends_at + i + k), spread(now)) << k;
            disseminate |= signs(vector_at(rows.labels + i + k) << 30) << k;
        }
        turns &= first_bits((int)(last - i));
        ends &= first_bits((int)(last - i));
        turning = list(own->turning, turning, turns, i);
        exploring = list(own->exploring, exploring, ends & ~disseminate, i);
        deciding = list(own->deciding, deciding, ends & disseminate, i);
    }
    turn(s, own, own->turning, turning, now);
    end_phases(job, s, own, own->exploring, exploring, now, false);
    end_phases(job, s, own, own->deciding, deciding, now, true);
}

static void step(const struct job *job, struct crowd *s, struct worker *own, uint32_t now)
{
    if (RARELY(own->counted >= ENOUGH) && s->carried)
        carry(s, own); /* before the cells get the labels */
    move(s, own);
    if (!goes_on(job, s))
        return;
    fill_cells(s, own);
    if (!goes_on(job, s) || (now % INTERVAL == 1 && !sort_in_space(job, s, own)))
        return;
    for (uint32_t first = own->first; first < own->last && !is_cancelled(job->control); first += CHUNK)
        step_chunk(job, s, own, first, own->last - first < CHUNK ? own->last : first + CHUNK, now);
}

/* Sum up what the threads have counted, and record it: a step later, or at the start. */
static void record(const struct job *job, struct crowd *s, int64_t row, int64_t steps)
{
    s->now += steps;
    s->spoken += s->speaking * steps;
    s->feasible = s->neutral = s->speaking = 0;
    s->ended = s->now >= s->params.run.steps;
    for (const struct worker *each = s->workers; each < s->workers + s->team.threads; each++) {
        s->feasible += each->feasible;
        s->neutral += each->neutral;
        s->speaking += each->speaking;
        s->ended |= each->ends;
    }
    count_steps(job->control, steps);
    record_step(job, &s->verdict, row, s->now, quorum_of(&s->params), s->feasible, s->count - s->feasible - s->neutral);
    s->ended |= s->params.run.stop_at_decision && s->verdict.decision != UNDECIDED;
}

/* End a step for all threads; return whether there is a next one. */
static bool end_step(const struct job *job, struct crowd *s, struct worker *own, int64_t row, int64_t steps)
{
    own->ends |= own->lacks_memory || is_cancelled(job->control);
    if (comes_last(&s->team)) {
        record(job, s, row, steps);
        let_go(&s->team);
    }
    return !s->ended;
}

/* --- Runs --- */

struct part {
    const struct job *job;
    struct crowd *crowd;
    struct worker *own;
    int64_t run, row;
};

/* Simulate a thread's part of a run. */
static int64_t advance(void *given)
{
    const struct part *part = given;
    const struct job *job = part->job;
    struct crowd *s = part->crowd;
    struct worker *own = part->own;
    begin(job, s, own, part->run);
    own->in_step = true;
    for (bool goes_on = end_step(job, s, own, part->row, 0); goes_on; goes_on = end_step(job, s, own, part->row, 1))
        step(job, s, own, (uint32_t)s->now + 1);
    own->in_step = false;
    if (are_asked(job))
        for (uint32_t i = own->first; i < own->last && !own->ends; i++) {
            struct mind mind = mind_in(job, s, i, s->rows.labels[i]);
            own->said += said_by(job, &mind);
        }
    return 0;
}

/* Let all threads leave a run, and record its end. */
static void end_run(const struct job *job, struct crowd *s, int64_t row)
{
    if (comes_last(&s->team)) {
        s->result = 1;
        int64_t said = 0;
        for (struct worker *each = s->workers; each < s->workers + s->team.threads; each++) {
            said += each->said;
            if (each->failure.what)
                job->control->failure = each->failure;
            s->result = each->lacks_memory || s->result < 0 ? -1 : each->ends ? 0 : s->result;
        }
        record_end(job, &s->verdict, row, s->now, s->feasible, s->count - s->feasible - s->neutral,
                   s->spoken * s->params.radio.message_bits);
        if (are_asked(job))
            job->outcome->account[row * job->outcome->columns + SAID_AT_END] = said;
        let_go(&s->team);
    }
}

int64_t feasibee_crowd_run(struct crowd *crowd, int64_t run, int64_t row, const struct outcome *outcome,
                           struct control *control, int64_t thread)
{
    struct worker *own = &crowd->workers[thread];
    struct job job = crowd->job;
    struct part part = {&job, crowd, own, run, row};
    job.outcome = outcome;
    job.control = control;
    own->failure = (struct failure){0};
    if (attempt(advance, &part, -1, &own->failure) != 0) { /* the others end the run, too */
        own->ends = true;
        if (own->in_step)
            end_step(&job, crowd, own, row, 1);
    }
    end_run(&job, crowd, row);
    return crowd->result;
}

static bool allocate_cells(struct cells *cells, size_t points, bool labelled)
{
    const size_t room = 2 * points + PADDING; /* every point may be in the column that is repeated */
    cells->places = calloc(room, sizeof *cells->places);
    cells->numbers = calloc(room, sizeof *cells->numbers);
    cells->labels = labelled ? calloc(room, sizeof *cells->labels) : NULL;
    cells->start = calloc(starts_of(cells), sizeof *cells->start);
    return cells->places && cells->numbers && cells->start && (cells->labels || !labelled);
}

static void free_cells(const struct cells *cells)
{
    free(cells->places);
    free(cells->numbers);
    free(cells->labels);
    free(cells->start);
}

static bool allocate(struct crowd *s)
{
    const size_t robots = s->count, tasks = (size_t)s->params.tasks.count, most = robots > tasks ? robots : tasks;
    const bool lines = !s->params.decision.every_message, values = s->params.strategy.value_scale > 0.0;
    const bool used[BLOCKS] = {[STATE] = true, [COUNTS] = true, [LINES] = lines, [VALUES] = values};
    const bool carries = most > ENOUGH / (uint64_t)s->params.run.steps;
    bool all = allocate_cells(&s->robots, robots, true) && allocate_cells(&s->tasks, tasks, false);
    for (int k = 0; k < BLOCKS; k++) {
        s->blocks[k] = used[k] ? calloc(s->room, sizeof(union line)) : NULL;
        all = all && (s->blocks[k] || !used[k]);
    }
    s->spare = calloc(s->room, sizeof(union line));
    s->order = calloc(s->room, sizeof *s->order);
    s->memory = calloc(robots * (size_t)s->job.memory + 1, sizeof *s->memory);
    s->task_x = calloc(tasks + 1, sizeof *s->task_x);
    s->task_y = calloc(tasks + 1, sizeof *s->task_y);
    s->carried = carries ? calloc(robots, sizeof *s->carried) : NULL;
    s->sent = values ? calloc(robots, sizeof *s->sent) : NULL;
    all = all && s->spare && s->order && s->memory && s->task_x && s->task_y;
    if (!all || (carries && !s->carried) || (values && !s->sent))
        return false;
    s->tasks.x = s->task_x;
    s->tasks.y = s->task_y;
    find_rows(s);
    return true;
}

struct crowd *feasibee_crowd_new(const struct params *params, const struct rules *rules, const struct setting *setting,
                                 int64_t memory, int64_t threads)
{
    struct crowd *s = calloc(1, sizeof *s + (size_t)threads * sizeof *s->workers);
    if (!s)
        return NULL;
    s->params = *params;
    s->job = (struct job){.params = &s->params, .rules = rules, .setting = setting, .memory = memory};
    s->team.threads = threads;
    s->count = (uint32_t)params->robots.count;
    s->room = (s->count + PADDING) & ~(size_t)(PADDING - 1);
    s->robots = empty_cells(&params->robots.grid);
    s->tasks = empty_cells(&params->tasks.grid);
    s->sight = reach_of(params->sensing.limit, s->robots.shift);
    s->radio = reach_of(params->radio.limit, s->robots.shift);
    s->tasks_in_sight = reach_of(params->sensing.limit, s->tasks.shift);
    for (int64_t thread = 0; thread < threads; thread++) {
        const int64_t words = (s->count + 31) / 32, end = 32 * (words * (thread + 1) / threads);
        s->workers[thread].first = (uint32_t)(32 * (words * thread / threads));
        s->workers[thread].last = end < s->count ? (uint32_t)end : s->count;
        s->workers[thread].tables.values = params->strategy.value_scale > 0.0;
    }
    if (allocate(s))
        return s;
    feasibee_crowd_free(s);
    return NULL;
}

void feasibee_crowd_free(struct crowd *s)
{
    for (int64_t thread = 0; thread < s->team.threads; thread++)
        clear_arena(&s->workers[thread].tables);
    void *rooms[] = {s->spare, s->order, s->memory, s->task_x, s->task_y, s->carried, s->sent};
    for (size_t k = 0; k < sizeof rooms / sizeof *rooms; k++)
        free(rooms[k]);
    for (int k = 0; k < BLOCKS; k++)
        free(s->blocks[k]);
    free_cells(&s->robots);
    free_cells(&s->tasks);
    free(s);
}

int64_t crowd_play(const struct job *job, int64_t first_run)
{
    struct crowd *s = feasibee_crowd_new(job->params, job->rules, job->setting, job->memory, 1);
    int64_t row = 0, complete = 1;
    if (!s)
        return -1;
    while (row < job->outcome->runs && complete == 1) {
        complete = feasibee_crowd_run(s, first_run + row, row, job->outcome, job->control, 0);
        row += complete == 1;
    }
    feasibee_crowd_free(s);
    return complete < 0 ? -1 : row;
}

/* The paper's world with more than 128 robots (model.md 1 to 4): sorted in space, met through cells.
 *
 * Robots that meet should lie close together in memory. So what is stored of each robot is sorted by cells,
 * in rows; between two sorts robots move only a few cells. Place i of a row then holds another robot than
 * number i, and its label has its number. Draws are coordinates of that number: the order changes no result.
 *
 * Each thread has some of the robots, and sorts the points of some rows of cells: those of its own robots
 * that are in these rows, and those that others have listed as leaving. The cells also hold what a robot is
 * and says. So threads wait for each other three times a step, and up to five times more where they sort the
 * robots. */

#include "crowd.h"

#include <stdlib.h>

#include "crowd_order.h"
#include "crowd_phases.h"
#include "crowd_sight.h"
#include "crowd_start.h"
#include "failures.h"

#define INTERVAL 8 /* steps between two sorts */

/* --- A step (model.md 3) --- */

/* List the robots of a word, of which the first has place `first`. */
ALWAYS uint32_t list(uint32_t *listed, uint32_t count, uint32_t word, uint32_t first)
{
    for (; word; word &= word - 1)
        listed[count++] = first + (uint32_t)lowest(word);
    return count;
}

/* Let the processor fetch what listed robots need where a phase ends, since few of them are neighbours. With
 * the fetching of inboxes it saves about a tenth of a step of a million robots. */
ALWAYS void fetch(const struct own *own, const uint32_t *listed, uint32_t count)
{
    for (uint32_t k = 0; k < count; k++)
        __builtin_prefetch(own + listed[k], 1);
}

/* Do a step for robots from `first` on, whose cells are filled. */
static void step_chunk(const struct job *job, struct crowd *s, struct worker *own, uint32_t first,
                       uint32_t last, uint32_t now)
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
    fetch(s->own, own->exploring, exploring);
    fetch(s->own, own->deciding, deciding);
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
    record_step(job, &s->verdict, row, s->now, quorum_of(&s->params), s->feasible,
                s->count - s->feasible - s->neutral);
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
    for (bool goes_on = end_step(job, s, own, part->row, 0); goes_on;
         goes_on = end_step(job, s, own, part->row, 1))
        step(job, s, own, (uint32_t)s->now + 1);
    own->in_step = false;
    if (are_asked(job))
        for (uint32_t i = own->first; i < own->last && !own->ends; i++) {
            struct mind mind = mind_in(job, s, i, s->rows.labels[i]);
            own->said += said_by(job, &mind, (struct known){0});
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
    const size_t robots = s->count, tasks = (size_t)s->params.tasks.count,
                 most = robots > tasks ? robots : tasks;
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

struct crowd *feasibee_crowd_new(const struct params *params, const struct rules *rules,
                                 const struct setting *setting, int64_t memory, int64_t threads)
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

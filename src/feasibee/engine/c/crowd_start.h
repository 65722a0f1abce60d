/* How a crowd begins (model.md 1.2, 1.3, 2.1, 4.1), and the draws of headings and phases. */

#ifndef CROWD_START_H
#define CROWD_START_H

#include "crowd_state.h"

/* Draw the next heading of listed robots. */
APART void turn(struct crowd *s, const struct worker *own, const uint32_t *listed, uint32_t count,
                uint32_t now)
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
            rows.turns_at[i] = now + (RARELY(drawn.doubtful[q])
                                          ? (uint32_t)duration((uint32_t)drawn.word[q], mean)
                                          : (uint32_t)drawn.lasts[q]);
        }
    }
}

/* The draws of a phase in each lane: see `fill_phases`. */
struct phases {
    f64 length;
    u64 word, chance, tie;
};

/* Draw the next phase of up to PAIRS listed robots. */
ALWAYS struct phases draw_phases(struct crowd *s, const struct worker *own, const uint32_t *listed,
                                 uint32_t count)
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
    return (uint32_t)steps_of(drawn->length[q], (uint32_t)drawn->word[q], mean);
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
    const uint32_t first = (uint32_t)(tasks * thread / threads),
                   last = (uint32_t)(tasks * (thread + 1) / threads);
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
        memset(s->memory + own->first * s->job.memory, 0,
               sizeof *s->memory * (own->last - own->first) * (size_t)s->job.memory);
    place_tasks(job, s, own, run);
    if (comes_last(&s->team)) {
        sort_tasks(job, s);
        s->now = s->speaking = s->spoken = 0;
        s->verdict = (struct verdict){UNDECIDED, -1};
        let_go(&s->team);
    }
}

#endif

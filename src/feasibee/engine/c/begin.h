/* How robots begin or stop, and what follows from who is there (model.md 4.1, 4.7, 6.6, 6.24). */

#ifndef BEGIN_H
#define BEGIN_H

#include "knowledge.h"
#include "messages.h"
#include "motion.h"
#include "near.h"
#include "phases.h"
#include "sense.h"

/* Stop the robots of a word with that fault for the rest of the run (model.md 6.6). */
static void stop_word(struct state *s, int64_t w)
{
    const enum set left_by[] = {WORKING, COUNTED, DISSEMINATING, SPEAKING, BLOCKED};
    const uint32_t stopping = s->sets[STOPPING][w];
    for (int k = 0; k < 5; k++)
        s->sets[left_by[k]][w] &= ~stopping;
    for (uint32_t left = stopping; left; left = without_lowest(left)) {
        const int64_t i = lowest_member(w, left);
        stand_still(s, i);
        s->robots[LABEL][i] = label_of(s, i);
        drop_delayed(s, i);
    }
}

/* Give a robot its first opinion and phase. */
static void prepare_robot(struct state *s, int64_t i)
{
    const bool neutral = s->params->strategy.starts_neutral;
    const uint32_t word = draw(s, i, s->robots[JOINED][i], FIRST_OPINION);
    set_opinion(s, i, neutral ? NO_OPINION : coin(word));
    enter_phase(s, i, duration_of(present_phase(s, i), s->params->decision.exploration));
    clear_inbox(s, i);
    clear_counts(s, i);
    s->robots[AGREED][i] = 0;
    s->quality[i] = 0.5; /* until it has rated */
    memset(s->memory + i * s->memory_length, 0, (size_t)s->memory_length * sizeof *s->memory);
}

/* Store over how many robots the decision is taken, and how many of them it needs (model.md 4.7). */
static void set_quorum(struct state *s, int64_t counted)
{
    const struct quorum *quorum = &s->params->decision.quorum;
    s->clock->counted = counted;
    s->clock->quorum = counted * quorum->share / quorum->whole + 1;
}

/* Store how many robots or tasks Byzantine robots invent (model.md 6.12, 6.16). */
static void set_inventions(struct state *s)
{
    const int64_t robots = s->clock->robots, tasks = s->clock->tasks, exactly = s->params->faults.exactly;
    s->clock->invented_robots = tasks - exactly * robots;
    s->clock->invented_tasks = robots + 1 - exactly * tasks;
}

/* Give the tasks that are near a task and have no name yet its name; add them to those that wait. */
static int64_t name_near(struct state *s, int32_t task, int32_t name, int32_t *chain, int64_t waiting)
{
    const struct params *p = s->params;
    const struct grid_cells *cells = &s->task_cells;
    const int32_t *xs = cells->points[POINT_X], *ys = cells->points[POINT_Y];
    const int32_t x = s->tasks[POINT_X][task], y = s->tasks[POINT_Y][task];
    const struct stretches block = block_at(cells, &p->tasks.grid, x, y);
    int64_t first = block.first, last = block.last;
    for (int stretch = 0; stretch < 2; stretch++, first = block.other_first, last = block.other_last)
        for (; first < last; first += WORD) {
            uint32_t close = near_word(p, xs, ys, first, last, x, y, p->sensing.merge_limit);
            for (; close; close = without_lowest(close)) {
                const int32_t other = cells->points[NUMBER][first + lowest(close)];
                if (s->names[other] < 0) {
                    s->names[other] = name;
                    chain[waiting++] = other;
                }
            }
        }
    return waiting;
}

/* Give each task the name of the lowest in its chain of tasks under one name (model.md 6.24). */
static void name_tasks(struct state *s)
{
    int32_t *chain = s->parts[0].who;
    for (int64_t task = 0; task < s->params->tasks.count; task++)
        s->names[task] = -1;
    for (int32_t lowest_task = 0; lowest_task < s->params->tasks.count; lowest_task++) {
        if (s->names[lowest_task] >= 0)
            continue;
        s->names[lowest_task] = chain[0] = lowest_task;
        for (int64_t waiting = 1; waiting > 0;)
            waiting = name_near(s, chain[waiting - 1], lowest_task, chain, waiting - 1);
    }
}

/* Sort the tasks in their places so that robots find those in sight. */
static void sort_tasks(struct state *s)
{
    const struct params *p = s->params;
    const int32_t *xs = s->tasks[POINT_X], *ys = s->tasks[POINT_Y];
    for (int64_t task = 0; task < p->tasks.count; task++)
        s->tasks[NUMBER][task] = (int32_t)task;
    sort_into_cells(&s->task_cells, &p->tasks.grid, xs, ys, s->tasks[NUMBER], s->tasks_there, p->tasks.count);
    if (p->sensing.merges)
        name_tasks(s);
    if (p->tasks.numbered)
        for (int64_t task = 0; task < p->tasks.count; task++)
            s->task_places[task] = pack_place(xs[task], ys[task]);
}

#endif

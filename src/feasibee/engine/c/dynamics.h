/* How a world changes, and robots charge (model.md 6.17, 6.23). One thread simulates a world that changes. */

#ifndef DYNAMICS_H
#define DYNAMICS_H

#include "acting.h"
#include "begin.h"
#include "placing.h"

#define DRAWN (-1) /* in place of a coordinate */

/* Return whether a set is one that each step forms anew: a robot that leaves the arena doesn't leave it. */
ALWAYS bool is_of_a_step(enum set kind)
{
    return kind == BLOCKED || kind == LISTENING || kind == TURNING_LEFT || kind == CLEARED;
}

/* --- How long things stay --- */

/* Draw the step at which a task vanishes. */
static void begin_lifetime(struct state *s, int64_t task, int64_t now)
{
    const double lifetime = s->params->tasks.lifetime;
    if (lifetime > 0.0)
        s->vanish_at[task] = (int32_t)(now + duration(draw(s, task, 0, LIFETIME), lifetime));
}

/* Draw the step at which a robot fails. */
static void draw_failure(struct state *s, int64_t i, int64_t now)
{
    const double mean = s->params->robots.failure_time;
    if (mean > 0.0)
        s->robots[LEAVES_AT][i] = (int32_t)(now + duration(draw(s, i, s->robots[JOINED][i], FAILURE), mean));
}

/* Draw the step at which a robot goes to charge for the first time; its first step is 1 or later. */
static void draw_battery(struct state *s, int64_t i, int64_t now)
{
    const int64_t work = s->params->robots.work, first = now > 1 ? now : 1;
    if (work > 0)
        s->robots[SWITCHES_AT][i] = (int32_t)(first + 1 + choose(draw(s, i, s->robots[JOINED][i], BATTERY), work));
}

/* Draw lifetimes, times of failure and classes at the start of a run. */
static void draw_dynamics(struct state *s)
{
    const struct params *p = s->params;
    const int64_t robots = p->robots.at_start, tasks = p->tasks.at_start;
    int32_t *class_of = s->class_of, *task_class = class_of + p->robots.count;
    s->clock->appeared = tasks;
    s->clock->events = s->clock->vanished = s->clock->left = 0;
    for (int64_t task = 0; task < tasks; task++)
        begin_lifetime(s, task, 0);
    for (int64_t i = 0; i < robots; i++) {
        draw_failure(s, i, 0);
        draw_battery(s, i, 0);
    }
    for (int64_t i = robots; i < p->robots.count; i++)
        class_of[i] = class_of[choose(draw(s, i, 0, JOINING_CLASS), robots)];
    for (int64_t task = tasks; task < p->tasks.count; task++)
        task_class[task] = tasks > 0 ? task_class[choose(draw(s, task, 0, APPEARING_CLASS), tasks)] : 0;
}

/* --- Tasks that come and go --- */

/* Let the next task appear, unless all numbers have been used (model.md 6.17.4). */
static void appear(struct state *s, int64_t now, int64_t x, int64_t y)
{
    const int64_t task = s->clock->appeared;
    if (task >= s->params->tasks.count)
        return;
    if (x < 0)
        place_task(s, task);
    else
        put(s->tasks, task, x, y);
    begin_lifetime(s, task, now);
    put_in(s->tasks_there, task, true);
    s->clock->changed = 1;
    s->clock->appeared++;
    s->clock->tasks++;
}

static void vanish(struct state *s, int64_t task)
{
    s->clock->changed = 1;
    put_in(s->tasks_there, task, false);
    s->clock->tasks--;
}

/* Remove the tasks whose lifetime is over. */
static void end_lifetimes(struct state *s, int64_t now)
{
    if (s->params->tasks.lifetime > 0.0)
        for (int64_t task = 0; task < s->params->tasks.count; task++)
            if (s->vanish_at[task] == now && has(s->tasks_there, task))
                vanish(s, task);
}

/* --- Robots that come and go --- */

ALWAYS void begin_to_walk(struct state *s, int64_t i)
{
    const int32_t who = (int32_t)i;
    take_headings(s, &who, 1);
}

/* Let a robot join, if a number and a place are free (model.md 6.17.6, 6.17.7). */
static void join(struct state *s, int64_t now, int64_t x, int64_t y)
{
    const enum set entered[] = {THERE, WORKING, COUNTED, JOINING, PRESENT};
    const uint32_t *there = s->sets[THERE], *away = s->sets[AWAY];
    int64_t w = 0;
    while (w < s->words && (there[w] | away[w]) == UINT32_MAX)
        w++;
    const int64_t i = w < s->words ? lowest_member(w, ~(there[w] | away[w])) : WORD * w;
    if (i >= s->params->robots.count)
        return;
    if (!(x < 0 ? place_robot(s, i, true) : put_clear(s, i, x, y, true)))
        return;
    for (int k = 0; k < 5; k++)
        put_in(s->sets[entered[k]], i, true);
    s->clock->changed = 1;
    s->clock->robots++;
    s->robots[LABEL][i] = label(i, false, false);
    if (s->params->sensing.unique)
        memset(s->remembered + i * s->remembered_words, 0, (size_t)s->remembered_words * sizeof *s->remembered);
    if (s->params->acting.acts)
        forget_tasks(s, i);
    begin_to_walk(s, i);
    prepare_robot(s, i);
    draw_failure(s, i, now);
    draw_battery(s, i, now);
}

/* Remove a robot from the arena for good; the next one of its number goes on with its draws. */
static void leave(struct state *s, int64_t i)
{
    s->clock->robots -= has(s->sets[PRESENT], i);
    for (enum set kind = 0; kind < SETS; kind++)
        if (!is_of_a_step(kind))
            put_in(s->sets[kind], i, false);
    s->clock->changed = 1;
    empty_inbox(s, &s->parts[0], i);
    stand_still(s, i);
    drop_delayed(s, i);
    s->robots[LABEL][i] = label(i, false, false);
    s->robots[JOINED][i]++;
}

/* Remove the robots that fail at this step; begin to count those that leave by events. */
static void fail_robots(struct state *s, int64_t now)
{
    s->clock->vanished = s->clock->left = 0;
    if (s->params->robots.failure_time == 0.0)
        return;
    for (int64_t i = 0; i < s->params->robots.count; i++)
        if (s->robots[LEAVES_AT][i] == now && (has(s->sets[THERE], i) || has(s->sets[AWAY], i)))
            leave(s, i);
}

/* --- Robots that charge --- */

/* Let a robot leave the arena to charge, or enter it again. */
static void move_between(struct state *s, int64_t i, bool away)
{
    put_in(s->sets[AWAY], i, away);
    put_in(s->sets[THERE], i, !away);
    put_in(s->sets[WORKING], i, !away);
    put_in(s->sets[SPEAKING], i, !away && has(s->sets[SPEAKING_AGAIN], i));
    if (!s->params->robots.away_counts) {
        put_in(s->sets[PRESENT], i, !away);
        put_in(s->sets[COUNTED], i, !away && !has(s->sets[BYZANTINE], i));
        s->clock->robots += away ? -1 : 1;
    }
    s->robots[LABEL][i] = label_of(s, i);
    s->clock->changed = 1;
}

/* Let a robot charge: it keeps its mind, and its phase waits for the step at which it comes back. */
static void go_away(struct state *s, int64_t i, int64_t now)
{
    const int32_t phase_left = s->robots[PHASE_LEFT][i], charge = (int32_t)s->params->robots.charge;
    put_in(s->sets[SPEAKING_AGAIN], i, has(s->sets[SPEAKING], i));
    move_between(s, i, true);
    stand_still(s, i);
    drop_delayed(s, i);
    s->robots[PHASE_LEFT][i] = phase_left + charge; /* it ticks meanwhile */
    s->robots[SWITCHES_AT][i] = (int32_t)(now + charge);
}

/* Let a robot come back as one that joins is placed; without a free place, it waits for a step. */
static void come_back(struct state *s, int64_t i, int64_t now)
{
    s->robots[JOINED][i]++; /* each attempt has draws of its own */
    if (!place_robot(s, i, true)) {
        s->robots[SWITCHES_AT][i] = (int32_t)(now + 1);
        s->robots[PHASE_LEFT][i]++;
        return;
    }
    move_between(s, i, false);
    begin_to_walk(s, i);
    s->robots[SWITCHES_AT][i] = (int32_t)(now + s->params->robots.work);
}

/* Let robots go whose battery is empty, then those come back that have charged theirs (model.md 6.23). */
static void charge_robots(struct state *s, int64_t now)
{
    const int32_t *switches_at = s->robots[SWITCHES_AT];
    const bool stopped = now >= s->params->faults.stop_step;
    if (s->params->robots.work == 0)
        return;
    for (int64_t i = 0; i < s->params->robots.count; i++)
        if (switches_at[i] == now && has(s->sets[WORKING], i))
            go_away(s, i, now);
    for (int64_t i = 0; i < s->params->robots.count; i++)
        if (switches_at[i] == now && has(s->sets[AWAY], i) && !(stopped && has(s->sets[STOPPING], i)))
            come_back(s, i, now);
}

/* --- Events --- */

/* Return the k-th member of a set, from 0 on. */
static int64_t member_of(const uint32_t *set, int64_t k)
{
    int64_t w = 0;
    for (; k >= members(set[w]); w++)
        k -= members(set[w]);
    uint32_t left = set[w];
    for (; k > 0; k--)
        left = without_lowest(left);
    return lowest_member(w, left);
}

/* Remove a robot that is present, or put it at a point if it is in the arena and the point is clear. */
static void take_or_put_robot(struct state *s, int64_t i, int64_t x, int64_t y)
{
    const int32_t old_x = s->robots[X][i], old_y = s->robots[Y][i];
    if (x < 0 && has(s->sets[PRESENT], i))
        leave(s, i);
    if (x < 0 || !has(s->sets[THERE], i))
        return;
    put_in(s->sets[THERE], i, false); /* it isn't in its own way */
    if (!put_clear(s, i, x, y, true))
        put(s->robots, i, old_x, old_y);
    put_in(s->sets[THERE], i, true);
    s->clock->changed = 1;
}

/* Remove a task that is there, or put it at a point (model.md 6.17.12). */
static void take_or_put_task(struct state *s, int64_t task, int64_t x, int64_t y)
{
    if (x < 0) {
        vanish(s, task);
        return;
    }
    put(s->tasks, task, x, y);
    s->clock->changed = 1;
}

/* Let so many of the robots or tasks that are there go, drawn at random. */
static void remove_tasks(struct state *s, int64_t count, int64_t now)
{
    for (int64_t left = count < s->clock->tasks ? count : s->clock->tasks; left > 0; left--) {
        const uint32_t word = draw(s, s->clock->vanished++, now, VANISH);
        vanish(s, member_of(s->tasks_there, choose(word, s->clock->tasks)));
    }
}

static void remove_robots(struct state *s, int64_t count, int64_t now)
{
    for (int64_t left = count < s->clock->robots ? count : s->clock->robots; left > 0; left--) {
        const uint32_t word = draw(s, s->clock->left++, now, LEAVE);
        leave(s, member_of(s->sets[PRESENT], choose(word, s->clock->robots)));
    }
}

/* Let an event happen: tasks, robots, then probabilities. */
static void happen(struct state *s, const int64_t *event, int64_t now)
{
    const int64_t x = event[EVENT_X], y = event[EVENT_Y], task = event[EVENT_TASK];
    for (int64_t k = 0; k < event[EVENT_TASKS]; k++)
        appear(s, now, x, y);
    remove_tasks(s, -event[EVENT_TASKS], now);
    for (int64_t k = 0; k < event[EVENT_ROBOTS]; k++)
        join(s, now, x, y);
    remove_robots(s, -event[EVENT_ROBOTS], now);
    if (task >= 0 && has(s->tasks_there, task))
        take_or_put_task(s, task, x, y);
    if (event[EVENT_ROBOT] >= 0)
        take_or_put_robot(s, event[EVENT_ROBOT], x, y);
    if (event[EVENT_MISS] >= 0)
        s->clock->miss = event[EVENT_MISS];
    if (event[EVENT_LOSS] >= 0)
        s->clock->loss = event[EVENT_LOSS];
}

/* Let tasks appear and robots join by their rates. */
static void arrive_by_rates(struct state *s, int64_t now)
{
    const double tasks = s->params->tasks.arrival_rate, robots = s->params->robots.arrival_rate;
    if (tasks == 0.0 && robots == 0.0)
        return;
    const struct words drawn = draw_words(s, 0, now, ARRIVAL);
    for (int64_t left = poisson(drawn.word[0], tasks); left > 0; left--)
        appear(s, now, DRAWN, DRAWN);
    for (int64_t left = poisson(drawn.word[1], robots); left > 0; left--)
        join(s, now, DRAWN, DRAWN);
}

/* --- What follows --- */

/* Return how many robots, or tasks, of a set a set of skills has, each as often as it adds. */
static int64_t sum_of(const uint32_t *set, int64_t count, const int32_t *class_of, const int64_t *adds)
{
    int64_t sum = 0;
    for (int64_t k = 0; k < count; k++)
        sum += has(set, k) * adds[class_of[k]];
    return sum;
}

/* Return whether the robots that are present can do the tasks that are there (model.md 6.7). */
static bool is_feasible(const struct state *s)
{
    const int64_t robots = s->params->robots.count, tasks = s->params->tasks.count;
    if (!s->params->sensing.by_class)
        return s->clock->robots >= s->clock->tasks;
    for (int64_t k = 0; k < s->tables.skill_sets; k++) {
        const int64_t *adds = s->tables.adds + k * s->tables.classes, *of_tasks = adds + s->params->robots.classes;
        if (sum_of(s->sets[PRESENT], robots, s->class_of, adds) <
            sum_of(s->tasks_there, tasks, s->class_of + robots, of_tasks))
            return false;
    }
    return true;
}

/* Store what follows from who is there: the truth, the quorum, and where robots and tasks are. */
static void settle(struct state *s)
{
    const struct params *p = s->params;
    int64_t counted = 0;
    sort_tasks(s);
    for (int64_t w = 0; w < s->words; w++)
        counted += members(s->sets[COUNTED][w]);
    set_quorum(s, counted);
    set_inventions(s);
    if (!p->truth_stays)
        s->clock->truth = is_feasible(s);
    if (p->robots.avoid_collisions && !p->together)
        fill_cells(s);
}

/* Change the world at the beginning of a step; before the first step, only events do. */
static void change_world(struct state *s, int64_t now)
{
    s->clock->changed = 0;
    if (now > 0) {
        end_lifetimes(s, now);
        fail_robots(s, now);
        charge_robots(s, now);
    }
    for (; s->clock->events < s->tables.event_count; s->clock->events++) {
        const int64_t *event = s->tables.events + s->clock->events * EVENT_COLUMNS;
        if (event[EVENT_STEP] != now)
            break;
        happen(s, event, now);
    }
    if (now > 0)
        arrive_by_rates(s, now);
    if (s->clock->changed || now == s->params->faults.stop_step)
        settle(s);
}

#endif

/* Robots that act: ways to tasks, arrivals, what they know of tasks, and what they choose (model.md 6.25).
 *
 * One thread simulates robots that act. A version in `news` and `told` is one more than the model's; 0 stands for
 * nothing. */

#ifndef ACTING_H
#define ACTING_H

#include "motion.h"
#include "near.h"
#include "place.h"
#include "way.h"

#define GONE 1073741825  /* version of a task that has vanished */
#define PATIENCE 20      /* steps after which a robot that has no task by its rank goes to the nearest */
#define LONGEST_DETOUR 3 /* steps that a blocked robot at most walks another way before it heads for its target again */
#define NOWHERE UINT64_MAX

enum holder { FREE = -1, DONE = -2 }; /* in place of a robot */

/* --- What robots know --- */

ALWAYS int32_t *news_of(const struct state *s, int64_t i) { return s->news + i * s->params->tasks.count; }

/* Return what a robot's message of a step says of tasks. */
ALWAYS int32_t *told_at(const struct state *s, int64_t step, int64_t i)
{
    const int64_t slot = step % (s->params->radio.delay + 1);
    return s->told + (slot * s->padded + i) * s->params->tasks.count;
}

ALWAYS bool is_known(int32_t version) { return 0 < version && version < GONE; }

/* Return 0 if a task is free, else the rank of who has it. */
ALWAYS int64_t status_of(const struct state *s, int64_t task)
{
    return s->holders[task] < 0 ? 0 : s->tables.ranks[s->class_of[s->holders[task]]];
}

/* Return the least version with a status from a version on; 0 as the version stands for nothing. */
static int32_t next_version(const struct params *p, int32_t version, int64_t status)
{
    const int64_t period = p->acting.ranks + 1;
    if (!p->acting.come_free || version == 0)
        return (int32_t)(1 + status);
    const int64_t ahead = (status - (version - 1)) % period;
    return (int32_t)(version + (ahead < 0 ? ahead + period : ahead));
}

/* Let a robot know how a task is. */
static void see_task(struct state *s, int64_t i, int64_t task)
{
    int32_t *known = news_of(s, i) + task;
    *known = s->holders[task] == DONE ? GONE : next_version(s->params, *known, status_of(s, task));
}

/* Let a robot know how the tasks in sight are. */
static void see_tasks(struct state *s, int64_t i, int64_t w, uint32_t members)
{
    for (; members; members = without_lowest(members))
        see_task(s, i, lowest_member(w, members));
}

/* Let a robot keep the larger of its versions and those that it hears. */
static void hear_tasks(struct state *s, int64_t i, int64_t w, uint32_t members)
{
    int32_t *restrict known = news_of(s, i);
    const int64_t tasks = s->params->tasks.count;
    for (; members; members = without_lowest(members)) {
        const int32_t *restrict told = told_at(s, s->clock->step + 2, lowest_member(w, members));
        for (int64_t task = 0; task < tasks; task++)
            known[task] = known[task] > told[task] ? known[task] : told[task];
    }
}

/* Change a message, so that robots of the last rank have all tasks that it names. */
static void lie_of_tasks(const struct params *p, int32_t *told)
{
    for (int64_t task = 0; task < p->tasks.count; task++)
        if (is_known(told[task]))
            told[task] = next_version(p, told[task], p->acting.ranks);
}

/* Fix what each robot says of tasks, and count the bits of those that broadcast. */
static void tell_all(struct state *s)
{
    const struct params *p = s->params;
    const int64_t now = s->clock->step + 1, tasks = p->tasks.count;
    memcpy(told_at(s, now, 0), s->news, (size_t)(p->robots.count * tasks) * sizeof *s->told);
    for (int64_t w = 0; w < s->words; w++) {
        for (uint32_t left = s->sets[BYZANTINE][w]; left; left = without_lowest(left))
            lie_of_tasks(p, told_at(s, now, lowest_member(w, left)));
        for (uint32_t left = s->sets[SPEAKING][w]; left; left = without_lowest(left)) {
            const int32_t *told = told_at(s, now + 1, lowest_member(w, left)); /* the message that is heard now */
            int64_t known = 0;
            for (int64_t task = 0; task < tasks; task++)
                known += told[task] != 0;
            s->account->bits_sent += p->acting.list_bits + p->acting.task_bits * known;
        }
    }
}

/* --- Who can do what --- */

ALWAYS bool can_do(const struct state *s, int64_t i, int64_t task)
{
    const int64_t kind = s->class_of[i], of_task = s->class_of[s->params->robots.count + task];
    return s->tables.able[kind * s->tables.task_classes + of_task] == 1;
}

/* Return how many tasks of the start the counted robots can take at once, by Hall's condition. */
static int64_t most_at_once(const struct state *s)
{
    const struct params *p = s->params;
    const int64_t tasks = p->tasks.at_start, counted = s->clock->counted;
    const int32_t *task_class = s->class_of + p->robots.count;
    int64_t most = tasks;
    if (!p->sensing.by_class)
        return counted < tasks ? counted : tasks;
    for (int64_t k = 0; k < s->tables.skill_sets; k++) {
        const int64_t *adds = s->tables.adds + k * s->tables.classes;
        int64_t others = tasks;
        for (int64_t task = 0; task < tasks; task++)
            others -= adds[p->robots.classes + task_class[task]];
        for (int64_t i = 0; i < p->robots.count; i++)
            others += has(s->sets[COUNTED], i) * adds[s->class_of[i]];
        most = others < most ? others : most;
    }
    return most;
}

static bool can_be_done(const struct state *s, int64_t task)
{
    bool can = s->holders[task] == DONE;
    for (int64_t i = 0; i < s->params->robots.count && !can; i++)
        can = has(s->sets[COUNTED], i) && can_do(s, i, task);
    return can;
}

/* Return how many tasks the counted robots can take, or have done and can do (model.md 6.25.14). */
static int64_t most_of(const struct state *s)
{
    const struct params *p = s->params;
    const int64_t robots = s->clock->counted, tasks = s->clock->tasks;
    int64_t most = 0;
    if (p->changes && !p->truth_stays)
        return p->tasks.work > 0 || tasks < robots ? tasks : robots;
    if (p->tasks.work == 0)
        return s->clock->most;
    for (int64_t task = 0; task < p->tasks.count; task++)
        most += can_be_done(s, task);
    return most;
}

/* --- Motion --- */

/* Let no task be taken, and no robot know of any. */
static void start_acting(struct state *s)
{
    const int64_t tasks = s->params->tasks.count, news = s->padded * tasks;
    for (int64_t task = 0; task < tasks; task++)
        s->holders[task] = FREE;
    memset(s->news, 0, (size_t)news * sizeof *s->news);
    memset(s->told, 0, (size_t)(news * (s->params->radio.delay + 1)) * sizeof *s->told);
    clear_ways(s);
}

/* Let a robot that joins know of no task. */
static void forget_tasks(struct state *s, int64_t i)
{
    memset(news_of(s, i), 0, (size_t)s->params->tasks.count * sizeof *s->news);
}

/* Let the robot that has a task go on, and the task be free or done. */
static void take_from(struct state *s, int64_t task, enum holder becomes)
{
    put_in(s->sets[STANDING], s->holders[task], false);
    put_in(s->sets[MARKED], s->holders[task], false);
    s->holders[task] = becomes;
}

/* Return whether a robot works, and stands at a task or has marked one. */
static bool has_task(const struct state *s, int64_t i)
{
    return (has(s->sets[STANDING], i) || has(s->sets[MARKED], i)) && has(s->sets[WORKING], i);
}

/* Free tasks whose robots left, and robots whose tasks are done or vanished. */
static void free_holders(struct state *s)
{
    const int64_t now = s->clock->step + 1;
    int64_t taken = 0, done = 0;
    for (int64_t task = 0; task < s->params->tasks.count; task++) {
        const int64_t i = s->holders[task];
        const bool is_there = has(s->tasks_there, task);
        if (i >= 0 && !(is_there && has_task(s, i)))
            take_from(s, task, FREE);
        else if (i >= 0 && has(s->sets[STANDING], i) && s->robots[DONE_AT][i] == now)
            take_from(s, task, DONE);
        const bool stands = s->holders[task] >= 0 && has(s->sets[STANDING], s->holders[task]);
        const bool is_done = is_there && s->holders[task] == DONE;
        done += is_done;
        taken += is_done + stands;
    }
    s->account->tasks_taken = taken;
    if (s->params->tasks.work > 0 && s->account->all_done_step < 0 && done >= most_of(s))
        s->account->all_done_step = now;
}

/* The way from a robot to a task, or a step on it. */
struct course {
    int64_t x, y;
};

ALWAYS struct course way_to(const struct state *s, int64_t i, int64_t task)
{
    const struct arena *arena = &s->params->arena;
    const int64_t x = at_x(s->tasks, task) - at_x(s->robots, i), y = at_y(s->tasks, task) - at_y(s->robots, i);
    if (arena->walls)
        return (struct course){x, y};
    return (struct course){shortest(x, arena->width), shortest(y, arena->height)};
}

ALWAYS uint64_t square_of(int64_t x, int64_t y) { return (uint64_t)(x * x) + (uint64_t)(y * y); }

/* Return how far a robot is from a task: squared, or in a place around walls; or `NOWHERE`. */
static uint64_t far_from(struct state *s, int64_t i, int64_t task)
{
    if (s->params->arena.place.exists) {
        const int64_t way = way_around(s, i, task);
        return way < NO_WAY ? (uint64_t)way : NOWHERE;
    }
    const struct course way = way_to(s, i, task);
    return square_of(way.x, way.y);
}

/* Let a robot's step be one towards a task (model.md 6.25.2, 6.25.17). */
static void step_towards(struct state *s, int64_t i, int64_t task)
{
    int32_t *u = s->robots[STEP_X] + i, *v = s->robots[STEP_Y] + i;
    if (s->params->arena.place.exists) {
        step_around(s, i, task, u, v);
        return;
    }
    const struct course way = way_to(s, i, task);
    const double length = __builtin_sqrt((double)square_of(way.x, way.y)), reach = s->params->robots.reach;
    *u = length > 0.0 ? (int32_t)__builtin_floor(reach * ((double)way.x / length) + 0.5) : 0;
    *v = length > 0.0 ? (int32_t)__builtin_floor(reach * ((double)way.y / length) + 0.5) : 0;
}

/* Return whether the step of a standing robot's run ends where it would have arrived at its task. */
static bool may_shift(const struct state *s, int64_t i, int64_t task)
{
    const struct place *place = &s->params->arena.place;
    const int64_t u = s->robots[STEP_X][i], v = s->robots[STEP_Y][i];
    if (!place->exists) {
        const struct course way = way_to(s, i, task);
        return square_of(way.x - u, way.y - v) < s->params->acting.reach;
    }
    const int64_t x = at_x(s->robots, i), y = at_y(s->robots, i);
    if (passable_ends(s, (int32_t)x, (int32_t)y, (int32_t)u, (int32_t)v) < QUARTERS)
        return false;
    return s->ways[task * place->columns * place->rows + cell_at_place(s, x + u, y + v)] <= place->arrived;
}

/* Let a robot go to its target, unless it is on a detour, or stand; keep its run where it waits. */
static void set_out(struct state *s, int64_t i)
{
    const int64_t task = s->robots[TARGET][i];
    const bool stands = has(s->sets[STANDING], i);
    if (s->robots[DETOUR][i] > 0) {
        s->robots[DETOUR][i]--;
        return;
    }
    if (stands && s->params->robots.avoid_collisions && may_shift(s, i, task))
        return;
    put_in(s->sets[COURSED], i, true);
    s->robots[HEADING_X][i] = s->robots[STEP_X][i];
    s->robots[HEADING_Y][i] = s->robots[STEP_Y][i];
    if (stands)
        s->robots[STEP_X][i] = s->robots[STEP_Y][i] = 0;
    else
        step_towards(s, i, task);
}

/* At the beginning of a step, free who has no task any more, and let the others go to their tasks. */
static void begin_acting(struct state *s)
{
    const int64_t now = s->clock->step + 1;
    if (now == 1 || now == s->params->faults.stop_step)
        s->clock->most = most_at_once(s);
    free_holders(s);
    for (int64_t w = 0; w < s->words; w++) {
        uint32_t left = (s->sets[BOUND][w] | s->sets[STANDING][w]) & s->sets[WORKING][w];
        s->sets[COURSED][w] = 0;
        for (; left; left = without_lowest(left))
            set_out(s, lowest_member(w, left));
    }
}

/* Once robots have moved, count the steps of those that don't stand; let runs wait, but not of bodies that stand. */
static void moved_acting(struct state *s)
{
    const bool bodies = s->params->robots.avoid_collisions;
    int64_t moved = 0;
    for (int64_t w = 0; w < s->words; w++) {
        const uint32_t stands = s->sets[STANDING][w], stays = stands | s->sets[BLOCKED][w];
        const uint32_t waits = s->sets[COURSED][w] & ~(bodies ? stands : 0);
        for (uint32_t left = s->sets[WORKING][w]; left; left = without_lowest(left)) {
            const int64_t i = lowest_member(w, left);
            s->robots[WALK_LEFT][i] += (int32_t)has_bit(waits, i);
            moved += (s->robots[STEP_X][i] != 0 || s->robots[STEP_Y][i] != 0) && !has_bit(stays, i);
        }
    }
    if (s->account->all_taken_step < 0)
        s->account->distance_walked += moved;
}

/* --- Arrival --- */

/* Let a robot stand at the task that it has reached. */
static void stand(struct state *s, int64_t i, int64_t now)
{
    const int64_t work = s->params->tasks.work;
    put_in(s->sets[STANDING], i, true);
    put_in(s->sets[MARKED], i, false);
    s->robots[DONE_AT][i] = work > 0 ? (int32_t)(now + work) : -1;
    s->account->tasks_taken++;
    s->account->starts_in_vain += 1 - s->clock->truth;
    if (s->account->first_taken_step < 0)
        s->account->first_taken_step = now;
}

/* Let a robot take a task, if it may have it, and know how the task is (model.md 6.25.3). */
static void arrive(struct state *s, int64_t i, int64_t task, int64_t now)
{
    if (!has(s->tasks_there, task) || s->holders[task] == DONE) {
        news_of(s, i)[task] = GONE;
        s->account->vain_arrivals++;
        return;
    }
    if (status_of(s, task) > 0 && s->holders[task] != i) {
        s->account->vain_arrivals++;
    } else {
        put_in(s->sets[BOUND], i, false);
        s->holders[task] = (int32_t)i;
        if (has(s->sets[ACTING], i))
            stand(s, i, now);
        else
            put_in(s->sets[MARKED], i, true);
    }
    see_task(s, i, task);
}

/* While robots speak, fix what they say of tasks; let each that has reached its target take the task. */
static void speak_acting(struct state *s)
{
    const struct params *p = s->params;
    const int64_t now = s->clock->step + 1;
    const uint64_t reach = p->arena.place.exists ? (uint64_t)(p->arena.place.arrived + 1) : p->acting.reach;
    tell_all(s);
    for (int64_t w = 0; w < s->words; w++)
        for (uint32_t left = s->sets[BOUND][w] & s->sets[WORKING][w]; left; left = without_lowest(left)) {
            const int64_t i = lowest_member(w, left), task = s->robots[TARGET][i];
            if (far_from(s, i, task) < reach)
                arrive(s, i, task, now);
        }
    if (s->account->all_taken_step < 0 && s->account->tasks_taken >= most_of(s))
        s->account->all_taken_step = now;
}

/* --- Choice --- */

/* Return whether a robot knows that there are more tasks than robots. */
static bool knows_too_many(const struct state *s, int64_t i)
{
    const struct params *p = s->params;
    const int64_t robots = p->robots.at_start > s->clock->robots ? p->robots.at_start : s->clock->robots;
    const int32_t *versions = news_of(s, i);
    int64_t known = 0;
    if (!p->robots.knows_count || p->tasks.work > 0)
        return false;
    for (int64_t task = 0; task < p->tasks.count; task++)
        known += is_known(versions[task]);
    return known > robots;
}

/* Return the task that a robot has marked. */
static int64_t marked_by(const struct state *s, int64_t i)
{
    for (int64_t task = 0; task < s->params->tasks.count; task++)
        if (s->holders[task] == i)
            return task;
    return -1;
}

/* Return whether a robot can do a task that is free as far as it knows. */
ALWAYS bool may_take(const struct state *s, int64_t i, int64_t task)
{
    const int32_t version = news_of(s, i)[task];
    const uint32_t period = (uint32_t)s->params->acting.ranks + 1;
    return is_known(version) && (uint32_t)(version - 1) % period == 0 && can_do(s, i, task);
}

/* Return the task that comes after so many known ones as a robot's number is, if it may take it; else -1. */
static int64_t task_of_rank(const struct state *s, int64_t i)
{
    int64_t before = 0;
    for (int64_t task = 0; task < s->params->tasks.count; task++) {
        const bool known = is_known(news_of(s, i)[task]);
        if (known && before == i)
            return may_take(s, i, task) ? task : -1;
        before += known;
    }
    return -1;
}

/* Return the nearest task that a robot may take, or -1. */
static int64_t nearest(struct state *s, int64_t i)
{
    int64_t found = -1;
    uint64_t least = NOWHERE;
    for (int64_t task = 0; task < s->params->tasks.count; task++) {
        if (!may_take(s, i, task))
            continue;
        const uint64_t far = far_from(s, i, task);
        if (far < least) {
            found = task;
            least = far;
        }
    }
    return found;
}

/* Let a robot act if it is time; return whether it acts. */
static bool begins_to_act(struct state *s, int64_t i, int64_t now)
{
    const struct acting *acting = &s->params->acting;
    if (now < acting->start && !(acting->by_word && has(s->sets[DECLARED], i)))
        return false;
    if (!has(s->sets[ACTING], i)) {
        put_in(s->sets[ACTING], i, true);
        s->robots[BEGAN][i] = (int32_t)now;
    }
    return true;
}

/* Return the task that a robot goes to, or -1. */
static int64_t target_of(struct state *s, int64_t i, int64_t now)
{
    const struct acting *acting = &s->params->acting;
    const bool gave_up = has(s->sets[DECLARED], i) && !has(s->sets[FOR_FEASIBLE_DECLARED], i);
    const bool marked = has(s->sets[MARKED], i);
    if (has(s->sets[BYZANTINE], i) || gave_up || knows_too_many(s, i))
        return -1;
    if (!begins_to_act(s, i, now) && (!acting->tags || marked))
        return -1;
    if (marked)
        return marked_by(s, i);
    return acting->by_rank && now < s->robots[BEGAN][i] + PATIENCE ? task_of_rank(s, i) : nearest(s, i);
}

static void choose_target(struct state *s, int64_t i, int64_t now)
{
    int64_t target = target_of(s, i, now);
    if (target >= 0 && far_from(s, i, target) == NOWHERE)
        target = -1;
    put_in(s->sets[BOUND], i, target >= 0);
    s->robots[TARGET][i] = (int32_t)target;
}

/* End the detours that are over, or let one begin. */
static void end_detour(struct state *s, int64_t i)
{
    const bool bound = has(s->sets[BOUND], i);
    if (bound && has(s->sets[BLOCKED], i))
        s->robots[DETOUR][i] = LONGEST_DETOUR;
    else if (!bound || has(s->sets[TURNING], i))
        s->robots[DETOUR][i] = 0;
}

/* Give robots their runs back, and end their detours. */
static void end_acting(struct state *s)
{
    for (int64_t w = 0; w < s->words; w++) {
        for (uint32_t left = s->sets[COURSED][w]; left; left = without_lowest(left)) {
            const int64_t i = lowest_member(w, left);
            s->robots[STEP_X][i] = s->robots[HEADING_X][i];
            s->robots[STEP_Y][i] = s->robots[HEADING_Y][i];
        }
        for (uint32_t left = s->sets[WORKING][w]; left; left = without_lowest(left))
            end_detour(s, lowest_member(w, left));
    }
}

/* Let robots choose targets, once they have decided: a robot that declares may act at once (model.md 6.25.9). */
static void choose_targets(struct state *s)
{
    for (int64_t w = 0; w < s->words; w++)
        for (uint32_t left = s->sets[WORKING][w] & ~s->sets[STANDING][w]; left; left = without_lowest(left))
            choose_target(s, lowest_member(w, left), s->clock->step + 1);
}

#endif

/* What functions of a strategy's knowledge are given: rows of words, the robot itself, and what it sees. */

#ifndef GIVEN_H
#define GIVEN_H

#include "queue.h"

#define UNSENT (-(INT64_C(1) << 62)) /* SENT_BITS of a robot whose message is no copy of what it once knew */

ALWAYS struct known known_by(const struct state *s, int64_t i)
{
    return (struct known){s->knowledge[KNOWN] + i * s->copy_words, s->params->strategy.knowledge.words};
}

ALWAYS struct known told_by(const struct state *s, int64_t i)
{
    return (struct known){s->knowledge[SENT] + i * s->copy_words, s->params->strategy.knowledge.message_words};
}

/* Return a coordinate in units of length. */
ALWAYS double in_units(const struct state *s, int32_t fixed) { return (uint32_t)fixed * s->params->arena.unit; }

ALWAYS struct me me_of(const struct state *s, int64_t i)
{
    const int64_t id = s->robots[IDENTITY][i];
    return (struct me){
        .id = id,
        .kind = s->class_of[i],
        .hash = s->hashes[id],
        .step = s->clock->step,
        .explores = !has(s->sets[DISSEMINATING], i),
        .x = in_units(s, s->robots[X][i]),
        .y = in_units(s, s->robots[Y][i]),
        .memory = s->memory + i * s->memory_length,
        .memory_count = s->memory_length,
        .setting = s->setting,
    };
}

/* Return a false sighting of a class: those of robots, then those of tasks. */
ALWAYS struct thing false_thing(const struct params *p, int64_t column, uint32_t mark)
{
    const bool is_robot = column < p->robots.classes;
    return (struct thing){is_robot, -1, is_robot ? column : column - p->robots.classes, mark, 0.0, 0.0};
}

/* Return a robot or task as robots see it: robots are numbered first, then tasks, then tasks under their wrong
 * names, with the hash given.
 *
 * Without branches: a wrong guess whether a robot or a task follows costs more than the rest. */
ALWAYS struct thing thing_seen(const struct state *s, int64_t number, uint32_t mark)
{
    const struct params *p = s->params;
    const int64_t robots = p->robots.count, tasks = p->tasks.count;
    const bool misnamed = number >= robots + tasks;
    number -= misnamed ? tasks : 0;
    const bool is_robot = number < robots;
    const int64_t task = number - robots, id = is_robot ? s->robots[IDENTITY][is_robot ? number : 0] : task;
    const int32_t *xs = is_robot ? s->robots[X] : s->tasks[POINT_X], *ys = is_robot ? s->robots[Y] : s->tasks[POINT_Y];
    const double x = in_units(s, xs[is_robot ? number : task]), y = in_units(s, ys[is_robot ? number : task]);
    const int64_t hash = s->hashes[is_robot ? id : number];
    if (RARELY(misnamed)) {
        const double half_way = 0.5 * p->arena.sides.width;
        const int64_t wrong = p->strategy.knowledge.task_ids - tasks + task;
        return (struct thing){false, wrong, s->class_of[number], mark, x < half_way ? x + half_way : x - half_way, y};
    }
    return (struct thing){is_robot, id, s->class_of[number], hash, x, y};
}

/* Mark a robot whose knowledge may have changed since its last message. */
ALWAYS void learns(struct state *s, int64_t i)
{
    if (s->counts[SENT_BITS][i] >= 0)
        s->counts[SENT_BITS][i] = ~s->counts[SENT_BITS][i];
}

ALWAYS bool is_copy(struct known message, struct known known)
{
    int32_t differing = 0;
    for (int64_t k = 0; k < known.length; k++)
        differing |= message.words[k] ^ known.words[k];
    return differing == 0;
}

/* Return where a message of a robot is kept that was made at a step. */
ALWAYS int64_t *kept_message(const struct state *s, int64_t step, int64_t i)
{
    return s->delayed + (step % (s->params->radio.delay + 1) * s->padded + i) * s->delayed_length;
}

#endif

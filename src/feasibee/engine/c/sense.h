/* Observation and messages in any world (model.md 3.2, 4.2, 4.5, 6.3, 6.5): what swarms of all sizes share.
 *
 * Up to 128 robots sense together, by sets of who is near (sense_few.h). Of larger swarms each robot looks through
 * cells (sense_crowd.h). Both have the same outcome. */

#ifndef SENSE_H
#define SENSE_H

#include "acting.h"
#include "knowledge.h"
#include "messages.h"
#include "near.h"
#include "view.h"

enum listening { ALWAYS_LISTENS = -1, WHILE_DISSEMINATING = 0 }; /* or a number of steps: decision.listens_for */

/* Return the upper 16 bits of each coordinate, those of x below. */
ALWAYS uint32_t pack_place(int32_t x, int32_t y) { return (uint32_t)x >> 16 | ((uint32_t)y & 0xFFFF0000u); }

/* --- Forgetting --- */

static inline void clear_counts(struct state *s, int64_t i)
{
    s->counts[ROBOTS_SEEN][i] = s->counts[TASKS_SEEN][i] = 0;
    if (s->seen)
        memset(s->seen + i * s->tables.classes, 0, sizeof *s->seen * (size_t)s->tables.classes);
}

/* Empty a robot's inbox, and its counts unless evidence is kept (model.md 4.6). */
static inline void forget(struct state *s, struct part *part, int64_t i)
{
    empty_inbox(s, part, i);
    if (s->params->strategy.forgets)
        clear_counts(s, i);
    if (s->params->sensing.unique)
        memset(s->remembered + i * s->remembered_words, 0, sizeof *s->remembered * (size_t)s->remembered_words);
}

/* --- Events that happen to pairs --- */

/* Draw whether an event happens to each pair of a queue in this step: ones or zeros in part->third.
 *
 * Numbers of the second have so many bits below them that don't belong to them. */
static inline void draw_lots(const struct state *s, struct part *part, int64_t queued, uint32_t purpose,
                             int64_t probability, int bits)
{
    const struct source from = source_of(s->params, s->clock->run, purpose);
    const u64 now = spread_long((uint32_t)(s->clock->step + 1)), limit = spread_long((uint64_t)probability);
    for (int64_t k = 0; k < queued; k += PAIRS) {
        const u64 number = longs_at(part->other + k) >> spread_long((uint64_t)bits);
        const struct many drawn = philox_lanes(from, now, longs_at(part->who + k), number * PAIR + purpose);
        store_halves(part->third + k, (u64)(drawn.word[0] < limit));
    }
}

/* Keep the pairs of a queue to which an event doesn't happen in this step; return their number. Robots, with one bit
 * below their numbers, are spared by themselves. */
static inline int64_t keep_lucky(const struct state *s, struct part *part, int64_t queued, uint32_t purpose,
                                 int64_t probability, bool robots)
{
    int64_t kept = 0;
    if (probability == 0)
        return queued;
    draw_lots(s, part, queued, purpose, probability, robots);
    for (int64_t k = 0; k < queued; k++) {
        const int32_t i = part->who[k], other = part->other[k];
        part->who[kept] = i;
        part->other[kept] = other;
        kept += !part->third[k] || (robots && other >> 1 == i);
    }
    return kept;
}

/* --- Observation, one thing at a time --- */

/* Give the next pending sighting, if it is a false one or has a wrong name, its hash. */
ALWAYS void mark_next(struct state *s, uint32_t mark)
{
    if (s->params->strategy.knowledge.enabled)
        s->pending_mark[s->clock->pending] = (int32_t)mark;
}

/* Count one thing of a class, or add it to what the robot knows; its number is as pending ones are. */
static inline void count_sighting(struct state *s, int64_t i, int64_t number, int64_t class, bool is_robot)
{
    const int64_t column = is_robot ? class : s->params->robots.classes + class;
    if (s->params->strategy.knowledge.enabled)
        defer(s, OBSERVE, i, number, column);
    else if (s->seen)
        s->seen[i * s->tables.classes + column]++;
    else
        s->counts[is_robot ? ROBOTS_SEEN : TASKS_SEEN][i]++;
}

/* Return whether a thing in sight counts: always, or unless it is remembered; remember it. */
ALWAYS bool is_new(struct state *s, int64_t i, int64_t thing)
{
    if (!s->params->sensing.unique)
        return true;
    uint32_t *remembered = s->remembered + i * s->remembered_words;
    const bool known = has(remembered, thing);
    put_in(remembered, thing, true);
    return !known;
}

/* Observe a robot that is in sight and not missed. */
ALWAYS void observe_robot(struct state *s, int64_t i, int64_t other)
{
    if ((other != i || s->params->sensing.count_self) && is_new(s, i, other))
        count_sighting(s, i, other, s->class_of[other], true);
}

/* Observe a task that is in sight and not missed; it may get a wrong name. */
ALWAYS void observe_task(struct state *s, int64_t i, int64_t task)
{
    const struct params *p = s->params;
    if (p->acting.acts)
        see_tasks(s, i, task >> 5, bit(task & 31));
    if (!is_new(s, i, WORD * s->words + task))
        return;
    int64_t number = p->robots.count + (p->sensing.merges ? s->names[task] : task);
    const int64_t class = s->class_of[number];
    if (happens(s, i, MISNAME + PAIR * task, p->sensing.misname)) {
        mark_next(s, draw_words(s, number, 0, IDENTITY_HASH).word[2]);
        number += p->tasks.count;
    }
    count_sighting(s, i, number, class, false);
}

/* Observe the queued sights: is it seen, is it new, which class has it (model.md 6.3). */
APART void observe_queued(struct state *s, struct part *part, int64_t queued, bool robots)
{
    if (s->params->sensing.hides)
        queued = keep_reached(s, part, robots ? s->robots : s->tasks, SIGHT, queued, robots);
    if (s->params->sensing.counts_all && !robots) {
        for (int64_t k = 0; k < queued; k++)
            s->counts[TASKS_SEEN][part->who[k]]++;
        return;
    }
    queued = keep_lucky(s, part, queued, robots ? MISS_ROBOT : MISS_TASK, s->clock->miss, robots);
    for (int64_t k = 0; k < queued; k++)
        if (robots)
            observe_robot(s, part->who[k], part->other[k] >> 1);
        else
            observe_task(s, part->who[k], part->other[k]);
}

/* Observe each robot or each task in sight of exploring robots. */
APART void observe_all(struct state *s, struct part *part, const struct grid_cells *cells, const struct grid *grid,
                       bool robots)
{
    const struct lens lens = lens_of(s, cells, grid);
    int64_t queued = 0;
    for (int64_t w = part->first; w < part->last; w++)
        for (uint32_t left = exploring_in(s, w); left; left = without_lowest(left)) {
            queued = queue_near(part, &lens, lowest_member(w, left), lens.sight, queued, -1);
            if (queued > QUEUE_ROOM) {
                observe_queued(s, part, queued, robots);
                queued = 0;
            }
        }
    observe_queued(s, part, queued, robots);
}

/* Observe the tasks in sight of exploring robots. */
static inline void observe_tasks(struct state *s, struct part *part)
{
    if (s->params->sensing.counts_all && !s->params->sensing.hides)
        count_tasks(s, part);
    else
        observe_all(s, part, &s->task_cells, &s->params->tasks.grid, false);
}

/* --- False sightings --- */

/* Count false sightings of a robot, each with a hash of its own and the class of one drawn of `count` things: the
 * robots or tasks of the start, numbered from `first` on. */
static inline void count_false(struct state *s, int64_t i, double mean, bool robots, int64_t first, int64_t count)
{
    const int64_t now = s->clock->step + 1, of_class = robots ? FALSE_ROBOT_CLASS : FALSE_TASK_CLASS;
    if (mean == 0.0)
        return;
    const int64_t number = poisson(draw_now(s, i, robots ? FALSE_ROBOT : FALSE_TASK), mean);
    for (int64_t k = 0; k < number; k++) {
        const struct words drawn = draw_words(s, i, now, of_class + PAIR * k);
        const int64_t class = count > 0 ? s->class_of[first + choose(drawn.word[0], count)] : 0;
        mark_next(s, drawn.word[1]);
        count_sighting(s, i, -1, class, robots);
    }
}

/* Count the false sightings of all exploring robots. */
static inline void count_false_sightings(struct state *s, const struct part *part)
{
    const struct params *p = s->params;
    if (p->sensing.false_robots == 0.0 && p->sensing.false_tasks == 0.0)
        return;
    for (int64_t w = part->first; w < part->last; w++)
        for (uint32_t left = exploring_in(s, w); left; left = without_lowest(left)) {
            const int64_t i = lowest_member(w, left);
            count_false(s, i, p->sensing.false_robots, true, 0, p->robots.at_start);
            count_false(s, i, p->sensing.false_tasks, false, p->robots.count, p->tasks.at_start);
        }
}

/* --- Listening --- */

/* Store which robots listen in this step; their phases have been shortened by it already. */
static inline void find_listeners(struct state *s, const struct part *part)
{
    const int64_t listens_for = s->params->decision.listens_for;
    for (int64_t w = part->first; w < part->last; w++) {
        uint32_t listening = s->sets[WORKING][w];
        if (listens_for != ALWAYS_LISTENS)
            listening &= s->sets[DISSEMINATING][w];
        if (listens_for > WHILE_DISSEMINATING)
            for (int j = 0; j < WORD; j++)
                listening &= ~bit_if(s->robots[PHASE_LEFT][WORD * w + j] >= listens_for, j);
        s->sets[LISTENING][w] = listening;
    }
}

#endif

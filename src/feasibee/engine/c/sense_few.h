/* What up to 128 robots see and hear, a pair of words of them after the other. */

#ifndef SENSE_FEW_H
#define SENSE_FEW_H

#include "near_few.h"
#include "place.h"
#include "sense.h"

/* --- Observation --- */

/* Store the set of robots within a range of each robot. */
static inline void find_sight(struct state *s, uint64_t limit, struct band band)
{
    find_all_near(s, IN_SIGHT, limit, band);
    if (s->params->changes)
        keep_only(s, IN_SIGHT, s->sets[THERE]);
}

/* Sets of robots or tasks, for each robot: word of them, robot. */
struct sets {
    uint32_t *of;
    int64_t words, first; /* first: the number of the first robot or task in all of them */
};

/* Leave the second of a listed pair out of the first one's set if an event happens to it in this step. */
APART void drop_listed(struct state *s, struct part *part, struct sets sets, int64_t listed, uint32_t purpose,
                       int64_t probability)
{
    draw_lots(s, part, listed, purpose, probability, 0);
    for (int64_t k = 0; k < listed; k++) {
        const int32_t other = part->other[k];
        sets.of[(other >> 5) * s->padded + part->who[k]] &= ~((uint32_t)part->third[k] & bit(other));
    }
}

/* Leave those out of the sets of the robots of `asked` to which an event happens in this step. */
static inline void drop_unlucky(struct state *s, struct part *part, struct sets sets, const uint32_t *asked,
                                uint32_t purpose, int64_t probability)
{
    int64_t listed = 0;
    if (probability == 0)
        return;
    for (int64_t w = part->first; w < part->last; w++)
        for (int64_t other = 0; other < sets.words; other++) {
            const uint32_t *of = sets.of + other * s->padded + WORD * w;
            listed += write_pairs(part->who + listed, part->other + listed, of, w, asked[w], WORD * other);
            if (listed > QUEUE_ROOM) {
                drop_listed(s, part, sets, listed, purpose, probability);
                listed = 0;
            }
        }
    drop_listed(s, part, sets, listed, purpose, probability);
}

/* Leave things that a robot remembers out of what it sees, if things count once, and remember the others. */
static inline void keep_new(struct state *s, struct sets sets, int64_t i, int64_t place)
{
    for (int64_t k = 0; k < sets.words; k++) {
        uint32_t *remembered = s->remembered + i * s->remembered_words + place + k;
        uint32_t *seen = sets.of + k * s->padded + i;
        *seen &= ~*remembered;
        *remembered |= *seen;
    }
}

/* Count the members of the sets of robots that look. */
ALWAYS void count_members(struct state *s, const struct part *part, struct sets sets, const uint32_t *looking,
                          int64_t *counts)
{
    for (int64_t w = part->first; w < part->last; w++)
        for (int k = 0; k < WORD; k += LANES) {
            u32 seen = spread(0);
            for (int64_t other = 0; other < sets.words; other++)
                seen += ones_of(*(const u32 *)(sets.of + other * s->padded + WORD * w + k));
            add_lanes(counts + WORD * w + k, seen & lanes_of(looking[w] >> k));
        }
}

/* Count the members of a word of a robot's set by class; `classes` is the number of those before theirs. */
static inline void count_classes(struct state *s, int64_t i, uint32_t seen, int64_t first, int64_t classes)
{
    for (; seen; seen = without_lowest(seen))
        s->seen[i * s->tables.classes + classes + s->class_of[first + lowest(seen)]]++;
}

/* Count what robots that look see, or add it to what they know. */
static inline void observe_sets(struct state *s, const struct part *part, struct sets sets, const uint32_t *looking,
                                enum count_row row)
{
    const int64_t classes = row == TASKS_SEEN ? s->params->robots.classes : 0;
    if (s->params->sensing.only_counts) {
        count_members(s, part, sets, looking, s->counts[row]);
        return;
    }
    for (int64_t w = part->first; w < part->last; w++)
        for (int64_t other = 0; other < sets.words; other++) {
            const uint32_t *of = sets.of + other * s->padded + WORD * w;
            const int64_t first = sets.first + WORD * other;
            if (s->params->strategy.knowledge.enabled)
                defer_sets(s, OBSERVE, of, w, looking[w], first);
            else
                for (uint32_t left = looking[w]; left; left = without_lowest(left))
                    count_classes(s, lowest_member(w, left), of[lowest(left)], first, classes);
        }
}

/* Return which of the tasks of a word are in sight of a place. */
ALWAYS uint32_t tasks_near(const struct state *s, int64_t w, int32_t x, int32_t y)
{
    const struct band band = s->params->sensing.band;
    const u32 here = spread(pack_place(x, y)), low = spread(band.low), width = spread(band.width);
    uint32_t close = 0, doubtful = 0;
    UNROLL for (int k = 0; k < WORD; k += LANES) {
        const u32 square = squared(subtract_halves(vector_at(s->task_places + WORD * w + k), here));
        close |= below(square, low) << k;
        doubtful |= below(square - low, width) << k;
    }
    close &= s->tasks_there[w];
    for (doubtful &= s->tasks_there[w]; RARELY(doubtful != 0); doubtful = without_lowest(doubtful)) {
        const int64_t task = lowest_member(w, doubtful);
        const int64_t way_x = (int32_t)((uint32_t)x - (uint32_t)s->tasks[POINT_X][task]);
        const int64_t way_y = (int32_t)((uint32_t)y - (uint32_t)s->tasks[POINT_Y][task]);
        const bool is_near = (uint64_t)(way_x * way_x) + (uint64_t)(way_y * way_y) < s->params->sensing.limit;
        close = (close & ~bit(task & 31)) | bit_if(is_near, task);
    }
    return close;
}

/* Store the tasks in sight of the robots that look, 32 at a time by number. */
static inline void find_tasks(struct state *s, const struct part *part, const uint32_t *looking)
{
    for (int64_t w = part->first; w < part->last; w++)
        for (uint32_t left = looking[w]; left; left = without_lowest(left)) {
            const int64_t i = lowest_member(w, left);
            const int32_t x = s->robots[X][i], y = s->robots[Y][i];
            for (int64_t k = 0; k < s->task_words; k++) {
                const uint32_t near = tasks_near(s, k, x, y);
                s->tasks_seen[k * s->padded + i] = s->params->sensing.hides && near ? seen_tasks(s, near, k, i) : near;
            }
        }
}

/* Let robots that look count themselves, act on the tasks that they see, and remember what they have seen. */
static inline void attend(struct state *s, const struct part *part, const uint32_t *looking, struct sets robots,
                          struct sets tasks)
{
    const bool itself = s->params->sensing.count_self, unique = s->params->sensing.unique;
    for (int64_t w = part->first; w < part->last; w++)
        for (uint32_t left = looking[w]; left; left = without_lowest(left)) {
            const int64_t i = lowest_member(w, left);
            robots.of[w * s->padded + i] |= bit_if(itself, i);
            for (int64_t k = 0; k < tasks.words && s->params->acting.acts; k++)
                see_tasks(s, i, k, tasks.of[k * s->padded + i]);
            if (unique) {
                keep_new(s, robots, i, 0);
                keep_new(s, tasks, i, s->words);
            }
        }
}

/* Observe the robots and tasks in sight of the exploring robots (model.md 6.3). */
static inline void observe_few(struct state *s, struct part *part)
{
    const struct params *p = s->params;
    const struct sensing *sensing = &p->sensing;
    uint32_t *looking = s->sets[LOOKING];
    struct sets robots = {s->links[IN_SIGHT], s->words, 0};
    struct sets tasks = {s->tasks_seen, p->tasks.numbered ? s->task_words : 0, p->robots.count};
    for (int64_t w = part->first; w < part->last; w++)
        looking[w] = exploring_in(s, w);
    find_sight(s, sensing->limit, sensing->band);
    if (sensing->hides)
        drop_hidden(s, part, looking);
    if (p->tasks.numbered)
        find_tasks(s, part, looking);
    if (s->clock->miss > 0 || sensing->unique || sensing->count_self) { /* they hear those whom they don't see */
        robots.of = s->links[SEEN];
        memcpy(robots.of, s->links[IN_SIGHT], (size_t)(s->words * s->padded) * sizeof *robots.of);
    }
    drop_unlucky(s, part, robots, looking, MISS_ROBOT, s->clock->miss);
    drop_unlucky(s, part, tasks, looking, MISS_TASK, s->clock->miss);
    if (sensing->unique || sensing->count_self || p->acting.acts)
        attend(s, part, looking, robots, tasks);
    observe_sets(s, part, robots, looking, ROBOTS_SEEN);
    observe_sets(s, part, tasks, looking, TASKS_SEEN);
    if (!p->tasks.numbered)
        observe_tasks(s, part);
}

/* --- Messages --- */

/* Keep those robots of a word in each robot's sight that it hears, unless a message is lost. */
ALWAYS void find_heard(struct state *s, const struct part *part, int64_t other)
{
    uint32_t *restrict heard = s->links[IN_SIGHT] + other * s->padded;
    const uint32_t *restrict listening = s->sets[LISTENING], speaking = s->sets[SPEAKING][other];
    for (int64_t w = part->first; w < part->last; w++)
        for (int k = 0; k < WORD; k += LANES)
            *(u32 *)(heard + WORD * w + k) &= spread(speaking) & lanes_of(listening[w] >> k);
}

/* Let robots add what they hear of tasks to what they know. */
static inline void hear_of_tasks(struct state *s, const struct part *part)
{
    for (int64_t i = 0; i < s->params->robots.count; i++)
        for (int64_t other = part->first; other < part->last; other++)
            hear_tasks(s, i, other, s->links[IN_SIGHT][other * s->padded + i]);
}

/* Let robots add what they hear to what they know. */
static inline void merge_heard(struct state *s, const struct part *part)
{
    for (int64_t w = part->first; w < part->last; w++)
        for (int64_t other = part->first; other < part->last; other++) {
            const uint32_t *heard = s->links[IN_SIGHT] + other * s->padded + WORD * w;
            defer_sets(s, MERGE, heard, w, s->sets[LISTENING][w], WORD * other);
        }
}

/* Return which robots' messages say feasible, of a word; labels have it of lies and late messages. */
static inline uint32_t sent_opinions(const struct state *s, int64_t w)
{
    uint32_t said = s->sets[SAYS_FEASIBLE][w], differing = s->sets[SPEAKING][w];
    if (s->params->radio.delay == 0)
        differing &= s->sets[BYZANTINE][w];
    for (; differing; differing = without_lowest(differing)) {
        const int64_t i = lowest_member(w, differing);
        said = (said & ~bit(i & 31)) | bit_if(feasible_in(s->robots[LABEL][i]), i);
    }
    return said;
}

/* Add what robots hear to their inboxes. */
static inline void receive_heard(struct state *s, struct part *part)
{
    for (int64_t other = part->first; other < part->last; other++) {
        const uint32_t said = sent_opinions(s, other);
        if (s->params->decision.inbox_is_set) {
            receive_together(s, part, other, s->sets[SPEAKING][other], said);
            continue;
        }
        for (int64_t i = 0; i < s->params->robots.count; i++)
            for (uint32_t heard = s->links[IN_SIGHT][other * s->padded + i]; heard; heard = without_lowest(heard)) {
                const int64_t j = lowest_member(other, heard);
                receive(s, part, i, label(s->robots[IDENTITY][j], has_bit(said, j), true), s->robots[SENT_VALUE][j]);
            }
    }
}

/* Let the listening robots receive what the robots in radio range of them send (model.md 6.5, 6.6). */
static inline void hear_few(struct state *s, struct part *part)
{
    const struct params *p = s->params;
    uint32_t anyone = 0;
    for (int64_t w = part->first; w < part->last; w++)
        anyone |= s->sets[SPEAKING][w];
    if (anyone == 0)
        return;
    if (!p->radio.as_sight) {
        find_sight(s, p->radio.limit, p->radio.band);
        if (p->arena.place.exists)
            drop_cut(s, part, RADIO, s->sets[LISTENING], s->sets[SPEAKING]);
    }
    for (int64_t other = part->first; other < part->last; other++)
        find_heard(s, part, other);
    const struct sets heard = {s->links[IN_SIGHT], s->words, 0};
    drop_unlucky(s, part, heard, s->sets[LISTENING], LOSS, s->clock->loss);
    if (p->acting.acts)
        hear_of_tasks(s, part);
    if (p->strategy.knowledge.enabled)
        merge_heard(s, part);
    if (p->decision.declare.enabled || !p->strategy.knowledge.enabled)
        receive_heard(s, part);
}

/* Let exploring robots observe and listening robots receive (model.md 6.3, 6.5, 6.6). What a robot observes in a step
 * it knows before it receives messages. */
static inline void sense_few(struct state *s, struct part *part)
{
    publish(s, part);
    observe_few(s, part);
    count_false_sightings(s, part);
    update_pending(s, OBSERVE);
    find_listeners(s, part);
    hear_few(s, part);
    update_pending(s, MERGE);
}

#endif

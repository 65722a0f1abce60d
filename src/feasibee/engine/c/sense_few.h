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

/* Sets of robots or tasks that each robot sees or hears: word of them, robot. */
struct sets {
    uint32_t *of;
    int64_t words;
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
        for (uint32_t left = asked[w]; left; left = without_lowest(left)) {
            const int64_t i = lowest_member(w, left);
            for (int64_t other = 0; other < sets.words; other++) {
                listed = list_members(part, listed, i, sets.of[other * s->padded + i], WORD * other);
                if (listed > QUEUE_ROOM) {
                    drop_listed(s, part, sets, listed, purpose, probability);
                    listed = 0;
                }
            }
        }
    drop_listed(s, part, sets, listed, purpose, probability);
}

/* Count the robots in sight of those of a word that look. */
ALWAYS void count_in_sight(struct state *s, const struct part *part, int64_t w, uint32_t looking)
{
    const uint32_t *sight = s->links[IN_SIGHT] + WORD * w;
    for (int k = 0; k < WORD; k += LANES) {
        u32 seen = spread((uint32_t)s->params->sensing.count_self);
        for (int64_t other = part->first; other < part->last; other++)
            seen += ones_of(*(const u32 *)(sight + other * s->padded + k));
        add_lanes(s->counts[ROBOTS_SEEN] + WORD * w + k, seen & lanes_of(looking >> k));
    }
}

/* Return the things of a word that count, if things count once: those not remembered; remember them. */
ALWAYS uint32_t new_ones(struct state *s, int64_t i, int64_t w, uint32_t things)
{
    if (!s->params->sensing.unique)
        return things;
    uint32_t *remembered = s->remembered + i * s->remembered_words + w;
    things &= ~*remembered;
    *remembered |= things;
    return things;
}

/* Count the members of a word of robots or tasks by class, or add them to what the robot knows: `first` is the number
 * of the lowest, and `classes` that of the classes before theirs. */
static inline void count_sightings(struct state *s, int64_t i, uint32_t seen, int64_t first, int64_t classes)
{
    if (s->params->strategy.knowledge.enabled)
        defer_members(s, OBSERVE, i, seen, first);
    else
        for (; seen; seen = without_lowest(seen))
            s->seen[i * s->tables.classes + classes + s->class_of[first + lowest(seen)]]++;
}

/* Observe the robots that a robot sees. */
ALWAYS void observe_neighbours(struct state *s, const struct part *part, const uint32_t *sight, int64_t i)
{
    for (int64_t other = part->first; other < part->last; other++) {
        const uint32_t itself = bit_if(s->params->sensing.count_self == 1 && i >> 5 == other, i);
        const uint32_t seen = new_ones(s, i, other, sight[other * s->padded + i] | itself);
        if (s->params->sensing.only_counts)
            s->counts[ROBOTS_SEEN][i] += members(seen);
        else
            count_sightings(s, i, seen, WORD * other, 0);
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
            const bool hides = s->params->sensing.hides && may_hide(s, i);
            for (int64_t k = 0; k < s->task_words; k++) {
                const uint32_t near = tasks_near(s, k, x, y);
                s->tasks_seen[k * s->padded + i] = hides && near ? seen_tasks(s, near, k, i) : near;
            }
        }
}

/* Observe the tasks that a robot sees. */
ALWAYS void observe_numbered(struct state *s, const struct part *part, int64_t i)
{
    const struct params *p = s->params;
    int64_t total = 0;
    for (int64_t k = 0; k < s->task_words; k++) {
        uint32_t seen = s->tasks_seen[k * s->padded + i];
        if (seen && p->acting.acts)
            see_tasks(s, i, k, seen);
        seen = new_ones(s, i, part->last + k, seen);
        if (p->sensing.only_counts)
            total += members(seen);
        else
            count_sightings(s, i, seen, p->robots.count + WORD * k, p->robots.classes);
    }
    s->counts[TASKS_SEEN][i] += total;
}

/* Store whom and what the robots that look see; return the sets of robots that they do. */
static inline const uint32_t *look(struct state *s, struct part *part, const uint32_t *looking)
{
    const struct params *p = s->params;
    const struct sets robots = {s->links[SEEN], s->words}, tasks = {s->tasks_seen, s->task_words};
    find_sight(s, p->sensing.limit, p->sensing.band);
    if (p->sensing.hides)
        drop_hidden(s, part, looking);
    if (p->tasks.numbered)
        find_tasks(s, part, looking);
    if (s->clock->miss == 0)
        return s->links[IN_SIGHT];
    memcpy(robots.of, s->links[IN_SIGHT], (size_t)(s->words * s->padded) * sizeof *robots.of);
    drop_unlucky(s, part, robots, looking, MISS_ROBOT, s->clock->miss);
    if (p->tasks.numbered)
        drop_unlucky(s, part, tasks, looking, MISS_TASK, s->clock->miss);
    return robots.of;
}

/* Observe the robots and tasks in sight of the exploring robots (model.md 6.3). */
static inline void observe_few(struct state *s, struct part *part)
{
    const struct params *p = s->params;
    uint32_t *looking = s->sets[LOOKING];
    for (int64_t w = part->first; w < part->last; w++)
        looking[w] = exploring_in(s, w);
    const uint32_t *sight = look(s, part, looking);
    for (int64_t w = part->first; w < part->last; w++) {
        if (p->sensing.counts_all)
            count_in_sight(s, part, w, looking[w]);
        for (uint32_t left = looking[w]; left; left = without_lowest(left)) {
            const int64_t i = lowest_member(w, left);
            if (!p->sensing.counts_all)
                observe_neighbours(s, part, sight, i);
            if (p->tasks.numbered)
                observe_numbered(s, part, i);
        }
    }
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

/* Let robots add what they hear of tasks and of the rest to what they know. */
static inline void merge_heard(struct state *s, const struct part *part)
{
    for (int64_t i = 0; i < s->params->robots.count; i++)
        for (int64_t other = part->first; other < part->last; other++) {
            const uint32_t heard = s->links[IN_SIGHT][other * s->padded + i];
            if (heard && s->params->acting.acts)
                hear_tasks(s, i, other, heard);
            if (s->params->strategy.knowledge.enabled)
                defer_members(s, MERGE, i, heard, WORD * other);
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
            drop_cut(s, part, RADIO, p->arena.place.radio);
    }
    for (int64_t other = part->first; other < part->last; other++)
        find_heard(s, part, other);
    const struct sets heard = {s->links[IN_SIGHT], s->words};
    drop_unlucky(s, part, heard, s->sets[LISTENING], LOSS, s->clock->loss);
    if (p->strategy.knowledge.enabled || p->acting.acts)
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

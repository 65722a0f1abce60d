/* What the robots of a larger swarm see and hear. Each looks through the cells around it; what it hears, or sees if
 * that has to be looked at closely, is queued, and worked off for many robots at once. */

#ifndef SENSE_CROWD_H
#define SENSE_CROWD_H

#include "sense.h"
#include "team.h"

/* Return whether robots are counted while listening: all in sight count, and who is seen is heard. */
ALWAYS bool counts_while_hearing(const struct params *p)
{
    return p->sensing.counts_all && (p->radio.as_sight || !p->sensing.hides);
}

/* Sort who has been heard by one robot by number: a few sorted runs. */
static inline void sort_by_number(struct part *part, int64_t first, int64_t last)
{
    int32_t *heard = part->other;
    for (int64_t k = first + 1; k < last; k++) {
        const int32_t other = heard[k];
        int64_t place = k;
        for (; place > first && heard[place - 1] > other; place--)
            heard[place] = heard[place - 1];
        heard[place] = other;
    }
}

/* Count the queued robots that robots see; keep those that they hear, and return their number. */
static inline int64_t count_queued(struct state *s, struct part *part, int64_t queued)
{
    int64_t kept = 0;
    for (int64_t k = 0; k < queued; k++) {
        const int32_t i = part->who[k], other = part->other[k];
        s->counts[ROBOTS_SEEN][i] += has_bit(exploring_in(s, i >> 5), i);
        part->who[kept] = i;
        part->other[kept] = other;
        kept += has(s->sets[LISTENING], i) & other & 1;
    }
    return kept;
}

/* Receive the message of a robot in radio range, which isn't lost. */
ALWAYS void receive_from(struct state *s, struct part *part, int64_t i, int64_t other)
{
    const struct params *p = s->params;
    int32_t message = s->robots[LABEL][other];
    if (p->acting.acts)
        hear_tasks(s, i, other >> 5, bit(other & 31));
    if (p->strategy.knowledge.enabled)
        defer(s, MERGE, i, other, 0);
    if (p->strategy.knowledge.enabled && !p->decision.declare.enabled)
        return;
    if (p->radio.random_ids)
        message = label(s->robots[IDENTITY][other], feasible_in(message), true);
    receive(s, part, i, message, s->robots[SENT_VALUE][other]);
}

/* Let robots receive the queued messages, of which some are lost. */
APART void receive_queued(struct state *s, struct part *part, int64_t queued)
{
    const struct params *p = s->params;
    if (p->arena.place.exists)
        queued = keep_reached(s, part, s->robots, RADIO, queued, true);
    if (p->sensing.hides && counts_while_hearing(p))
        queued = count_queued(s, part, queued);
    queued = keep_lucky(s, part, queued, LOSS, s->clock->loss, true);
    for (int64_t k = 0; k < queued; k++)
        receive_from(s, part, part->who[k], part->other[k] >> 1);
}

/* Let listening robots receive messages. */
static inline void hear_crowd(struct state *s, struct part *part)
{
    const struct lens lens = lens_of(s, &s->robot_cells, &s->params->robots.grid);
    const bool counts = counts_while_hearing(s->params), hides = counts && s->params->sensing.hides;
    const bool in_order = s->params->in_sender_order;
    const int64_t itself = s->params->sensing.count_self - 1;
    int64_t *robots_seen = s->counts[ROBOTS_SEEN], queued = 0;
    for (int64_t w = part->first; w < part->last; w++) {
        fetch_ahead(&lens, w, s->words);
        const uint32_t listening = s->sets[LISTENING][w], exploring = counts ? exploring_in(s, w) : 0;
        for (uint32_t left = listening | exploring; left; left = without_lowest(left)) {
            const int64_t i = lowest_member(w, left), before = queued;
            int64_t seen = itself;
            if (hides) { /* who of them is seen is found out later */
                seen = s->params->sensing.count_self;
                queued = queue_near(part, &lens, i, lens.radio, queued, (int32_t)i);
            } else
                queued = scan(part, &lens, i, has_bit(listening, i), queued, &seen);
            robots_seen[i] += seen & -(int64_t)has_bit(exploring, i);
            if (in_order)
                sort_by_number(part, before, queued);
            if (queued > QUEUE_ROOM) {
                receive_queued(s, part, queued);
                queued = 0;
            }
        }
    }
    receive_queued(s, part, queued);
}

/* Sort all robots into cells once all threads have come here. */
static inline void fill_cells_together(struct state *s)
{
    struct team *team = s->team;
    if (comes_last(team)) {
        fill_cells(s);
        let_go(team);
    }
}

/* Do what sense_few does, in a swarm of more than 128. */
static inline void sense_crowd(struct state *s, struct part *part)
{
    publish(s, part);
    fill_cells_together(s);
    if (!counts_while_hearing(s->params))
        observe_all(s, part, &s->robot_cells, &s->params->robots.grid, true);
    observe_tasks(s, part);
    count_false_sightings(s, part);
    update_pending(s, OBSERVE);
    find_listeners(s, part);
    hear_crowd(s, part);
    update_pending(s, MERGE);
}

#endif

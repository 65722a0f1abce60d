/* Knowledge that robots pass on: for whom the strategy's functions are called, and what robots broadcast.
 *
 * A call through a pointer for each thing seen or heard costs much, so calls wait: `update` of the strategy
 * (update.h) makes all of them, three or four times per step of the whole swarm. */

#ifndef KNOWLEDGE_H
#define KNOWLEDGE_H

#include "acting.h"
#include "chance.h"
#include "given.h"

enum lie { OPPOSITE, SAY_FEASIBLE, SAY_INFEASIBLE, RANDOM, COLLUDING }; /* params.faults.byzantine_says */

/* Call a strategy's function for all that waits. */
static inline void update_pending(struct state *s, enum action action)
{
    if (s->clock->pending > 0)
        s->account->bits_sent += s->rules->update(s, action, s->clock->pending);
    s->clock->pending = 0;
}

/* Let robot i wait for a call; call for all that wait when there is no more room. */
ALWAYS void defer(struct state *s, enum action action, int64_t i, int64_t number, int64_t column)
{
    const int64_t place = s->clock->pending++;
    s->pending_who[place] = (int32_t)i;
    s->pending_number[place] = (int32_t)number;
    s->pending_column[place] = (int32_t)column;
    if (place + 1 == PENDING_ROOM)
        update_pending(s, action);
}

/* Let robots of a word that are asked wait for a call with each member of their sets, whose first has a number. */
static inline void defer_sets(struct state *s, enum action action, const uint32_t *sets, int64_t w, uint32_t asked,
                              int64_t first)
{
    if (s->clock->pending >= PENDING_ROOM - PAIRS_OF_WORDS)
        update_pending(s, action);
    const int64_t place = s->clock->pending;
    s->clock->pending += write_pairs(s->pending_who + place, s->pending_number + place, sets, w, asked, first);
}

/* Return the opinion in a Byzantine robot's message (model.md 6.6, 6.16). */
static inline int64_t false_opinion(const struct state *s, int64_t i)
{
    switch ((enum lie)s->params->faults.byzantine_says) {
    case COLLUDING: return 1 - s->clock->truth;
    case OPPOSITE: return 1 - has(s->sets[SAYS_FEASIBLE], i);
    case RANDOM: return coin(draw_now(s, i, LIE));
    case SAY_FEASIBLE: return 1;
    default: return 0;
    }
}

/* Let the Byzantine robots of a word that speak say what they say. */
static inline void lie_by_opinion(struct state *s, int64_t w)
{
    for (uint32_t lying = s->sets[SPEAKING][w] & s->sets[BYZANTINE][w]; lying; lying = without_lowest(lying)) {
        const int64_t i = lowest_member(w, lying), opinion = false_opinion(s, i);
        s->robots[LABEL][i] = label(i, opinion == FEASIBLE, true);
        s->robots[SENT_VALUE][i] = opinion == FEASIBLE ? (int32_t)s->params->strategy.value_scale : 0;
    }
}

/* Let a robot's message be one that was kept. */
static inline void take_message(struct state *s, const int64_t *kept, int64_t i)
{
    const struct known told = told_by(s, i);
    s->robots[LABEL][i] = (s->robots[LABEL][i] & ~3) | (int32_t)kept[SAYS];
    put_in(s->sets[SPEAKING], i, kept[SAYS] & 1);
    s->robots[SENT_VALUE][i] = (int32_t)kept[DELAYED_VALUE];
    for (int64_t k = 0; k < told.length; k++)
        told.words[k] = (int32_t)kept[TOLD + k];
}

/* Keep the messages of this step, and take those that are due in their place; return their bits. */
static inline int64_t delay_messages(struct state *s, const struct part *part)
{
    const int64_t now = s->clock->step;
    int64_t bits_sent = 0;
    for (int64_t i = WORD * part->first; i < WORD * part->last; i++) {
        int64_t *own = kept_message(s, now, i);
        const int64_t *due = kept_message(s, now + 1, i); /* whose place the next message takes */
        const struct known told = told_by(s, i);
        own[SAYS] = s->robots[LABEL][i] & 3;
        own[DELAYED_VALUE] = s->robots[SENT_VALUE][i];
        for (int64_t k = 0; k < told.length; k++)
            own[TOLD + k] = told.words[k];
        take_message(s, due, i);
        if (has(s->sets[SPEAKING], i))
            bits_sent += s->params->radio.message_bits + due[LENGTH];
    }
    return bits_sent;
}

/* Fix the message of each robot for this step, and count its bits. */
static inline void publish(struct state *s, struct part *part)
{
    const struct params *p = s->params;
    part->bits = 0;
    for (int64_t w = part->first; w < part->last; w++) {
        const uint32_t byzantine = s->sets[BYZANTINE][w];
        if (p->faults.colluding)
            s->sets[SPEAKING][w] |= byzantine & s->sets[WORKING][w];
        const uint32_t speaking = s->sets[SPEAKING][w];
        part->bits += members(speaking) * p->radio.message_bits;
        lie_by_opinion(s, w);
        for (uint32_t left = p->strategy.knowledge.enabled ? speaking : 0; left; left = without_lowest(left)) {
            const int64_t i = lowest_member(w, left);
            defer(s, SPEAK, i, has_bit(byzantine, i) ? feasible_in(s->robots[LABEL][i]) : -1, 0);
        }
    }
    update_pending(s, SPEAK);
    if (p->radio.delay > 0)
        part->bits = delay_messages(s, part);
    if (p->acting.acts)
        speak_acting(s);
}

/* Let each robot's message be that of this step again, once delayed ones have been heard. */
static inline void take_own_messages(struct state *s, const struct part *part)
{
    for (int64_t i = WORD * part->first; i < WORD * part->last; i++)
        take_message(s, kept_message(s, s->clock->step, i), i);
}

/* Drop the delayed messages of a robot that stops or leaves. */
static inline void drop_delayed(struct state *s, int64_t i)
{
    for (int64_t step = 0; s->params->radio.delay > 0 && step <= s->params->radio.delay; step++)
        kept_message(s, step, i)[SAYS] = 0;
}

#endif

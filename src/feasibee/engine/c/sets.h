/* Sets of robots or tasks, labels, and opinions that robots hold. */

#ifndef SETS_H
#define SETS_H

#include "decisions.h"
#include "state.h"

#define WORD 32

ALWAYS bool has(const uint32_t *set, int64_t i) { return set[i >> 5] >> (i & 31) & 1; }
ALWAYS bool has_bit(uint32_t word, int64_t i) { return word >> (i & 31) & 1; }
ALWAYS uint32_t bit_if(bool member, int64_t i) { return (uint32_t)member << (i & 31); }
ALWAYS uint32_t without_lowest(uint32_t word) { return word & (word - 1); }
ALWAYS int64_t lowest_member(int64_t w, uint32_t word) { return WORD * w + lowest(word); }

ALWAYS void put_in(uint32_t *set, int64_t i, bool member)
{
    set[i >> 5] = (set[i >> 5] & ~bit((int)i)) | bit_if(member, i);
}

/* A label is the number of a robot or an id, and below it the opinion sent and whether it is sent. */
ALWAYS int32_t label(int64_t number, bool feasible, bool speaks)
{
    return (int32_t)((uint32_t)number << 2 | (uint32_t)feasible << 1 | (uint32_t)speaks);
}
ALWAYS int32_t sender_in(int32_t label) { return label >> 2; }
ALWAYS int64_t feasible_in(int32_t label) { return label >> 1 & 1; }

/* Return a robot's present label. */
ALWAYS int32_t label_of(const struct state *s, int64_t i)
{
    return label(i, has(s->sets[SAYS_FEASIBLE], i), has(s->sets[SPEAKING], i));
}

ALWAYS int opinion_of(const struct state *s, int64_t i)
{
    return has(s->sets[NEUTRAL], i) ? NO_OPINION : (int)has(s->sets[FOR_FEASIBLE], i);
}

/* Set a robot's opinion; any value but 1 and 0 means none. */
ALWAYS void set_opinion(struct state *s, int64_t i, int64_t opinion)
{
    put_in(s->sets[FOR_FEASIBLE], i, opinion == FEASIBLE);
    put_in(s->sets[NEUTRAL], i, opinion != FEASIBLE && opinion != INFEASIBLE);
}

/* Set a robot's opinion, unless it never changes it again: it is stubborn, or has declared. */
ALWAYS void adopt(struct state *s, int64_t i, int64_t opinion)
{
    if (!has(s->sets[STUBBORN], i) && !has(s->sets[DECLARED], i))
        set_opinion(s, i, opinion);
}

/* Let a robot declare an opinion, which is 1 or 0; it declares once only (model.md 6.15). */
ALWAYS void set_declared(struct state *s, int64_t i, int64_t opinion)
{
    if (has(s->sets[DECLARED], i))
        return;
    put_in(s->sets[DECLARED], i, true);
    put_in(s->sets[FOR_FEASIBLE_DECLARED], i, opinion == FEASIBLE);
}

#endif

/* Queues of pairs: a robot, and what it may see, hear or meet. They are worked off together. */

#ifndef QUEUE_H
#define QUEUE_H

#include "sets.h"

#define QUEUE_ROOM 512   /* entries from which on a queue is worked off; one robot may add all others to it */
#define PENDING_ROOM 256 /* calls of functions of a strategy that wait: see knowledge.h */
#define LINE 8           /* senders that an inbox holds before it takes a table: see messages.h */

/* Add a robot and each member of a word, whose lowest has number `first`; return how many pairs there are.
 *
 * Whole vectors are stored, with anything behind the members: a branch for each would often be mispredicted. */
ALWAYS int64_t list_members(struct part *part, int64_t listed, int64_t i, uint32_t members, int64_t first)
{
#if defined AVX512
    for (int k = 0; k < WORD; k += LANES) {
        const uint32_t some = members >> k & first_bits(LANES);
        const u32 who = spread((uint32_t)i), others = compressed(lanes_from((uint32_t)first + (uint32_t)k), some);
        memcpy(part->who + listed, &who, sizeof who);
        memcpy(part->other + listed, &others, sizeof others);
        listed += __builtin_popcount(some);
    }
#else
    for (; members; members = without_lowest(members), listed++) {
        part->who[listed] = (int32_t)i;
        part->other[listed] = (int32_t)(first + lowest(members));
    }
#endif
    return listed;
}

#endif

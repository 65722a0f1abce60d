/* Queues of pairs: a robot, and what it may see, hear or meet. They are worked off together. */

#ifndef QUEUE_H
#define QUEUE_H

#include "sets.h"

#define QUEUE_ROOM 512   /* entries from which on a queue is worked off; one robot may add all others to it */
#define PENDING_ROOM 256 /* calls of functions of a strategy that wait: see knowledge.h */
#define LINE 8           /* senders that an inbox holds before it takes a table: see messages.h */

/* Add a robot and each member of a word, whose lowest has number `first`; return how many pairs there are. */
ALWAYS int64_t list_members(struct part *part, int64_t listed, int64_t i, uint32_t members, int64_t first)
{
    for (; members; members = without_lowest(members), listed++) {
        part->who[listed] = (int32_t)i;
        part->other[listed] = (int32_t)(first + lowest(members));
    }
    return listed;
}

#endif

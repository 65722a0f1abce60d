/* Queues of pairs: a robot, and what it may see, hear or meet. They are worked off together. */

#ifndef QUEUE_H
#define QUEUE_H

#include "sets.h"

#define QUEUE_ROOM 512   /* entries from which on a queue is worked off; one robot may add all others to it */
#define PAIRS_OF_WORDS (WORD * WORD) /* that a word of robots has with another one at most */
#define PENDING_ROOM (512 + PAIRS_OF_WORDS) /* calls of a strategy's functions that wait at most */
#define LINE 8           /* senders that an inbox holds before it takes a table: see messages.h */

/* Write each robot of a word that is asked and each member of its set to two lists; return how many pairs these are.
 *
 * `sets` has the sets of the word's robots. One loop over pairs: an inner one for each robot would often be
 * mispredicted. */
ALWAYS int64_t write_pairs(int32_t *who, int32_t *other, const uint32_t *sets, int64_t w, uint32_t asked, int64_t first)
{
    int64_t written = 0;
    uint32_t some = 0;
    for (int k = 0; k < WORD; k += LANES)
        some |= (~equal(*(const u32 *)(sets + k), spread(0)) & first_bits(LANES)) << k;
    asked &= some;
    uint32_t left = asked ? sets[lowest(asked)] : 0;
    while (asked) {
        who[written] = (int32_t)lowest_member(w, asked);
        other[written++] = (int32_t)(first + lowest(left));
        left = without_lowest(left);
        asked = left ? asked : without_lowest(asked);
        left = left ? left : sets[lowest(asked | bit(WORD - 1))];
    }
    return written;
}

#endif

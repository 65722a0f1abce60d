/* Estimate: a tally that knows that nobody sees itself. */

#include "tally.h"

#if FEASIBEE_WORDS > 0

/* Write both sides of the comparison: the sums of k rows, times 2k + 1 for robots and 2k - 2 for tasks. */
static inline void feasibee_estimate_count(struct feasibee_robot *robot, uint32_t *robots, uint32_t *tasks)
{
    uint64_t totals[2] = {0, 0};
    uint32_t rows = 0;
    for (uint32_t k = 0; k < feasibee_tally_words(robot->settings->setting); k += 2) {
        totals[0] += robot->known[k];
        totals[1] += robot->known[k + 1];
        rows += (robot->known[k] | robot->known[k + 1]) != 0;
    }
    feasibee_write_counts(totals[0] * (2 * rows + 1), rows == 0 ? 0 : totals[1] * (2 * rows - 2), robots,
                          tasks);
}

static const struct feasibee_knowledge feasibee_estimate_knowledge = {
    NULL,
    feasibee_tally_observe,
    feasibee_tally_encode,
    feasibee_tally_merge,
    feasibee_estimate_count,
    NULL,
    NULL,
    NULL,
    feasibee_tally_words,
    feasibee_tally_words,
    feasibee_tally_pack,
    feasibee_tally_unpack,
    0,
};

static const struct feasibee_strategy feasibee_estimate = {
    true,
    false,
    false,
    false,
    feasibee_share_of_robots,
    NULL,
    NULL,
    feasibee_more,
    &feasibee_estimate_knowledge,
};

#endif

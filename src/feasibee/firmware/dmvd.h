/* DMVD: broadcasts in proportion to quality, then one of the opinions heard at random. */

#include "rules.h"

static const struct feasibee_strategy feasibee_dmvd = {
    true, false, false, true, feasibee_share_of_robots, NULL, NULL, feasibee_one_vote, NULL,
};

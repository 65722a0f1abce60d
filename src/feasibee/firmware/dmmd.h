/* DMMD: broadcasts in proportion to quality, then the majority of the opinions heard. */

#include "rules.h"

static const struct feasibee_strategy feasibee_dmmd = {
    true, false, false, true, feasibee_share_of_robots, NULL, NULL, feasibee_majority_of, NULL,
};

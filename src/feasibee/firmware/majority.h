/* Majority: broadcasts whatever the quality, then the majority of the opinions heard. */

#include "rules.h"

static const struct feasibee_strategy feasibee_majority = {
    true, false, false, false, feasibee_share_of_robots, NULL, NULL, feasibee_majority_of, NULL,
};

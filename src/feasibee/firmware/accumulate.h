/* Accumulate: dmmd with counts that run over the robot's life. */

#include "rules.h"

static const struct feasibee_strategy feasibee_accumulate = {
    false, false, false, true, feasibee_share_of_robots, NULL, NULL, feasibee_majority_of, NULL,
};

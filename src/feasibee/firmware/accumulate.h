/* Accumulate: dmmd with counts that run over the robot's life. */

#include "rules.h"

static const struct feasibee_strategy feasibee_accumulate = {
    /* forgets */ false, /* starts_neutral */ false, /* sends_value */ false, /* modulates */ true,
    feasibee_share_of_robots, /* say */ NULL, /* value */ NULL,
    feasibee_majority_of, /* knowledge */ NULL,
};

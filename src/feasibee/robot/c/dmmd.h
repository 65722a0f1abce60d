/* DMMD: broadcasts in proportion to quality, then the majority of the opinions heard. */

#include "rules.h"

static const struct feasibee_strategy feasibee_dmmd = {
    /* forgets */ true, /* starts_neutral */ false, /* sends_value */ false, /* modulates */ true,
    feasibee_share_of_robots, /* say */ NULL, /* value */ NULL,
    feasibee_majority_of, /* knowledge */ NULL,
};

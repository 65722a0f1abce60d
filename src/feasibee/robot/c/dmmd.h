/* DMMD: broadcasts in proportion to quality, then the majority of the opinions heard. */

#include "rules.h"

static const struct feasibee_strategy feasibee_dmmd = {
    /* forgets */ true, /* starts_neutral */ false, /* value_bits */ 0, /* modulates */ true,
    feasibee_share_of_robots, /* say */ NULL, /* value */ NULL, /* lasting */ NULL,
    feasibee_majority_of, /* knowledge */ NULL,
};

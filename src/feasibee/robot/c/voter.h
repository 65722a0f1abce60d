/* Voter: broadcasts whatever the quality, then one of the opinions heard at random. */

#include "rules.h"

static const struct feasibee_strategy feasibee_voter = {
    /* forgets */ true, /* starts_neutral */ false, /* value_bits */ 0, /* modulates */ false,
    feasibee_share_of_robots, /* say */ NULL, /* value */ NULL, /* lasting */ NULL,
    feasibee_one_vote, /* knowledge */ NULL,
};

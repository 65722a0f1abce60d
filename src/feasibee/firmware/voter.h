/* Voter: broadcasts whatever the quality, then one of the opinions heard at random. */

#include "rules.h"

static const struct feasibee_strategy feasibee_voter = {
    true, false, false, false, feasibee_share_of_robots, NULL, NULL, feasibee_one_vote, NULL,
};

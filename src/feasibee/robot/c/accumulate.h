/* Accumulate: dmmd with counts that run over the robot's life. */

#include "rules.h"

static inline int8_t feasibee_accumulate_decide(struct feasibee_robot *robot,
                                                const struct feasibee_votes *votes)
{
    feasibee_bound_counts(robot);
    return feasibee_majority_of(robot, votes);
}

static const struct feasibee_strategy feasibee_accumulate = {
    /* forgets */ false, /* starts_neutral */ false, /* value_bits */ 0, /* modulates */ true,
    feasibee_share_of_robots, /* say */ NULL, /* value */ NULL, /* lasting */ NULL,
    feasibee_accumulate_decide, /* knowledge */ NULL,
};

/* Accumulate: dmmd with counts that run over the robot's life. */

#include "rules.h"

static inline int8_t feasibee_accumulate_decide(struct feasibee_robot *robot,
                                                const struct feasibee_votes *votes)
{
    feasibee_bound_counts(robot);
    return feasibee_majority_of(robot, votes);
}

static const struct feasibee_strategy feasibee_accumulate = {
    /* forgets */ false, /* starts_neutral */ false, /* sends_value */ false, /* modulates */ true,
    feasibee_share_of_robots, /* say */ NULL, /* value */ NULL,
    feasibee_accumulate_decide, /* knowledge */ NULL,
};

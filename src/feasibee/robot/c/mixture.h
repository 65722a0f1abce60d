/* Mixture: voters among majority robots. At its first decision a robot is made one of both, for life. */

#include "rules.h"

enum { FEASIBEE_VOTER = 1, FEASIBEE_MAJORITY = 2 };

static inline int8_t feasibee_mixture_decide(struct feasibee_robot *robot, const struct feasibee_votes *votes)
{
    if (robot->memory.rule == 0)
        robot->memory.rule =
            votes->chance < robot->settings->parameters.voters ? FEASIBEE_VOTER : FEASIBEE_MAJORITY;
    if (robot->memory.rule == FEASIBEE_VOTER)
        return feasibee_one_vote(robot, votes);
    return feasibee_majority_of(robot, votes);
}

static const struct feasibee_strategy feasibee_mixture = {
    /* forgets */ true, /* starts_neutral */ false, /* value_bits */ 0, /* modulates */ true,
    feasibee_share_of_robots, /* say */ NULL, /* value */ NULL, /* lasting */ NULL,
    feasibee_mixture_decide, /* knowledge */ NULL,
};

/* Cross-inhibition: who hears the other opinion has none from then on, and is silent until it hears one. */

#include "rules.h"

static inline int8_t feasibee_cross_inhibition_decide(struct feasibee_robot *robot,
                                                      const struct feasibee_votes *votes)
{
    if (votes->heard == FEASIBEE_NONE)
        return robot->opinion;
    if (robot->opinion == FEASIBEE_NONE)
        return votes->heard;
    return votes->heard == robot->opinion ? robot->opinion : (int8_t)FEASIBEE_NONE;
}

static const struct feasibee_strategy feasibee_cross_inhibition = {
    /* forgets */ true, /* starts_neutral */ false, /* value_bits */ 0, /* modulates */ true,
    feasibee_share_of_robots, /* say */ NULL, /* value */ NULL, /* lasting */ NULL,
    feasibee_cross_inhibition_decide, /* knowledge */ NULL,
};

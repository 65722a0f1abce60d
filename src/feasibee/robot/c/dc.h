/* DC: broadcasts opinion and quality; takes the opinion of a random message if its quality is higher. */

#include "numbers.h"
#include "rules.h"

/* Return whether the quality in the drawn message is higher than that of the robot's opinion. */
static inline bool feasibee_heard_higher(struct feasibee_robot *robot, const struct feasibee_votes *votes)
{
#ifdef FEASIBEE_DOUBLE
    double heard = votes->value / 65535.0, own = feasibee_double(robot->feasible_quality);
    return (votes->heard == FEASIBEE_FEASIBLE ? heard : 1.0 - heard) >
           (robot->opinion == FEASIBEE_FEASIBLE ? own : 1.0 - own);
#else
    struct feasibee_ratio own = robot->feasible_quality;
    uint16_t heard = votes->heard == FEASIBEE_FEASIBLE ? votes->value : (uint16_t)(65535 - votes->value);
    if (robot->opinion != FEASIBEE_FEASIBLE)
        own.part = own.whole - own.part;
    return (uint64_t)heard * own.whole > (uint64_t)own.part * 65535;
#endif
}

static inline int8_t feasibee_dc_decide(struct feasibee_robot *robot, const struct feasibee_votes *votes)
{
    if (votes->heard != FEASIBEE_NONE && feasibee_heard_higher(robot, votes))
        return votes->heard;
    return robot->opinion;
}

static const struct feasibee_strategy feasibee_dc = {
    /* forgets */ true, /* starts_neutral */ false, /* value_bits */ 16, /* modulates */ false,
    feasibee_share_of_robots, /* say */ NULL, /* value */ NULL, /* lasting */ NULL,
    feasibee_dc_decide, /* knowledge */ NULL,
};

/* Average: gossip averaging of the log ratio of all evidence. Needs floating point and log. */

#include "rules.h"

#ifndef FEASIBEE_LOG
#include <math.h>
#define FEASIBEE_LOG log
#endif

/* Return the quality of feasible, half a sighting of each added, so that it is never 0 or 1. */
static inline struct feasibee_ratio feasibee_average_quality(feasibee_amount robots, feasibee_amount tasks)
{
    struct feasibee_ratio share = {2 * robots + 1, 2 * (robots + tasks + 1)};
    return share;
}

static inline double feasibee_average_evidence(const struct feasibee_robot *robot)
{
    double feasible = (double)robot->feasible_quality.part / (double)robot->feasible_quality.whole;
    return FEASIBEE_LOG(feasible / (1.0 - feasible));
}

/* Return x as a share of the way from -16 to 16; before the first decision, that of the evidence. */
static inline uint16_t feasibee_average_value(struct feasibee_robot *robot)
{
    double x = robot->memory.average.decided ? robot->memory.average.x : feasibee_average_evidence(robot);
    double value = x / 32.0 + 0.5;
    value = value < 0.0 ? 0.0 : value > 1.0 ? 1.0 : value;
    return (uint16_t)(value * 65535.0 + 0.5);
}

static inline int8_t feasibee_average_decide(struct feasibee_robot *robot, const struct feasibee_votes *votes)
{
    uint32_t heard = (uint32_t)votes->feasible + votes->infeasible;
    double mean = heard > 0 ? (double)votes->sum / ((double)heard * 65535.0) : 0.0;
    double sum = feasibee_average_evidence(robot) + (double)heard * (mean - 0.5) * 32.0;
    double x = sum / (1.0 + (double)heard);
    robot->memory.average.x = x;
    robot->memory.average.decided = true;
    feasibee_bound_counts(robot);
    if (x == 0.0)
        return robot->opinion;
    return x > 0.0 ? FEASIBEE_FEASIBLE : FEASIBEE_INFEASIBLE;
}

static const struct feasibee_strategy feasibee_average = {
    /* forgets */ false, /* starts_neutral */ false, /* value_bits */ 16, /* modulates */ false,
    feasibee_average_quality, /* say */ NULL, feasibee_average_value, /* lasting */ NULL,
    feasibee_average_decide, /* knowledge */ NULL,
};

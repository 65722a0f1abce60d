/* Bayes Bots: counts observations, its own and others', until it is sure. Needs floating point. */

#include "rules.h"

/* Return what the last exploration showed: 1 more robots than tasks, 0 fewer, -1 as many. */
static inline int8_t feasibee_bayes_observation(const struct feasibee_robot *robot)
{
    feasibee_amount part = robot->feasible_quality.part, rest = robot->feasible_quality.whole - part;
    if (part == rest)
        return FEASIBEE_NONE;
    return part > rest ? FEASIBEE_FEASIBLE : FEASIBEE_INFEASIBLE;
}

static inline int8_t feasibee_bayes_say(struct feasibee_robot *robot)
{
    if (robot->settings->parameters.positive_feedback && robot->opinion != FEASIBEE_NONE)
        return robot->opinion;
    return feasibee_bayes_observation(robot);
}

/* Return the probability that so many fair coins show at least so many heads, more than half of them: a sum
 * that starts at its largest term, kept near 1 while it is multiplied out. */
static inline double feasibee_bayes_tail(double coins, double heads)
{
    double term = 1.0, factors = 0.0, halves = coins, tail = 0.0;
    while (factors < coins - heads || halves > 0.0) {
        if (halves > 0.0 && (term > 1.0 || factors == coins - heads)) {
            halves -= 1.0;
            term *= 0.5;
        } else {
            factors += 1.0;
            term *= (heads + factors) / factors;
        }
    }
    while (heads <= coins && term > 0.0) {
        tail += term;
        heads += 1.0;
        term *= (coins - heads + 1.0) / heads;
    }
    return tail;
}

static inline int8_t feasibee_bayes_decide(struct feasibee_robot *robot, const struct feasibee_votes *votes)
{
    if (robot->opinion != FEASIBEE_NONE)
        return robot->opinion;
    int8_t observed = feasibee_bayes_observation(robot);
    robot->memory.bayes.feasible += (uint32_t)votes->feasible + (observed == FEASIBEE_FEASIBLE);
    robot->memory.bayes.infeasible += (uint32_t)votes->infeasible + (observed == FEASIBEE_INFEASIBLE);
    double alpha = (double)robot->memory.bayes.feasible + 1.0;
    double beta = (double)robot->memory.bayes.infeasible + 1.0;
    double tail = feasibee_bayes_tail(alpha + beta - 1.0, alpha > beta ? alpha : beta);
    if (alpha != beta && tail < 1.0 - robot->settings->parameters.credence)
        return alpha > beta ? FEASIBEE_FEASIBLE : FEASIBEE_INFEASIBLE;
    return FEASIBEE_NONE;
}

static const struct feasibee_strategy feasibee_bayes = {
    /* forgets */ true, /* starts_neutral */ true, /* value_bits */ 0, /* modulates */ false,
    feasibee_share_of_robots, feasibee_bayes_say, /* value */ NULL, /* lasting */ NULL,
    feasibee_bayes_decide, /* knowledge */ NULL,
};

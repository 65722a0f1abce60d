/* Rules that several strategies share. */

#include "controller.h"

/* Return the quality of feasible: n_obs / (n_obs + m_obs), or 1/2 with nothing seen (eq. 1). */
static inline struct feasibee_ratio feasibee_share_of_robots(feasibee_amount robots, feasibee_amount tasks)
{
    struct feasibee_ratio half = {1, 2}, share = {robots, robots + tasks};
    return share.whole == 0 ? half : share;
}

/* Return the majority of the votes; a tie keeps the opinion, or takes a random message. */
static inline int8_t feasibee_majority_of(struct feasibee_robot *robot, const struct feasibee_votes *votes)
{
    uint8_t own = robot->settings->own_vote ? 1 : 0;
    uint32_t feasible = (uint32_t)votes->feasible + (robot->opinion == FEASIBEE_FEASIBLE ? own : 0);
    uint32_t infeasible = (uint32_t)votes->infeasible + (robot->opinion == FEASIBEE_INFEASIBLE ? own : 0);
    if (feasible > infeasible)
        return FEASIBEE_FEASIBLE;
    if (feasible < infeasible)
        return FEASIBEE_INFEASIBLE;
    return robot->settings->random_ties && votes->heard != FEASIBEE_NONE ? votes->heard : robot->opinion;
}

/* Return a random opinion of those heard, or the robot's own if none was heard. */
static inline int8_t feasibee_one_vote(struct feasibee_robot *robot, const struct feasibee_votes *votes)
{
    return votes->heard == FEASIBEE_NONE ? robot->opinion : votes->heard;
}

/* Rules that several strategies share. */

#include "controller.h"

/* Return the quality of feasible: n_obs / (n_obs + m_obs), or 1/2 with nothing seen (eq. 1). */
static inline struct feasibee_ratio feasibee_share_of_robots(uint32_t robots, uint32_t tasks)
{
    struct feasibee_ratio half = {1, 2}, share = {robots, robots + tasks};
    return share.whole == 0 ? half : share;
}

/* Return the majority of the votes; a tie keeps the opinion. */
static inline int8_t feasibee_majority_of(struct feasibee_robot *robot, const struct feasibee_votes *votes)
{
    uint8_t own = robot->settings->own_vote ? 1 : 0;
    uint32_t feasible = (uint32_t)votes->feasible + (robot->opinion == FEASIBEE_FEASIBLE ? own : 0);
    uint32_t infeasible = (uint32_t)votes->infeasible + (robot->opinion == FEASIBEE_INFEASIBLE ? own : 0);
    if (feasible > infeasible)
        return FEASIBEE_FEASIBLE;
    if (feasible < infeasible)
        return FEASIBEE_INFEASIBLE;
    return robot->opinion;
}

/* Halve both counts of a life long before their sum overflows: their ratio stays. */
static inline void feasibee_bound_counts(struct feasibee_robot *robot)
{
    if ((robot->robots_seen | robot->tasks_seen) >> 29) {
        robot->robots_seen /= 2;
        robot->tasks_seen /= 2;
    }
}

/* Return a random opinion of those heard, or the robot's own if none was heard. */
static inline int8_t feasibee_one_vote(struct feasibee_robot *robot, const struct feasibee_votes *votes)
{
    return votes->heard == FEASIBEE_NONE ? robot->opinion : votes->heard;
}

/* Return feasible if as many robots as tasks are counted, or more. */
static inline int8_t feasibee_at_least(struct feasibee_robot *robot, const struct feasibee_votes *votes)
{
    (void)votes;
    uint32_t robots = robot->feasible_quality.part, tasks = robot->feasible_quality.whole - robots;
    return robots >= tasks ? FEASIBEE_FEASIBLE : FEASIBEE_INFEASIBLE;
}

/* Return the opinion that has more on its side; a tie keeps the robot's. */
static inline int8_t feasibee_more(struct feasibee_robot *robot, const struct feasibee_votes *votes)
{
    (void)votes;
    uint32_t robots = robot->feasible_quality.part, tasks = robot->feasible_quality.whole - robots;
    if (robots == tasks)
        return robot->opinion;
    return robots > tasks ? FEASIBEE_FEASIBLE : FEASIBEE_INFEASIBLE;
}

static inline int8_t feasibee_keep_opinion(struct feasibee_robot *robot, const struct feasibee_votes *votes)
{
    (void)votes;
    return robot->opinion;
}

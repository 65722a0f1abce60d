/* k-unanimity: takes the opinion on which k of the messages heard agree, drawn without replacement. */

#include "numbers.h"
#include "rules.h"

#ifdef FEASIBEE_DOUBLE

/* Return the probability that k messages of so many are all among these; each operation as in Python. */
static inline double feasibee_all_among(uint16_t these, uint16_t all, uint16_t k)
{
    double probability = 1.0;
    for (uint16_t drawn = 0; drawn < k; drawn++)
        probability *= (double)(these > drawn ? these - drawn : 0) / (double)(all - drawn);
    return probability;
}

static inline bool feasibee_all_feasible(const struct feasibee_votes *votes, uint16_t all, uint16_t k)
{
    return (double)votes->chance / 4294967296.0 < feasibee_all_among(votes->feasible, all, k);
}

static inline bool feasibee_all_infeasible(const struct feasibee_votes *votes, uint16_t all, uint16_t k)
{
    return (double)votes->chance / 4294967296.0 >= 1.0 - feasibee_all_among(votes->infeasible, all, k);
}

#else

/* Return the probability that k messages of so many are all among these, in 1/2^32, for these < all. Each of
 * the 2 k roundings makes it less by up to 1/2^32. */
static inline uint32_t feasibee_all_among(uint16_t these, uint16_t all, uint16_t k)
{
    uint32_t probability = UINT32_MAX;
    if (these < k)
        return 0;
    for (uint16_t drawn = 0; drawn < k; drawn++) {
        uint32_t share = feasibee_fraction((uint32_t)(these - drawn), (uint32_t)(all - drawn));
        probability = feasibee_times(probability, share);
    }
    return probability;
}

static inline bool feasibee_all_feasible(const struct feasibee_votes *votes, uint16_t all, uint16_t k)
{
    return votes->infeasible == 0 || votes->chance < feasibee_all_among(votes->feasible, all, k);
}

static inline bool feasibee_all_infeasible(const struct feasibee_votes *votes, uint16_t all, uint16_t k)
{
    return votes->feasible == 0 || UINT32_MAX - votes->chance < feasibee_all_among(votes->infeasible, all, k);
}

#endif

static inline int8_t feasibee_k_unanimity_decide(struct feasibee_robot *robot,
                                                 const struct feasibee_votes *votes)
{
    uint16_t k = robot->settings->parameters.k;
    uint16_t all = (uint16_t)(votes->feasible + votes->infeasible);
    if (all < k)
        return robot->opinion;
    if (feasibee_all_feasible(votes, all, k))
        return FEASIBEE_FEASIBLE;
    if (feasibee_all_infeasible(votes, all, k))
        return FEASIBEE_INFEASIBLE;
    return robot->opinion;
}

static const struct feasibee_strategy feasibee_k_unanimity = {
    /* forgets */ true, /* starts_neutral */ false, /* value_bits */ 0, /* modulates */ true,
    feasibee_share_of_robots, /* say */ NULL, /* value */ NULL, /* lasting */ NULL,
    feasibee_k_unanimity_decide, /* knowledge */ NULL,
};

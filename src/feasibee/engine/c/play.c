/* What Python calls: runs of a swarm of any size. */

#include "crowd.h"
#include "few.h"

int64_t feasibee_play(const struct params *params, const struct rules *rules, const struct setting *setting,
                      int64_t memory, int64_t first_run, const struct outcome *outcome, struct control *control)
{
    const struct job job = {params, rules, setting, outcome, control, memory};
    return params->robots.count > FEW ? crowd_play(&job, first_run) : few_play(&job, first_run);
}

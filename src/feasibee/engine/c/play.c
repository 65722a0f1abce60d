/* What Python calls: is a world one of the engine's, and what comes of runs of a swarm of any size. */

#include "crowd.h"
#include "few.h"
#include "lists.h"

#define MOST_ROBOTS (INT64_C(1) << 24) /* whose numbers fit into labels */
#define MOST_TASKS (INT64_C(1) << 26)
#define MOST_CELLS (INT64_C(1) << 14) /* along an axis */
#define MOST_COUNTED UINT32_MAX       /* robots that one of few can see in a run */

static bool lies(int64_t number, int64_t least, int64_t most) { return least <= number && number <= most; }

/* Return whether a grid is one of a square torus, and its half cells are at least as long as a range. */
static bool has_grid(const struct grid *grid, uint64_t limit)
{
    if (!lies(grid->columns, 1, MOST_CELLS) || grid->rows != grid->columns)
        return false;
    const uint64_t half = (UINT64_C(1) << 31) / (uint64_t)grid->columns;
    return grid->half_width == (int64_t)half && limit <= half * half + 1;
}

/* Return whether each cell's list finds all tasks in its range, and none twice. */
static bool has_lists(const struct list *lists, uint64_t limit)
{
    if (lists->bits == 0)
        return lists->shift == 16;
    return lies(lists->bits, 2, 4) && lists->shift <= 16 && limit <= UINT64_C(1) << 62 &&
           columns_in_range(limit, (int)lists->bits) < 1 << (lists->bits - 1);
}

bool feasibee_has(const struct params *params)
{
    const int64_t robots = params->robots.count, steps = params->run.steps;
    const uint64_t sight = params->sensing.limit, radio = params->radio.limit;
    if (!lies(robots, 1, MOST_ROBOTS) || !lies(params->tasks.count, 0, MOST_TASKS) || !lies(steps, 0, INT32_MAX))
        return false;
    if (!lies(params->sensing.count_self, 0, 1) || !lies(params->decision.dissemination_floor, 0, INT32_MAX) ||
        !lies(params->decision.quorum.whole, 1, MOST_ROBOTS) || !lies(params->decision.quorum.share, 0, MOST_ROBOTS) ||
        !lies(params->radio.message_bits, 0, INT32_MAX))
        return false;
    if (robots <= FEW)
        return has_lists(&params->tasks.lists, sight) && robots * steps <= MOST_COUNTED;
    return has_grid(&params->robots.grid, sight > radio ? sight : radio) && has_grid(&params->tasks.grid, sight);
}

int64_t feasibee_play(const struct params *params, const struct rules *rules, const struct setting *setting,
                      int64_t memory, int64_t first_run, const struct outcome *outcome, struct control *control)
{
    const struct job job = {params, rules, setting, outcome, control, memory};
#ifndef __wasm__
    if (params->robots.count > FEW)
        return crowd_play(&job, first_run);
#endif
    return few_play(&job, first_run);
}

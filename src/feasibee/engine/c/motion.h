/* Motion in any world: straight runs of exponential duration, and uniform headings (model.md 2). */

#ifndef MOTION_H
#define MOTION_H

#include "chance.h"
#include "queue.h"

#define COS_EIGHTH INT64_C(3037000499) /* cosine of an eighth of a turn, in units of 2**-32, rounded down */
#define NEVER_AGAIN INT32_MAX          /* steps left until a stopped robot turns or ends its phase */

/* Return a length times the cosine of an eighth of a turn, rounded towards 0. */
ALWAYS int64_t shortened(int64_t length) { return (length * COS_EIGHTH + ((length >> 63) & 0xFFFFFFFF)) >> 32; }

ALWAYS void set_heading(struct state *s, int64_t i, int32_t x, int32_t y, int32_t lasts)
{
    s->robots[WALKS][i]++;
    s->robots[STEP_X][i] = x;
    s->robots[STEP_Y][i] = y;
    s->robots[WALK_LEFT][i] = lasts;
}

/* Let robots take their next headings, drawn several at a time (model.md 2.1). */
static inline void draw_and_take(struct state *s, struct source from, const int32_t *who, int64_t count)
{
    const double reach = s->params->robots.reach, mean = s->params->walk.mean_run;
    for (int64_t first = 0; first < count; first += PAIRS) {
        const int64_t lanes = count - first < PAIRS ? count - first : PAIRS;
        u64 counter = {0}, robot = {0};
        for (int64_t k = 0; k < lanes; k++) {
            counter[k] = (uint32_t)s->robots[WALKS][who[first + k]];
            robot[k] = (uint32_t)who[first + k];
        }
        const struct headings drawn = draw_headings(from, counter, robot, reach, mean);
        for (int64_t k = 0; k < lanes; k++) {
            const int32_t lasts = drawn.doubtful[k] ? duration((uint32_t)drawn.word[k], mean) : (int32_t)drawn.lasts[k];
            set_heading(s, who[first + k], (int32_t)drawn.x[k], (int32_t)drawn.y[k], lasts);
        }
    }
}

/* Let a robot take its next heading from its pool. */
ALWAYS void take_from_pool(struct state *s, struct source from, int64_t i)
{
    struct heading_pool *pool = (struct heading_pool *)s->heading_pools + i;
    const uint32_t walks = (uint32_t)s->robots[WALKS][i], place = walks % POOL;
    if (place == 0)
        fill_headings(pool, from, (uint32_t)i, walks, s->params->robots.reach, s->params->walk.mean_run);
    set_heading(s, i, pool->x[place], pool->y[place], pool->lasts[place]);
}

static inline void take_headings(struct state *s, const int32_t *who, int64_t count)
{
    const struct source from = source_of(s->params, s->clock->run, WALK);
    if (!s->heading_pools)
        draw_and_take(s, from, who, count);
    else
        for (int64_t k = 0; k < count; k++)
            take_from_pool(s, from, who[k]);
}

/* Let each robot of a part whose straight run has ended take a heading. */
ALWAYS void turn_all(struct state *s, struct part *part)
{
    int64_t listed = 0;
    for (int64_t w = part->first; w < part->last; w++)
        for (uint32_t left = s->sets[TURNING][w]; left; left = without_lowest(left))
            part->who[listed++] = (int32_t)lowest_member(w, left);
    take_headings(s, part->who, listed);
}

/* Let a robot neither move nor end a phase again. */
ALWAYS void stand_still(struct state *s, int64_t i)
{
    s->robots[WALK_LEFT][i] = s->robots[PHASE_LEFT][i] = NEVER_AGAIN;
    s->robots[STEP_X][i] = s->robots[STEP_Y][i] = 0;
}

/* Move all robots of a part one step on a square torus, through each other (model.md 3.1). */
ALWAYS void move_freely(struct state *s, const struct part *part)
{
    int32_t *restrict x = s->robots[X], *restrict y = s->robots[Y];
    const int32_t *restrict step_x = s->robots[STEP_X], *restrict step_y = s->robots[STEP_Y];
    for (int64_t i = WORD * part->first; i < WORD * part->last; i++) {
        x[i] = (int32_t)((uint32_t)x[i] + (uint32_t)step_x[i]);
        y[i] = (int32_t)((uint32_t)y[i] + (uint32_t)step_y[i]);
    }
}

/* Advance the timers; find whose heading and whose phase end with this step (model.md 3.3). */
ALWAYS void tick(struct state *s, const struct part *part)
{
    int32_t *restrict walk_left = s->robots[WALK_LEFT], *restrict phase_left = s->robots[PHASE_LEFT];
    for (int64_t w = part->first; w < part->last; w++) {
        uint32_t turning = 0, ending = 0;
        UNROLL for (int k = 0; k < WORD; k += LANES) {
            i32 *walks = (i32 *)(walk_left + WORD * w + k), *phases = (i32 *)(phase_left + WORD * w + k);
            *walks -= 1;
            *phases -= 1;
            turning |= equal((u32)*walks, spread(0)) << k;
            ending |= equal((u32)*phases, spread(0)) << k;
        }
        s->sets[TURNING][w] = turning | s->sets[BLOCKED][w];
        s->sets[ENDING][w] = ending;
    }
}

#endif

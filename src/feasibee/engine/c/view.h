/* What a robot sees of what is in range: not behind walls, and within its view (model.md 6.20, 6.22). */

#ifndef VIEW_H
#define VIEW_H

#include "near.h"
#include "place.h"

/* Return whether a point is ahead of a robot, within half the angle of view. */
static inline bool is_in_view(const struct state *s, int64_t i, int32_t *const *points, int64_t k)
{
    const struct arena *arena = &s->params->arena;
    const struct sensing *sensing = &s->params->sensing;
    const int64_t x = short_way(s->robots[X][i], points[POINT_X][k], arena->width, arena->walls);
    const int64_t y = short_way(s->robots[Y][i], points[POINT_Y][k], arena->height, arena->walls);
    const int64_t u = s->robots[STEP_X][i], v = s->robots[STEP_Y][i], along = u * x + v * y;
    return (double)along * sensing->view_sine >= (double)distance(u * y, v * x) * sensing->view_cosine;
}

/* Leave robots out of the sets in IN_SIGHT that are in range but not seen by those that look. */
APART void drop_hidden(struct state *s, struct part *part, const uint32_t *looking)
{
    const uint32_t *there = s->sets[THERE];
    if (s->params->arena.place.exists)
        drop_cut(s, part, SIGHT, s->params->radio.as_sight ? there : looking, there);
    if (!s->params->sensing.ahead)
        return;
    for (int64_t other = 0; other < s->words; other++)
        for (int64_t i = 0; i < s->params->robots.count; i++) {
            uint32_t *sight = &s->links[IN_SIGHT][other * s->padded + i];
            for (uint32_t left = has(looking, i) ? *sight : 0; left; left = without_lowest(left))
                if (!is_in_view(s, i, s->robots, lowest_member(other, left)))
                    *sight &= ~bit(lowest(left));
        }
}

/* Return which tasks of a word, all in range of a robot, it sees. */
APART uint32_t seen_tasks(const struct state *s, uint32_t tasks, int64_t w, int64_t i)
{
    if (s->params->arena.place.exists)
        tasks = visible_tasks(s, tasks, w, s->robots[X][i], s->robots[Y][i]);
    for (uint32_t left = s->params->sensing.ahead ? tasks : 0; left; left = without_lowest(left))
        if (!is_in_view(s, i, s->tasks, lowest_member(w, left)))
            tasks &= ~bit(lowest(left));
    return tasks;
}

/* Keep those pairs of the queue of which the first sees, or hears, the second; return their number.
 *
 * `packed` says that numbers are those of robots in cells: twice the robot's, and whether it broadcasts. */
APART int64_t keep_reached(const struct state *s, struct part *part, int32_t *const *points, enum sense sense,
                           int64_t queued, bool packed)
{
    const bool ahead = s->params->sensing.ahead && sense == SIGHT, place = s->params->arena.place.exists;
    int64_t kept = 0;
    for (int64_t k = 0; k < queued; k++) {
        const int32_t i = part->who[k], other = part->other[k], j = packed ? other >> 1 : other;
        bool reached = !ahead || is_in_view(s, i, points, j);
        if (reached && place)
            reached = !is_cut(s, sense, at_x(s->robots, i), at_y(s->robots, i), at_x(points, j), at_y(points, j));
        part->who[kept] = i;
        part->other[kept] = other;
        kept += reached;
    }
    return kept;
}

#endif

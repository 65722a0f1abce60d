/* Where robots and tasks are placed (model.md 1, 6.4, 6.17, 6.20). */

#ifndef PLACING_H
#define PLACING_H

#include "chance.h"
#include "near.h"

#define ATTEMPTS 256 /* random places that are tried before one with room is computed: feasibee.base.codes */
#define UNSORTED 512 /* robots that are placed before they are sorted into cells */

enum placing { ANYWHERE_AT_RANDOM, IN_CLUSTERS, AT_POINTS }; /* how robots or tasks are placed (model.md 6.4) */

struct point_at {
    int64_t x, y;
};

/* The purposes of the draws of a place: uniform, of a centre, which cluster, offset from the centre. */
struct purposes {
    int64_t uniform, centre, cluster, scatter;
};

static const struct purposes OF_ROBOTS = {PLACE_ROBOT, CENTRE_ROBOT, CLUSTER_ROBOT, SCATTER_ROBOT};
static const struct purposes OF_TASKS = {PLACE_TASK, CENTRE_TASK, CLUSTER_TASK, SCATTER_TASK};

/* Store the place of a robot or task. */
ALWAYS void put(int32_t *const *points, int64_t i, int64_t x, int64_t y)
{
    points[X][i] = (int32_t)(uint32_t)x;
    points[Y][i] = (int32_t)(uint32_t)y;
}

ALWAYS int64_t wrapped_into(int64_t coordinate, int64_t side)
{
    const int64_t rest = coordinate % side;
    return rest < 0 ? rest + side : rest;
}

ALWAYS int64_t kept_between(int64_t coordinate, int64_t low, int64_t high)
{
    const int64_t least = coordinate > low ? coordinate : low;
    return least < high ? least : high;
}

/* Return a uniform place. */
static struct point_at anywhere(const struct state *s, const struct placement *placing, int64_t i, int64_t counter,
                                int64_t purpose)
{
    const struct arena *arena = &s->params->arena;
    const struct words drawn = draw_words(s, i, counter, purpose);
    const int64_t low = arena->walls ? placing->margin : 0;
    return (struct point_at){low + choose(drawn.word[0], arena->width - 2 * low),
                             low + choose(drawn.word[1], arena->height - 2 * low)};
}

/* Return the place drawn for a robot or task at an attempt; within walls, clipped to the arena.
 *
 * `joined` is the number of robots that had its number before it. */
static struct point_at candidate(const struct state *s, const struct placement *placing, int64_t i, int64_t joined,
                                 int64_t attempt, const struct purposes *purposes)
{
    const struct arena *arena = &s->params->arena;
    const int64_t counter = ATTEMPTS * joined + attempt, low = placing->margin;
    if (placing->how == ANYWHERE_AT_RANDOM)
        return anywhere(s, placing, i, counter, purposes->uniform);
    const int64_t chosen = choose(draw(s, i, joined, purposes->cluster), placing->clusters);
    struct point_at at = anywhere(s, placing, chosen, 0, purposes->centre);
    const int64_t spread = placing->spread * (1 + attempt / 32); /* wider after each 32 failed attempts */
    at.x += normal(s, i, 6 * counter, purposes->scatter, spread);
    at.y += normal(s, i, 6 * counter + 3, purposes->scatter, spread);
    if (!arena->walls)
        return (struct point_at){wrapped_into(at.x, arena->width), wrapped_into(at.y, arena->height)};
    at.x = kept_between(at.x, low, arena->width - low);
    at.y = kept_between(at.y, low, arena->height - low);
    return at;
}

/* Return a position drawn in a cell of a robot's or task's piece and zone (model.md 6.20.7). */
static struct point_at on_ground(const struct state *s, int64_t i, int64_t thing, int64_t attempt, int64_t purpose)
{
    const struct place *place = &s->params->arena.place;
    const struct ground *ground = &s->tables.ground;
    const struct words drawn = draw_words(s, i, attempt, purpose);
    const int64_t first = ground->stand_of[2 * thing], number = ground->stand_of[2 * thing + 1];
    const int64_t cell = ground->stands[first + choose(drawn.word[0], number)], width = INT64_C(1) << place->bits;
    return (struct point_at){cell % place->columns * width + choose(drawn.word[1], width),
                             cell / place->columns * width + choose(drawn.word[2], width)};
}

ALWAYS struct point_at given_point(const struct state *s, int64_t thing)
{
    return (struct point_at){s->tables.points[2 * thing], s->tables.points[2 * thing + 1]};
}

/* Place a task; one that appears later (model.md 6.17.4), at any of the given points. */
static void place_task(struct state *s, int64_t i)
{
    const struct params *p = s->params;
    struct point_at at;
    if (p->tasks.placement.how == AT_POINTS) {
        const bool later = i >= p->tasks.at_start;
        at = given_point(s, p->robots.at_start + (later ? choose(draw(s, i, 0, PLACE_TASK), p->tasks.at_start) : i));
    } else if (p->arena.place.exists) {
        at = on_ground(s, i, p->robots.count + i, 0, PLACE_TASK);
    } else {
        at = candidate(s, &p->tasks.placement, i, 0, 0, &OF_TASKS);
    }
    put(s->tasks, i, at.x, at.y);
}

/* Return whether a robot's disc overlaps none of the robots in cells. */
static bool is_clear_of_sorted(const struct state *s, int64_t i)
{
    const struct lens lens = lens_of(s, &s->robot_cells, &s->params->robots.grid);
    const int32_t x = lens.x[i], y = lens.y[i];
    struct stretches left = block_at(&lens.cells, &lens.grid, x, y);
    uint32_t met = 0;
    do {
        const struct groups of = take_groups(&left);
        met |= of.valid & find_within(&lens.arena, lens.cells.points, of.first, of.second, x, y,
                                      s->params->robots.apart_limit, 0).one;
    } while (RARELY(has_more(&left)));
    return met == 0;
}

/* Return whether a robot's disc overlaps none of those there; at the start, of the robots before it. */
static bool is_clear(const struct state *s, int64_t i, bool joins)
{
    const int32_t *xs = s->robots[X], *ys = s->robots[Y];
    const struct params *p = s->params;
    const uint32_t diameter = 2 * (uint32_t)p->robots.radius;
    const int64_t sorted = joins || p->together ? 0 : i - i % UNSORTED;
    if (sorted > 0 && !is_clear_of_sorted(s, i))
        return false;
    for (int64_t w = sorted / WORD; w < s->words && (joins || WORD * w < i); w++) {
        const int64_t first = WORD * w;
        const uint32_t there = joins ? s->sets[THERE][w] : first_bits((int)(i - first));
        const uint32_t beside = there & beside_word(&p->arena, xs, ys, first, xs[i], ys[i], diameter);
        if (RARELY(beside != 0) &&
            near_word(p, xs, ys, first, first + WORD, xs[i], ys[i], p->robots.apart_limit) & beside)
            return false;
    }
    return true;
}

/* Put a robot at a point; return whether it is clear of those there, or need not be. */
static bool put_clear(struct state *s, int64_t i, int64_t x, int64_t y, bool joins)
{
    put(s->robots, i, x, y);
    return !s->params->robots.avoid_collisions || is_clear(s, i, joins);
}

/* Draw places for a robot of the start, or one that joins, until one is clear; return whether one was.
 *
 * One that joins (model.md 6.17.7) may take any of the given points. */
static bool place_robot(struct state *s, int64_t i, bool joins)
{
    const struct params *p = s->params;
    const struct placement *placing = &p->robots.placement;
    const int64_t joined = joins ? s->robots[JOINED][i] : 0;
    for (int64_t attempt = 0; attempt < ATTEMPTS; attempt++) {
        const int64_t counter = ATTEMPTS * joined + attempt;
        struct point_at at;
        if (placing->how == AT_POINTS)
            at = given_point(s, choose(draw(s, i, counter, PLACE_ROBOT), p->robots.at_start));
        else if (p->arena.place.exists)
            at = on_ground(s, i, i, counter, PLACE_ROBOT);
        else
            at = candidate(s, placing, i, joined, attempt, &OF_ROBOTS);
        if (put_clear(s, i, at.x, at.y, joins))
            return true;
    }
    return false;
}

/* Place the robots on a square lattice over the whole arena, in random order, or as a place has it. */
static void place_on_lattice(struct state *s)
{
    const struct params *p = s->params;
    const int64_t robots = p->robots.at_start, radius = p->robots.radius, step = 2 * radius;
    const int32_t *order = s->robots[ORDER], *lattice = s->tables.ground.lattice;
    if (p->arena.place.exists) {
        for (int64_t i = 0; i < robots; i++)
            put(s->robots, i, lattice[2 * i], lattice[2 * i + 1]);
        return;
    }
    const int64_t columns = p->arena.width / step, rows = p->arena.height / step;
    shuffle(s, s->robots[ORDER], robots, SITE);
    for (int64_t i = 0; i < robots; i++) {
        const int64_t site = order[i] * (columns * rows) / robots;
        put(s->robots, i, radius + site % columns * step, radius + site / columns * step);
    }
}

/* Place the robots of the start: apart if they avoid collisions, if need be on a lattice. */
static void place_robots(struct state *s)
{
    const struct params *p = s->params;
    const bool sorts = p->robots.avoid_collisions && !p->together;
    for (int64_t i = 0; i < p->robots.at_start; i++) {
        if (sorts && i % UNSORTED == 0)
            sort_into_cells(&s->robot_cells, &p->robots.grid, s->robots[X], s->robots[Y], s->robots[ORDER],
                            s->sets[THERE], i);
        if (p->robots.placement.how == AT_POINTS) {
            const struct point_at at = given_point(s, i);
            put(s->robots, i, at.x, at.y);
        } else if (!place_robot(s, i, false)) {
            place_on_lattice(s);
            return;
        }
    }
}

#endif

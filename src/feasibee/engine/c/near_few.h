/* Who is near each of up to 128 robots, as sets of robots, by 16 bits of each coordinate.
 *
 * Differences of 16 bits wrap by themselves as those of 32 do. Those robots that they leave in doubt of another
 * one are compared with all exactly, as all robots are on a torus whose sides differ. */

#ifndef NEAR_FEW_H
#define NEAR_FEW_H

#include "near.h"
#include "sets.h"

#define MOST_VECTORS (128 / LANES)        /* vectors of the largest swarm that has such sets */
#define WORD_VECTORS (WORD / LANES)
#define AT_ONCE (WORD_VECTORS < 4 ? WORD_VECTORS : 4) /* vectors whose places and sets fit into registers */
#define FARTHEST (UINT64_C(1) << 63)  /* no squared distance is above this */

/* The sets of robots that are near each, and what they are found from. */
struct nearness {
    uint32_t *sets;
    int64_t padded;
    u32 low;
    u32 places[MOST_VECTORS], least[MOST_VECTORS]; /* least: of what squared distances are above `low`, or all if one is below */
};

/* --- Exactly --- */

/* Return which robots of a word are near a robot, exactly. */
ALWAYS uint32_t near_exactly(const struct state *s, int64_t w, int64_t i, uint64_t limit)
{
    const int64_t first = WORD * w, last = first + WORD < s->params->robots.count ? first + WORD : s->params->robots.count;
    const int32_t *xs = s->robots[X], *ys = s->robots[Y];
    const uint32_t close = limit > FARTHEST ? first_bits((int)(last - first))
                                            : near_word(s->params, xs, ys, first, last, xs[i], ys[i], limit);
    return close & ~bit_if(w == i >> 5, i);
}

APART void find_all_exactly(struct state *s, uint32_t *sets, uint64_t limit)
{
    for (int64_t w = 0; w < s->words; w++)
        for (int64_t i = 0; i < s->params->robots.count; i++)
            sets[w * s->padded + i] = near_exactly(s, w, i, limit);
}

/* Find exactly who is near a robot, and let those have it in their sets. */
APART void find_exactly(struct state *s, uint32_t *sets, uint64_t limit, int64_t i)
{
    for (int64_t w = 0; w < s->words; w++) {
        const uint32_t close = near_exactly(s, w, i, limit);
        for (uint32_t changed = close ^ sets[w * s->padded + i]; changed; changed = without_lowest(changed))
            sets[(i >> 5) * s->padded + lowest_member(w, changed)] ^= bit((int)(i & 31));
        sets[w * s->padded + i] = close;
    }
}

/* --- By 16 bits --- */

/* Put the bits of a vector of robots into the sets of another vector; they are its first bits or later ones. */
ALWAYS void put_sets(const struct nearness *n, int members, int vector, u32 near)
{
    const int shift = members % WORD_VECTORS * LANES;
    u32 *set = (u32 *)(n->sets + members / WORD_VECTORS * n->padded + vector * LANES);
    if (shift == 0)
        *set = near;
    else
        *set |= near << shift;
}

/* Compare `rows` robots of a vector with `count` vectors from `first` on, none of which is a later one.
 *
 * Each pair is compared once. Lanes collect which robots of the vector those others see; masks say the reverse,
 * which is left out for the vector itself. */
ALWAYS void compare(struct nearness *n, int vector, int first, const int count, int rows)
{
    const uint32_t *places = (const uint32_t *)n->places;
    const u32 low = n->low;
    const int others = first + count > vector ? count - 1 : count, shift = first % WORD_VECTORS * LANES;
    uint32_t *set = n->sets + first / WORD_VECTORS * n->padded;
    u32 near[AT_ONCE], place[AT_ONCE], least[AT_ONCE];
    UNROLL for (int a = 0; a < count; a++)
    {
        near[a] = spread(0);
        place[a] = n->places[first + a];
        least[a] = n->least[first + a];
    }
    for (int j = vector * LANES + rows - 1; j >= vector * LANES; j--) {
        const u32 here = spread(places[j]);
        uint32_t row = 0;
        UNROLL for (int a = 0; a < count; a++)
        {
            const u32 beyond = squared(subtract_halves(place[a], here)) - low; /* below 0 if surely near */
            least[a] = least_of(least[a], beyond);
            near[a] = near[a] << 1 | beyond >> 31;
            if (a < others)
                row |= signs(beyond) << a * LANES;
        }
        if (others > 0)
            set[j] = shift == 0 ? row : set[j] | row << shift;
    }
    if (others < count)
        near[count - 1] &= ~lane_bits();
    UNROLL for (int a = 0; a < count; a++)
    {
        put_sets(n, vector, first + a, near[a]);
        n->least[first + a] = least[a];
    }
}

/* Compare the robots of a vector with those of all vectors up to it, by groups. */
ALWAYS void compare_up_to(struct nearness *n, int vector, int rows)
{
    int first = 0;
    for (; first + AT_ONCE <= vector; first += AT_ONCE)
        compare(n, vector, first, AT_ONCE, rows);
    switch (vector - first) {
    case 0: compare(n, vector, first, 1, rows); break;
#if AT_ONCE > 2
    case 1: compare(n, vector, first, 2, rows); break;
    case 2: compare(n, vector, first, 3, rows); break;
#endif
    default: compare(n, vector, first, AT_ONCE, rows); break;
    }
}

/* Store who is near each robot: whose squared distance is below a limit, which is in doubt within a band. */
static inline void find_all_near(struct state *s, enum link row, uint64_t limit, struct band band)
{
    const int robots = (int)s->params->robots.count, vectors = (robots + LANES - 1) / LANES;
    if (!s->params->arena.wraps || band.low == 0) {
        find_all_exactly(s, s->links[row], limit);
        return;
    }
    struct nearness n = {.sets = s->links[row], .padded = s->padded, .low = spread(band.low)};
    const u32 *x = (const u32 *)s->robots[X], *y = (const u32 *)s->robots[Y];
    for (int a = 0; a < vectors; a++) {
        n.places[a] = x[a] >> 16 | (y[a] & 0xFFFF0000u);
        n.least[a] = spread(UINT32_MAX);
    }
    for (int b = 0; b < vectors; b++)
        compare_up_to(&n, b, b + 1 < vectors ? LANES : robots - b * LANES);
    for (int a = 0; a < vectors; a++) {
        uint32_t doubtful = below(n.least[a], spread(band.width)) & first_bits(robots - a * LANES);
        for (; RARELY(doubtful != 0); doubtful = without_lowest(doubtful))
            find_exactly(s, s->links[row], limit, a * LANES + lowest(doubtful));
    }
}

/* Leave those robots out of each robot's set that aren't in a set. */
static inline void keep_only(struct state *s, enum link row, const uint32_t *there)
{
    for (int64_t other = 0; other < s->words; other++) {
        u32 *sets = (u32 *)(s->links[row] + other * s->padded);
        for (int64_t a = 0; a < s->padded / LANES; a++)
            sets[a] &= spread(there[other]) & lanes_of(there[a / WORD_VECTORS] >> a % WORD_VECTORS * LANES);
    }
}

#endif

/* Bodies: robots that go where their way is clear of walls and discs (model.md 6.1, 6.2).
 *
 * Up to 128 robots list the pairs that may meet once, and test all of them together; with more robots, those near
 * the robots of a word are queued, and tested word by word. */

#ifndef BODIES_H
#define BODIES_H

#include "near.h"
#include "near_few.h"
#include "place.h"
#include "team.h"

#define SURELY 1e-14 /* more than the relative error of a product of four numbers, each rounded once */
#define TRIES 2      /* eighths of a turn that a blocked robot turns away */

/* Whether a robot meets another one, which it has on its left, or on its right; then the reverse, if it is asked. */
enum meeting { MEETS = 1, ON_LEFT = 2, ON_RIGHT = 4, REVERSE_BITS = 3, IN_DOUBT = 64 };

/* Wait until all threads have come here. */
ALWAYS void wait_for_all(struct state *s)
{
    struct team *team = s->team;
    if (team->threads > 1 && comes_last(team))
        let_go(team);
}

/* --- Discs that meet, exactly --- */

struct wide {
    uint64_t high, low;
};

/* Return the product of two words, as 128 bits: not all compilers have a type for it. */
ALWAYS struct wide wide_product(uint64_t a, uint64_t b)
{
    const uint64_t a0 = a & UINT32_MAX, a1 = a >> 32, b0 = b & UINT32_MAX, b1 = b >> 32;
    uint64_t low = a0 * b0;
    __asm__("" : "+r"(low)); /* else LLVM finds the product, and calls a function that wasm hasn't */
    const uint64_t middle = a1 * b0 + (low >> 32), other = a0 * b1 + (middle & UINT32_MAX);
    return (struct wide){a1 * b1 + (middle >> 32) + (other >> 32), a * b};
}

/* Return whether two discs overlap at some moment of a step, exactly.
 *
 * `way` is the difference of their places at the start, `d` that of their steps. */
static inline bool overlap(uint64_t limit, int64_t way_x, int64_t way_y, int64_t dx, int64_t dy)
{
    const int64_t along = way_x * dx + way_y * dy, length = dx * dx + dy * dy;
    if (along >= 0) /* the distance grows */
        return (uint64_t)(way_x * way_x + way_y * way_y) < limit;
    if (-along >= length) { /* the distance shrinks until the end */
        const int64_t end_x = way_x + dx, end_y = way_y + dy;
        return (uint64_t)(end_x * end_x + end_y * end_y) < limit;
    }
    /* The least distance is within the step. */
    const uint64_t across = (uint64_t)distance(way_x * dy, way_y * dx);
    const struct wide squared = wide_product(across, across), least = wide_product(limit, (uint64_t)length);
    return squared.high < least.high || (squared.high == least.high && squared.low < least.low);
}

/* Return how a robot meets another, which moves or may stay. */
APART int32_t meets_exactly(const struct state *s, int64_t i, int64_t j, bool may_stay)
{
    const struct arena *arena = &s->params->arena;
    const uint64_t limit = s->params->robots.apart_limit;
    const int64_t way_x = short_way(s->robots[X][i], s->robots[X][j], arena->width, arena->walls);
    const int64_t way_y = short_way(s->robots[Y][i], s->robots[Y][j], arena->height, arena->walls);
    const int64_t u = s->robots[STEP_X][i], v = s->robots[STEP_Y][i], side = u * way_y - v * way_x;
    const bool met = overlap(limit, way_x, way_y, s->robots[STEP_X][j] - u, s->robots[STEP_Y][j] - v) ||
                     (may_stay && overlap(limit, way_x, way_y, -u, -v));
    return met ? MEETS | (side > 0 ? ON_LEFT : 0) | (side < 0 ? ON_RIGHT : 0) : 0;
}

/* --- Discs that meet, by floats where these leave no doubt: a pair in each lane --- */

/* The robots of pairs, the ways from the first ones to the others, and their steps. */
struct encounters {
    i64 i, j, way_x, way_y, ix, iy, jx, jy;
};

ALWAYS i64 numbers_at(const int32_t *from)
{
    i64 lanes = {0};
    for (int k = 0; k < PAIRS; k++)
        lanes[k] = from[k];
    return lanes;
}

ALWAYS i64 picked(const int32_t *numbers, i64 places)
{
    i64 lanes = {0};
    UNROLL for (int k = 0; k < PAIRS; k++)
        lanes[k] = numbers[places[k]];
    return lanes;
}

/* Return ways along an axis, on the torus the short ones. */
ALWAYS i64 ways_between(const int32_t *at, i64 i, i64 j, int64_t side, bool walls)
{
    const int64_t around = walls ? INT64_C(1) << 60 : side;
    const i64 lower = (i64)spread_long(UINT32_MAX), way = (picked(at, j) & lower) - (picked(at, i) & lower);
    return way - ((i64)(2 * way >= around) & around) + ((i64)(2 * way < -around) & around);
}

ALWAYS struct encounters encounters_of(const struct state *s, i64 i, i64 j)
{
    const struct arena *arena = &s->params->arena;
    return (struct encounters){
        .i = i,
        .j = j,
        .way_x = ways_between(s->robots[X], i, j, arena->width, arena->walls),
        .way_y = ways_between(s->robots[Y], i, j, arena->height, arena->walls),
        .ix = picked(s->robots[STEP_X], i),
        .iy = picked(s->robots[STEP_Y], i),
        .jx = picked(s->robots[STEP_X], j),
        .jy = picked(s->robots[STEP_Y], j),
    };
}

ALWAYS i64 dot(i64 x1, i64 y1, i64 x2, i64 y2) { return signed_product(x1, x2) + signed_product(y1, y2); }
ALWAYS i64 cross(i64 x1, i64 y1, i64 x2, i64 y2) { return signed_product(x1, y2) - signed_product(y1, x2); }

/* Return whether two discs overlap at some moment of a step, and add whether that is in doubt.
 *
 * The squared distance is `apart` at the start and `apart + 2 along + length` at the end. */
ALWAYS i64 meets(int64_t limit, i64 apart, i64 along, i64 across, i64 length, i64 *doubtful)
{
    const i64 closer = (i64)(along < 0), passes = closer & (i64)(-along < length);
    const i64 at_ends = (i64)(apart + (closer & (2 * along + length)) < limit);
    const f64 side = __builtin_convertvector(across, f64), squared = side * side;
    const f64 least = (double)limit * __builtin_convertvector(length, f64);
    const f64 beyond = squared - least, unsure = SURELY * least;
    *doubtful |= passes & (i64)(beyond <= unsure) & (i64)(-beyond <= unsure);
    return (passes & (i64)(squared < least)) | (~passes & at_ends);
}

ALWAYS i64 meeting_bits(i64 met, i64 side)
{
    return met & (MEETS | ((i64)(side > 0) & ON_LEFT) | ((i64)(side < 0) & ON_RIGHT));
}

/* Return which robots may stay: any, or those of a set. */
ALWAYS i64 staying(const uint32_t *blocked, i64 robots, bool any)
{
    i64 lanes = (i64){0} - (int64_t)any;
    for (int k = 0; !any && k < PAIRS; k++)
        lanes[k] = -(int64_t)has(blocked, robots[k]);
    return lanes;
}

/* Return how robots meet others, which move, or may stay; if `mutual` also the reverse; or IN_DOUBT.
 *
 * A stopped robot has step 0. Opposite to each other on the torus, both take the way round in the same direction:
 * so the one isn't the reverse of the other. */
ALWAYS i64 meetings_of(const struct state *s, const struct encounters *e, bool any_stays, const bool mutual)
{
    const struct arena *arena = &s->params->arena;
    const int64_t limit = (int64_t)s->params->robots.apart_limit;
    const i64 apart = dot(e->way_x, e->way_y, e->way_x, e->way_y);
    const i64 along_i = -dot(e->way_x, e->way_y, e->ix, e->iy), across_i = cross(e->ix, e->iy, e->way_x, e->way_y);
    const i64 along_j = dot(e->way_x, e->way_y, e->jx, e->jy), across_j = cross(e->way_x, e->way_y, e->jx, e->jy);
    const i64 length_i = dot(e->ix, e->iy, e->ix, e->iy), length_j = dot(e->jx, e->jy, e->jx, e->jy);
    const i64 length = length_i + length_j - 2 * dot(e->ix, e->iy, e->jx, e->jy);
    i64 doubtful = {0};
    const i64 both = meets(limit, apart, along_i + along_j, across_i + across_j, length, &doubtful);
    const i64 alone = meets(limit, apart, along_i, across_i, length_i, &doubtful);
    i64 meeting = meeting_bits(both | (alone & staying(s->sets[BLOCKED], e->j, any_stays)), across_i);
    if (mutual) {
        const i64 reverse = meets(limit, apart, along_j, across_j, length_j, &doubtful);
        meeting |= meeting_bits(both | (reverse & staying(s->sets[BLOCKED], e->i, any_stays)), across_j) << REVERSE_BITS;
        doubtful |= (i64)(2 * e->way_x == -arena->width) | (i64)(2 * e->way_y == -arena->height);
    }
    return (meeting & ~doubtful) | (doubtful & IN_DOUBT);
}

/* Put a robot that meets another one into sets. */
ALWAYS void collect(struct state *s, int64_t i, int32_t meeting)
{
    s->sets[MET][i >> 5] |= bit_if(meeting & MEETS, i);
    s->sets[MET_LEFT][i >> 5] |= bit_if(meeting & ON_LEFT, i);
    s->sets[MET_RIGHT][i >> 5] |= bit_if(meeting & ON_RIGHT, i);
}

/* Put the robots of a pair that meet the other into sets, and if it is in doubt, find out first. */
ALWAYS void collect_pair(struct state *s, int64_t i, int64_t j, int32_t meeting, bool at_first, const bool mutual)
{
    const uint32_t *blocked = s->sets[BLOCKED];
    if (RARELY(meeting == IN_DOUBT)) {
        meeting = meets_exactly(s, i, j, at_first || has(blocked, j));
        if (mutual)
            meeting |= meets_exactly(s, j, i, at_first || has(blocked, i)) << REVERSE_BITS;
    }
    collect(s, i, meeting);
    if (mutual)
        collect(s, j, meeting >> REVERSE_BITS);
}

/* Put those first robots of listed pairs into sets that meet the others, and if `mutual` these, too; if not, they
 * are numbered as in cells. The other one moves, or may stay: `at_first` any, later the blocked ones. */
ALWAYS void test_pairs(struct state *s, struct part *part, int64_t listed, bool at_first, const bool mutual)
{
    for (int64_t k = listed; k < listed + PAIRS; k++) { /* the last pair again: which changes no set */
        part->who[k] = part->who[listed ? listed - 1 : 0];
        part->other[k] = part->other[listed ? listed - 1 : 0];
    }
    for (int64_t k = 0; k < listed; k += PAIRS) {
        const i64 i = numbers_at(part->who + k), j = numbers_at(part->other + k) >> (mutual ? 0 : 1);
        const struct encounters e = encounters_of(s, i, j);
        const i64 meetings = meetings_of(s, &e, at_first, mutual);
        uint32_t left = signs((u32)(meetings != 0)) & 0x55555555; /* one bit of two */
        for (; left; left = without_lowest(left)) {
            const int lane = lowest(left) / 2;
            collect_pair(s, i[lane], j[lane], (int32_t)meetings[lane], at_first, mutual);
        }
    }
}

ALWAYS void clear_met(struct state *s, int64_t w) { s->sets[MET][w] = s->sets[MET_LEFT][w] = s->sets[MET_RIGHT][w] = 0; }

/* --- Edges with walls --- */

/* Return the robots of a word whose step leads beyond an edge with a wall. */
ALWAYS uint32_t find_beyond_edges(const struct state *s, int64_t w)
{
    const struct arena *arena = &s->params->arena;
    const int64_t radius = s->params->robots.radius;
    const u32 low = spread((uint32_t)radius); /* beyond it, a difference without sign is large */
    const u32 across = spread((uint32_t)(arena->width - 2 * radius)), along = spread((uint32_t)(arena->height - 2 * radius));
    uint32_t found = 0;
    UNROLL for (int64_t a = 0; a < WORD_VECTORS; a++)
    {
        const int64_t i = WORD * w + a * LANES;
        const u32 x = *(const u32 *)(s->robots[X] + i) + *(const u32 *)(s->robots[STEP_X] + i) - low;
        const u32 y = *(const u32 *)(s->robots[Y] + i) + *(const u32 *)(s->robots[STEP_Y] + i) - low;
        found |= (below(across, x) | below(along, y)) << a * LANES;
    }
    return found;
}

/* Find which robots of a word have an edge that blocks them on their left, and on their right. */
static inline void find_edges_beside(const struct state *s, uint32_t blocked, int64_t w, uint32_t *left, uint32_t *right)
{
    const int64_t low = s->params->robots.radius;
    const int64_t high_x = s->params->arena.width - low, high_y = s->params->arena.height - low;
    *left = *right = 0;
    for (; blocked; blocked = without_lowest(blocked)) {
        const int64_t i = lowest_member(w, blocked), u = s->robots[STEP_X][i], v = s->robots[STEP_Y][i];
        const int64_t x = at_x(s->robots, i) + u, y = at_y(s->robots, i) + v;
        const bool west = x < low, east = x > high_x, south = y < low, north = y > high_y;
        *left |= bit_if((east && v < 0) || (west && v > 0) || (north && u > 0) || (south && u < 0), i);
        *right |= bit_if((east && v > 0) || (west && v < 0) || (north && u < 0) || (south && u > 0), i);
    }
}

/* Return which robots of a set in a word have steps that walls block. */
ALWAYS uint32_t find_beyond_walls(const struct state *s, uint32_t tried, int64_t w)
{
    if (s->params->arena.place.exists)
        return find_blocked_by_place(s, tried, w);
    return s->params->arena.walls ? find_beyond_edges(s, w) & tried : 0;
}

/* --- Steps --- */

/* Choose to which side the blocked robots of a word turn: to the left, unless what blocks them is only there. */
static inline void choose_sides(struct state *s, int64_t w)
{
    uint32_t left = 0, right = 0;
    if (s->params->arena.place.exists)
        find_place_beside(s, s->sets[BLOCKED][w], w, &left, &right);
    else if (s->params->arena.walls)
        find_edges_beside(s, s->sets[BLOCKED][w], w, &left, &right);
    s->sets[TURNING_LEFT][w] = s->sets[MET_RIGHT][w] | right | ~(s->sets[MET_LEFT][w] | left);
}

/* Turn the steps of the blocked robots of a word by an eighth of a turn, to the left or to the right. */
static inline void turn_away(struct state *s, int64_t w)
{
    for (uint32_t blocked = s->sets[BLOCKED][w]; blocked; blocked = without_lowest(blocked)) {
        const int64_t i = lowest_member(w, blocked), side = has(s->sets[TURNING_LEFT], i) ? 1 : -1;
        const int64_t u = s->robots[STEP_X][i], v = s->robots[STEP_Y][i];
        s->robots[STEP_X][i] = (int32_t)shortened(u - side * v);
        s->robots[STEP_Y][i] = (int32_t)shortened(v + side * u);
    }
}

/* Return where a step leads along an axis of a torus, whose side it is shorter than. */
ALWAYS int32_t around(int32_t coordinate, int32_t step, int64_t side)
{
    int64_t end = (int64_t)(uint32_t)coordinate + step;
    end += end < 0 ? side : 0;
    end -= end >= side ? side : 0;
    return (int32_t)(uint32_t)end;
}

/* Move the robots of a word but those of a set. On a torus whose sides differ, places don't wrap by themselves. */
ALWAYS void move_unless(struct state *s, uint32_t stays, int64_t w)
{
    const struct arena *arena = &s->params->arena;
    if (!arena->wraps) {
        for (uint32_t left = ~stays; left; left = without_lowest(left)) {
            const int64_t i = lowest_member(w, left);
            s->robots[X][i] = around(s->robots[X][i], s->robots[STEP_X][i], arena->width);
            s->robots[Y][i] = around(s->robots[Y][i], s->robots[STEP_Y][i], arena->height);
        }
        return;
    }
    UNROLL for (int64_t a = 0; a < WORD_VECTORS; a++)
    {
        const int64_t i = WORD * w + a * LANES;
        const u32 moves = ~lanes_of(stays >> a * LANES);
        *(u32 *)(s->robots[X] + i) += *(const u32 *)(s->robots[STEP_X] + i) & moves;
        *(u32 *)(s->robots[Y] + i) += *(const u32 *)(s->robots[STEP_Y] + i) & moves;
    }
}

/* --- Few robots --- */

/* List the pairs of a robot of one word and a lower one of another word; return the number of pairs. */
ALWAYS int64_t list_pairs_of(struct state *s, struct part *part, int64_t other, int64_t w, int64_t listed)
{
    uint32_t *sets = s->links[CLOSE] + other * s->padded, none = 0;
    UNROLL for (int64_t a = 0; a < WORD_VECTORS; a++)
    {
        u32 *close = (u32 *)(sets + WORD * w + a * LANES);
        if (w == other)
            *close &= (lane_bits() << a * LANES) - 1;
        none |= equal(*close, spread(0)) << a * LANES;
    }
    uint32_t rows = ~none & first_bits((int)(s->params->robots.count - WORD * w));
    while (rows) { /* one loop over pairs: an inner one for each robot would often be mispredicted */
        const int64_t i = lowest_member(w, rows);
        const uint32_t close = sets[i], rest = without_lowest(close);
        part->who[listed] = (int32_t)i;
        part->other[listed++] = (int32_t)lowest_member(other, close);
        sets[i] = rest;
        rows &= ~bit_if(rest == 0, i);
    }
    return listed;
}

/* List the pairs of robots that are there and may meet within a step; return their number. */
static inline int64_t list_pairs(struct state *s, struct part *part)
{
    int64_t listed = 0;
    find_all_near(s, CLOSE, s->params->robots.meet_limit, s->params->robots.meet_band);
    if (s->params->changes)
        keep_only(s, CLOSE, s->sets[THERE]);
    for (int64_t other = 0; other < s->words; other++)
        for (int64_t w = other; w < s->words; w++)
            listed = list_pairs_of(s, part, other, w, listed);
    return listed;
}

/* Keep those pairs of a list of which one or both are blocked; return their number. */
static inline int64_t keep_blocked(const struct state *s, struct part *part, int64_t listed)
{
    int64_t kept = 0;
    for (int64_t k = 0; k < listed; k++) {
        const int32_t i = part->who[k], j = part->other[k];
        part->who[kept] = i;
        part->other[kept] = j;
        const bool one = has(s->sets[BLOCKED], i), other = has(s->sets[BLOCKED], j);
        kept += one | other;
    }
    return kept;
}

/* Find which robots of listed pairs meet the other, and which of these have it on the left and right. */
static inline void find_meeting(struct state *s, struct part *part, int64_t listed, bool at_first)
{
    for (int64_t w = 0; w < s->words; w++)
        clear_met(s, w);
    test_pairs(s, part, listed, at_first, true);
}

/* Let the blocked robots turn away twice, as long as they are blocked; return whether some still are.
 *
 * Their steps change, also of those that stay blocked: these draw a new heading (model.md 6.2.2 to 6.2.5). */
static inline bool deflect_few(struct state *s, struct part *part, int64_t listed)
{
    uint32_t some = UINT32_MAX;
    for (int tried = 0; tried < TRIES && some; tried++) {
        for (int64_t w = 0; w < s->words; w++)
            turn_away(s, w);
        listed = keep_blocked(s, part, listed);
        find_meeting(s, part, listed, false);
        some = 0;
        for (int64_t w = 0; w < s->words; w++) {
            s->sets[BLOCKED][w] &= s->sets[MET][w] | find_beyond_walls(s, s->sets[BLOCKED][w], w);
            some |= s->sets[BLOCKED][w];
        }
    }
    return some != 0;
}

/* Find the robots that stand in this step; return whether there are any. The steps of others may turn. */
static inline bool find_standing(struct state *s, struct part *part)
{
    const int64_t listed = s->params->robots.avoid_collisions ? list_pairs(s, part) : 0;
    uint32_t some = 0;
    find_meeting(s, part, listed, true);
    for (int64_t w = 0; w < s->words; w++) {
        const uint32_t working = s->sets[WORKING][w];
        s->sets[BLOCKED][w] = (s->sets[MET][w] & working) | find_beyond_walls(s, working, w);
        some |= s->sets[BLOCKED][w];
    }
    if (!s->params->robots.deflects || !some)
        return some != 0;
    for (int64_t w = 0; w < s->words; w++)
        choose_sides(s, w);
    return deflect_few(s, part, listed);
}

/* Move each robot whose way is clear; the others stay and will turn (model.md 6.1, 6.2). */
static inline void move_few(struct state *s, struct part *part)
{
    if (!find_standing(s, part) && s->params->arena.wraps) {
        move_freely(s, part);
        return;
    }
    for (int64_t w = 0; w < s->words; w++)
        move_unless(s, s->sets[BLOCKED][w], w);
}

/* --- More robots --- */

/* Return which of some robots of a word are blocked; find which meet others, and have these on which side.
 *
 * Another robot moves, or may stay: `at_first` any, later the blocked ones. */
static inline uint32_t find_blocked(struct state *s, struct part *part, int64_t w, uint32_t tried, bool at_first)
{
    const struct robot *robots = &s->params->robots;
    const struct lens lens = lens_of(s, &s->robot_cells, &robots->grid);
    const uint64_t limit = robots->meet_limit;
    const uint32_t found = find_beyond_walls(s, tried, w);
    int64_t queued = 0;
    clear_met(s, w);
    if (!robots->avoid_collisions)
        return found;
    uint32_t left = at_first && robots->deflects ? tried : tried & ~found; /* sides matter at first only */
    while (left) {
        const int64_t i = lowest_member(w, left);
        queued = queue_near(part, &lens, i, limit, queued, (int32_t)i);
        left = without_lowest(left);
        if (queued > QUEUE_ROOM || left == 0) {
            test_pairs(s, part, queued, at_first, false);
            queued = 0;
        }
    }
    return found | s->sets[MET][w];
}

/* Let the blocked robots turn away twice, as long as they are blocked (model.md 6.2.2 to 6.2.5). */
static inline void deflect(struct state *s, struct part *part)
{
    for (int tried = 0; tried < TRIES; tried++) {
        for (int64_t w = part->first; w < part->last; w++)
            turn_away(s, w);
        wait_for_all(s);
        for (int64_t w = part->first; w < part->last; w++) {
            const uint32_t blocked = s->sets[BLOCKED][w];
            s->sets[CLEARED][w] = blocked & ~find_blocked(s, part, w, blocked, false);
        }
        wait_for_all(s);
        for (int64_t w = part->first; w < part->last; w++)
            s->sets[BLOCKED][w] &= ~s->sets[CLEARED][w];
    }
}

/* Move each robot of a part whose way is clear; the others stay and will turn (model.md 6.2). */
static inline void move_crowd(struct state *s, struct part *part)
{
    if (s->params->arena.wraps && !s->params->arena.walls && !s->params->robots.avoid_collisions) {
        move_freely(s, part); /* stopped robots have speed 0 */
        return;
    }
    for (int64_t w = part->first; w < part->last; w++) {
        s->sets[BLOCKED][w] = find_blocked(s, part, w, s->sets[WORKING][w], true);
        if (s->params->robots.deflects)
            choose_sides(s, w);
    }
    wait_for_all(s);
    if (s->params->robots.deflects)
        deflect(s, part);
    for (int64_t w = part->first; w < part->last; w++)
        move_unless(s, s->sets[BLOCKED][w] | ~s->sets[WORKING][w], w);
}

#endif

/* The paper's world with up to 128 robots (model.md 1 to 4): whom each robot sees and has heard are sets.
 *
 * Robots lie in vectors, and in words of 32 for sets. A swarm of few vectors is played by code of its own, in
 * which their number is a constant, so that its sets stay in registers; more of them go word by word. */

#include "few.h"

#include <stdlib.h>
#ifdef _WIN32
#include <malloc.h>
#endif

#include "draws.h"
#include "failures.h"
#include "lists.h"

#define WORDS (FEW / 32)
#define VECTORS (FEW / LANES)
#define WORD_VECTORS (32 / LANES)
#define NEVER UINT32_MAX /* a step that no run reaches */

union row {
    u32 v[VECTORS];
    uint32_t e[FEW];
};

struct swarm {
    union row x, y, step_x, step_y, turns_at, ends_at; /* steps at which heading and phase end */
    union row robots_seen, votes, feasible_votes, sight[WORDS], heard[WORDS], heard_feasible[WORDS];
    int64_t tasks_seen[FEW];
    uint32_t feasible[WORDS], neutral[WORDS], disseminating[WORDS], speaking[WORDS], says_feasible[WORDS];
    uint32_t there[WORDS], joining[WORDS]; /* those that still explore for the first time */
    uint32_t walks[FEW], phases[FEW];      /* headings and phases drawn */
    double quality[FEW];                   /* of feasible, by the last exploration */
    struct heading_pool headings[FEW];
    struct phase_pool phase_pools[FEW];
    struct lists tasks;
    struct source walk, phase;
    double *memory;
    int32_t *values;                  /* heard by each robot of each other one, if messages have values */
    int32_t sent[FEW];                /* the value in a robot's messages */
};

/* --- Sight (model.md 4.2) --- */

struct reach {
    uint64_t limit;   /* in range if the squared distance is below this */
    struct band band; /* where 16 bits an axis leave it in doubt */
};

/* Find exactly whom a robot sees, and who sees it. */
APART void find_exactly(struct swarm *s, uint64_t limit, int robots, int i)
{
    uint32_t near[WORDS] = {0};
    for (int j = 0; j < robots; j++) {
        int64_t way_x = (int32_t)(s->x.e[i] - s->x.e[j]), way_y = (int32_t)(s->y.e[i] - s->y.e[j]);
        near[j >> 5] |= (uint32_t)((uint64_t)(way_x * way_x) + (uint64_t)(way_y * way_y) < limit) << (j & 31);
    }
    near[i >> 5] &= ~bit(i);
    for (int w = 0; w < WORDS; w++) {
        for (uint32_t changed = near[w] ^ s->sight[w].e[i]; changed; changed &= changed - 1)
            s->sight[i >> 5].e[32 * w + lowest(changed)] ^= bit(i);
        s->sight[w].e[i] = near[w];
    }
}

ALWAYS void find_doubtful(struct swarm *s, uint64_t limit, int robots, int vector, uint32_t doubtful)
{
    for (doubtful &= first_bits(robots - vector * LANES); RARELY(doubtful != 0); doubtful &= doubtful - 1)
        find_exactly(s, limit, robots, vector * LANES + lowest(doubtful));
}

/* Put the bits of a vector of robots into a row of sets, of which they are the first bits or later ones. */
ALWAYS void put_sets(union row *sets, int member_vector, int vector, u32 near)
{
    const int shift = member_vector % WORD_VECTORS * LANES;
    u32 *set = &sets[member_vector / WORD_VECTORS].v[vector];
    if (shift == 0)
        *set = near;
    else
        *set |= near << shift;
}

/* Compare the robots of a vector with `count` vectors from `first` on, none of which is a later one.
 *
 * Each pair is compared once. Lanes collect which robots of the vector those others see; masks say the reverse,
 * which is left out for the vector itself. */
ALWAYS void compare(struct swarm *s, const union row *places, int vector, int first, const int count, int rows,
                    const u32 low, u32 *least)
{
    u32 near[8], place[8];
    UNROLL for (int a = 0; a < count; a++)
    {
        near[a] = spread(0);
        place[a] = places->v[first + a];
    }
    const bool itself = first + count > vector;
    const int others = itself ? count - 1 : count, shift = first % WORD_VECTORS * LANES;
    for (int j = vector * LANES + rows - 1; j >= vector * LANES; j--) {
        const u32 here = spread(places->e[j]);
        uint32_t row = 0;
        UNROLL for (int a = 0; a < count; a++)
        {
            u32 beyond = squared(subtract_halves(place[a], here)) - low; /* below 0 if surely in sight */
            least[a] = least_of(least[a], beyond);
            near[a] = near[a] << 1 | beyond >> 31;
            if (a < others)
                row |= signs(beyond) << a * LANES;
        }
        if (others > 0) {
            uint32_t *set = &s->sight[first / WORD_VECTORS].e[j];
            *set = shift == 0 ? row : *set | row << shift;
        }
    }
    if (itself)
        near[count - 1] &= ~lane_bits();
    UNROLL for (int a = 0; a < count; a++)
        put_sets(s->sight, vector, first + a, near[a]);
}

ALWAYS void pack_places(const struct swarm *s, union row *places, const int vectors)
{
    UNROLL for (int a = 0; a < vectors; a++)
        places->v[a] = s->x.v[a] >> 16 | (s->y.v[a] & 0xFFFF0000u);
}

/* Store whom each robot of a word or less sees. */
ALWAYS void find_sight_in_word(struct swarm *s, struct reach reach, int robots, const int vectors)
{
    const u32 low = spread(reach.band.low);
    union row places;
    u32 least[WORD_VECTORS];
    pack_places(s, &places, vectors);
    UNROLL for (int a = 0; a < vectors; a++)
        least[a] = spread(UINT32_MAX);
    UNROLL for (int b = 0; b < vectors; b++)
    {
        const int rows = b + 1 < vectors ? LANES : robots - b * LANES;
        compare(s, &places, b, 0, b + 1, rows, low, least);
    }
    UNROLL for (int a = 0; a < vectors; a++)
        find_doubtful(s, reach.limit, robots, a, below(least[a], spread(reach.band.width)));
}

#define GROUP (WORD_VECTORS < 4 ? WORD_VECTORS : 4) /* vectors whose places and sets fit into registers */

/* Store whom each robot sees, by groups of vectors. */
APART void find_sight_in_words(struct swarm *s, struct reach reach, int robots, int vectors)
{
    const u32 low = spread(reach.band.low), width = spread(reach.band.width);
    union row places;
    u32 least[VECTORS + GROUP];
    pack_places(s, &places, vectors);
    for (int a = 0; a < VECTORS; a++)
        least[a] = spread(UINT32_MAX);
    for (int b = 0; b < vectors; b++) {
        const int rows = b + 1 < vectors ? LANES : robots - b * LANES;
        int first = 0;
        for (; first + GROUP <= b; first += GROUP)
            compare(s, &places, b, first, GROUP, rows, low, least + first);
        switch (b - first) {
        case 0: compare(s, &places, b, first, 1, rows, low, least + first); break;
        case 1: compare(s, &places, b, first, 2, rows, low, least + first); break;
        case 2: compare(s, &places, b, first, 3, rows, low, least + first); break;
        default: compare(s, &places, b, first, 4, rows, low, least + first); break;
        }
    }
    for (int a = 0; a < vectors; a++)
        find_doubtful(s, reach.limit, robots, a, below(least[a], width));
}

ALWAYS void find_sight(struct swarm *s, struct reach reach, int robots, const int vectors, const bool fixed)
{
    if (fixed)
        find_sight_in_word(s, reach, robots, vectors);
    else
        find_sight_in_words(s, reach, robots, vectors);
}

/* --- A run begins (model.md 1.2, 1.3, 2.1, 4.1) --- */

static void place_tasks(const struct job *job, struct swarm *s, int64_t run)
{
    const struct source from = source_of(job->params, run, PLACE_TASK);
    for (int task = 0; task < s->tasks.count; task++) {
        struct words drawn = philox(from, 0, (uint32_t)task);
        s->tasks.x[task] = drawn.word[0];
        s->tasks.y[task] = drawn.word[1];
    }
    fill_lists(&s->tasks);
}

ALWAYS void put(uint32_t *set, int i, bool in) { set[i >> 5] = (set[i >> 5] & ~bit(i)) | (in ? bit(i) : 0); }

ALWAYS bool has(const uint32_t *set, int i) { return set[i >> 5] >> (i & 31) & 1; }

ALWAYS void turn(const struct job *job, struct swarm *s, int i, uint32_t now)
{
    const uint32_t number = s->walks[i]++, k = number & (POOL - 1);
    struct heading_pool *pool = &s->headings[i];
    if (k == 0)
        fill_headings(pool, s->walk, (uint32_t)i, number, job->params->robots.reach, job->params->walk.mean_run);
    s->step_x.e[i] = (uint32_t)pool->x[k];
    s->step_y.e[i] = (uint32_t)pool->y[k];
    s->turns_at.e[i] = now + (uint32_t)pool->lasts[k];
}

/* Draw a robot's next phase; return its place in the pool. */
ALWAYS uint32_t next_phase(struct swarm *s, int i)
{
    const uint32_t number = s->phases[i]++, k = number & (POOL - 1);
    if (k == 0)
        fill_phases(&s->phase_pools[i], s->phase, (uint32_t)i, number);
    return k;
}

ALWAYS uint32_t phase_lasts(const struct swarm *s, int i, uint32_t k, double mean)
{
    return (uint32_t)steps_of(s->phase_pools[i].length[k], s->phase_pools[i].word[k], mean);
}

static void begin_robot(const struct job *job, struct swarm *s, int64_t run, int i)
{
    const struct params *params = job->params;
    const struct words place = philox(source_of(params, run, PLACE_ROBOT), 0, (uint32_t)i);
    const uint32_t coin = philox(source_of(params, run, FIRST_OPINION), 0, (uint32_t)i).word[0] >> 31;
    s->x.e[i] = place.word[0];
    s->y.e[i] = place.word[1];
    put(s->there, i, true);
    put(s->joining, i, params->decision.first_sight);
    put(s->feasible, i, coin && !params->strategy.starts_neutral);
    put(s->neutral, i, params->strategy.starts_neutral);
    s->quality[i] = 0.5;
    turn(job, s, i, 0);
    s->ends_at.e[i] = phase_lasts(s, i, next_phase(s, i), params->decision.exploration);
}

static void begin(const struct job *job, struct swarm *s, int64_t run)
{
    const int robots = (int)job->params->robots.count;
    memset(s, 0, offsetof(struct swarm, headings));
    memset(s->memory, 0, sizeof *s->memory * (size_t)(robots * job->memory));
    for (int i = 0; i < FEW; i++)
        s->turns_at.e[i] = s->ends_at.e[i] = NEVER;
    s->walk = source_of(job->params, run, WALK);
    s->phase = source_of(job->params, run, PHASE);
    place_tasks(job, s, run);
    for (int i = 0; i < robots; i++)
        begin_robot(job, s, run, i);
}

/* --- Phases end (model.md 4.3 to 4.6) --- */

ALWAYS int opinion_of(const struct swarm *s, int i)
{
    return has(s->neutral, i) ? NO_OPINION : (int)has(s->feasible, i);
}

ALWAYS void set_opinion(struct swarm *s, int i, int64_t opinion)
{
    put(s->feasible, i, opinion == FEASIBLE);
    put(s->neutral, i, opinion != FEASIBLE && opinion != INFEASIBLE);
}

ALWAYS struct mind mind_in(const struct job *job, struct swarm *s, int i)
{
    return mind_of(job, opinion_of(s, i), s->quality[i], s->memory + i * job->memory);
}

/* Let a robot hold what its first exploration favours; a tie keeps its opinion (model.md 6.10). */
ALWAYS void adopt_first_sight(struct swarm *s, int i)
{
    put(s->joining, i, false);
    if (s->quality[i] != 0.5)
        set_opinion(s, i, s->quality[i] > 0.5);
}

ALWAYS void end_exploration(const struct job *job, struct swarm *s, int i, uint32_t now)
{
    const uint32_t k = next_phase(s, i);
    s->quality[i] = rated(job, s->robots_seen.e[i], s->tasks_seen[i]);
    if (RARELY(has(s->joining, i)))
        adopt_first_sight(s, i);
    struct mind mind = mind_in(job, s, i);
    struct broadcast made = broadcast_of(job, &mind);
    put(s->speaking, i, made.speaks);
    put(s->says_feasible, i, made.says_feasible);
    put(s->disseminating, i, true);
    s->sent[i] = made.value;
    s->ends_at.e[i] = now + phase_lasts(s, i, k, made.mean) + (uint32_t)job->params->decision.dissemination_floor;
}

/* Read the value of the message drawn, which is the k-th of its opinion by sender, and the sum of all values. */
APART void read_values(const struct job *job, const struct swarm *s, int i, int words, int64_t k, struct inbox *inbox)
{
    int64_t value = 0, total = 0;
    for (int w = 0; w < words; w++)
        for (uint32_t left = s->heard[w].e[i]; left; left &= left - 1) {
            int j = lowest(left), held = s->values[FEW * i + 32 * w + j];
            total += held;
            if ((s->heard_feasible[w].e[i] >> j & 1) == (inbox->heard_opinion == FEASIBLE) && k-- == 0)
                value = held;
        }
    inbox->heard_value = mean_share(job->params, value, 1);
    inbox->mean_value = mean_share(job->params, total, inbox->feasible_votes + inbox->infeasible_votes);
}

/* Return what a robot has heard, and empty its inbox (model.md 4.5, 4.6). */
ALWAYS struct inbox take_inbox(const struct job *job, struct swarm *s, int i, uint32_t k, const int words)
{
    int64_t votes = s->votes.e[i], feasible = s->feasible_votes.e[i], drawn = 0;
    for (int w = 0; w < words; w++) {
        votes += members(s->heard[w].e[i]);
        feasible += members(s->heard_feasible[w].e[i]);
    }
    struct inbox inbox = {.feasible_votes = feasible, .infeasible_votes = votes - feasible, .heard_opinion = NO_OPINION};
    inbox.chance = s->phase_pools[i].chance[k] * (1.0 / 4294967296.0);
    if (votes > 0) {
        drawn = choose(s->phase_pools[i].tie[k], votes);
        inbox.heard_opinion = drawn < feasible;
        drawn -= drawn < feasible ? 0 : feasible;
    }
    if (job->params->strategy.value_scale > 0.0)
        read_values(job, s, i, words, drawn, &inbox);
    s->votes.e[i] = s->feasible_votes.e[i] = 0;
    for (int w = 0; w < words; w++)
        s->heard[w].e[i] = s->heard_feasible[w].e[i] = 0;
    return inbox;
}

ALWAYS void end_dissemination(const struct job *job, struct swarm *s, int i, uint32_t now, const int words)
{
    const uint32_t k = next_phase(s, i);
    struct inbox inbox = take_inbox(job, s, i, k, words);
    struct mind mind = mind_in(job, s, i);
    set_opinion(s, i, job->rules->decide(&mind, &inbox));
    if (job->params->strategy.forgets)
        s->robots_seen.e[i] = 0, s->tasks_seen[i] = 0;
    put(s->disseminating, i, false);
    put(s->speaking, i, false);
    s->ends_at.e[i] = now + phase_lasts(s, i, k, job->params->decision.exploration);
}

/* --- A step (model.md 3) --- */

/* Keep the values that the speaking robots of a word send to who hears them. */
APART void keep_values(struct swarm *s, int robots, int w, const union row *spoken)
{
    for (int i = 0; i < robots; i++)
        for (uint32_t left = spoken->e[i]; left; left &= left - 1)
            s->values[FEW * i + 32 * w + lowest(left)] = s->sent[32 * w + lowest(left)];
}

/* Return the bits of a set for a vector of robots, as lanes. */
ALWAYS u32 lanes_in(const uint32_t *set, int vector)
{
    return lanes_of(set[vector / WORD_VECTORS] >> vector % WORD_VECTORS * LANES);
}

ALWAYS void hear(const struct job *job, struct swarm *s, const int vectors, const int words)
{
    const struct decision *decision = &job->params->decision;
    const bool always = decision->listens_for < 0, values = job->params->strategy.value_scale > 0.0;
    union row heard;
    for (int w = 0; w < words; w++) {
        const u32 speaking = spread(s->speaking[w]), said = spread(s->says_feasible[w]);
        for (int a = 0; a < vectors; a++) {
            u32 spoken = s->sight[w].v[a] & speaking;
            if (!always)
                spoken &= lanes_in(s->disseminating, a);
            if (decision->every_message) {
                s->votes.v[a] += ones_of(spoken);
                s->feasible_votes.v[a] += ones_of(spoken & said);
            } else {
                s->heard[w].v[a] |= spoken;
                s->heard_feasible[w].v[a] = (s->heard_feasible[w].v[a] & ~spoken) | (spoken & said);
            }
            if (RARELY(values))
                heard.v[a] = spoken;
        }
        if (RARELY(values && !decision->every_message))
            keep_values(s, (int)job->params->robots.count, w, &heard);
    }
}

ALWAYS void look(const struct job *job, struct swarm *s, const int vectors, const int words)
{
    const u32 itself = spread((uint32_t)job->params->sensing.count_self);
    for (int w = 0; w < words; w++)
        for (uint32_t left = s->there[w] & ~s->disseminating[w]; left; left &= left - 1) {
            int i = 32 * w + lowest(left);
            s->tasks_seen[i] += count_tasks(&s->tasks, job->params->tasks.lists.band, s->x.e[i], s->y.e[i]);
        }
    for (int a = 0; a < vectors; a++) {
        u32 seen = itself;
        for (int w = 0; w < words; w++)
            seen += ones_of(s->sight[w].v[a]);
        s->robots_seen.v[a] += seen & ~lanes_in(s->disseminating, a);
    }
}

ALWAYS void move(struct swarm *s, uint32_t now, uint32_t *turning, uint32_t *ending, const int vectors)
{
    const u32 present = spread(now);
    for (int a = 0; a < vectors; a++) {
        const int shift = a % WORD_VECTORS * LANES;
        s->x.v[a] += s->step_x.v[a];
        s->y.v[a] += s->step_y.v[a];
        turning[a / WORD_VECTORS] |= equal(s->turns_at.v[a], present) << shift;
        ending[a / WORD_VECTORS] |= equal(s->ends_at.v[a], present) << shift;
    }
}

ALWAYS void step(const struct job *job, struct swarm *s, uint32_t now, const int vectors, const bool fixed)
{
    const struct params *params = job->params;
    const int words = (vectors + WORD_VECTORS - 1) / WORD_VECTORS, robots = (int)params->robots.count;
    uint32_t turning[WORDS] = {0}, ending[WORDS] = {0};
    move(s, now, turning, ending, vectors);
    find_sight(s, (struct reach){params->sensing.limit, params->sensing.band}, robots, vectors, fixed);
    look(job, s, vectors, words);
    if (params->radio.limit != params->sensing.limit)
        find_sight(s, (struct reach){params->radio.limit, params->radio.band}, robots, vectors, fixed);
    hear(job, s, vectors, words);
    for (int w = 0; w < words; w++)
        for (uint32_t left = turning[w]; left; left &= left - 1)
            turn(job, s, 32 * w + lowest(left), now);
    for (int w = 0; w < words; w++) {
        const uint32_t exploring = ending[w] & ~s->disseminating[w], deciding = ending[w] & s->disseminating[w];
        for (uint32_t left = exploring; left; left &= left - 1)
            end_exploration(job, s, 32 * w + lowest(left), now);
        for (uint32_t left = deciding; left; left &= left - 1)
            end_dissemination(job, s, 32 * w + lowest(left), now, words);
    }
}

/* --- Runs --- */

#define POLLED 256 /* steps, of a few microseconds each, between two looks at what others have set */

ALWAYS int64_t members_of(const uint32_t *set, const int words)
{
    int64_t number = 0;
    for (int w = 0; w < words; w++)
        number += members(set[w]);
    return number;
}

APART int64_t sum_probabilities(const struct job *job, struct swarm *s)
{
    int64_t said = 0;
    for (int i = 0; i < job->params->robots.count; i++) {
        struct mind mind = mind_in(job, s, i);
        said += said_by(job, &mind, (struct known){0});
    }
    return said;
}

/* Play a run that has begun; return whether it came to its end. */
ALWAYS bool play(const struct job *job, struct swarm *s, int64_t row, const int vectors, const bool fixed)
{
    const struct params *params = job->params;
    const int words = (vectors + WORD_VECTORS - 1) / WORD_VECTORS;
    const int64_t robots = params->robots.count, quorum = quorum_of(params), steps = params->run.steps;
    struct verdict verdict = {UNDECIDED, -1};
    int64_t messages = 0, now = 0, feasible, infeasible;
    for (;; now++) {
        feasible = members_of(s->feasible, words);
        infeasible = robots - feasible - members_of(s->neutral, words);
        record_step(job, &verdict, row, now, quorum, feasible, infeasible);
        if (now == steps || (params->run.stop_at_decision && verdict.decision != UNDECIDED))
            break;
        if (RARELY(now % POLLED == POLLED - 1)) {
            count_steps(job->control, POLLED);
            if (is_cancelled(job->control))
                return false;
        }
        messages += members_of(s->speaking, words);
        step(job, s, (uint32_t)(now + 1), vectors, fixed);
    }
    count_steps(job->control, now % POLLED);
    record_end(job, &verdict, row, now, feasible, infeasible, messages * params->radio.message_bits);
    if (are_asked(job))
        job->outcome->account[row * job->outcome->columns + SAID_AT_END] = sum_probabilities(job, s);
    return true;
}

#define PLAY(count) \
    APART bool play_##count(const struct job *job, struct swarm *s, int64_t row) { return play(job, s, row, count, true); }
#if VECTOR < 32
PLAY(5)
#endif
#ifndef __wasm__ /* a page loads the paper's swarm only */
PLAY(1)
PLAY(2)
#if VECTOR < 64
PLAY(3)
PLAY(4)
#endif
#if VECTOR < 32
PLAY(6)
PLAY(7)
PLAY(8)
#endif
#endif
APART bool play_more(const struct job *job, struct swarm *s, int64_t row, int vectors)
{
    return play(job, s, row, vectors, false);
}

static bool play_run(const struct job *job, struct swarm *s, int64_t run, int64_t row)
{
    const int vectors = (int)((job->params->robots.count + LANES - 1) / LANES);
    begin(job, s, run);
    switch (vectors) {
#if VECTOR < 32
    case 5: return play_5(job, s, row);
#endif
#ifndef __wasm__
    case 1: return play_1(job, s, row);
    case 2: return play_2(job, s, row);
#if VECTOR < 64
    case 3: return play_3(job, s, row);
    case 4: return play_4(job, s, row);
#endif
#if VECTOR < 32
    case 6: return play_6(job, s, row);
    case 7: return play_7(job, s, row);
    case 8: return play_8(job, s, row);
#endif
#endif
    default: return play_more(job, s, row, vectors);
    }
}

#ifdef _WIN32 /* whose C library has no aligned_alloc */
#define new_aligned(alignment, size) _aligned_malloc(size, alignment)
#define free_aligned _aligned_free
#else
#define new_aligned aligned_alloc
#define free_aligned free
#endif
#define ALIGNED(size) (((size_t)(size) + 63) & ~(size_t)63)

/* Allocate a swarm with all that its size depends on, in one piece; free it by its address. */
static struct swarm *new_swarm(const struct job *job)
{
    const struct params *params = job->params;
    const int bits = (int)params->tasks.lists.bits;
    struct lists tasks = {
        .count = (int)params->tasks.count,
        .bits = bits,
        .shift = (int)params->tasks.lists.shift,
        .far = columns_in_range(params->sensing.limit, bits),
        .limit = params->sensing.limit,
    };
    const size_t cells = (size_t)4 << 2 * bits, values = params->strategy.value_scale > 0.0 ? sizeof(int32_t) * FEW * FEW : 0;
    const size_t sizes[] = {sizeof(struct swarm), 4 * places_needed(&tasks), cells, cells, 4 * (size_t)tasks.count,
                            4 * (size_t)tasks.count, sizeof(double) * (size_t)(FEW * job->memory), values};
    const size_t parts = sizeof sizes / sizeof *sizes;
    size_t total = 0;
    char *part[sizeof sizes / sizeof *sizes];
    for (size_t k = 0; k < parts; k++)
        total += ALIGNED(sizes[k]);
    char *at = new_aligned(64, total);
    if (!at)
        return NULL;
    for (size_t k = 0; k < parts; k++) {
        part[k] = at;
        at += ALIGNED(sizes[k]);
    }
    struct swarm *swarm = (struct swarm *)(void *)part[0];
    tasks.places = (uint32_t *)(void *)part[1];
    tasks.first = (int32_t *)(void *)part[2];
    tasks.last = (int32_t *)(void *)part[3];
    tasks.x = (uint32_t *)(void *)part[4];
    tasks.y = (uint32_t *)(void *)part[5];
    swarm->tasks = tasks;
    swarm->memory = (double *)(void *)part[6];
    swarm->values = (int32_t *)(void *)part[7];
    return swarm;
}

/* The runs of a call, of which so many are complete. */
struct runs {
    const struct job *job;
    struct swarm *swarm;
    int64_t first, complete;
};

static int64_t play_runs(void *given)
{
    struct runs *runs = given;
    while (runs->complete < runs->job->outcome->runs &&
           play_run(runs->job, runs->swarm, runs->first + runs->complete, runs->complete))
        runs->complete++;
    return 0;
}

int64_t few_play(const struct job *job, int64_t first_run)
{
    struct runs runs = {job, new_swarm(job), first_run, 0};
    if (!runs.swarm)
        return -1;
    attempt(play_runs, &runs, 0, &job->control->failure);
    free_aligned(runs.swarm);
    return runs.complete;
}

/* What is drawn one at a time: any coordinate, and numbers made of its words (model.md 1.5). */

#ifndef CHANCE_H
#define CHANCE_H

#include "decisions.h"
#include "draws.h"
#include "state.h"

/* Purposes of draws: feasibee.base.purposes, after those of draws.h. */
enum later_purpose {
    CENTRE_ROBOT = 5,
    CENTRE_TASK = 6,
    CLUSTER_ROBOT = 7,
    CLUSTER_TASK = 8,
    SCATTER_ROBOT = 9,
    SCATTER_TASK = 10,
    SITE = 11,
    FAULT = 12,
    MISS_ROBOT = 13,
    MISS_TASK = 14,
    FALSE_ROBOT = 15,
    FALSE_TASK = 16,
    FALSE_ROBOT_CLASS = 17,
    FALSE_TASK_CLASS = 18,
    LOSS = 19,
    LIE = 20,
    IDENTITY_HASH = 21,
    ARRIVAL = 22,
    LIFETIME = 23,
    FAILURE = 24,
    VANISH = 25,
    LEAVE = 26,
    JOINING_CLASS = 27,
    APPEARING_CLASS = 28,
    MISNAME = 30,
    BATTERY = 31,
    PAIR = 256, /* a draw about a pair has the purpose, plus PAIR times the number of the second */
};

/* Return the words of the draw at a coordinate. */
ALWAYS struct words draw_words(const struct state *s, int64_t robot, int64_t counter, int64_t purpose)
{
    return philox(source_of(s->params, s->clock->run, (uint32_t)purpose), (uint32_t)counter, (uint32_t)robot);
}

ALWAYS uint32_t draw(const struct state *s, int64_t robot, int64_t counter, int64_t purpose)
{
    return draw_words(s, robot, counter, purpose).word[0];
}

/* Return the first word of a draw whose counter is the number of the present step. */
ALWAYS uint32_t draw_now(const struct state *s, int64_t robot, int64_t purpose)
{
    return draw(s, robot, s->clock->step + 1, purpose);
}

/* Return whether an event happens to a robot in this step; its probability is in units of 2**-32. */
ALWAYS bool happens(const struct state *s, int64_t robot, int64_t purpose, uint64_t probability)
{
    return probability > 0 && draw_now(s, robot, purpose) < probability;
}

ALWAYS int64_t coin(uint32_t word) { return word >> 31; }

/* Return e to the power of a number of 0 or less, to the last bits: the same on any platform. */
static inline double exponential_of(double x)
{
    union {
        uint64_t bits;
        double number;
    } scale;
    const double power = __builtin_floor(x * 1.4426950408889634 + 0.5);
    const double rest = (x - power * 6.93147180369123816490e-01) - power * 1.90821492927058770002e-10;
    double series = 1.0;
    for (int k = 20; k > 0; k--)
        series = 1.0 + rest / k * series;
    if (power < -1022.0)
        return 0.0;
    scale.bits = (uint64_t)(1023 + (int64_t)power) << 52;
    return series * scale.number;
}

/* Return a Poisson number by inverting its distribution function. */
static inline int64_t poisson(uint32_t word, double mean)
{
    int64_t number = 0;
    double probability = exponential_of(-mean), below = probability;
    while (word >= below * 4294967296.0 && number < 200) {
        number++;
        probability = probability * mean / (double)number;
        below = below + probability;
    }
    return number;
}

/* Write 0 to count - 1 in random order (Fisher and Yates). */
static inline void shuffle(const struct state *s, int32_t *order, int64_t count, int64_t purpose)
{
    for (int64_t k = 0; k < count; k++)
        order[k] = (int32_t)k;
    for (int64_t k = 0; k < count; k++) {
        const int64_t other = k + choose(draw(s, 0, k, purpose), count - k);
        const int32_t moved = order[k];
        order[k] = order[other];
        order[other] = moved;
    }
}

/* Return a nearly normal deviate of a standard deviation: the sum of twelve words, less its mean. */
static inline int64_t normal(const struct state *s, int64_t robot, int64_t counter, int64_t purpose, int64_t scale)
{
    int64_t total = 0;
    for (int part = 0; part < 3; part++) {
        const struct words drawn = draw_words(s, robot, counter + part, purpose);
        total += (int64_t)drawn.word[0] + drawn.word[1] + drawn.word[2] + drawn.word[3];
    }
    return (((total - 6 * (INT64_C(1) << 32)) >> 8) * scale) >> 24;
}

#endif

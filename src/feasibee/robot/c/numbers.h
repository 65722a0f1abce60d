/* Arithmetic of the controller: ratios, and durations drawn from a random word (model.md 3.4). */

#include "controller.h"

#if defined(FEASIBEE_DOUBLE) && !defined(FEASIBEE_LOG)
#include <math.h>
#define FEASIBEE_LOG log
#endif

/* Return the quality of feasible: n_obs / (n_obs + m_obs), or 1/2 with nothing seen (eq. 1). */
static inline struct feasibee_ratio feasibee_share_of_robots(feasibee_amount robots, feasibee_amount tasks)
{
    struct feasibee_ratio half = {1, 2}, share = {robots, robots + tasks};
    return share.whole == 0 ? half : share;
}

/* Return the upper half of a product: a * b / 2^32. */
static inline uint32_t feasibee_times(uint32_t a, uint32_t b)
{
    return (uint32_t)((uint64_t)a * b >> 32);
}

/* Return part / whole in 1/2^32, for part < whole. One bit at a time: no division of 64 bits. */
static inline uint32_t feasibee_fraction(uint32_t part, uint32_t whole)
{
    uint32_t quotient = 0;
    for (uint8_t bit = 0; bit < 32; bit++) {
        bool carry = part >> 31;
        part <<= 1;
        quotient <<= 1;
        if (carry || part >= whole) {
            part -= whole;
            quotient |= 1;
        }
    }
    return quotient;
}

#ifdef FEASIBEE_DOUBLE

static inline double feasibee_double(struct feasibee_ratio ratio)
{
    return (double)ratio.part / (double)ratio.whole;
}

/* Return a mean in steps; each operation as in Python. */
static inline double feasibee_mean_steps(const struct feasibee_mean *mean)
{
    double share = feasibee_double(mean->share);
    return mean->steps * (mean->complement ? 1.0 - share : share);
}

/* Return an exponential duration in whole steps, at least 1: the draw of the simulator. */
static inline uint32_t feasibee_exponential(const struct feasibee_mean *mean, uint32_t word)
{
    const uint32_t longest = UINT32_C(1) << 30;
    double drawn = -feasibee_mean_steps(mean) * FEASIBEE_LOG(((double)word + 1.0) / 4294967296.0);
    if (drawn >= (double)longest)
        return longest;
    uint32_t whole = (uint32_t)drawn;
    return drawn > (double)whole ? whole + 1 : (whole > 0 ? whole : 1);
}

#else

/* Return -log((word + 1) / 2^32) in 1/2^26, by squaring one bit of the binary logarithm at a time. */
static inline uint32_t feasibee_minus_log(uint32_t word)
{
    if (word == UINT32_MAX)
        return 0;
    uint32_t number = word + 1;
    uint32_t octaves = 1;
    for (; number >> 31 == 0; number <<= 1)
        octaves++;
    uint32_t digits = 0;
    for (uint8_t bit = 0; bit < 26; bit++) {
        number = feasibee_times(number, number);
        digits = digits << 1 | number >> 31;
        if (number >> 31 == 0)
            number <<= 1;
    }
    const uint32_t log_of_two = UINT32_C(2977044472); /* times 2^32 */
    return feasibee_times((octaves << 26) - digits, log_of_two);
}

/* Return an exponential duration in whole steps, at least 1, without floating point. */
static inline uint32_t feasibee_exponential(const struct feasibee_mean *mean, uint32_t word)
{
    uint32_t part = mean->complement ? mean->share.whole - mean->share.part : mean->share.part;
    uint32_t steps = mean->steps;
    if (part < mean->share.whole)
        steps = feasibee_times(steps, feasibee_fraction(part, mean->share.whole));
    return (feasibee_times(steps, feasibee_minus_log(word)) >> 10) + 1; /* 16 + 26 - 32 binary places */
}

#endif

/* Return a share as a value of so many bits, to the nearest. */
static inline uint16_t feasibee_value_of(struct feasibee_ratio ratio, uint8_t bits)
{
    uint32_t one = (UINT32_C(1) << bits) - 1;
#ifdef FEASIBEE_DOUBLE
    return (uint16_t)(feasibee_double(ratio) * (double)one + 0.5);
#else
    return (uint16_t)(((uint64_t)ratio.part * (2 * one) + ratio.whole) / ((uint64_t)ratio.whole * 2));
#endif
}

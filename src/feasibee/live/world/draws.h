/* Random numbers, and what is drawn from them: docs/model.md 2, 3.4, and reference/draws.py to the last bit.
 *
 * Sums, products and quotients of doubles only, so that no platform's mathematical library has a say.
 */
#ifndef FEASIBEE_PAGE_DRAWS_H
#define FEASIBEE_PAGE_DRAWS_H

#include <stdint.h>

/* Numbers of purposes, as in model/purposes.py; a test compares them. */
enum purpose {
    PLACE_ROBOT = 0, PLACE_TASK = 1, FIRST_OPINION = 2, WALK = 3, PHASE = 4, MISS_ROBOT = 13, MISS_TASK = 14, LOSS = 19,
    IDENTITY = 21, VANISH = 25, LEAVE = 26, PAIR = 256
};

#define TURN 4294967296.0       /* number of words; as an angle, a full turn */
#define LONGEST (1 << 30)       /* steps, as in model/codes.py */
#define ATTEMPTS 256            /* draws of a place for each robot that comes, likewise */
#define HALF_PI 1.5707963267948966

struct draw {
    uint32_t word[4];
};

/* Return four random words: Philox4x32-10 (Salmon et al., SC 2011, section 4.3). */
static struct draw philox(uint64_t seed, uint32_t run, uint32_t robot, uint32_t counter, uint32_t purpose)
{
    uint32_t low = (uint32_t)seed, high = (uint32_t)(seed >> 32);
    uint32_t a = counter, b = robot, c = run, d = purpose;
    for (int round = 0; round < 10; round++) {
        uint64_t left = (uint64_t)a * 0xD2511F53u, right = (uint64_t)c * 0xCD9E8D57u;
        a = (uint32_t)(right >> 32) ^ b ^ low;
        b = (uint32_t)right;
        c = (uint32_t)(left >> 32) ^ d ^ high;
        d = (uint32_t)left;
        low += 0x9E3779B9u;
        high += 0xBB67AE85u;
    }
    return (struct draw){{a, b, c, d}};
}

/* Return a product's rounding error, by Dekker's splitting. */
static double product_error(double x, double y, double product)
{
    double split_x = 134217729.0 * x, split_y = 134217729.0 * y; /* 2**27 + 1 */
    double high_x = split_x - (split_x - x), low_x = x - high_x;
    double high_y = split_y - (split_y - y), low_y = y - high_y;
    return ((high_x * high_y - product) + high_x * low_y + low_x * high_y) + low_x * low_y;
}

/* Return 2 atanh(s) - 2 s for |s| < 0.172: a series whose next term is below the last bit. */
static double beyond_first_term(double s)
{
    double square = s * s, sum = 0.0;
    for (int k = 25; k >= 3; k -= 2)
        sum = sum * square + 2.0 / k;
    return s * square * sum;
}

/* Return the natural logarithm of a positive normal number.
 *
 * log(2**e m) = e log 2 + 2 atanh(s) with s = (m - 1) / (m + 1). The two leading terms carry their rounding
 * errors along, so the error is at most 0.52 units of the last place. That of C libraries is no smaller.
 */
static double natural_log(double x)
{
    union { double number; uint64_t bits; } parts = {x};
    int exponent = (int)(parts.bits >> 52) - 1023;
    parts.bits = (parts.bits & 0xFFFFFFFFFFFFFull) | 0x3FF0000000000000ull;
    if (parts.number > 1.4142135623730951) {
        parts.number *= 0.5;
        exponent++;
    }
    double f = parts.number - 1.0;                  /* exact */
    double divisor = 2.0 + f, lost = f - (divisor - 2.0);
    double s = f / divisor, product = s * divisor;
    double s_lost = (((f - product) - product_error(s, divisor, product)) - s * lost) / divisor;
    double whole = exponent * 6.93147180369123816490e-01;   /* 32 bits of log 2: exact */
    double sum = whole + 2.0 * s;
    double back = sum - whole, sum_lost = (whole - (sum - back)) + (2.0 * s - back);
    double small = exponent * 1.90821492927058770002e-10 + 2.0 * s_lost + beyond_first_term(s);
    return sum + (sum_lost + small);
}

/* Return an exponential duration in whole steps, at least 1 (model.md 3.4). */
static uint32_t duration(uint32_t word, double mean)
{
    double steps = __builtin_ceil(-mean * natural_log((word + 1.0) / TURN));
    if (!(steps > 1.0))
        return 1;
    return steps < LONGEST ? (uint32_t)steps : LONGEST;
}

/* Return cosine and sine of a heading: Taylor's polynomial about the nearest quarter turn (model.md 2.2). */
static void cos_sin(uint32_t heading, double *cosine, double *sine)
{
    uint64_t turned = (uint64_t)heading + (1u << 29);
    double angle = (double)((int64_t)(turned & 0x3FFFFFFF) - (1 << 29)) * (HALF_PI / (1 << 30));
    double square = angle * angle, c = 1.0, s = 1.0;
    for (int k = 16; k > 0; k -= 2) {
        s = 1.0 - square * (1.0 / (k * (k + 1))) * s;
        c = 1.0 - square * (1.0 / (k * (k - 1))) * c;
    }
    s *= angle;
    switch ((turned >> 30) & 3) {
    case 0: *cosine = c, *sine = s; return;
    case 1: *cosine = -s, *sine = c; return;
    case 2: *cosine = -c, *sine = -s; return;
    default: *cosine = s, *sine = -c; return;
    }
}

#endif

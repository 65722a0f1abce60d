/* Python's operations on numbers, for a user's strategy: what Python raises an error for is a failure.
 *
 * Before this file, a program includes the enumeration of failures, which feasibee.engine.failing writes.
 * Names are those that feasibee.engine.operations writes. The first argument is the line of the user's file. */

#ifndef CHECKED_H
#define CHECKED_H

#include <math.h>

#include "translated.h"

#define FEASIBEE_LEAST (-9223372036854775807 - 1)
#define FEASIBEE_BEYOND 9223372036854775808.0 /* the first real number that is too large for 64 bits */

static void (*fail)(int32_t what, int32_t line, double first, double second);

void feasibee_bind(void (*given)(int32_t what, int32_t line, double first, double second))
{
    fail = given;
}

static _Noreturn __attribute__((noinline, cold)) void feasibee_failed(int32_t line, int32_t what, double first, double second)
{
    fail(what, line, first, second);
    __builtin_trap(); /* it never returns */
}

/* Count a pass of a loop: one that goes on for ever would keep the run from being stopped. */
static inline void feasibee_pass(int32_t line, int64_t *passes)
{
    if (++*passes > PASSES)
        feasibee_failed(line, ENDLESS, PASSES, 0);
}

/* --- Whole numbers: what leaves 64 bits is a failure, and division rounds down --- */

static inline int64_t feasibee_plus(int32_t line, int64_t one, int64_t other)
{
    int64_t sum;
    if (__builtin_add_overflow(one, other, &sum))
        feasibee_failed(line, SUM, (double)one, (double)other);
    return sum;
}

static inline int64_t feasibee_minus(int32_t line, int64_t one, int64_t other)
{
    int64_t difference;
    if (__builtin_sub_overflow(one, other, &difference))
        feasibee_failed(line, DIFFERENCE, (double)one, (double)other);
    return difference;
}

static inline int64_t feasibee_times(int32_t line, int64_t one, int64_t other)
{
    int64_t product;
    if (__builtin_mul_overflow(one, other, &product))
        feasibee_failed(line, PRODUCT, (double)one, (double)other);
    return product;
}

static inline int64_t feasibee_divided(int32_t line, int64_t one, int64_t other)
{
    if (other == 0)
        feasibee_failed(line, WHOLE_DIVISION, (double)one, 0);
    if (other == -1 && one == FEASIBEE_LEAST)
        feasibee_failed(line, QUOTIENT, (double)one, -1);
    int64_t quotient = one / other;
    return one % other != 0 && (one < 0) != (other < 0) ? quotient - 1 : quotient;
}

static inline int64_t feasibee_modulo(int32_t line, int64_t one, int64_t other)
{
    if (other == 0)
        feasibee_failed(line, WHOLE_MODULO, (double)one, 0);
    if (other == -1)
        return 0;
    int64_t rest = one % other;
    return rest != 0 && (rest < 0) != (other < 0) ? rest + other : rest;
}

static inline int64_t feasibee_power(int32_t line, int64_t base, int64_t exponent)
{
    if (exponent < 0)
        feasibee_failed(line, NEGATIVE_EXPONENT, (double)base, (double)exponent);
    int64_t power = 1, square = base;
    bool left = false; /* whether the square has left 64 bits */
    for (int64_t rest = exponent; rest > 0; rest >>= 1) {
        if ((rest & 1) && (left || __builtin_mul_overflow(power, square, &power)))
            feasibee_failed(line, POWER, (double)base, (double)exponent);
        left = left || __builtin_mul_overflow(square, square, &square);
    }
    return power;
}

static inline int64_t feasibee_left(int32_t line, int64_t number, int64_t places)
{
    if (places < 0)
        feasibee_failed(line, LEFT_SHIFT, (double)number, (double)places);
    if (number == 0)
        return 0;
    int64_t shifted = places < 64 ? (int64_t)((uint64_t)number << places) : 0;
    if (places > 63 || shifted >> places != number)
        feasibee_failed(line, SHIFT, (double)number, (double)places);
    return shifted;
}

static inline int64_t feasibee_right(int32_t line, int64_t number, int64_t places)
{
    if (places < 0)
        feasibee_failed(line, RIGHT_SHIFT, (double)number, (double)places);
    return number >> (places < 63 ? places : 63);
}

static inline int64_t feasibee_negative(int32_t line, int64_t number)
{
    if (number == FEASIBEE_LEAST)
        feasibee_failed(line, NEGATION, (double)number, 0);
    return -number;
}

static inline int64_t feasibee_abs_int(int32_t line, int64_t number)
{
    if (number == FEASIBEE_LEAST)
        feasibee_failed(line, SIZE, (double)number, 0);
    return number < 0 ? -number : number;
}

static inline int64_t feasibee_bit_count(int64_t number)
{
    return __builtin_popcountll(number < 0 ? 0 - (uint64_t)number : (uint64_t)number);
}

static inline int64_t feasibee_bit_length(int64_t number)
{
    uint64_t size = number < 0 ? 0 - (uint64_t)number : (uint64_t)number;
    return size == 0 ? 0 : 64 - __builtin_clzll(size);
}

static inline int64_t feasibee_gcd(int32_t line, int64_t one, int64_t other)
{
    uint64_t a = one < 0 ? 0 - (uint64_t)one : (uint64_t)one, b = other < 0 ? 0 - (uint64_t)other : (uint64_t)other;
    while (b != 0) {
        uint64_t rest = a % b;
        a = b;
        b = rest;
    }
    if (a >> 63)
        feasibee_failed(line, SIZE, (double)one, (double)other);
    return (int64_t)a;
}

/* Return the quotient of two whole numbers as a real one, rounded once. */
static inline double feasibee_ratio(int32_t line, int64_t one, int64_t other)
{
    const int64_t exact = INT64_C(1) << 53;
    if (other == 0)
        feasibee_failed(line, RATIO, (double)one, 0);
    if (-exact <= one && one <= exact && -exact <= other && other <= exact)
        return (double)one / (double)other;
    bool negative = (one < 0) != (other < 0);
    uint64_t part = one < 0 ? 0 - (uint64_t)one : (uint64_t)one;
    uint64_t whole = other < 0 ? 0 - (uint64_t)other : (uint64_t)other;
    int places = 0; /* bits until the quotient has at least 56, so that one more says whether it is exact */
    uint64_t quotient = part / whole, rest = part % whole;
    for (; rest != 0 && quotient >> 56 == 0; places++) {
        rest <<= 1;
        quotient = quotient << 1 | (rest >= whole);
        rest -= rest >= whole ? whole : 0;
    }
    double found = ldexp((double)(quotient | (rest != 0)), -places);
    return negative ? -found : found;
}

/* Return -1, 0 or 1 where a whole number is below, equal to or above a real one; 2 if that is no number. */
static inline int feasibee_order(int64_t one, double other)
{
    if (other != other)
        return 2;
    if (other >= FEASIBEE_BEYOND || other < -FEASIBEE_BEYOND)
        return other > 0 ? -1 : 1;
    int64_t whole = (int64_t)other;
    double rest = other - (double)whole;
    if (one != whole)
        return one < whole ? -1 : 1;
    return rest > 0 ? -1 : rest < 0 ? 1 : 0;
}

/* Return how often a loop over a range passes. */
static inline uint64_t feasibee_passes(int32_t line, int64_t first, int64_t last, int64_t step)
{
    if (step == 0)
        feasibee_failed(line, STEP, (double)first, (double)last);
    if (step > 0)
        return first < last ? ((uint64_t)last - (uint64_t)first - 1) / (uint64_t)step + 1 : 0;
    return first > last ? ((uint64_t)first - (uint64_t)last - 1) / (0 - (uint64_t)step) + 1 : 0;
}

static inline int64_t feasibee_next(int64_t counter, int64_t step)
{
    return (int64_t)((uint64_t)counter + (uint64_t)step); /* after the last pass it may wrap */
}

/* --- Real numbers --- */

static inline int64_t cut_whole(int32_t line, int32_t what, double given, double number)
{
    if (number != number)
        feasibee_failed(line, WHOLE_OF_NAN, given, 0);
    if (!(number < FEASIBEE_BEYOND && number >= -FEASIBEE_BEYOND))
        feasibee_failed(line, number - number == 0 ? what : WHOLE_OF_INFINITY, given, 0);
    return (int64_t)number;
}

static inline int64_t feasibee_int_of(int32_t line, double number)
{
    return cut_whole(line, WHOLE, number, trunc(number));
}

static inline int64_t feasibee_floor(int32_t line, double number)
{
    return cut_whole(line, FLOOR, number, floor(number));
}

static inline int64_t feasibee_ceil(int32_t line, double number)
{
    return cut_whole(line, CEIL, number, ceil(number));
}

static inline int64_t feasibee_round(int32_t line, double number)
{
    return cut_whole(line, ROUND, number, rint(number)); /* halves go to the even number */
}

static inline double feasibee_abs_real(double number)
{
    return fabs(number);
}

static inline double feasibee_over(int32_t line, double one, double other)
{
    if (other == 0)
        feasibee_failed(line, DIVISION, one, 0);
    return one / other;
}

static inline double feasibee_modulo_real(int32_t line, double one, double other)
{
    if (other == 0)
        feasibee_failed(line, REAL_MODULO, one, 0);
    double rest = fmod(one, other);
    if (rest == 0)
        return copysign(0.0, other);
    return (rest < 0) != (other < 0) ? rest + other : rest;
}

static inline double feasibee_divided_real(int32_t line, double one, double other)
{
    if (other == 0)
        feasibee_failed(line, REAL_DIVISION, one, 0);
    double rest = fmod(one, other), quotient = (one - rest) / other;
    if (rest != 0 && (rest < 0) != (other < 0))
        quotient -= 1.0;
    if (quotient == 0)
        return copysign(0.0, one / other);
    double below = floor(quotient);
    return quotient - below > 0.5 ? below + 1.0 : below;
}

static inline double feasibee_power_real(int32_t line, double base, double exponent)
{
    if (base == 0 && exponent < 0)
        feasibee_failed(line, ZERO_POWER, base, exponent);
    if (base < 0 && base - base == 0 && exponent - exponent == 0 && floor(exponent) != exponent)
        feasibee_failed(line, ROOT, base, exponent);
    double power = pow(base, exponent);
    if (power - power != 0 && base - base == 0 && exponent - exponent == 0)
        feasibee_failed(line, REAL_POWER, base, exponent);
    return power;
}

/* --- Functions of math: a number that isn't one, or an infinite one, of finite numbers is a failure --- */

static inline double of_one(int32_t line, int32_t domain, int32_t range, double result, double number)
{
    if (result != result && number == number)
        feasibee_failed(line, domain, number, 0);
    if (isinf(result) && isfinite(number))
        feasibee_failed(line, range, number, 0);
    return result;
}

static inline double of_two(int32_t line, int32_t domain, int32_t range, double result, double one, double other)
{
    if (result != result && one == one && other == other)
        feasibee_failed(line, domain, one, other);
    if (isinf(result) && isfinite(one) && isfinite(other))
        feasibee_failed(line, range, one, other);
    return result;
}

#define OF_ONE(name, range)                                                   \
    static inline double feasibee_##name(int32_t line, double number)         \
    {                                                                         \
        return of_one(line, DOMAIN_##name, range##_##name, name(number), number); \
    }
#define OF_TWO(name, range)                                                        \
    static inline double feasibee_##name(int32_t line, double one, double other)   \
    {                                                                              \
        return of_two(line, DOMAIN_##name, range##_##name, name(one, other), one, other); \
    }

OF_ONE(acos, DOMAIN)
OF_ONE(acosh, DOMAIN)
OF_ONE(asin, DOMAIN)
OF_ONE(asinh, DOMAIN)
OF_ONE(atan, DOMAIN)
OF_ONE(atanh, DOMAIN)
OF_ONE(cbrt, DOMAIN)
OF_ONE(cos, DOMAIN)
OF_ONE(cosh, RANGE)
OF_ONE(erf, DOMAIN)
OF_ONE(erfc, DOMAIN)
OF_ONE(exp, RANGE)
OF_ONE(exp2, RANGE)
OF_ONE(expm1, RANGE)
OF_ONE(fabs, DOMAIN)
OF_ONE(log, DOMAIN)
OF_ONE(log10, DOMAIN)
OF_ONE(log1p, DOMAIN)
OF_ONE(log2, DOMAIN)
OF_ONE(sin, DOMAIN)
OF_ONE(sinh, RANGE)
OF_ONE(sqrt, DOMAIN)
OF_ONE(tan, DOMAIN)
OF_ONE(tanh, DOMAIN)
OF_TWO(atan2, RANGE)
OF_TWO(copysign, RANGE)
OF_TWO(fmod, DOMAIN)
OF_TWO(hypot, RANGE)
#undef OF_ONE
#undef OF_TWO

static inline double feasibee_pow(int32_t line, double base, double exponent)
{
    int32_t infinite = base == 0 ? DOMAIN_pow : RANGE_pow;
    if (!isfinite(base) || !isfinite(exponent))
        return pow(base, exponent);
    return of_two(line, DOMAIN_pow, infinite, pow(base, exponent), base, exponent);
}

static inline double feasibee_degrees(int32_t line, double number)
{
    (void)line;
    return number * (180.0 / 3.141592653589793);
}

static inline double feasibee_radians(int32_t line, double number)
{
    (void)line;
    return number * (3.141592653589793 / 180.0);
}

/* --- Rows: a negative place counts from the end --- */

static inline int64_t place_in(int32_t line, int64_t place, int64_t length)
{
    int64_t counted = place < 0 ? place + length : place;
    if (counted < 0 || counted >= length)
        feasibee_failed(line, PLACE, (double)place, (double)length);
    return counted;
}

static inline double *feasibee_place_in_reals(int32_t line, struct feasibee_reals row, int64_t place)
{
    return &row.numbers[place_in(line, place, row.length)];
}

/* The parameters, which a strategy only reads. */
struct feasibee_constants {
    const double *numbers;
    int64_t length;
};

#define feasibee_constants_of(record) \
    ((struct feasibee_constants){(record)->parameters, (record)->parameter_count})

static inline double feasibee_parameter(int32_t line, struct feasibee_constants row, int64_t place)
{
    return row.numbers[place_in(line, place, row.length)];
}

static inline int64_t feasibee_cell(int32_t line, struct feasibee_plan plan, int64_t place)
{
    return plan.cells[place_in(line, place, plan.length)];
}

static inline int64_t feasibee_word(int32_t line, struct known row, int64_t place)
{
    return row.words[place_in(line, place, row.length)];
}

static inline int32_t *feasibee_place_in_row(int32_t line, struct known row, int64_t place)
{
    return &row.words[place_in(line, place, row.length)];
}

static inline int64_t *feasibee_place_in_counts(int32_t line, struct feasibee_counts row, int64_t place)
{
    return &row.numbers[place_in(line, place, row.length)];
}

/* A number of a constant tuple. */
static inline double feasibee_real_of(int32_t line, const double *numbers, int64_t length, int64_t place)
{
    return numbers[place_in(line, place, length)];
}

static inline int64_t feasibee_whole_of(int32_t line, const int64_t *numbers, int64_t length, int64_t place)
{
    return numbers[place_in(line, place, length)];
}

/* --- Variables and results --- */

static inline void feasibee_assigned(int32_t line, bool has)
{
    if (!has)
        feasibee_failed(line, NO_VALUE, 0, 0);
}

static inline double feasibee_result(int32_t line, int32_t what, double result, double least, double most)
{
    if (!(least <= result && result <= most))
        feasibee_failed(line, what, result, 0);
    return result;
}

static inline int64_t feasibee_whole_result(int32_t line, int32_t what, int64_t result, int64_t most)
{
    if (result < 0 || result > most)
        feasibee_failed(line, what, (double)result, 0);
    return result;
}

static inline int64_t feasibee_opinion(int32_t line, int32_t what, double result)
{
    if (!(result == 1 || result == 0 || result == -1))
        feasibee_failed(line, what, result, 0);
    return (int64_t)result;
}

#endif

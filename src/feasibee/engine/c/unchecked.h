/* Python's operations on numbers, for built-in strategies, whose numbers are never out of range. */

#ifndef UNCHECKED_H
#define UNCHECKED_H

#include "translated.h"
#include "vec.h"

#define FEASIBEE_DOUBLE /* functions that compute with real numbers are there */

typedef uint64_t feasibee_unsigned;

/* --- Rows --- */

ALWAYS double *feasibee_real_at(struct feasibee_reals row, int64_t place) { return &row.numbers[place]; }
ALWAYS int32_t *feasibee_at(struct known row, int64_t place) { return &row.words[place]; }
ALWAYS int64_t *feasibee_count_at(struct feasibee_counts row, int64_t place) { return &row.numbers[place]; }
ALWAYS const uint8_t *feasibee_cell_at(struct feasibee_plan plan, int64_t place) { return &plan.cells[place]; }

/* --- Whole numbers: division rounds down, and a remainder has the sign of the divisor --- */

FEASIBEE_ORDER(word, uint32_t)

ALWAYS int64_t feasibee_abs_int(int64_t number) { return number < 0 ? -number : number; }
ALWAYS uint64_t feasibee_size_int(int64_t number) { return number < 0 ? 0 - (uint64_t)number : (uint64_t)number; }

ALWAYS int64_t feasibee_divided_int(int64_t one, int64_t other)
{
    const int64_t quotient = one / other;
    return one % other != 0 && (one < 0) != (other < 0) ? quotient - 1 : quotient;
}

ALWAYS int64_t feasibee_modulo_int(int64_t one, int64_t other)
{
    const int64_t rest = one % other;
    return rest != 0 && (rest < 0) != (other < 0) ? rest + other : rest;
}

static inline int64_t feasibee_power_int(int64_t base, int64_t exponent)
{
    int64_t power = 1;
    for (; exponent > 0; exponent--)
        power *= base;
    return power;
}

ALWAYS int64_t feasibee_bit_count_int(uint64_t size) { return __builtin_popcountll(size); }
ALWAYS int64_t feasibee_bit_count_word(uint32_t word) { return __builtin_popcount(word); }
ALWAYS int64_t feasibee_bit_length_int(uint64_t size) { return size == 0 ? 0 : 64 - __builtin_clzll(size); }
ALWAYS int64_t feasibee_bit_length_word(uint32_t word) { return feasibee_bit_length_int(word); }

/* Numbers that are long on a robot are as others here. */
#define feasibee_min_long feasibee_min_int
#define feasibee_max_long feasibee_max_int
#define feasibee_abs_long feasibee_abs_int
#define feasibee_size_long feasibee_size_int
#define feasibee_divided_long feasibee_divided_int
#define feasibee_modulo_long feasibee_modulo_int
#define feasibee_power_long feasibee_power_int
#define feasibee_bit_count_long feasibee_bit_count_int
#define feasibee_bit_length_long feasibee_bit_length_int

/* --- Real numbers --- */

ALWAYS double feasibee_abs_real(double number) { return __builtin_fabs(number); }

ALWAYS int64_t feasibee_floor(double number)
{
    const int64_t whole = (int64_t)number;
    return (double)whole > number ? whole - 1 : whole;
}

ALWAYS int64_t feasibee_ceil(double number)
{
    const int64_t whole = (int64_t)number;
    return (double)whole < number ? whole + 1 : whole;
}

#define FEASIBEE_SQRT __builtin_sqrt

#ifdef __wasm__ /* without a C library */

#include "chance.h"

#define FEASIBEE_LOG natural_log
#define FEASIBEE_POW power_of_share

/* Return a power of a number above 0 that is at most 1, with an exponent of 0 or more, to the last bits. */
static inline double power_of_share(double base, double exponent)
{
    return exponential_of(exponent * natural_log(base));
}

#else

#define FEASIBEE_LOG __builtin_log
#define FEASIBEE_POW __builtin_pow

#endif

#endif

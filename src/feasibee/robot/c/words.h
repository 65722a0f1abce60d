/* What strategies that are translated from Python need: rows, records, and Python's whole numbers. */

#include "knowledge.h"
#include "numbers.h"

#define FEASIBEE_INFINITY FEASIBEE_REAL(1e30) /* a float may have 32 bits */

/* Functions of math.h; a program may define its own where there is none, as numbers.h has it for FEASIBEE_LOG. */
#ifdef FEASIBEE_DOUBLE
#ifndef FEASIBEE_POW
#include <math.h>
#define FEASIBEE_POW pow
#endif
#ifndef FEASIBEE_SQRT
#include <math.h>
#define FEASIBEE_SQRT sqrt
#endif
#endif

/* --- Rows --- */

struct feasibee_reals {
    feasibee_real *numbers;
    int16_t length;
};

struct feasibee_counts {
    int64_t *numbers;
    int16_t length;
};

/* With FEASIBEE_BOUNDS, for tests, a program ends where a place isn't in its row. */
#ifdef FEASIBEE_BOUNDS
#define FEASIBEE_WITHIN(place, length) ((place) >= 0 && (place) < (length) ? (void)0 : __builtin_trap())
#else
#define FEASIBEE_WITHIN(place, length) ((void)0)
#endif

static inline int32_t *feasibee_at(struct feasibee_row row, int place)
{
    FEASIBEE_WITHIN(place, row.length);
    return &row.words[place];
}

static inline feasibee_real *feasibee_real_at(struct feasibee_reals row, int place)
{
    FEASIBEE_WITHIN(place, row.length);
    return &row.numbers[place];
}

static inline int64_t *feasibee_count_at(struct feasibee_counts row, int place)
{
    FEASIBEE_WITHIN(place, row.length);
    return &row.numbers[place];
}

#ifdef FEASIBEE_DOUBLE

static inline const uint8_t *feasibee_cell_at(struct feasibee_plan plan, int place)
{
    FEASIBEE_WITHIN(place, plan.length);
    return &plan.cells[place];
}

#endif

/* --- Records --- */

static inline struct feasibee_reals feasibee_parameters_of(const struct feasibee_setting *setting)
{
    struct feasibee_reals row = {(feasibee_real *)(uintptr_t)setting->parameters, FEASIBEE_PARAMETERS};
    return row;
}

/* Return a quality as a ratio. */
static inline struct feasibee_ratio feasibee_whole_of(feasibee_real quality)
{
    struct feasibee_ratio ratio = {(feasibee_amount)quality, 1};
    return ratio;
}

static inline feasibee_real feasibee_real_of(struct feasibee_ratio ratio)
{
    return (feasibee_real)ratio.part / (feasibee_real)ratio.whole;
}

/* Return the quality of the robot's opinion; 1/2 without one (model.md 4.3). */
static inline feasibee_real feasibee_own_quality(const struct feasibee_robot *robot)
{
    feasibee_real quality = feasibee_real_of(robot->feasible_quality);
    if (robot->opinion == FEASIBEE_NONE)
        return FEASIBEE_REAL(0.5);
    return robot->opinion == FEASIBEE_FEASIBLE ? quality : FEASIBEE_REAL(1.0) - quality;
}

static inline int8_t feasibee_opinion(feasibee_int number)
{
    return number == 0 || number == 1 ? (int8_t)number : (int8_t)FEASIBEE_NONE;
}

/* Return a value from 0 to 1 as the whole number of so many bits that a message holds. */
static inline uint16_t feasibee_sent(feasibee_real value, uint8_t bits)
{
    value = value < 0 ? 0 : value > 1 ? 1 : value;
    return (uint16_t)(value * (feasibee_real)((UINT32_C(1) << bits) - 1) + FEASIBEE_REAL(0.5));
}

static inline feasibee_real feasibee_heard_value(const struct feasibee_votes *votes)
{
    return (feasibee_real)votes->value / (feasibee_real)votes->one;
}

static inline feasibee_real feasibee_mean_value(const struct feasibee_votes *votes)
{
    feasibee_real heard = (feasibee_real)votes->feasible + (feasibee_real)votes->infeasible;
    return heard > 0 ? (feasibee_real)votes->sum / (heard * (feasibee_real)votes->one) : 0;
}

static inline feasibee_real feasibee_chance(const struct feasibee_votes *votes)
{
    return (feasibee_real)votes->chance / FEASIBEE_REAL(4294967296.0);
}

#ifdef FEASIBEE_DOUBLE

static inline struct feasibee_reals feasibee_memory_of(struct feasibee_robot *robot)
{
    struct feasibee_reals row = {robot->memory, FEASIBEE_MEMORY};
    return row;
}

#endif

/* --- Python's whole numbers: division rounds down, and a remainder has the sign of the divisor --- */

#define FEASIBEE_ORDER(name, type)                               \
    static inline type feasibee_min_##name(type one, type other) \
    {                                                            \
        return other < one ? other : one;                        \
    }                                                            \
    static inline type feasibee_max_##name(type one, type other) \
    {                                                            \
        return other > one ? other : one;                        \
    }

#define FEASIBEE_SIGNED(name, type)                     \
    FEASIBEE_ORDER(name, type)                          \
    static inline type feasibee_abs_##name(type number) \
    {                                                   \
        return number < 0 ? -number : number;           \
    }

#define FEASIBEE_WHOLE(name, type)                                                   \
    FEASIBEE_SIGNED(name, type)                                                      \
    static inline type feasibee_divided_##name(type one, type other)                 \
    {                                                                                \
        type quotient = one / other;                                                 \
        return one % other != 0 && (one < 0) != (other < 0) ? quotient - 1 : quotient; \
    }                                                                                \
    static inline type feasibee_modulo_##name(type one, type other)                  \
    {                                                                                \
        type rest = one % other;                                                     \
        return rest != 0 && (rest < 0) != (other < 0) ? rest + other : rest;         \
    }                                                                                \
    static inline type feasibee_power_##name(type base, type exponent)               \
    {                                                                                \
        type power = 1;                                                              \
        for (; exponent > 0; exponent--)                                             \
            power *= base;                                                           \
        return power;                                                                \
    }

FEASIBEE_WHOLE(int, feasibee_int)
FEASIBEE_WHOLE(long, int64_t)
FEASIBEE_ORDER(word, uint32_t)
FEASIBEE_SIGNED(real, feasibee_real)

static inline feasibee_int feasibee_floor(feasibee_real number)
{
    feasibee_int whole = (feasibee_int)number;
    return (feasibee_real)whole > number ? whole - 1 : whole;
}

static inline feasibee_int feasibee_ceil(feasibee_real number)
{
    feasibee_int whole = (feasibee_int)number;
    return (feasibee_real)whole < number ? whole + 1 : whole;
}

/* Return how many bits of a number are 1, and how many it has without the zeros before it. */
#define FEASIBEE_BITS(name, type)                                  \
    static inline feasibee_int feasibee_bit_count_##name(type left)  \
    {                                                              \
        feasibee_int found = 0;                                    \
        for (; left != 0; left &= left - 1)                        \
            found++;                                               \
        return found;                                              \
    }                                                              \
    static inline feasibee_int feasibee_bit_length_##name(type left) \
    {                                                              \
        feasibee_int bits = 0;                                     \
        for (; left != 0; left >>= 1)                              \
            bits++;                                                \
        return bits;                                               \
    }

FEASIBEE_BITS(word, uint32_t)
FEASIBEE_BITS(int, feasibee_unsigned)
FEASIBEE_BITS(long, uint64_t)

/* Return the absolute value, which always fits. */
static inline feasibee_unsigned feasibee_size_int(feasibee_int number)
{
    return number < 0 ? 0 - (feasibee_unsigned)number : (feasibee_unsigned)number;
}

static inline uint64_t feasibee_size_long(int64_t number)
{
    return number < 0 ? 0 - (uint64_t)number : (uint64_t)number;
}

/* --- Messages as bits (strategies/layout.py) --- */

/* The bits of one message, which go to a writer or come from a reader: the other is NULL. */
struct feasibee_layout {
    struct feasibee_writer *writer;
    struct feasibee_reader *reader;
};

static inline uint32_t feasibee_wire_number(struct feasibee_layout *wire, uint32_t number, uint32_t bits)
{
    if (wire->reader)
        return feasibee_reader_number(wire->reader, (uint8_t)bits);
    feasibee_writer_number(wire->writer, number, (uint8_t)bits);
    return number;
}

static inline uint32_t feasibee_wire_below(struct feasibee_layout *wire, uint32_t number, uint32_t bits,
                                           uint32_t limit)
{
    if (wire->reader)
        return feasibee_reader_below(wire->reader, limit, (uint8_t)bits);
    return feasibee_wire_number(wire, number, bits);
}

static inline bool feasibee_wire_flag(struct feasibee_layout *wire, bool flag)
{
    if (wire->reader)
        return feasibee_reader_flag(wire->reader);
    feasibee_writer_flag(wire->writer, flag);
    return flag && !wire->writer->failed;
}

static inline uint32_t feasibee_wire_rice(struct feasibee_layout *wire, uint32_t number, uint32_t low,
                                          uint32_t limit)
{
    if (wire->reader)
        return feasibee_reader_rice(wire->reader, limit, (uint8_t)low);
    feasibee_writer_rice(wire->writer, number, (uint8_t)low);
    return number;
}

static inline uint32_t feasibee_wire_task(struct feasibee_layout *wire, uint32_t name, uint32_t task,
                                          uint32_t limit)
{
    return wire->reader ? feasibee_reader_task(wire->reader, name, limit) : task;
}

/* Write or read all words as they are: the layout of strategies that have none. */
static inline feasibee_int feasibee_as_they_are(struct feasibee_layout *wire, struct feasibee_row message,
                                                feasibee_int sender, const struct feasibee_setting *setting)
{
    (void)sender, (void)setting;
    for (int16_t k = 0; k < message.length; k++)
        message.words[k] = (int32_t)feasibee_wire_number(wire, (uint32_t)message.words[k], 32);
    return -1;
}

static inline void feasibee_wire_check(struct feasibee_layout *wire, bool holds)
{
    if (wire->reader)
        feasibee_reader_check(wire->reader, holds);
}

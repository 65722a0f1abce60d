/* What functions translated from Python need in the engine: the names that feasibee.robot.translate writes. */

#ifndef TRANSLATED_H
#define TRANSLATED_H

#include "engine.h"

typedef int64_t feasibee_int;
typedef double feasibee_real;
#define FEASIBEE_REAL(number) (number)
#define FEASIBEE_INFINITY __builtin_inf()

struct feasibee_reals {
    double *numbers;
    int64_t length;
};

struct feasibee_counts {
    int64_t *numbers;
    int64_t length;
};

struct feasibee_plan {
    const uint8_t *cells;
    int64_t length;
};

/* What a robot keeps for its strategy, in a mind or in `me`. */
#define feasibee_memory_of(record) ((struct feasibee_reals){(record)->memory, (record)->memory_count})

/* Parameters of a mind or of a setting, which strategies only read. */
#define feasibee_parameters_of(record) \
    ((struct feasibee_reals){(double *)(uintptr_t)(record)->parameters, (record)->parameter_count})

static inline struct feasibee_plan feasibee_plan_of(const struct setting *setting)
{
    return (struct feasibee_plan){setting->plan, setting->plan_length};
}

/* Python's min and max: of equal numbers, the first. */
#define FEASIBEE_ORDER(name, type)                               \
    static inline type feasibee_min_##name(type one, type other) \
    {                                                            \
        return other < one ? other : one;                        \
    }                                                            \
    static inline type feasibee_max_##name(type one, type other) \
    {                                                            \
        return other > one ? other : one;                        \
    }

FEASIBEE_ORDER(int, int64_t)
FEASIBEE_ORDER(real, double)

#endif

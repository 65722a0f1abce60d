/* What a page of a browser needs in addition: runs by one call. Only WebAssembly has it. */

#include "memory.h"

#ifdef __wasm__

#include "engine.h"

#pragma GCC visibility push(default)

/* Simulate runs of a built-in strategy, as feasibee_play does; return how many are complete. */
int64_t feasibee_play_flat(const struct params *params, const char *strategy, const struct setting *setting,
                           int32_t memory, int64_t first_run, int32_t runs, int32_t curve_length, int32_t columns,
                           int8_t *decision, int32_t *decision_step, int32_t *feasible_count,
                           int32_t *infeasible_count, int64_t *account);

#pragma GCC visibility pop

int64_t feasibee_play_flat(const struct params *params, const char *strategy, const struct setting *setting,
                           int32_t memory, int64_t first_run, int32_t runs, int32_t curve_length, int32_t columns,
                           int8_t *decision, int32_t *decision_step, int32_t *feasible_count,
                           int32_t *infeasible_count, int64_t *account)
{
    const struct outcome outcome = {decision, decision_step, feasible_count, infeasible_count,
                                    account,  runs,          curve_length,   columns};
    int64_t steps = 0;
    const bool cancelled = false;
    struct control control = {&steps, &cancelled, {0}};
    const struct rules *rules = feasibee_rules(strategy);
    const uintptr_t before = room_taken();
    const int64_t complete =
        rules ? feasibee_play(params, rules, setting, memory, first_run, &outcome, &control) : -1;
    take_back(before);
    return complete;
}

#endif

/* What a page of a browser needs in addition: memory, and runs by one call. Only WebAssembly has it.
 *
 * A module has no system, and the engine takes little of a C library. So there is none to compile, which would
 * take 26 s, and the module imports nothing. */

#include "engine.h"

#ifdef __wasm__

#include <stdlib.h>
#include <string.h>

#pragma GCC visibility push(default)

/* Return room of this size; NULL if the memory can't grow. */
void *feasibee_room(size_t size);

/* Take back all room, that of a page and that of the engine. */
void feasibee_clear(void);

/* Simulate runs of a built-in strategy, as feasibee_play does; return how many are complete. */
int64_t feasibee_play_flat(const struct params *params, const char *strategy, const struct setting *setting,
                           int32_t memory, int64_t first_run, int32_t runs, int32_t curve_length, int32_t columns,
                           int8_t *decision, int32_t *decision_step, int32_t *feasible_count,
                           int32_t *infeasible_count, int64_t *account);

#pragma GCC visibility pop

#define PAGE 65536u
extern unsigned char __heap_base; /* the linker's: the end of the stack and the constants */
static uintptr_t used;            /* where the free memory begins; 0: nothing is used */

void *aligned_alloc(size_t alignment, size_t size)
{
    const uintptr_t from = used ? used : (uintptr_t)&__heap_base;
    const uintptr_t begin = (from + alignment - 1) & ~(uintptr_t)(alignment - 1), end = begin + size;
    const uintptr_t limit = (uintptr_t)__builtin_wasm_memory_size(0) * PAGE;
    if (begin < from || end < begin)
        return NULL;
    if (end > limit && __builtin_wasm_memory_grow(0, (end - limit + PAGE - 1) / PAGE) == SIZE_MAX)
        return NULL;
    used = end;
    return (void *)begin;
}

void *malloc(size_t size) { return aligned_alloc(64, size); } /* compilers call it for calloc, too */

void *calloc(size_t count, size_t size)
{
    if (size && count > SIZE_MAX / size)
        return NULL;
    void *room = aligned_alloc(64, count * size);
    return room ? memset(room, 0, count * size) : NULL; /* it may have been used before */
}

/* Memory comes free at the end of a call that took it: see feasibee_play_flat. */
void free(void *room) { (void)room; }

/* Each is one instruction. */
void *memset(void *to, int byte, size_t size) { return __builtin_memset(to, byte, size); }
void *memcpy(void *restrict to, const void *restrict from, size_t size) { return __builtin_memcpy(to, from, size); }
void *memmove(void *to, const void *from, size_t size) { return __builtin_memmove(to, from, size); }

void abort(void) { __builtin_trap(); }

void *feasibee_room(size_t size) { return aligned_alloc(64, size); }
void feasibee_clear(void) { used = 0; }

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
    const uintptr_t before = used;
    const int64_t complete =
        rules ? feasibee_play(params, rules, setting, memory, first_run, &outcome, &control) : -1;
    used = before;
    return complete;
}

#endif

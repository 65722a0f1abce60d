/* Work in which a user's strategy may fail: a failure ends all of it at once. */

#ifndef FAILURES_H
#define FAILURES_H

#include "engine.h"

/* Do work that may call a strategy's functions; return what it returns.
 *
 * If one fails, store where and why, and return `failed`. What the work has allocated stays allocated, so
 * allocate before. Each thread has failures of its own. */
int64_t attempt(int64_t (*work)(void *given), void *given, int64_t failed, struct failure *failure);

#ifdef __wasm__
/* Return where and why a user's strategy failed, after the trap. */
__attribute__((visibility("default"))) const struct failure *feasibee_failed(void);
#endif

#endif

/* How a user's strategy ends the work that called it: by a jump to the thread's last attempt. */

#include "failures.h"

#ifdef __wasm__

static struct failure last_failure;

const struct failure *feasibee_failed(void) { return &last_failure; }

/* No jumps here: whoever embeds the module sees the trap. */
int64_t attempt(int64_t (*work)(void *given), void *given, int64_t failed, struct failure *failure)
{
    (void)failed;
    (void)failure;
    return work(given);
}

void feasibee_fail(int32_t what, int32_t line, double first, double second)
{
    last_failure = (struct failure){what, line, first, second};
    __builtin_trap();
}

#else

#include <setjmp.h>
#include <stddef.h>
#include <stdlib.h>

struct attempt {
    jmp_buf begin;
    struct failure failure;
};

static _Thread_local struct attempt *last; /* NULL outside of any */

int64_t attempt(int64_t (*work)(void *given), void *given, int64_t failed, struct failure *failure)
{
    struct attempt own = {.failure = {0}}, *outer = last;
    int64_t result = failed;
    last = &own;
    if (setjmp(own.begin) == 0)
        result = work(given);
    else
        *failure = own.failure;
    last = outer;
    return result;
}

void feasibee_fail(int32_t what, int32_t line, double first, double second)
{
    if (last == NULL)
        abort(); /* no engine called the strategy */
    last->failure = (struct failure){what, line, first, second};
    longjmp(last->begin, 1);
}

#endif

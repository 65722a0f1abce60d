/* Several threads that simulate one swarm: all do the same steps, and wait for each other where one reads
 * what another has written. */

#ifndef TEAM_H
#define TEAM_H

#include "vec.h"

#if defined _WIN32
__declspec(dllimport) int __stdcall SwitchToThread(void);
#elif !defined __wasm__
#include <sched.h>
#endif

#define SPINS 4000     /* looks of a waiting thread before it lets other threads run: about 10 us */
#define CACHE_LINE 128 /* bytes: two lines of a processor's cache, which it may fetch together */

struct team {
    int64_t threads;
    char apart[CACHE_LINE];
    int64_t arrived; /* threads that wait */
    char away[CACHE_LINE];
    int64_t turn; /* how often all have waited */
};

static inline void give_way(void)
{
#if defined _WIN32
    (void)SwitchToThread();
#elif !defined __wasm__
    (void)sched_yield();
#endif
}

/* Let the other threads go, which wait for the one that came last. */
ALWAYS void let_go(struct team *team) { __atomic_fetch_add(&team->turn, 1, __ATOMIC_ACQ_REL); }

/* Wait until one of several threads lets the others go; return false at once if all others wait. */
APART bool has_waited(struct team *team)
{
    const int64_t turn = __atomic_load_n(&team->turn, __ATOMIC_ACQUIRE);
    if (__atomic_add_fetch(&team->arrived, 1, __ATOMIC_ACQ_REL) == team->threads) {
        __atomic_store_n(&team->arrived, 0, __ATOMIC_RELAXED);
        return false;
    }
    for (int looks = 0; __atomic_load_n(&team->turn, __ATOMIC_ACQUIRE) == turn; looks++)
        if (looks > SPINS) {
            looks = SPINS;
            give_way();
        }
    return true;
}

/* Wait until all threads have come here, and one has done what one must do for all.
 *
 * That is the last to come. It gets true, does not wait, and lets the others go when it is done. */
ALWAYS bool comes_last(struct team *team) { return team->threads == 1 || !has_waited(team); }

#endif

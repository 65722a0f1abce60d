/* Phases of a robot in any world: their draws, and how long they last (model.md 4). */

#ifndef PHASES_H
#define PHASES_H

#include "chance.h"
#include "sets.h"

#define SHARE_OF_WORD (1.0 / 4294967296.0)

/* The draw of a phase: of its duration, and for the decision before it. */
struct phase {
    double length; /* exponential of mean 1, nearly */
    double chance;
    uint32_t word, tie;
};

/* Return the draw of a robot's present phase: in a small swarm from its pool. */
ALWAYS struct phase present_phase(const struct state *s, int64_t i)
{
    const struct source from = source_of(s->params, s->clock->run, PHASE);
    const uint32_t phases = (uint32_t)s->robots[PHASES][i], place = phases % POOL;
    struct phase_pool *pool = (struct phase_pool *)s->phase_pools + i;
    if (!s->phase_pools) {
        const struct words drawn = philox(from, phases, (uint32_t)i);
        const double length = exponentials(spread_long(drawn.word[0]))[0];
        return (struct phase){length, drawn.word[1] * SHARE_OF_WORD, drawn.word[0], drawn.word[2]};
    }
    if (place == 0)
        fill_phases(pool, from, (uint32_t)i, phases);
    return (struct phase){pool->length[place], pool->chance[place] * SHARE_OF_WORD, pool->word[place], pool->tie[place]};
}

/* Return the duration of a phase of a mean, in steps. */
ALWAYS int32_t duration_of(struct phase phase, double mean) { return steps_of(phase.length, phase.word, mean); }

/* Begin a robot's next phase, of a given duration in steps. */
ALWAYS void enter_phase(struct state *s, int64_t i, int64_t lasts)
{
    s->robots[PHASES][i]++;
    s->robots[PHASE_LEFT][i] = (int32_t)lasts;
    s->robots[LABEL][i] = label_of(s, i);
}

#endif

/* Phases of a robot in any world: their draws, and how long they last (model.md 4). */

#ifndef PHASES_H
#define PHASES_H

#include "chance.h"
#include "sets.h"

/* The draw of a phase: of its duration, and for the decision before it. */
struct phase {
    double length; /* exponential of mean 1, nearly */
    double chance;
    uint32_t word, tie;
};

/* Return the draw of a robot's present phase. */
ALWAYS struct phase present_phase(const struct state *s, int64_t i)
{
    const struct words drawn = draw_words(s, i, s->robots[PHASES][i], PHASE);
    return (struct phase){
        .length = exponentials(spread_long(drawn.word[0]))[0],
        .chance = drawn.word[1] * (1.0 / 4294967296.0),
        .word = drawn.word[0],
        .tie = drawn.word[2],
    };
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

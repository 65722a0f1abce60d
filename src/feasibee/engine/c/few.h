#ifndef FEW_H
#define FEW_H

#include "decisions.h"

#define FEW 128 /* robots of the largest swarm that is played together */

/* Play runs of few robots, as feasibee_play does for any number. */
int64_t few_play(const struct job *job, int64_t first_run);

#endif

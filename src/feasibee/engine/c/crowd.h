#ifndef CROWD_H
#define CROWD_H

#include "decisions.h"

/* Play runs of a crowd by one thread, as feasibee_play does for any number of robots. */
int64_t crowd_play(const struct job *job, int64_t first_run);

#endif

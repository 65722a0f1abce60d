/* What is stored of a crowd, of each robot in it, and of each thread. */

#ifndef CROWD_STATE_H
#define CROWD_STATE_H

#include "cells.h"
#include "decisions.h"
#include "draws.h"
#include "inbox.h"
#include "team.h"

#define CHUNK BATCH /* robots whose whole step a thread does at a time, while they are in its cache */
#define QUEUE 1024  /* messages that wait until they are received */
#define PADDING 64  /* numbers that vectors may read, or write, behind the last one */
#ifndef ENOUGH      /* tests have less */
#define ENOUGH UINT32_C(0x80000000) /* what a count of 32 bits reaches before it is carried to one of 64 */
#endif

/* A label has the number of a robot above these bits. From SAYS_FEASIBLE on it is the robot's message. */
enum label {
    SPEAKS = 1,
    DISSEMINATES = 2,
    HOLDS_FEASIBLE = 4,
    NEUTRAL = 8,
    JOINS = 16,
    CARRIED = 32,
    SAYS_FEASIBLE = 128
};
#define NUMBER_BITS 8
#define MESSAGE_BITS 7

/* What a robot has seen in its exploration, and has heard since its last decision. */
struct tally {
    uint32_t robots, tasks, votes, feasible_votes;
};

struct counts {
    int64_t robots, tasks, votes, feasible_votes;
};

/* What a robot needs where a phase ends only. */
struct own {
    double quality;  /* of feasible, by the last exploration */
    uint32_t phases; /* phases drawn */
};

/* Rows of 32 bits by place: what is sorted in space. */
struct rows {
    uint32_t *x, *y, *step_x, *step_y, *turns_at, *ends_at; /* steps at which heading and phase end */
    uint32_t *labels, *walks;                               /* headings drawn */
};

#define ROWS (sizeof(struct rows) / sizeof(uint32_t *))

/* What is sorted in space, in blocks of 32 bytes a robot: rows, counts, and the lines of inboxes if any. */
enum block_kind { STATE, COUNTS, LINES, VALUES, BLOCKS };

/* What a thread has, and what it tells the others. */
struct worker {
    uint32_t first, last;   /* its robots: the last excluded */
    uint32_t row, last_row; /* of cells that it sorts, likewise */
    uint32_t leaving;       /* its robots that other threads sort */
    uint32_t inside,
        points; /* robots in its rows, and places that its own robots and those repeated take there */
    int64_t feasible, neutral,
        speaking; /* robots: the sums over all threads count, since robots change threads */
    int64_t said;
    uint32_t counted; /* all bits of its robots' counts at the last sort */
    bool ends, lacks_memory;
    struct failure failure;
    struct tables tables;
    bool in_step; /* whether the others wait for it at the end of a step */
    struct source walk, phase;
    uint32_t queued, receivers[QUEUE + PADDING], messages[QUEUE + PADDING];
    uint32_t turning[CHUNK], exploring[CHUNK],
        deciding[CHUNK];  /* robots of a chunk whose heading or phase ends */
    struct blocks blocks; /* of its present chunk of robots */
    char apart[CACHE_LINE];
};

struct crowd {
    struct params params;
    struct job job; /* without outcome and control, which are those of a run */
    struct team team;
    uint32_t count;
    size_t room; /* of a row */
    uint32_t *blocks[BLOCKS], *spare;
    struct rows rows;  /* what lies in the blocks, from here on */
    union line *lines; /* NULL if every message counts */
    uint32_t *values;  /* in lines, as their messages; NULL if messages have none */
    struct tally *tallies;
    struct own *own;
    uint32_t
        *sent; /* values in messages, by the number of a robot: that of a sender is read at its messages */
    double *memory;         /* of the strategy, by number as well, since it may have any length */
    struct counts *carried; /* by number: what tallies have no room for; NULL if that can't be */
    uint32_t *order, *task_x, *task_y;
    struct cells robots, tasks;
    struct reach sight, radio, tasks_in_sight;
    int64_t now, speaking, spoken, feasible, neutral;
    struct verdict verdict;
    bool ended, cancelled;
    int64_t result;
    struct worker workers[];
};

/* Wait for all threads; return whether the run goes on, the same to all of them: if not, it is cancelled. */
static bool goes_on(const struct job *job, struct crowd *s)
{
    if (comes_last(&s->team)) {
        s->cancelled = is_cancelled(job->control);
        let_go(&s->team);
    }
    return !s->cancelled;
}

/* Return a robot's counts, with what has been carried. */
ALWAYS struct counts counts_of(const struct crowd *s, uint32_t i)
{
    const struct tally tally = s->tallies[i];
    struct counts counts = {tally.robots, tally.tasks, tally.votes, tally.feasible_votes};
    if (RARELY(s->rows.labels[i] & CARRIED)) {
        const struct counts carried = s->carried[s->rows.labels[i] >> NUMBER_BITS];
        counts = (struct counts){counts.robots + carried.robots, counts.tasks + carried.tasks,
                                 counts.votes + carried.votes,
                                 counts.feasible_votes + carried.feasible_votes};
    }
    return counts;
}

#endif

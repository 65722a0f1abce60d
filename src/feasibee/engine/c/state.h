/* One swarm at one step, in any world: the arrays that the general path works on.
 *
 * Python reads this file after engine.h, so it has declarations only. Robots are padded to whole words of 32;
 * robot i is bit i % 32 of word i / 32 of a set. All arrays lie in one block of memory, so a copy of the block
 * is a copy of the swarm. Positions and velocities are fixed-point numbers of 32 bits, whose unit is the
 * torus's longer side / 2**32: differences on a square torus wrap by themselves. Within walls the unit is
 * twice that, and no difference wraps. */

#ifndef STATE_H
#define STATE_H

#include "engine.h"

/* --- What robots have --- */

enum robot_row {
    X,
    Y,
    STEP_X, /* velocity per step */
    STEP_Y,
    WALK_LEFT,  /* steps until the next heading */
    PHASE_LEFT, /* steps until the next phase */
    WALKS,      /* headings drawn so far */
    PHASES,     /* phases drawn so far */
    LABEL,      /* see sets.h */
    ORDER,      /* a shuffle of the robots */
    SENT_VALUE, /* the value in its messages */
    AGREED,     /* successive decisions with which its inbox agreed */
    MESSAGES,   /* heard since the inbox was emptied */
    IDENTITY,   /* the first robot with the same id */
    TABLE,      /* number of the table that its inbox takes, from 1 on, or 0 */
    LEAVES_AT,  /* step at which it fails, in a world that changes */
    JOINED,     /* robots that had its number before it */
    SWITCHES_AT, /* step at which it goes to charge, or comes back */
    TARGET,     /* number of the task to which it goes */
    DETOUR,     /* steps that it still goes another way */
    BEGAN,      /* step at which it began to act */
    HEADING_X,  /* of the run that waits while it goes to a task */
    HEADING_Y,
    DONE_AT, /* step at whose beginning its task is done, if tasks take time */
    ROBOT_ROWS
};

enum set {
    FOR_FEASIBLE, /* opinion 1 */
    DISSEMINATING,
    TURNING, /* heading ends with this step */
    ENDING,  /* phase ends with this step */
    WORKING, /* not stopped */
    COUNTED, /* the decision is taken over these */
    BYZANTINE,
    STUBBORN,
    BLOCKED,  /* stays in place in this step */
    SPEAKING, /* disseminating, and not silent */
    SAYS_FEASIBLE,
    NEUTRAL,   /* no opinion */
    LISTENING, /* hears in this step */
    DECLARED,
    FOR_FEASIBLE_DECLARED, /* those of them that declared feasible */
    STOPPING,              /* robots that stop at faults.stop_step */
    THERE,                 /* in the arena, whether they work or not */
    JOINING, /* those that don't know yet what robots know when they begin, or in their first exploration */
    TURNING_LEFT, /* blocked robots that deflect to the left */
    CLEARED,      /* those of them whose new step is clear, in larger swarms */
    MET,          /* robots in the way of which another one is */
    MET_LEFT,
    MET_RIGHT,
    LOOKING, /* observes in this step */
    AWAY,    /* charge, out of the arena (model.md 6.23) */
    PRESENT, /* for the truth and events: those there, and those away that count */
    SPEAKING_AGAIN, /* those away that will speak when they are back */
    ACTING,
    BOUND,    /* those that have a target */
    COURSED,  /* those whose run waits in this step */
    STANDING, /* at their tasks */
    MARKED,   /* those that have marked a task */
    SETS
};

enum count_row {
    ROBOTS_SEEN, /* n_obs of this exploration */
    TASKS_SEEN,  /* m_obs */
    VOTES,       /* messages in the inbox */
    FEASIBLE_VOTES,
    SENT_BITS, /* length of its message, if that is still a copy of what it knows; else negative */
    COUNTS
};

/* For each robot a set of up to 128 robots: rows of words of others, each of all robots. */
enum link {
    IN_SIGHT,       /* or in radio range */
    SEEN,           /* those in sight that it doesn't miss */
    HEARD,          /* senders in the inbox */
    HEARD_FEASIBLE, /* senders in the inbox with opinion 1 */
    CLOSE,          /* robots that it may meet within a step */
    LINKS
};

enum slot_row {
    SENDER, /* label of the sender with its latest opinion, or -1 */
    VALUE,  /* in that message */
    WHEN,   /* number of that message among all heard */
    SLOT_ROWS
};

enum copy { KNOWN, SENT, COPIES }; /* of a robot's knowledge: in its mind, in its messages of this step */

enum delayed { SAYS, DELAYED_VALUE, LENGTH, TOLD }; /* a message: its opinion, value, bits, words from TOLD on */

enum point { POINT_X, POINT_Y, NUMBER, POINTS };

enum lack { SLOTS_LACK = 1, TABLES_LACK = 2 }; /* what an inbox lacked; the caller then doubles it */

enum event_column { EVENT_STEP, EVENT_TASKS, EVENT_ROBOTS, EVENT_MISS, EVENT_LOSS, EVENT_TASK, EVENT_ROBOT, EVENT_X, EVENT_Y, EVENT_COLUMNS };

/* When functions of a strategy's knowledge are called. */
enum action { START, SPEAK, OBSERVE, MERGE, COUNT, DECLARE, JUDGE };

struct clock {
    int64_t run, step, full; /* full: an enum lack */
    int64_t pending, table_slots, counted, quorum, truth, robots, tasks, appeared, events, miss, loss;
    int64_t invented_robots, invented_tasks, vanished, left, changed, most;
};

/* What a record keeps of a run: feasibee.base.outcomes.ACCOUNT. */
struct account {
    int64_t bits_sent, declare_step, declared_feasible, declared_infeasible, feasible_at_end, infeasible_at_end;
    int64_t last_step, said_at_end, first_taken_step, all_taken_step, tasks_taken, distance_walked;
    int64_t vain_arrivals, starts_in_vain, all_done_step;
};

/* The cells of a place, row by row (model.md 6.20). */
struct ground {
    const uint64_t *walls, *passable; /* rows begin at whole words */
    const int32_t *boxes;             /* left, right, top, bottom: all walls, tile by tile */
    const int32_t *tiles;             /* first of its boxes, by tile */
    const uint64_t *limits;           /* for sight, then radio: squared distances too far behind so many walls */
    const int32_t *stands;            /* where things are placed, piece by piece */
    const int32_t *stand_of;          /* by robot, then task: first of its cells in `stands`, and their number */
    const int32_t *lattice;           /* by robot: x, y */
};

/* The arrays of a scenario. */
struct tables {
    const int32_t *class_of; /* robots, then tasks */
    const int64_t *adds;     /* by set of skills and class of robots, then of tasks: per member of the class */
    int64_t skill_sets, classes;
    const int32_t *points;  /* by robot, then task of the start: x, y */
    const int64_t *ranks;   /* by class of robots: 1 for the most skilled */
    const int64_t *able;    /* by class of robots and class of tasks: 1 if they can do them */
    int64_t task_classes;   /* columns of `able` */
    const int64_t *events;  /* in their order; columns are those of enum event_column */
    int64_t event_count;
    struct ground ground;
};

/* Points sorted into a square grid of cells. */
struct grid_cells {
    int32_t *points[POINTS];
    int32_t *start; /* first place of each cell, and the place after the last */
};

/* The room for inboxes with more senders than a line has. */
struct room {
    int64_t slots; /* of a table, a power of two */
    int64_t tables;
};

/* A thread's part of the work on a swarm. */
struct part {
    int64_t thread, first, last; /* words of its robots; the last one is excluded */
    int32_t *who, *other, *third; /* a queue: messages to be received, things to be observed, pairs that may meet */
    int32_t *free_tables;         /* their number, and their numbers */
    int64_t feasible, neutral, bits, declared_feasible, declared_infeasible; /* sums over its robots */
    bool ended;                   /* whether this thread wants the run to end here */
    struct failure failure;
    char apart[128];              /* no line of the cache is shared */
};

struct state {
    const struct params *params;
    const struct rules *rules;
    const struct setting *setting;
    struct tables tables;
    int64_t words, padded, task_words, copy_words, memory_length, slots, remembered_words, delayed_length;
    int64_t threads;
    struct part *parts;
    void *team; /* a struct team */
    bool goes_on; /* whether the run has a next step */
    int32_t *robots[ROBOT_ROWS];
    uint32_t *sets[SETS];     /* of words */
    int64_t *counts[COUNTS];
    uint32_t *links[LINKS];   /* word of others, robot; NULL in larger swarms */
    int64_t *seen;            /* robot, class of robots, then of tasks; NULL unless there are several */
    uint32_t *remembered;     /* robot, word of robots, then of tasks; NULL unless observation is unique */
    int32_t *inbox[SLOT_ROWS]; /* see messages.h */
    void *heading_pools, *phase_pools; /* of each robot: see draws.h; NULL in larger swarms */
    double *quality;          /* rated quality of feasible */
    double *memory;           /* robot, number: the strategy's own */
    int32_t *knowledge[COPIES]; /* robot, word */
    int64_t *delayed;         /* step, robot, enum delayed: messages of the last steps, if they are delayed */
    int32_t *pending_who, *pending_number, *pending_column, *pending_mark; /* see knowledge.h */
    uint32_t *hashes;         /* robot, then task, then invention: if robots pass on knowledge */
    int32_t *tasks[POINTS];
    int32_t *names;           /* the task whose name each has, if positions have errors */
    uint32_t *tasks_there;
    int32_t *vanish_at;       /* steps at which lifetimes end, if tasks have any */
    int32_t *holders;         /* who has each task, -1 for none, -2 if it is done; this and what follows if robots act */
    int32_t *news;            /* robot, task: versions that robots know; see acting.h */
    int32_t *told;            /* step, robot, task: versions in messages of this and the last steps */
    int32_t *ways;            /* task, then two queues, cell: if robots act in a place; see way.h */
    uint32_t *task_places;    /* packed, if few robots look through tasks by number */
    uint32_t *tasks_seen;     /* word of tasks, robot: sets, likewise */
    struct grid_cells task_cells, robot_cells;
    int32_t *class_of;        /* robots, then tasks; those that join and appear are drawn */
    struct clock *clock;
    struct account *account;
};

#pragma GCC visibility push(default)

/* Lay out the arrays of a swarm whose numbers, tables, memory_length and threads are set, in a block of memory.
 *
 * Return the size of the block, which begins at a multiple of 64; without a block, only that. */
int64_t feasibee_lay_out(struct state *s, struct room room, char *block);

/* Put a swarm at step 0 of a run. */
void feasibee_start(struct state *s, int64_t run);

/* Simulate a thread's part of a run up to a step, or to its end, recorded in a row of the outcome.
 *
 * Return 0; -1 if a function of the strategy fails, which the control then tells. */
int64_t feasibee_advance(struct state *s, int64_t row, int64_t until, const struct outcome *outcome,
                         struct control *control, int64_t thread);

/* Simulate the runs from `first_run` on by one thread; return how many are complete: fewer if they were cancelled,
 * an inbox lacked room (clock->full), or the strategy failed. */
int64_t feasibee_play_any(struct state *s, int64_t first_run, const struct outcome *outcome, struct control *control);

#pragma GCC visibility pop

#endif

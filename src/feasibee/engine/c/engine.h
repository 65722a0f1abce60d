/* What Python and the engine know of each other: the only description of these structs.
 *
 * Python reads this file (feasibee.engine.library), so it has declarations only. params.h is written from
 * feasibee.engine.params when the engine is compiled: the numbers of a scenario and a seed. */

#ifndef ENGINE_H
#define ENGINE_H

#include <stdbool.h>
#include <stdint.h>

#include "params.h"

/* --- A strategy: feasibee.strategies.contract says what its functions are given and return --- */

struct setting {
    int64_t robots, count, tasks, robot_ids, task_ids, robot_classes, task_classes, id_bits;
    bool knows_count, colluding, walled;
    double width, height, sight, radio, speed, exploration, dissemination, mean_run, flooding, delay, work, charge;
    const uint8_t *plan; /* cells by row */
    int64_t plan_length, columns;
    const double *parameters;
    int64_t parameter_count;
};

struct mind {
    int64_t opinion;
    double quality, feasible_quality;
    int64_t own_vote, random_ties;
    double *memory;
    int64_t memory_count;
    const double *parameters;
    int64_t parameter_count;
};

struct inbox {
    int64_t feasible_votes, infeasible_votes, heard_opinion;
    double heard_value, mean_value, chance;
};

/* The words that a robot knows, or that a message holds. */
struct known {
    int32_t *words;
    int64_t length;
};

/* The robot whose knowledge a function is given. */
struct me {
    int64_t id, kind, hash, step;
    bool explores;
    double x, y;
    double *memory;
    int64_t memory_count;
    const struct setting *setting;
};

struct thing {
    bool is_robot;
    int64_t id, kind, hash;
    double x, y;
};

struct state;

/* The functions of a strategy. From `say` on they are NULL if it doesn't define them. */
struct rules {
    double (*quality)(int64_t robots_seen, int64_t tasks_seen);
    double (*dissemination)(double quality, double gain);
    int64_t (*decide)(struct mind *mind, const struct inbox *inbox);
    int64_t (*say)(struct mind *mind);
    double (*value)(struct mind *mind);
    double (*lasting)(struct mind *mind, double gain);
    double (*probability)(struct mind *mind, struct known known, const struct setting *setting);
    int64_t (*words)(const struct setting *setting); /* only pages call these two */
    int64_t (*message_words)(const struct setting *setting);
    /* Calls the functions for knowledge for so many robots that wait for an action; returns the bits sent. */
    int64_t (*update)(struct state *s, int32_t action, int64_t number);
};

/* Where and why a function of a user's strategy failed. */
struct failure {
    int32_t what; /* 0: it did not; else see feasibee.engine.failing */
    int32_t line;
    double first, second; /* the values that it failed for */
};

#pragma GCC visibility push(default) /* what a library exports */

/* End the run because a function of a strategy fails; never returns. The values are those it fails for. */
void feasibee_fail(int32_t what, int32_t line, double first, double second);

/* Of a user's library: store what it calls where its strategy fails. */
void feasibee_bind(void (*fail)(int32_t what, int32_t line, double first, double second));

/* --- Runs --- */

/* Rows of the record of consecutive runs (feasibee.base.record). */
struct outcome {
    int8_t *decision;
    int32_t *decision_step;
    int32_t *feasible_count, *infeasible_count; /* by run and step */
    int64_t *account;                           /* by run and column */
    int64_t runs;
    int64_t curve_length; /* 0 without curves */
    int64_t columns;
    int8_t *truth, *held; /* by run and step, as what follows */
    int32_t *robots_present, *tasks_present;
    int64_t trace_length; /* 0 unless robots or tasks come and go */
};

/* What threads that simulate share with the one that waits for them. */
struct control {
    int64_t *steps_done;
    const bool *cancelled; /* set from outside: the runs end within 50 ms */
    struct failure failure;
};

/* Return the number of the highest level (feasibee.engine.build) that the processor has, from 0 on; -1: none. */
int32_t feasibee_level(void);

/* Return the rules of a built-in strategy, or those of a user's library; NULL if there are none. */
const struct rules *feasibee_rules(const char *name);

/* Return whether the engine has a world: with other numbers it would read and write where nothing is. */
bool feasibee_has(const struct params *params);

/* Simulate the runs from `first_run` on, one for each row of the outcome; `memory` is that of the strategy.
 *
 * Return how many are complete: fewer if they were cancelled or the strategy failed; -1 without memory. */
int64_t feasibee_play(const struct params *params, const struct rules *rules, const struct setting *setting,
                      int64_t memory, int64_t first_run, const struct outcome *outcome, struct control *control);

/* A swarm of more than 128 robots that threads simulate together; each of them calls feasibee_crowd_run. */
struct crowd;

/* Allocate a swarm for a number of threads; return NULL without memory. Rules and setting must stay. */
struct crowd *feasibee_crowd_new(const struct params *params, const struct rules *rules, const struct setting *setting,
                                 int64_t memory, int64_t threads);

/* Simulate a thread's part of a run, recorded in a row of the outcome; return once all threads are done.
 *
 * Return 1 if the run is complete, 0 if it was cancelled or the strategy failed, -1 without memory. */
int64_t feasibee_crowd_run(struct crowd *crowd, int64_t run, int64_t row, const struct outcome *outcome,
                           struct control *control, int64_t thread);

void feasibee_crowd_free(struct crowd *crowd);

#pragma GCC visibility pop

#endif

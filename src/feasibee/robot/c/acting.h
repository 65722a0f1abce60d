/* What one robot knows of tasks, and which one it goes to: acting.py in C99 (model.md 6.25). It needs no other file.
 *
 * Give it what the robot sees and hears of tasks, let it choose at the end of each step, and tell it how the task is
 * that it reaches. A task's name is any number below 2^32 - 1 that all robots give it. Define FEASIBEE_TASKS, the most
 * tasks that it knows, before you include this file.
 */
#ifndef FEASIBEE_ACTING_H
#define FEASIBEE_ACTING_H

#include <stdbool.h>
#include <stdint.h>

#ifndef FEASIBEE_TASKS
#define FEASIBEE_TASKS 64
#endif

#define FEASIBEE_NO_TASK UINT32_MAX
#define FEASIBEE_UNKNOWN (-1)
#define FEASIBEE_GONE INT32_C(1073741824) /* version of a task that has vanished */
#define FEASIBEE_PATIENCE 20              /* steps until a robot without a task by its rank goes to the nearest */
#define FEASIBEE_FAR UINT64_MAX           /* how far a task is that the robot can't do */

/* The rules by which a robot acts, which never change. */
struct feasibee_rules {
    uint32_t start;  /* step from the end of which on it acts; 2^30 for never */
    uint32_t number; /* of the robot, from 0 on */
    uint32_t count;  /* of the robots; 0 if it doesn't know that */
    uint8_t rank;    /* 1 for robots with the most skills */
    uint8_t ranks;
    bool by_word; /* it acts once it has declared feasible */
    bool by_rank;
    bool tags;
    bool comes_free; /* taken tasks may come free again */
};

struct feasibee_task {
    uint32_t name;
    int32_t version;
};

/* A robot's errand. Read target, task and mark: each a name, or FEASIBEE_NO_TASK. */
struct feasibee_errand {
    const struct feasibee_rules *rules;
    uint32_t target; /* to which it goes */
    uint32_t task;   /* at which it stands */
    uint32_t mark;   /* which it has marked */
    uint32_t began;  /* the step at whose end it began to act, if it acts */
    uint32_t count;
    bool acts;
    uint16_t known;
    struct feasibee_task tasks[FEASIBEE_TASKS]; /* by name */
};

/* Return how far away a task is, or its square; FEASIBEE_FAR if the robot can't do it. */
typedef uint64_t (*feasibee_way)(void *context, uint32_t name);

static inline void feasibee_set_out(struct feasibee_errand *errand, const struct feasibee_rules *rules)
{
    errand->rules = rules;
    errand->target = errand->task = errand->mark = FEASIBEE_NO_TASK;
    errand->began = 0;
    errand->count = rules->count;
    errand->acts = false;
    errand->known = 0;
}

/* Return the entry of a task, which is new unless it is there; NULL if there is no room. */
static inline struct feasibee_task *feasibee_entry(struct feasibee_errand *errand, uint32_t name)
{
    uint16_t place = errand->known, k;
    while (place > 0 && errand->tasks[place - 1].name >= name)
        place--;
    if (place < errand->known && errand->tasks[place].name == name)
        return &errand->tasks[place];
    if (errand->known == FEASIBEE_TASKS)
        return (struct feasibee_task *)0;
    for (k = errand->known; k > place; k--)
        errand->tasks[k] = errand->tasks[k - 1];
    errand->known++;
    errand->tasks[place].name = name;
    errand->tasks[place].version = FEASIBEE_UNKNOWN;
    return &errand->tasks[place];
}

/* Return the status of a version: 0 free, else a rank; FEASIBEE_UNKNOWN if the task is unknown or has vanished. */
static inline int32_t feasibee_status(const struct feasibee_errand *errand, int32_t version)
{
    if (version == FEASIBEE_UNKNOWN || version == FEASIBEE_GONE)
        return FEASIBEE_UNKNOWN;
    return version % (errand->rules->ranks + 1);
}

/* Return the least version with a status, from a version on. */
static inline int32_t feasibee_version(const struct feasibee_errand *errand, int32_t version, int32_t status)
{
    int32_t own = feasibee_status(errand, version), period = errand->rules->ranks + 1;
    if (own == FEASIBEE_UNKNOWN || !errand->rules->comes_free)
        return status;
    return version + (status - own + period) % period;
}

/* Store the status of a task in sight. */
static inline void feasibee_see_task(struct feasibee_errand *errand, uint32_t name, int32_t status)
{
    struct feasibee_task *task = feasibee_entry(errand, name);
    if (task)
        task->version = feasibee_version(errand, task->version, status);
}

/* Keep the larger of both versions of a task. Call it for each task of a message. */
static inline void feasibee_hear_task(struct feasibee_errand *errand, uint32_t name, int32_t version)
{
    struct feasibee_task *task = feasibee_entry(errand, name);
    if (task && version > task->version)
        task->version = version;
}

/* Return whether a robot knows more tasks than there are robots. */
static inline bool feasibee_knows_too_many(const struct feasibee_errand *errand)
{
    uint32_t there = 0;
    uint16_t k;
    for (k = 0; k < errand->known; k++)
        there += feasibee_status(errand, errand->tasks[k].version) != FEASIBEE_UNKNOWN;
    return errand->rules->count > 0 && there > errand->count;
}

/* Return the task that comes after as many known ones as the robot's number, if it is free. */
static inline uint32_t feasibee_task_of_rank(const struct feasibee_errand *errand, feasibee_way way, void *context)
{
    uint32_t before = 0;
    uint16_t k;
    for (k = 0; k < errand->known; k++) {
        const struct feasibee_task *task = &errand->tasks[k];
        int32_t status = feasibee_status(errand, task->version);
        if (status != FEASIBEE_UNKNOWN && before++ == errand->rules->number)
            return status == 0 && way(context, task->name) != FEASIBEE_FAR ? task->name : FEASIBEE_NO_TASK;
    }
    return FEASIBEE_NO_TASK;
}

/* Return the nearest free task. */
static inline uint32_t feasibee_nearest(const struct feasibee_errand *errand, feasibee_way way, void *context)
{
    uint32_t found = FEASIBEE_NO_TASK;
    uint64_t least = FEASIBEE_FAR;
    uint16_t k;
    for (k = 0; k < errand->known; k++) {
        uint64_t far;
        if (feasibee_status(errand, errand->tasks[k].version) != 0)
            continue;
        far = way(context, errand->tasks[k].name);
        if (far < least) {
            least = far;
            found = errand->tasks[k].name;
        }
    }
    return found;
}

/* Choose the target at the end of a step; declared is 1 for feasible, 0 for infeasible, -1 for nothing. */
static inline void feasibee_choose_task(struct feasibee_errand *errand, uint32_t step, int8_t declared,
                                        feasibee_way way, void *context)
{
    const struct feasibee_rules *rules = errand->rules;
    errand->target = FEASIBEE_NO_TASK;
    if (errand->task != FEASIBEE_NO_TASK || declared == 0 || feasibee_knows_too_many(errand))
        return;
    if (step >= rules->start || (rules->by_word && declared == 1)) {
        if (!errand->acts)
            errand->began = step;
        errand->acts = true;
    } else if (!rules->tags || errand->mark != FEASIBEE_NO_TASK) {
        return;
    }
    if (errand->mark != FEASIBEE_NO_TASK)
        errand->target = errand->mark;
    else if (rules->by_rank && step < errand->began + FEASIBEE_PATIENCE)
        errand->target = feasibee_task_of_rank(errand, way, context);
    else
        errand->target = feasibee_nearest(errand, way, context);
}

/* Store how the target is, which the robot has reached, FEASIBEE_UNKNOWN if it has vanished; return whether it gets
 * it. Then it stands there if it acts, and else it has marked it. */
static inline bool feasibee_arrive(struct feasibee_errand *errand, int32_t status)
{
    uint32_t name = errand->target;
    bool gets = status == 0 || errand->mark == name;
    if (status == FEASIBEE_UNKNOWN) {
        struct feasibee_task *task = feasibee_entry(errand, name);
        if (task)
            task->version = FEASIBEE_GONE;
        return false;
    }
    if (gets) {
        errand->target = FEASIBEE_NO_TASK;
        errand->task = errand->acts ? name : FEASIBEE_NO_TASK;
        errand->mark = errand->acts ? FEASIBEE_NO_TASK : name;
    }
    feasibee_see_task(errand, name, gets ? errand->rules->rank : status);
    return gets;
}

/* Go on without task and mark. */
static inline void feasibee_lose_task(struct feasibee_errand *errand)
{
    errand->task = errand->mark = FEASIBEE_NO_TASK;
}

/* Store how many robots there are if more have joined. */
static inline void feasibee_announce(struct feasibee_errand *errand, uint32_t robots)
{
    errand->count = robots > errand->rules->count ? robots : errand->rules->count;
}

#endif

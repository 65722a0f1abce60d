/* Totals: anonymous sums of what each robot saw in its life, in 16 bits and an id.
 *
 * Parameters: arrivals, kappa, tolerates. */

#include "quiet.h"
#include "rules.h"

#if FEASIBEE_WORDS > 0

enum { FEASIBEE_TOTALS_ROWS = 2 }; /* place of the first row heard; its own totals stand before */

#ifdef FEASIBEE_DOUBLE
typedef double feasibee_lean;
#else
typedef int64_t feasibee_lean; /* twice the number, rounded down */
#endif

static inline bool feasibee_totals_by_arrival(const struct feasibee_setting *setting)
{
    return setting->parameters[0] == FEASIBEE_NUMBER(1);
}

static inline uint32_t feasibee_totals_words(const struct feasibee_setting *setting)
{
    uint32_t in_sight = feasibee_totals_by_arrival(setting) ? (uint32_t)setting->robots + setting->tasks : 0;
    return FEASIBEE_TOTALS_ROWS + setting->robots + in_sight;
}

/* Count a robot or task in sight, with arrivals only if it wasn't in sight in the step before. */
static inline void feasibee_totals_observe(struct feasibee_robot *robot, const struct feasibee_thing *thing)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    if (feasibee_totals_by_arrival(setting) &&
        (uint32_t)thing->id < (thing->is_robot ? setting->robots : setting->tasks)) {
        uint32_t place = FEASIBEE_TOTALS_ROWS + setting->robots + (uint32_t)thing->id;
        uint32_t *since = &robot->known[place + (thing->is_robot ? 0 : setting->robots)];
        bool stays = *since == feasibee_stamp_of(robot->me.step - 1);
        *since = feasibee_stamp_of(robot->me.step);
        if (stays)
            return;
    }
    uint32_t *total = &robot->known[thing->is_robot ? 0 : 1];
    if (++*total == FEASIBEE_FULL) {
        robot->known[0] /= 2;
        robot->known[1] /= 2;
    }
}

/* Return one of two totals, of which the larger is given, as if that were at most the largest of a message. */
static inline uint32_t feasibee_totals_scaled(uint32_t total, uint32_t larger)
{
    const uint32_t largest = UINT32_C(63) << 15;
    return larger <= largest ? total : (uint32_t)((uint64_t)total * largest / larger);
}

/* Return two totals as 16 bits: 4 of the exponent, 6 of the robots, 6 of the tasks. */
static inline uint32_t feasibee_totals_row_of(uint32_t robots, uint32_t tasks)
{
    uint32_t larger = robots > tasks ? robots : tasks, half;
    robots = feasibee_totals_scaled(robots, larger);
    tasks = feasibee_totals_scaled(tasks, larger);
    larger = feasibee_totals_scaled(larger, larger);
    uint8_t bits = feasibee_bit_length(larger), units = bits > 6 ? (uint8_t)(bits - 6) : 0;
    half = UINT32_C(1) << units >> 1;
    if ((larger + half) >> units > 63)
        units++;
    half = UINT32_C(1) << units >> 1;
    return (uint32_t)units << 12 | (robots + half) >> units << 6 | (tasks + half) >> units;
}

static inline uint32_t feasibee_totals_robots_of(uint32_t row)
{
    return (row >> 6 & 63) << (row >> 12);
}

static inline uint32_t feasibee_totals_tasks_of(uint32_t row)
{
    return (row & 63) << (row >> 12);
}

static inline void feasibee_totals_encode(struct feasibee_robot *robot, uint32_t *words)
{
    words[0] = feasibee_totals_row_of(robot->known[0], robot->known[1]);
}

/* Keep the latest row of each id. */
static inline void feasibee_totals_merge(struct feasibee_robot *robot, const uint32_t *words,
                                         feasibee_id sender)
{
    robot->known[FEASIBEE_TOTALS_ROWS + (uint32_t)sender] = words[0];
}

/* Return by how much a robot is counted more often than a task, at least 0.01. */
static inline feasibee_number feasibee_totals_kappa(const struct feasibee_setting *setting)
{
    if (!feasibee_totals_by_arrival(setting))
        return FEASIBEE_NUMBER(1);
    return setting->parameters[1] < FEASIBEE_NUMBER(0.01) ? FEASIBEE_NUMBER(0.01) : setting->parameters[1];
}

/* Return how much a row speaks for feasible: (n + 1/2) r / kappa - (n - 1) t. */
static inline feasibee_lean feasibee_totals_lean_of(uint32_t row, const struct feasibee_setting *setting)
{
    uint32_t robots = feasibee_totals_robots_of(row), tasks = feasibee_totals_tasks_of(row);
#ifdef FEASIBEE_DOUBLE
    return (setting->robots + 0.5) * (double)robots / feasibee_totals_kappa(setting) -
           (setting->robots - 1.0) * (double)tasks;
#else
    int64_t for_it = (int64_t)(2 * (uint32_t)setting->robots + 1) * robots * FEASIBEE_NUMBER(1);
    return for_it / feasibee_totals_kappa(setting) - 2 * ((int64_t)setting->robots - 1) * tasks;
#endif
}

/* Return the place of the first row from which on the rows heard lean most to a side after the last one; 0
 * for none. The side is 1, feasible first, or -1, exactly the reverse order; last is 0 in the first call. */
static inline uint32_t feasibee_totals_next_extreme(const struct feasibee_robot *robot, int8_t side,
                                                    uint32_t last)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    uint32_t found = 0, end = FEASIBEE_TOTALS_ROWS + (uint32_t)setting->robots;
    feasibee_lean most = 0,
                  bound = last > 0 ? side * feasibee_totals_lean_of(robot->known[last], setting) : 0;
    for (uint32_t place = FEASIBEE_TOTALS_ROWS; place < end; place++) {
        if (robot->known[place] == 0)
            continue;
        feasibee_lean leans = side * feasibee_totals_lean_of(robot->known[place], setting);
        bool follows =
            last == 0 || leans < bound || (leans == bound && (side > 0 ? place > last : place < last));
        bool leads =
            found == 0 || leans > most || (leans == most && (side > 0 ? place < found : place > found));
        if (follows && leads) {
            found = place;
            most = leans;
        }
    }
    return found;
}

/* Sum up its own totals and the rows heard, but for the extreme ones, by both sides of the rule. */
static inline void feasibee_totals_count(struct feasibee_robot *robot, uint32_t *robots, uint32_t *tasks)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    uint64_t robots_seen = 0, tasks_seen = 0;
    uint32_t heard = 0, out = feasibee_tolerated(setting, 2);
    for (uint32_t place = FEASIBEE_TOTALS_ROWS; place < FEASIBEE_TOTALS_ROWS + (uint32_t)setting->robots;
         place++) {
        robots_seen += feasibee_totals_robots_of(robot->known[place]);
        tasks_seen += feasibee_totals_tasks_of(robot->known[place]);
        heard += robot->known[place] != 0;
    }
    if (heard <= 2 * out)
        robots_seen = tasks_seen = out = 0;
    for (int8_t side = -1; side <= 1; side = (int8_t)(side + 2)) {
        uint32_t place = 0;
        for (uint32_t k = 0; k < out; k++) {
            place = feasibee_totals_next_extreme(robot, side, place);
            robots_seen -= feasibee_totals_robots_of(robot->known[place]);
            tasks_seen -= feasibee_totals_tasks_of(robot->known[place]);
        }
    }
    uint32_t larger = robot->known[0] > robot->known[1] ? robot->known[0] : robot->known[1];
    robots_seen += feasibee_totals_scaled(robot->known[0], larger);
    tasks_seen += feasibee_totals_scaled(robot->known[1], larger);
    uint64_t product = (2 * (uint64_t)setting->robots + 1) * robots_seen;
#ifdef FEASIBEE_DOUBLE
    product = (uint64_t)((double)product / feasibee_totals_kappa(setting));
#else
    product = product * (uint64_t)FEASIBEE_NUMBER(1) / (uint64_t)feasibee_totals_kappa(setting);
#endif
    feasibee_write_counts(product, 2 * ((uint64_t)setting->robots - 1) * tasks_seen, robots, tasks);
}

/* An id, and a number of 16 bits: messages of totals. */
static inline void feasibee_totals_pack(struct feasibee_writer *writer, const uint32_t *words,
                                        feasibee_id sender, const struct feasibee_setting *setting)
{
    feasibee_pack_word(writer, words, sender, setting, 16);
}

static inline int32_t feasibee_totals_unpack(uint32_t *words, struct feasibee_reader *reader,
                                             const struct feasibee_setting *setting)
{
    return feasibee_unpack_word(words, reader, setting, 16);
}

static const struct feasibee_knowledge feasibee_totals_knowledge = {
    NULL,
    feasibee_totals_observe,
    feasibee_totals_encode,
    feasibee_totals_merge,
    feasibee_totals_count,
    NULL,
    NULL,
    NULL,
    feasibee_totals_words,
    feasibee_one_word,
    feasibee_totals_pack,
    feasibee_totals_unpack,
    3,
};

static const struct feasibee_strategy feasibee_totals = {
    true,
    false,
    false,
    false,
    feasibee_share_of_robots,
    NULL,
    NULL,
    feasibee_more,
    &feasibee_totals_knowledge,
};

#endif

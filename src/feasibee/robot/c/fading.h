/* Fading: counts of lately seen tasks that lose their weight with time, for worlds that change.
 *
 * Parameters: tau, margin, ratio, sees, fast, bounded. Needs FEASIBEE_DOUBLE. */

#include "quiet.h"
#include "rules.h"

#if FEASIBEE_WORDS > 0 && defined(FEASIBEE_DOUBLE)

/* Numbers of a robot's memory: the share kept in a step, its own counts, and the sums of those heard; then
 * the same of the fast ones. */
enum {
    FEASIBEE_FADE,
    FEASIBEE_LOOKS,
    FEASIBEE_TASKS,
    FEASIBEE_ALL_LOOKS,
    FEASIBEE_ALL_TASKS,
    FEASIBEE_OF_FAST
};

#define FEASIBEE_FADING_TAU 0
#define FEASIBEE_FADING_MARGIN 1
#define FEASIBEE_FADING_RATIO 2
#define FEASIBEE_FADING_SEES 3
#define FEASIBEE_FADING_FAST 4
#define FEASIBEE_FADING_BOUNDED 5
#define FEASIBEE_PI 3.141592653589793
#define FEASIBEE_FADING_LEAST (1.0 / 2048.0)

static inline bool feasibee_fading_by_ratio(const struct feasibee_setting *setting)
{
    return setting->parameters[FEASIBEE_FADING_RATIO] > 0.0;
}

static inline bool feasibee_fading_is_fast(const struct feasibee_setting *setting)
{
    return setting->parameters[FEASIBEE_FADING_FAST] > 0.0;
}

/* Return a number, kept between two others. */
static inline double feasibee_between(double number, double least, double most)
{
    number = number > least ? number : least;
    return number < most ? number : most;
}

/* Return tau in steps, by the rule unless it is set. */
static inline double feasibee_fading_tau(const struct feasibee_setting *setting)
{
    const double longest = 1e6;
    bool by_ratio = feasibee_fading_by_ratio(setting);
    if (setting->parameters[FEASIBEE_FADING_TAU] > 0.0)
        return feasibee_between(setting->parameters[FEASIBEE_FADING_TAU], 1.0, longest);
    if (!setting->knows_count)
        return by_ratio ? 150.0 : 120.0;
    double exploring = feasibee_exploring(setting), margin = setting->parameters[FEASIBEE_FADING_MARGIN];
    double visits =
        feasibee_swept(setting->sight * exploring, setting->count, setting) / feasibee_room(setting);
    double met =
        feasibee_swept(setting->radio * (1.0 - exploring), 1, setting) / (setting->width * setting->height);
    double meets = 4.0 / FEASIBEE_PI * met;
    margin = margin > 1e-3 ? margin : 1e-3;
    double seen = 2.0 * visits * setting->count * (margin * margin);
    if (seen <= 0.0 || meets <= 0.0)
        return longest;
    double pooled = 1.2 * 2.4 * 2.4 / seen * (by_ratio ? 2.0 : 1.0);
    return feasibee_between((pooled + FEASIBEE_SQRT(pooled * (pooled + 4.0 / meets))) / 2.0, 1.0, longest);
}

/* Return the mean share of the arena that a robot sees; within walls that of a random place. */
static inline double feasibee_share_in_sight(const struct feasibee_setting *setting)
{
    double area = setting->width * setting->height, reach = setting->sight,
           seen = FEASIBEE_PI * reach * reach;
    if (setting->walled)
        seen +=
            FEASIBEE_POW(reach, 3.0) * (reach / 2.0 - 4.0 / 3.0 * (setting->width + setting->height)) / area;
    return feasibee_between(seen / area * setting->parameters[FEASIBEE_FADING_SEES], 1e-9, 1.0);
}

/* Return a power with a whole exponent. */
static inline double feasibee_power(double base, uint32_t exponent)
{
    double result = 1.0;
    for (; exponent > 0; exponent >>= 1) {
        if (exponent & 1)
            result *= base;
        base *= base;
    }
    return result;
}

/* Return a number from 0 to 1 by the robot's hash and the step. */
static inline double feasibee_fading_chance(const struct feasibee_robot *robot, uint32_t which)
{
    uint32_t bits = robot->me.hash ^ (robot->me.step * UINT32_C(0x5851F42D) + which * UINT32_C(0x14057B7F));
    bits = (bits ^ bits >> 16) * UINT32_C(0x2C1B3C6D);
    bits = (bits ^ bits >> 12) * UINT32_C(0x297A2D39);
    return (double)(bits ^ bits >> 15) / 4294967296.0;
}

/* Return a number as 8 bits, rounded up or down at random so that its mean is right. */
static inline uint32_t feasibee_fading_code_of(double value, double chance)
{
    uint32_t code = 1;
    double reached = FEASIBEE_FADING_LEAST;
    if (value < reached)
        return chance * FEASIBEE_FADING_LEAST < value;
    for (uint32_t weight = 128; weight > 0; weight >>= 1) {
        double factor = feasibee_power(1.04, weight);
        if (code + weight <= 255 && reached * factor <= value) {
            code += weight;
            reached *= factor;
        }
    }
    return code + (code < 255 && chance * (1.04 - 1.0) * reached < value - reached);
}

static inline double feasibee_fading_value_of(uint32_t code)
{
    return code > 0 ? FEASIBEE_FADING_LEAST * feasibee_power(1.04, code - 1) : 0.0;
}

/* Words of what is known: number of robots heard; then for each robot and tau its row, and the step when it
 * came. */
static inline uint32_t feasibee_fading_words(const struct feasibee_setting *setting)
{
    return 1 + 2 * (uint32_t)setting->robots * (feasibee_fading_is_fast(setting) ? 2 : 1);
}

static inline void feasibee_fading_start(struct feasibee_robot *robot)
{
    double fast = robot->settings->setting->parameters[FEASIBEE_FADING_FAST], *memory = robot->memory.numbers;
    memory[FEASIBEE_FADE] = 1.0 - 1.0 / feasibee_fading_tau(robot->settings->setting);
    memory[FEASIBEE_OF_FAST + FEASIBEE_FADE] = 1.0 - 1.0 / (fast > 1.0 ? fast : 1.0);
}

/* Count a task in sight, or, for the ratio, a robot. */
static inline void feasibee_fading_observe(struct feasibee_robot *robot, const struct feasibee_thing *thing)
{
    double *memory = robot->memory.numbers;
    if (!thing->is_robot) {
        memory[FEASIBEE_TASKS] += 1.0;
        memory[FEASIBEE_OF_FAST + FEASIBEE_TASKS] += 1.0;
    } else if (thing->id != (int32_t)robot->me.id && feasibee_fading_by_ratio(robot->settings->setting)) {
        memory[FEASIBEE_LOOKS] += 1.0;
        memory[FEASIBEE_OF_FAST + FEASIBEE_LOOKS] += 1.0;
    }
}

/* Write the robot's own counts in units of tau, in turn of the slow and the fast ones. */
static inline void feasibee_fading_encode(struct feasibee_robot *robot, uint32_t *words)
{
    bool fast = feasibee_fading_is_fast(robot->settings->setting) && (robot->me.step & 1);
    const double *own = robot->memory.numbers + (fast ? FEASIBEE_OF_FAST : 0);
    double unit = 1.0 - own[FEASIBEE_FADE];
    double looks = own[FEASIBEE_LOOKS] * unit, tasks = own[FEASIBEE_TASKS] * unit;
    double too_large = (looks > tasks ? looks : tasks) / feasibee_fading_value_of(255);
    too_large = too_large > 1.0 ? too_large : 1.0;
    words[0] = feasibee_fading_code_of(looks / too_large, feasibee_fading_chance(robot, 0)) << 8;
    words[0] |= feasibee_fading_code_of(tasks / too_large, feasibee_fading_chance(robot, 1));
    words[0] |= fast ? UINT32_C(1) << 16 : 0;
}

/* Return the largest code of looks, or of robots in sight, that bounded robots believe. */
static inline uint32_t feasibee_fading_most_looks(const struct feasibee_setting *setting)
{
    double mean = feasibee_exploring(setting);
    if (feasibee_fading_by_ratio(setting))
        mean *= feasibee_share_in_sight(setting) * setting->count;
    return feasibee_fading_code_of(1.2 * mean, 1.0);
}

/* Return the row of a message; with bounded one that is honest for about n + 1/2 tasks. */
static inline uint32_t feasibee_fading_believed(uint32_t word, const struct feasibee_setting *setting)
{
    uint32_t looks = word >> 8 & 255, tasks = word & 255;
    if (setting->parameters[FEASIBEE_FADING_BOUNDED] > 0.0 && setting->knows_count) {
        uint32_t most = feasibee_fading_most_looks(setting), excess = looks > most ? looks - most : 0;
        looks -= excess;
        tasks = tasks > excess ? tasks - excess : 0;
        double others = setting->count > 1 ? setting->count - 1.0 : 1.0;
        double neutral = (setting->count + 0.5) * feasibee_fading_value_of(looks);
        neutral *= feasibee_fading_by_ratio(setting) ? 1.0 / others : feasibee_share_in_sight(setting);
        uint32_t low = feasibee_fading_code_of(neutral / 2.0, 1.0),
                 high = feasibee_fading_code_of(neutral * 2.0, 1.0);
        tasks = tasks < high ? tasks : high;
        tasks = tasks > low ? tasks : low;
    }
    return looks << 8 | tasks;
}

/* Add a row to the sums with a weight. */
static inline void feasibee_fading_add(double *sums, uint32_t row, double weight)
{
    weight /= 1.0 - sums[FEASIBEE_FADE];
    sums[FEASIBEE_ALL_LOOKS] += weight * feasibee_fading_value_of(row >> 8 & 255);
    sums[FEASIBEE_ALL_TASKS] += weight * feasibee_fading_value_of(row & 255);
}

/* Subtract what is left of the row of an id from the sums; return whether it had one. */
static inline bool feasibee_fading_drop(struct feasibee_robot *robot, uint32_t place, double *sums)
{
    uint32_t came = robot->known[place + 1];
    if (came == 0)
        return false;
    double left = feasibee_power(sums[FEASIBEE_FADE], feasibee_stamp_of(robot->me.step) - came);
    feasibee_fading_add(sums, robot->known[place], -left);
    robot->known[place + 1] = 0;
    return true;
}

/* Replace the row of an id, and what is left of it in the sums. */
static inline void feasibee_fading_merge(struct feasibee_robot *robot, const uint32_t *words,
                                         feasibee_id sender)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    bool fast = feasibee_fading_is_fast(setting) && (words[0] >> 16 & 1);
    uint32_t row = feasibee_fading_believed(words[0], setting);
    uint32_t place = 1 + 2 * (sender + (fast ? (uint32_t)setting->robots : 0));
    double *sums = robot->memory.numbers + (fast ? FEASIBEE_OF_FAST : 0);
    bool had = feasibee_fading_drop(robot, place, sums);
    feasibee_fading_add(sums, row, 1.0);
    robot->known[place] = row;
    robot->known[place + 1] = feasibee_stamp_of(robot->me.step);
    robot->known[0] += !fast && !had;
}

/* Return the number of robots that the robot believes in: n of the start, or itself and all heard. */
static inline uint32_t feasibee_fading_robots(const struct feasibee_robot *robot)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    return setting->knows_count ? setting->count : 1 + robot->known[0];
}

/* Return the number of tasks by the counts, slow or fast; -1.0 as long as they say nothing. */
static inline double feasibee_fading_tasks(const struct feasibee_robot *robot, const double *counts)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    double looks = counts[FEASIBEE_LOOKS] + counts[FEASIBEE_ALL_LOOKS];
    double tasks = counts[FEASIBEE_TASKS] + counts[FEASIBEE_ALL_TASKS];
    bool by_ratio = feasibee_fading_by_ratio(setting);
    uint32_t others = feasibee_fading_robots(robot) - 1;
    if (looks < 1e-9 || (by_ratio && others == 0))
        return -1.0;
    tasks = tasks > 0.0 ? tasks : 0.0;
    return by_ratio ? tasks * (double)others / looks : tasks / (looks * feasibee_share_in_sight(setting));
}

/* Return the estimated number of tasks; -1.0 if nothing is known. */
static inline double feasibee_fading_estimate(const struct feasibee_robot *robot)
{
    double slow = feasibee_fading_tasks(robot, robot->memory.numbers);
    if (feasibee_fading_is_fast(robot->settings->setting)) {
        double fast = feasibee_fading_tasks(robot, robot->memory.numbers + FEASIBEE_OF_FAST);
        if (fast >= 0.0 && (fast > 1.5 * slow || 1.5 * fast < slow))
            return fast;
    }
    return slow;
}

/* Return whether a row that came in a step, counted from 1, is from a robot that may have left since. */
static inline bool feasibee_fading_is_old(const struct feasibee_robot *robot, uint32_t came)
{
    uint32_t age = feasibee_stamp_of(robot->me.step) - came;
    return came > 0 && age > feasibee_steps_for(3.0, 1, robot->settings->setting);
}

/* Return what the estimate says, and let all counts fade. */
static inline int8_t feasibee_fading_judge(struct feasibee_robot *robot)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    double *memory = robot->memory.numbers;
    uint32_t place = 1 + 2 * (robot->me.step % setting->robots);
    if (!robot->disseminating && !feasibee_fading_by_ratio(setting)) {
        memory[FEASIBEE_LOOKS] += 1.0;
        memory[FEASIBEE_OF_FAST + FEASIBEE_LOOKS] += 1.0;
    }
    if (!setting->knows_count && feasibee_fading_is_old(robot, robot->known[place + 1]))
        robot->known[0] -= feasibee_fading_drop(robot, place, memory);
    double tasks = feasibee_fading_estimate(robot);
    for (uint8_t k = FEASIBEE_LOOKS; k <= FEASIBEE_ALL_TASKS; k++) {
        memory[k] *= memory[FEASIBEE_FADE];
        memory[FEASIBEE_OF_FAST + k] *= memory[FEASIBEE_OF_FAST + FEASIBEE_FADE];
    }
    if (tasks < 0.0)
        return FEASIBEE_NONE;
    return tasks <= (double)feasibee_fading_robots(robot) + 0.5 ? FEASIBEE_FEASIBLE : FEASIBEE_INFEASIBLE;
}

/* Write both sides of the rule. */
static inline void feasibee_fading_count(struct feasibee_robot *robot, uint32_t *robots, uint32_t *tasks)
{
    const double scale = 65536.0;
    double estimate = feasibee_fading_estimate(robot);
    *robots = *tasks = 0;
    if (estimate >= 0.0)
        feasibee_write_counts((uint64_t)(scale * ((double)feasibee_fading_robots(robot) + 0.5)),
                              (uint64_t)(scale * (estimate < scale * scale ? estimate : scale * scale)),
                              robots, tasks);
}

static inline void feasibee_fading_pack(struct feasibee_writer *writer, const uint32_t *words,
                                        feasibee_id sender, const struct feasibee_setting *setting)
{
    feasibee_pack_word(writer, words, sender, setting, feasibee_fading_is_fast(setting) ? 17 : 16);
}

static inline int32_t feasibee_fading_unpack(uint32_t *words, struct feasibee_reader *reader,
                                             const struct feasibee_setting *setting)
{
    return feasibee_unpack_word(words, reader, setting, feasibee_fading_is_fast(setting) ? 17 : 16);
}

static const struct feasibee_knowledge feasibee_fading_knowledge = {
    feasibee_fading_start,
    feasibee_fading_observe,
    feasibee_fading_encode,
    feasibee_fading_merge,
    feasibee_fading_count,
    NULL,
    feasibee_fading_judge,
    NULL,
    feasibee_fading_words,
    feasibee_one_word,
    feasibee_fading_pack,
    feasibee_fading_unpack,
    6,
};

static const struct feasibee_strategy feasibee_fading = {
    true,
    false,
    false,
    false,
    feasibee_share_of_robots,
    NULL,
    NULL,
    feasibee_keep_opinion,
    &feasibee_fading_knowledge,
};

#endif

/* Quiet census: robots count the tasks by name, and declare once nothing new has come for long enough.
 *
 * Parameters: quiet, tolerates, hurry, lasts. Without FEASIBEE_DOUBLE, quiet must be above 0: it isn't
 * computed. */

#include "quiet.h"
#include "rules.h"

#if FEASIBEE_WORDS > 0

/* Words of what is known: number of names, until when to wait for another; then the sets, 31 names a word,
 * and for each name the neighbours that sent it. */
enum { FEASIBEE_QUIET_NAMES, FEASIBEE_QUIET_UNTIL, FEASIBEE_QUIET_SETS, FEASIBEE_QUIET_IN_WORD = 31 };

/* Return the size of the set of robots, which is counted only if n is unknown. */
static inline uint32_t feasibee_quiet_robot_words(const struct feasibee_setting *setting)
{
    return setting->knows_count ? 0 : (setting->robot_ids + UINT32_C(30)) / FEASIBEE_QUIET_IN_WORD;
}

static inline uint32_t feasibee_quiet_message_words(const struct feasibee_setting *setting)
{
    return feasibee_quiet_robot_words(setting) + (setting->task_ids + UINT32_C(30)) / FEASIBEE_QUIET_IN_WORD;
}

static inline uint32_t feasibee_quiet_words(const struct feasibee_setting *setting)
{
    uint32_t sets = feasibee_quiet_message_words(setting);
    return FEASIBEE_QUIET_SETS + sets + sets * FEASIBEE_QUIET_IN_WORD * feasibee_tolerated(setting, 1);
}

static inline void feasibee_quiet_add(uint32_t *set, uint32_t id)
{
    set[id / FEASIBEE_QUIET_IN_WORD] |= UINT32_C(1) << (id % FEASIBEE_QUIET_IN_WORD);
}

static inline void feasibee_quiet_start(struct feasibee_robot *robot)
{
    if (!robot->settings->setting->knows_count)
        feasibee_quiet_add(robot->known + FEASIBEE_QUIET_SETS, robot->me.id);
}

static inline void feasibee_quiet_observe(struct feasibee_robot *robot, const struct feasibee_thing *thing)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    uint32_t *sets = robot->known + FEASIBEE_QUIET_SETS;
    if (!feasibee_has_id(thing, setting))
        return;
    if (!thing->is_robot)
        feasibee_quiet_add(sets + feasibee_quiet_robot_words(setting), (uint32_t)thing->id);
    else if (!setting->knows_count)
        feasibee_quiet_add(sets, (uint32_t)thing->id);
}

static inline void feasibee_quiet_encode(struct feasibee_robot *robot, uint32_t *words)
{
    for (uint32_t k = 0; k < feasibee_quiet_message_words(robot->settings->setting); k++)
        words[k] = robot->known[FEASIBEE_QUIET_SETS + k];
}

/* Add the names that enough neighbours have sent. */
static inline void feasibee_quiet_merge(struct feasibee_robot *robot, const uint32_t *words,
                                        feasibee_id sender)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    uint32_t *sets = robot->known + FEASIBEE_QUIET_SETS, length = feasibee_quiet_message_words(setting);
    uint16_t tolerates = feasibee_tolerated(setting, 1);
    for (uint32_t k = 0; k < length * FEASIBEE_QUIET_IN_WORD; k++) {
        uint32_t word = k / FEASIBEE_QUIET_IN_WORD, bit = UINT32_C(1) << (k % FEASIBEE_QUIET_IN_WORD);
        if ((words[word] & ~sets[word] & bit) != 0 &&
            feasibee_told_enough(sets + length + k * tolerates, tolerates, sender))
            sets[word] |= bit;
    }
}

static inline void feasibee_quiet_count(struct feasibee_robot *robot, uint32_t *robots, uint32_t *tasks)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    const uint32_t *sets = robot->known + FEASIBEE_QUIET_SETS;
    uint32_t first = feasibee_quiet_robot_words(setting);
    *robots = setting->knows_count ? setting->robots : feasibee_members(sets, first);
    *tasks = feasibee_members(sets + first, feasibee_quiet_message_words(setting) - first);
}

/* Return the quiet time after which a robot that knows of so many robots is sure, in steps. */
static inline uint32_t feasibee_quiet_steps(uint32_t robots, const struct feasibee_setting *setting)
{
    if (setting->parameters[0] > 0)
        return feasibee_steps_given(setting->parameters[0]);
#ifdef FEASIBEE_DOUBLE
    double half = (setting->parameters[3] < FEASIBEE_NEVER ? setting->parameters[3] : FEASIBEE_NEVER) / 2.0;
    double lasts = half > setting->dissemination ? half : setting->dissemination;
    double exploring = setting->exploration / (setting->exploration + lasts);
    return feasibee_steps_with(exploring, feasibee_patience(robots, feasibee_tolerated(setting, 1)), robots,
                               setting);
#else
    (void)robots;
    return FEASIBEE_NEVER;
#endif
}

/* Return infeasible if there are more tasks than n; otherwise the answer, after the quiet time. */
static inline int8_t feasibee_quiet_declare(struct feasibee_robot *robot)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    uint32_t robots, tasks, *known = robot->known;
    feasibee_quiet_count(robot, &robots, &tasks);
    if (setting->knows_count && tasks > robots)
        return FEASIBEE_INFEASIBLE;
    if (robots + tasks != known[FEASIBEE_QUIET_NAMES]) {
        known[FEASIBEE_QUIET_NAMES] = robots + tasks;
        known[FEASIBEE_QUIET_UNTIL] = robot->me.step + feasibee_quiet_steps(robots, setting);
    }
    if (!feasibee_has_come(robot, known[FEASIBEE_QUIET_UNTIL]))
        return FEASIBEE_NONE;
    return robots >= tasks ? FEASIBEE_FEASIBLE : FEASIBEE_INFEASIBLE;
}

static inline void feasibee_quiet_pack(struct feasibee_writer *writer, const uint32_t *words,
                                       feasibee_id sender, const struct feasibee_setting *setting)
{
    if (feasibee_tolerated(setting, 1) > 0)
        feasibee_write(writer, sender, setting->id_bits);
    if (!setting->knows_count)
        feasibee_pack_names(writer, words, FEASIBEE_QUIET_IN_WORD, setting->robot_ids, setting->id_bits);
    words += feasibee_quiet_robot_words(setting);
    feasibee_pack_names(writer, words, FEASIBEE_QUIET_IN_WORD, setting->task_ids, 32);
}

static inline int32_t feasibee_quiet_unpack(uint32_t *words, struct feasibee_reader *reader,
                                            const struct feasibee_setting *setting)
{
    int32_t sender = -1;
    if (feasibee_tolerated(setting, 1) > 0)
        sender = (int32_t)feasibee_read_below(reader, setting->robots, setting->id_bits);
    if (!setting->knows_count)
        feasibee_unpack_names(reader, words, FEASIBEE_QUIET_IN_WORD, setting->robot_ids, setting->id_bits);
    words += feasibee_quiet_robot_words(setting);
    feasibee_unpack_names(reader, words, FEASIBEE_QUIET_IN_WORD, setting->task_ids, 32);
    return sender;
}

/* Return any opinion, so that the robot is not silent. */
static inline int8_t feasibee_quiet_say(struct feasibee_robot *robot)
{
    return robot->opinion == FEASIBEE_FEASIBLE ? FEASIBEE_FEASIBLE : FEASIBEE_INFEASIBLE;
}

/* Return for how long to broadcast on average: one step in a hurry, then as given, or g. */
static inline feasibee_steps feasibee_quiet_lasting(struct feasibee_robot *robot)
{
    const feasibee_number *parameters = robot->settings->setting->parameters;
    feasibee_number hurry = parameters[2], lasts = parameters[3];
    struct feasibee_ratio quality = robot->feasible_quality;
#ifdef FEASIBEE_DOUBLE
    double feasible = (double)quality.part / (double)quality.whole;
    if (1.0 - feasible < hurry * feasible - 1e-9)
        return 0;
    if (lasts > FEASIBEE_NEVER)
        lasts = FEASIBEE_NEVER;
#else
    if ((int64_t)(quality.whole - quality.part) * 65536 < (int64_t)hurry * quality.part)
        return 0;
#endif
    return lasts > 0 ? (feasibee_steps)lasts : robot->settings->gain;
}

static const struct feasibee_knowledge feasibee_quiet_census_knowledge = {
    feasibee_quiet_start,
    feasibee_quiet_observe,
    feasibee_quiet_encode,
    feasibee_quiet_merge,
    feasibee_quiet_count,
    feasibee_quiet_declare,
    NULL,
    feasibee_quiet_lasting,
    feasibee_quiet_words,
    feasibee_quiet_message_words,
    feasibee_quiet_pack,
    feasibee_quiet_unpack,
    4,
};

static const struct feasibee_strategy feasibee_quiet_census = {
    true,
    true,
    false,
    false,
    feasibee_share_of_robots,
    feasibee_quiet_say,
    NULL,
    feasibee_keep_opinion,
    &feasibee_quiet_census_knowledge,
};

#endif

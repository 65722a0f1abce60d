/* Turns: a census in a few bits, a few names of tasks in turn and an alarm.
 *
 * Parameters: names, name_bits, quiet, tolerates, looks. n must be known. Without FEASIBEE_DOUBLE, quiet must
 * be above 0: it isn't computed. */

#include "quiet.h"
#include "rules.h"

#if FEASIBEE_WORDS > 0

/* Words of what is known; then come the senders of the alarm, the sorted names, each name that waits with its
 * senders, and the names seen once after their number. */
enum {
    FEASIBEE_TURNS_ALARM,
    FEASIBEE_TURNS_KNOWN,   /* number of names */
    FEASIBEE_TURNS_UNTIL,   /* end of the quiet time */
    FEASIBEE_TURNS_TURN,    /* whose turn it is */
    FEASIBEE_TURNS_PENDING, /* number of waiting names */
    FEASIBEE_TURNS_TOLD,
    FEASIBEE_TURNS_GLIMPSES = 16
};

static inline uint8_t feasibee_turns_name_bits(const struct feasibee_setting *setting)
{
    return (uint8_t)feasibee_whole(setting, 1, 1, 31);
}

static inline bool feasibee_turns_looks_twice(const struct feasibee_setting *setting)
{
    return setting->parameters[4] >= FEASIBEE_NUMBER(2);
}

static inline bool feasibee_turns_sends_all(const struct feasibee_setting *setting)
{
    return setting->parameters[0] < 0;
}

/* Return the number of places for names in a message. */
static inline uint32_t feasibee_turns_places(const struct feasibee_setting *setting)
{
    int32_t most = (int32_t)setting->robots + 1;
    return (uint32_t)(feasibee_turns_sends_all(setting) ? most : feasibee_whole(setting, 0, 0, most));
}

static inline uint32_t feasibee_turns_message_words(const struct feasibee_setting *setting)
{
    return 1 + feasibee_turns_places(setting);
}

/* Return the place of the first name. */
static inline uint32_t feasibee_turns_first(const struct feasibee_setting *setting)
{
    return FEASIBEE_TURNS_TOLD + (uint32_t)feasibee_tolerated(setting, 3);
}

/* Return the place of the first name that waits, and of the names seen once. */
static inline uint32_t feasibee_turns_waiting(const struct feasibee_setting *setting)
{
    return feasibee_turns_first(setting) + setting->robots + 1;
}

static inline uint32_t feasibee_turns_glimpses(const struct feasibee_setting *setting)
{
    uint16_t tolerates = feasibee_tolerated(setting, 3);
    uint32_t waiting = tolerates > 0 ? (uint32_t)setting->task_ids * (1 + (uint32_t)tolerates) : 0;
    return feasibee_turns_waiting(setting) + waiting;
}

static inline uint32_t feasibee_turns_words(const struct feasibee_setting *setting)
{
    bool twice = feasibee_turns_looks_twice(setting);
    return feasibee_turns_glimpses(setting) + (twice ? 1 + (uint32_t)FEASIBEE_TURNS_GLIMPSES : 0);
}

#ifdef FEASIBEE_DOUBLE

/* Return how often the swarm would find a task in the quiet time: the longer, the fewer names are sent. */
static inline double feasibee_turns_patience(const struct feasibee_setting *setting)
{
    uint32_t tolerates = feasibee_tolerated(setting, 3);
    double rounds = 0.0;
    if (!feasibee_turns_sends_all(setting))
        rounds = (1.0 + (double)tolerates) * setting->robots / (double)feasibee_turns_places(setting);
    return feasibee_patience(setting->robots, tolerates) * (1.0 + rounds / 50.0);
}

/* Return how often a robot must find a task by itself until f + 1 robots have seen all of n + 1. */
static inline double feasibee_turns_patience_alone(const struct feasibee_setting *setting)
{
    uint32_t robots = setting->robots, tolerates = feasibee_tolerated(setting, 3);
    if (tolerates > 0 && robots <= 2 * tolerates)
        return FEASIBEE_MUCH;
    double flooding = feasibee_patience(robots, tolerates) / (double)robots, groups = (double)tolerates + 1.0;
    double each = 1.0 - FEASIBEE_POW(0.001 / groups, groups / (double)(robots - tolerates));
    return flooding - FEASIBEE_LOG(1.0 - FEASIBEE_POW(each, 1.0 / (double)(robots + 1)));
}

#endif

/* Return the quiet time, in steps; the time from the start if no names are sent. */
static inline uint32_t feasibee_turns_quiet_steps(const struct feasibee_setting *setting)
{
    if (setting->parameters[2] > 0)
        return feasibee_steps_given(setting->parameters[2]);
#ifdef FEASIBEE_DOUBLE
    if (feasibee_turns_places(setting) == 0)
        return feasibee_steps_for(feasibee_turns_patience_alone(setting), 1, setting);
    return feasibee_steps_for(feasibee_turns_patience(setting), setting->robots, setting);
#else
    return FEASIBEE_NEVER;
#endif
}

static inline void feasibee_turns_start(struct feasibee_robot *robot)
{
    uint32_t quiet = feasibee_turns_quiet_steps(robot->settings->setting);
    robot->known[FEASIBEE_TURNS_UNTIL] = robot->me.step + quiet;
}

/* Return the place of the first name that counts and is not below this one. */
static inline uint32_t feasibee_turns_place_of(const struct feasibee_robot *robot, uint32_t name)
{
    uint32_t first = feasibee_turns_first(robot->settings->setting);
    for (uint32_t number = robot->known[FEASIBEE_TURNS_KNOWN]; number > 0;) {
        uint32_t half = (number + 1) / 2;
        first += robot->known[first + half - 1] < name ? half : 0;
        number -= half;
    }
    return first;
}

static inline bool feasibee_turns_counts(const struct feasibee_robot *robot, uint32_t name)
{
    uint32_t place = feasibee_turns_place_of(robot, name);
    uint32_t last = feasibee_turns_first(robot->settings->setting) + robot->known[FEASIBEE_TURNS_KNOWN];
    return place < last && robot->known[place] == name;
}

/* Add a name to those that count, and raise the alarm if there are more than robots. */
static inline void feasibee_turns_accept(struct feasibee_robot *robot, uint32_t name)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    uint32_t *known = robot->known, place = feasibee_turns_place_of(robot, name);
    uint32_t first = feasibee_turns_first(setting);
    if (known[FEASIBEE_TURNS_KNOWN] > setting->robots || feasibee_turns_counts(robot, name))
        return;
    for (uint32_t k = first + known[FEASIBEE_TURNS_KNOWN]; k > place; k--)
        known[k] = known[k - 1];
    known[place] = name;
    known[FEASIBEE_TURNS_KNOWN]++;
    known[FEASIBEE_TURNS_TURN] += place - first < known[FEASIBEE_TURNS_TURN];
    if (feasibee_turns_places(setting) > 0)
        known[FEASIBEE_TURNS_UNTIL] = robot->me.step + feasibee_turns_quiet_steps(setting);
    if (known[FEASIBEE_TURNS_KNOWN] > setting->robots)
        known[FEASIBEE_TURNS_ALARM] = 1;
}

/* Return whether a name is among the last ones that were seen once; if not, keep it there. */
static inline bool feasibee_turns_glimpsed(struct feasibee_robot *robot, uint32_t name)
{
    uint32_t *number = robot->known + feasibee_turns_glimpses(robot->settings->setting);
    for (uint8_t k = 1; k <= FEASIBEE_TURNS_GLIMPSES; k++)
        if (number[k] == name)
            return true;
    number[1 + *number % FEASIBEE_TURNS_GLIMPSES] = name;
    ++*number;
    return false;
}

/* Add the name of a task in sight, at the second look if there must be one. */
static inline void feasibee_turns_observe(struct feasibee_robot *robot, const struct feasibee_thing *thing)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    if (thing->is_robot)
        return;
    uint32_t name = thing->hash >> (32 - feasibee_turns_name_bits(setting));
    name = name > 0 ? name : 1;
    if (feasibee_turns_looks_twice(setting) && !feasibee_turns_counts(robot, name) &&
        !feasibee_turns_glimpsed(robot, name))
        return;
    feasibee_turns_accept(robot, name);
}

/* Write the alarm, and the names whose turn it is. */
static inline void feasibee_turns_encode(struct feasibee_robot *robot, uint32_t *words)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    uint32_t *known = robot->known, first = feasibee_turns_first(setting),
             number = known[FEASIBEE_TURNS_KNOWN];
    uint32_t turn = feasibee_turns_sends_all(setting) ? 0 : known[FEASIBEE_TURNS_TURN];
    words[0] = known[FEASIBEE_TURNS_ALARM];
    for (uint32_t k = 1; k <= feasibee_turns_places(setting); k++) {
        words[k] = 0;
        if (k <= number) {
            turn = turn < number ? turn : 0;
            words[k] = known[first + turn];
            turn++;
        }
    }
    known[FEASIBEE_TURNS_TURN] = turn;
}

/* Accept a name once enough neighbours have sent it; until then it waits. */
static inline void feasibee_turns_consider(struct feasibee_robot *robot, uint32_t name, feasibee_id sender)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    uint16_t tolerates = feasibee_tolerated(setting, 3);
    uint32_t *known = robot->known, entry = feasibee_turns_waiting(setting), size = 1 + (uint32_t)tolerates;
    uint32_t room = entry + setting->task_ids * size, end = entry + known[FEASIBEE_TURNS_PENDING] * size;
    if (tolerates == 0) {
        feasibee_turns_accept(robot, name);
        return;
    }
    if (feasibee_turns_counts(robot, name))
        return;
    while (entry < end && known[entry] != name)
        entry += size;
    if (entry == end && entry < room) {
        known[entry] = name;
        known[FEASIBEE_TURNS_PENDING]++;
    }
    if (entry < room && feasibee_told_enough(known + entry + 1, tolerates, sender))
        feasibee_turns_accept(robot, name);
}

static inline void feasibee_turns_merge(struct feasibee_robot *robot, const uint32_t *words,
                                        feasibee_id sender)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    uint32_t *known = robot->known;
    bool alarmed = words[0] == 1 && known[FEASIBEE_TURNS_ALARM] == 0;
    if (alarmed && feasibee_told_enough(known + FEASIBEE_TURNS_TOLD, feasibee_tolerated(setting, 3), sender))
        known[FEASIBEE_TURNS_ALARM] = 1;
    for (uint32_t k = 1; k <= feasibee_turns_places(setting); k++)
        if (words[k] != 0)
            feasibee_turns_consider(robot, words[k], sender);
}

/* Count the robots, and the names; more than robots after an alarm. */
static inline void feasibee_turns_count(struct feasibee_robot *robot, uint32_t *robots, uint32_t *tasks)
{
    *robots = robot->settings->setting->robots;
    *tasks = robot->known[FEASIBEE_TURNS_ALARM] ? *robots + 1 : robot->known[FEASIBEE_TURNS_KNOWN];
}

/* Return infeasible after an alarm, feasible after the quiet time. */
static inline int8_t feasibee_turns_declare(struct feasibee_robot *robot)
{
    if (robot->known[FEASIBEE_TURNS_ALARM])
        return FEASIBEE_INFEASIBLE;
    bool over = feasibee_has_come(robot, robot->known[FEASIBEE_TURNS_UNTIL]);
    return over ? FEASIBEE_FEASIBLE : FEASIBEE_NONE;
}

/* Return how many low bits of a gap Rice's code writes as they are, for so many names. */
static inline uint8_t feasibee_turns_low_bits(uint32_t number, uint8_t length)
{
    uint8_t bits = feasibee_bit_length((UINT32_C(1) << length) / (number + 1));
    return bits > 0 ? (uint8_t)(bits - 1) : 0;
}

static inline void feasibee_turns_pack(struct feasibee_writer *writer, const uint32_t *words,
                                       feasibee_id sender, const struct feasibee_setting *setting)
{
    uint32_t number = 0, last = 0, places = feasibee_turns_places(setting);
    uint8_t length = feasibee_turns_name_bits(setting);
    feasibee_write(writer, sender, setting->id_bits);
    feasibee_write_flag(writer, words[0] == 1);
    if (!feasibee_turns_sends_all(setting)) {
        for (uint32_t k = 1; k <= places; k++)
            feasibee_write(writer, words[k], length);
        return;
    }
    while (number < places && words[number + 1] != 0)
        number++;
    feasibee_write(writer, number, feasibee_bit_length(places));
    for (uint32_t k = 1; k <= number; k++) {
        feasibee_write_rice(writer, words[k] - last - 1, feasibee_turns_low_bits(number, length));
        last = words[k];
    }
}

static inline int32_t feasibee_turns_unpack(uint32_t *words, struct feasibee_reader *reader,
                                            const struct feasibee_setting *setting)
{
    uint32_t last = 0, places = feasibee_turns_places(setting);
    uint8_t length = feasibee_turns_name_bits(setting);
    int32_t sender = (int32_t)feasibee_read_below(reader, setting->robots, setting->id_bits);
    words[0] = feasibee_read_flag(reader);
    if (!feasibee_turns_sends_all(setting)) {
        for (uint32_t k = 1; k <= places; k++)
            words[k] = feasibee_read(reader, length);
        return sender;
    }
    uint32_t number = feasibee_read_below(reader, places + 1, feasibee_bit_length(places));
    for (uint32_t k = 1; k <= number && !reader->failed; k++) {
        uint32_t left = (UINT32_C(1) << length) - 1 - last; /* names above the last one */
        last += 1 + feasibee_read_rice(reader, left, feasibee_turns_low_bits(number, length));
        words[k] = last;
    }
    return sender;
}

static const struct feasibee_knowledge feasibee_turns_knowledge = {
    feasibee_turns_start,
    feasibee_turns_observe,
    feasibee_turns_encode,
    feasibee_turns_merge,
    feasibee_turns_count,
    feasibee_turns_declare,
    NULL,
    NULL,
    feasibee_turns_words,
    feasibee_turns_message_words,
    feasibee_turns_pack,
    feasibee_turns_unpack,
    5,
};

static const struct feasibee_strategy feasibee_turns = {
    true,
    false,
    false,
    false,
    feasibee_share_of_robots,
    NULL,
    NULL,
    feasibee_at_least,
    &feasibee_turns_knowledge,
};

#endif

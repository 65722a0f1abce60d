/* Roster in turns: a roster in 22 bits, one name per message, each with a version.
 *
 * Parameters: name_bits, robot_timeout, looks, tolerates. Needs FEASIBEE_DOUBLE, and positions: write the
 * robot's x and y in each step, and those of each thing. */

#include "grid.h"
#include "roster_entries.h"
#include "rules.h"

#if FEASIBEE_WORDS > 0 && defined(FEASIBEE_DOUBLE)

/* Words of a message: 1 if it is about a robot, a name or one more than an id, and a version or age. */
enum { FEASIBEE_ROSTER_KIND, FEASIBEE_ROSTER_WHAT, FEASIBEE_ROSTER_VALUE };

static inline void feasibee_roster_turns_observe(struct feasibee_robot *robot,
                                                 const struct feasibee_thing *thing)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    if (thing->is_robot) {
        if (feasibee_has_id(thing, setting))
            feasibee_roster_meet(robot, (uint32_t)thing->id);
        return;
    }
    uint8_t bits = feasibee_roster_name_bits(setting);
    uint32_t entry = feasibee_roster_find(robot, feasibee_grid_name(thing, bits, setting));
    if (entry == FEASIBEE_ROSTER_NO_ENTRY)
        return;
    uint32_t version = robot->known[entry + FEASIBEE_ROSTER_VERSION];
    if (!feasibee_roster_is_there(robot, entry))
        feasibee_roster_change(robot, entry, version > 1 ? version : 1);
    robot->known[entry + FEASIBEE_ROSTER_VAIN] = UINT32_MAX;
}

/* Count the looks in vain at the places of tasks; a task that was looked for in vain has vanished. */
static inline void feasibee_roster_look(struct feasibee_robot *robot)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    uint8_t bits = feasibee_roster_name_bits(setting);
    for (uint32_t k = 0; k < robot->known[FEASIBEE_ROSTER_NUMBER]; k++) {
        uint32_t entry = feasibee_roster_entry(setting, k),
                 *vain = &robot->known[entry + FEASIBEE_ROSTER_VAIN];
        if (*vain == UINT32_MAX) {
            *vain = 0;
        } else if (feasibee_roster_is_there(robot, entry) &&
                   feasibee_grid_is_near(robot, robot->known[entry + FEASIBEE_ROSTER_NAME], bits)) {
            ++*vain;
            if (*vain >= setting->parameters[2])
                feasibee_roster_change(robot, entry, robot->known[entry + FEASIBEE_ROSTER_VERSION]);
        }
    }
}

/* Write the next robot that was there lately, and its age. */
static inline void feasibee_roster_write_robot(struct feasibee_robot *robot, uint32_t *words)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    uint32_t *turn = &robot->known[FEASIBEE_ROSTER_ROBOT_TURN];
    words[FEASIBEE_ROSTER_KIND] = 1;
    for (uint32_t k = 0; k < setting->robot_ids; k++) {
        *turn = *turn + 1 < setting->robot_ids ? *turn + 1 : 0;
        uint32_t state = robot->known[feasibee_roster_robot(setting, *turn)];
        uint32_t age = feasibee_roster_age(robot, state) / 2;
        if (*turn != robot->me.id && state % 2 == 1 && age <= 4095) {
            words[FEASIBEE_ROSTER_WHAT] = *turn + 1;
            words[FEASIBEE_ROSTER_VALUE] = age;
            return;
        }
    }
}

/* Write a task that changed lately, or one in turn; unless n is known, also a robot in turn. */
static inline void feasibee_roster_turns_encode(struct feasibee_robot *robot, uint32_t *words)
{
    uint32_t *known = robot->known, entry = FEASIBEE_ROSTER_NO_ENTRY;
    words[FEASIBEE_ROSTER_KIND] = words[FEASIBEE_ROSTER_WHAT] = words[FEASIBEE_ROSTER_VALUE] = 0;
    known[FEASIBEE_ROSTER_TICK] = (known[FEASIBEE_ROSTER_TICK] + 1) % 4;
    if (known[FEASIBEE_ROSTER_TICK] % 2 == 0)
        entry = feasibee_roster_latest_news(robot, known[FEASIBEE_ROSTER_TICK] == 0);
    if (entry == FEASIBEE_ROSTER_NO_ENTRY) {
        known[FEASIBEE_ROSTER_TURNS] = 1 - known[FEASIBEE_ROSTER_TURNS];
        if (known[FEASIBEE_ROSTER_TURNS] == 0 && !robot->settings->setting->knows_count) {
            feasibee_roster_write_robot(robot, words);
            return;
        }
        entry = feasibee_roster_next_in_turn(robot);
    }
    if (entry != FEASIBEE_ROSTER_NO_ENTRY) {
        words[FEASIBEE_ROSTER_WHAT] = known[entry + FEASIBEE_ROSTER_NAME];
        words[FEASIBEE_ROSTER_VALUE] = known[entry + FEASIBEE_ROSTER_VERSION] - 1;
    }
}

/* Adopt the newer version of a task; send its own soon if the one heard is outdated. */
static inline void feasibee_roster_hear_task(struct feasibee_robot *robot, const uint32_t *words,
                                             feasibee_id sender)
{
    uint32_t entry = feasibee_roster_find(robot, words[FEASIBEE_ROSTER_WHAT]);
    if (entry == FEASIBEE_ROSTER_NO_ENTRY)
        return;
    uint16_t tolerates = feasibee_tolerated(robot->settings->setting, 3);
    uint32_t version = words[FEASIBEE_ROSTER_VALUE], own = robot->known[entry + FEASIBEE_ROSTER_VERSION];
    uint32_t ahead = own > 0 ? (version + 5 - own) % 4 : 1 + version % 2;
    if (ahead == 1 || (ahead == 2 && version + 1 > own)) {
        uint32_t *list = robot->known + entry + FEASIBEE_ROSTER_SENDERS + (ahead - 1) * tolerates;
        if (feasibee_told_enough(list, tolerates, sender))
            feasibee_roster_change(robot, entry, version);
    } else if (ahead != 0) {
        robot->known[entry + FEASIBEE_ROSTER_NEWS] = robot->me.step;
    }
}

/* Store a neighbour's report in a list of states, then of one more than the ids of those that reported them;
 * return the age of the oldest of the latest reports, the largest number if there are too few. */
static inline uint32_t feasibee_roster_oldest(const struct feasibee_robot *robot, uint32_t *list,
                                              uint32_t reports, uint32_t age, feasibee_id sender)
{
    uint32_t place = 0, oldest = 0;
    for (uint32_t k = 0; k < reports; k++) {
        if (list[k + reports] == (uint32_t)sender + 1) {
            place = k;
            break;
        }
        if (feasibee_roster_age(robot, list[k]) > feasibee_roster_age(robot, list[place]))
            place = k;
    }
    if (age < feasibee_roster_age(robot, list[place])) {
        list[place] = feasibee_roster_younger(robot, list[place], age);
        list[place + reports] = (uint32_t)sender + 1;
    }
    for (uint32_t k = 0; k < reports; k++) {
        age = feasibee_roster_age(robot, list[k]);
        oldest = age > oldest ? age : oldest;
    }
    return oldest;
}

/* Adopt the younger age of a robot. */
static inline void feasibee_roster_hear_robot(struct feasibee_robot *robot, const uint32_t *words,
                                              feasibee_id sender)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    uint16_t tolerates = feasibee_tolerated(setting, 3);
    uint32_t age = 2 * words[FEASIBEE_ROSTER_VALUE] + 1;
    uint32_t *known = robot->known + feasibee_roster_robot(setting, words[FEASIBEE_ROSTER_WHAT] - 1);
    if (age < feasibee_roster_age(robot, known[0]) && tolerates > 0)
        age = feasibee_roster_oldest(robot, known + 1, (uint32_t)tolerates + 1, age, sender);
    known[0] = feasibee_roster_younger(robot, known[0], age);
}

/* Store that the sender is there, and take what is newer in its message. */
static inline void feasibee_roster_turns_merge(struct feasibee_robot *robot, const uint32_t *words,
                                               feasibee_id sender)
{
    feasibee_roster_meet(robot, sender);
    if (words[FEASIBEE_ROSTER_WHAT] == 0)
        return;
    if (words[FEASIBEE_ROSTER_KIND] == 0)
        feasibee_roster_hear_task(robot, words, sender);
    else
        feasibee_roster_hear_robot(robot, words, sender);
}

/* Count the robots, those that were seen or heard lately if n is unknown, and the tasks. */
static inline void feasibee_roster_turns_count(struct feasibee_robot *robot, uint32_t *robots,
                                               uint32_t *tasks)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    *robots = *tasks = 0;
    for (uint32_t k = 0; k < setting->robot_ids && !setting->knows_count; k++)
        *robots += robot->known[feasibee_roster_robot(setting, k)] % 2;
    *robots = setting->knows_count ? setting->count : (*robots > 0 ? *robots : 1);
    for (uint32_t k = 0; k < robot->known[FEASIBEE_ROSTER_NUMBER]; k++)
        *tasks += feasibee_roster_is_there(robot, feasibee_roster_entry(setting, k));
}

/* Give up robots that were not there for too long, until there is younger news, and forget them at last. */
static inline void feasibee_roster_expire(struct feasibee_robot *robot)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    uint32_t oldest = 2 * robot->known[FEASIBEE_ROSTER_TIMEOUT] + 2;
    for (uint32_t k = 0; k < setting->robot_ids && !setting->knows_count; k++) {
        uint32_t *state = &robot->known[feasibee_roster_robot(setting, k)];
        uint32_t age = feasibee_roster_age(robot, *state);
        *state += age > oldest && *state % 2 == 1;
        if (age > 2 * FEASIBEE_ROSTER_FORGOTTEN)
            *state = 0;
    }
}

/* Return whether there are enough robots for the tasks, after a look around. */
static inline int8_t feasibee_roster_turns_judge(struct feasibee_robot *robot)
{
    uint32_t robots, tasks;
    if (!robot->disseminating)
        feasibee_roster_look(robot);
    feasibee_roster_expire(robot);
    feasibee_roster_meet(robot, robot->me.id);
    feasibee_roster_turns_count(robot, &robots, &tasks);
    feasibee_roster_set_timeout(robot, robots);
    return robots >= tasks ? FEASIBEE_FEASIBLE : FEASIBEE_INFEASIBLE;
}

static inline bool feasibee_roster_turns_names_sender(const struct feasibee_setting *setting)
{
    return !setting->knows_count || feasibee_tolerated(setting, 3) > 0;
}

/* Return how many bits 0 fill up the message. */
static inline uint8_t feasibee_roster_filling(bool about_robot, const struct feasibee_setting *setting)
{
    uint8_t task = (uint8_t)(feasibee_roster_name_bits(setting) + 2),
            robot = (uint8_t)(setting->id_bits + 12);
    if (setting->knows_count)
        return 0;
    if (about_robot)
        return robot < task ? (uint8_t)(task - robot) : 0;
    return task < robot ? (uint8_t)(robot - task) : 0;
}

static inline void feasibee_roster_turns_pack(struct feasibee_writer *writer, const uint32_t *words,
                                              feasibee_id sender, const struct feasibee_setting *setting)
{
    bool about_robot = words[FEASIBEE_ROSTER_KIND] == 1;
    uint32_t what = words[FEASIBEE_ROSTER_WHAT];
    if (feasibee_roster_turns_names_sender(setting))
        feasibee_write(writer, sender, setting->id_bits);
    if (!setting->knows_count)
        feasibee_write_flag(writer, about_robot);
    if (about_robot)
        feasibee_write(writer, what != 0 ? what - 1 : sender, setting->id_bits); /* itself: none */
    else
        feasibee_write(writer, what, feasibee_roster_name_bits(setting));
    feasibee_write(writer, words[FEASIBEE_ROSTER_VALUE], about_robot ? 12 : 2);
    feasibee_write(writer, 0, feasibee_roster_filling(about_robot, setting));
}

static inline int32_t feasibee_roster_turns_unpack(uint32_t *words, struct feasibee_reader *reader,
                                                   const struct feasibee_setting *setting)
{
    int32_t sender = -1;
    if (feasibee_roster_turns_names_sender(setting))
        sender = (int32_t)feasibee_read_below(reader, setting->robots, setting->id_bits);
    bool about_robot = !setting->knows_count && feasibee_read_flag(reader);
    words[FEASIBEE_ROSTER_KIND] = about_robot;
    if (about_robot) {
        uint32_t robot = feasibee_read_below(reader, setting->robot_ids, setting->id_bits);
        words[FEASIBEE_ROSTER_WHAT] = (int32_t)robot == sender ? 0 : robot + 1;
    } else {
        words[FEASIBEE_ROSTER_WHAT] = feasibee_read(reader, feasibee_roster_name_bits(setting));
    }
    words[FEASIBEE_ROSTER_VALUE] = feasibee_read(reader, about_robot ? 12 : 2);
    feasibee_check(reader, words[FEASIBEE_ROSTER_WHAT] != 0 || words[FEASIBEE_ROSTER_VALUE] == 0);
    feasibee_check(reader, feasibee_read(reader, feasibee_roster_filling(about_robot, setting)) == 0);
    return sender;
}

static const struct feasibee_knowledge feasibee_roster_turns_knowledge = {
    feasibee_roster_turns_start,
    feasibee_roster_turns_observe,
    feasibee_roster_turns_encode,
    feasibee_roster_turns_merge,
    feasibee_roster_turns_count,
    NULL,
    feasibee_roster_turns_judge,
    NULL,
    feasibee_roster_turns_words,
    feasibee_three_words,
    feasibee_roster_turns_pack,
    feasibee_roster_turns_unpack,
    4,
};

static const struct feasibee_strategy feasibee_roster_turns = {
    true,
    false,
    false,
    false,
    feasibee_share_of_robots,
    NULL,
    NULL,
    feasibee_keep_opinion,
    &feasibee_roster_turns_knowledge,
};

#endif

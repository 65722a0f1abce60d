/* What a robot keeps of each task and robot in a roster in turns, and whose turn it is. */

#include "quiet.h"

#if FEASIBEE_WORDS > 0 && defined(FEASIBEE_DOUBLE)

/* Words of what is known; then come the entries of names, and of robots, if listed. */
enum {
    FEASIBEE_ROSTER_NUMBER,     /* number of names */
    FEASIBEE_ROSTER_TICK,       /* messages sent, modulo 4 */
    FEASIBEE_ROSTER_TURNS,      /* whether the next turn is a robot's */
    FEASIBEE_ROSTER_TURN,       /* the name whose turn it was */
    FEASIBEE_ROSTER_ROBOT_TURN, /* the robot whose turn it was */
    FEASIBEE_ROSTER_QUIET,      /* quiet time, in steps */
    FEASIBEE_ROSTER_TIMEOUT,    /* timeout of robots, in steps */
    FEASIBEE_ROSTER_ENTRIES
};

/* Words of a name's entry; then come one more than the ids of neighbours that sent the next versions. */
enum {
    FEASIBEE_ROSTER_NAME,
    FEASIBEE_ROSTER_VERSION, /* one more than that sent; 0: it doesn't count yet */
    FEASIBEE_ROSTER_NEWS,    /* the step when it was news */
    FEASIBEE_ROSTER_VAIN,    /* looks in vain; all ones: it was seen in this step */
    FEASIBEE_ROSTER_SENDERS
};

#define FEASIBEE_ROSTER_NO_ENTRY UINT32_MAX
#define FEASIBEE_ROSTER_PAST (UINT32_C(1) << 20)
#define FEASIBEE_ROSTER_FORGOTTEN (UINT32_C(1) << 30) /* steps: the words of states count modulo 2^31 */

static inline uint8_t feasibee_roster_name_bits(const struct feasibee_setting *setting)
{
    return (uint8_t)feasibee_whole(setting, 0, 2, 30);
}

static inline uint32_t feasibee_roster_entry_words(const struct feasibee_setting *setting)
{
    return FEASIBEE_ROSTER_SENDERS + 2 * (uint32_t)feasibee_tolerated(setting, 3);
}

static inline uint32_t feasibee_roster_robot_words(const struct feasibee_setting *setting)
{
    uint32_t tolerates = feasibee_tolerated(setting, 3);
    return tolerates > 0 ? 1 + 2 * (tolerates + 1) : 1;
}

/* Return the place of a name's entry, by its rank. */
static inline uint32_t feasibee_roster_entry(const struct feasibee_setting *setting, uint32_t rank)
{
    return FEASIBEE_ROSTER_ENTRIES + rank * feasibee_roster_entry_words(setting);
}

/* Return the place of a robot's entry. */
static inline uint32_t feasibee_roster_robot(const struct feasibee_setting *setting, uint32_t robot)
{
    return feasibee_roster_entry(setting, setting->task_ids) + robot * feasibee_roster_robot_words(setting);
}

static inline uint32_t feasibee_roster_turns_words(const struct feasibee_setting *setting)
{
    return feasibee_roster_robot(setting, setting->knows_count ? 0 : setting->robot_ids);
}

static inline uint32_t feasibee_three_words(const struct feasibee_setting *setting)
{
    (void)setting;
    return 3;
}

/* Return the state of a robot that is there in this step; of one given up it is larger by 1. */
static inline uint32_t feasibee_roster_now(const struct feasibee_robot *robot)
{
    return 2 * (robot->me.step + FEASIBEE_ROSTER_PAST) + 1;
}

/* Return twice the age of a state in steps, and 1 if there, 2 if given up; the largest number for none. */
static inline uint32_t feasibee_roster_age(const struct feasibee_robot *robot, uint32_t state)
{
    return state != 0 ? feasibee_roster_now(robot) + 1 - state : UINT32_MAX;
}

/* Return a state, or that of an age if this is younger. */
static inline uint32_t feasibee_roster_younger(const struct feasibee_robot *robot, uint32_t state,
                                               uint32_t age)
{
    return age < feasibee_roster_age(robot, state) ? feasibee_roster_now(robot) + 1 - age : state;
}

/* Store the quiet time and the timeout for so many robots. */
static inline void feasibee_roster_set_timeout(struct feasibee_robot *robot, uint32_t robots)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    const uint32_t longest = UINT32_C(1) << 26;
    uint32_t quiet =
        feasibee_steps_for(feasibee_patience(robots, feasibee_tolerated(setting, 3)), robots, setting);
    robot->known[FEASIBEE_ROSTER_QUIET] = quiet < longest ? quiet : longest;
    robot->known[FEASIBEE_ROSTER_TIMEOUT] = 6 * robot->known[FEASIBEE_ROSTER_QUIET];
    if (setting->parameters[1] > 0.0)
        robot->known[FEASIBEE_ROSTER_TIMEOUT] = feasibee_steps_given(setting->parameters[1]);
}

/* Store that a robot is there, if robots are listed. */
static inline void feasibee_roster_meet(struct feasibee_robot *robot, uint32_t id)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    if (!setting->knows_count)
        robot->known[feasibee_roster_robot(setting, id)] = feasibee_roster_now(robot);
}

static inline void feasibee_roster_turns_start(struct feasibee_robot *robot)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    feasibee_roster_set_timeout(robot, setting->knows_count ? setting->count : 1);
    feasibee_roster_meet(robot, robot->me.id);
}

/* Return the place of a name's entry, a new one if it has none; names are sorted. */
static inline uint32_t feasibee_roster_find(struct feasibee_robot *robot, uint32_t name)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    uint32_t *known = robot->known, low = 0, high = known[FEASIBEE_ROSTER_NUMBER];
    while (low < high) {
        uint32_t middle = (low + high) / 2;
        if (known[feasibee_roster_entry(setting, middle) + FEASIBEE_ROSTER_NAME] < name)
            low = middle + 1;
        else
            high = middle;
    }
    uint32_t entry = feasibee_roster_entry(setting, low), size = feasibee_roster_entry_words(setting);
    uint32_t end = feasibee_roster_entry(setting, known[FEASIBEE_ROSTER_NUMBER]);
    if (entry < end && known[entry + FEASIBEE_ROSTER_NAME] == name)
        return entry;
    if (known[FEASIBEE_ROSTER_NUMBER] >= setting->task_ids)
        return FEASIBEE_ROSTER_NO_ENTRY;
    for (uint32_t k = end; k > entry; k--)
        known[k - 1 + size] = known[k - 1];
    for (uint32_t k = entry; k < entry + size; k++)
        known[k] = 0;
    known[entry + FEASIBEE_ROSTER_NAME] = name;
    known[FEASIBEE_ROSTER_NUMBER]++;
    known[FEASIBEE_ROSTER_TURN] += low <= known[FEASIBEE_ROSTER_TURN];
    return entry;
}

/* Give an entry a version. */
static inline void feasibee_roster_change(struct feasibee_robot *robot, uint32_t entry, uint32_t version)
{
    uint32_t *known = robot->known + entry;
    known[FEASIBEE_ROSTER_VERSION] = version % 4 + 1;
    known[FEASIBEE_ROSTER_NEWS] = robot->me.step;
    for (uint32_t k = FEASIBEE_ROSTER_VAIN; k < feasibee_roster_entry_words(robot->settings->setting); k++)
        known[k] = 0;
}

/* Return whether the task of an entry is there. */
static inline bool feasibee_roster_is_there(const struct feasibee_robot *robot, uint32_t entry)
{
    uint32_t version = robot->known[entry + FEASIBEE_ROSTER_VERSION];
    return version > 0 && version % 2 == 0;
}

/* Return the entry with the latest news, or with the second latest if any; none if nothing is news. */
static inline uint32_t feasibee_roster_latest_news(const struct feasibee_robot *robot, bool second)
{
    const uint32_t *known = robot->known;
    uint32_t latest = FEASIBEE_ROSTER_NO_ENTRY, before = FEASIBEE_ROSTER_NO_ENTRY;
    uint32_t youngest = 2 * known[FEASIBEE_ROSTER_QUIET], second_youngest = youngest;
    for (uint32_t k = 0; k < known[FEASIBEE_ROSTER_NUMBER]; k++) {
        uint32_t entry = feasibee_roster_entry(robot->settings->setting, k);
        uint32_t age = robot->me.step - known[entry + FEASIBEE_ROSTER_NEWS];
        if (known[entry + FEASIBEE_ROSTER_VERSION] == 0 || age > second_youngest)
            continue;
        if (age <= youngest) {
            before = latest;
            latest = entry;
            second_youngest = youngest;
            youngest = age;
        } else {
            before = entry;
            second_youngest = age;
        }
    }
    return second && before != FEASIBEE_ROSTER_NO_ENTRY ? before : latest;
}

/* Return the next entry that counts, or none; tasks that vanished long ago have no turn. */
static inline uint32_t feasibee_roster_next_in_turn(struct feasibee_robot *robot)
{
    uint32_t *known = robot->known, *turn = &known[FEASIBEE_ROSTER_TURN];
    for (uint32_t k = 0; k < known[FEASIBEE_ROSTER_NUMBER]; k++) {
        *turn = *turn + 1 < known[FEASIBEE_ROSTER_NUMBER] ? *turn + 1 : 0;
        uint32_t entry = feasibee_roster_entry(robot->settings->setting, *turn);
        uint32_t age = robot->me.step - known[entry + FEASIBEE_ROSTER_NEWS];
        if (feasibee_roster_is_there(robot, entry))
            return entry;
        if (known[entry + FEASIBEE_ROSTER_VERSION] > 0 && age <= 4 * known[FEASIBEE_ROSTER_QUIET])
            return entry;
    }
    return FEASIBEE_ROSTER_NO_ENTRY;
}

#endif

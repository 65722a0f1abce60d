/* Census: sets of robots and tasks by name, which all robots pass on. */

#include "knowledge.h"
#include "rules.h"

#if FEASIBEE_WORDS > 0

/* Return the number of words of a set of some of so many ids. */
static inline uint32_t feasibee_census_words_of(uint32_t ids)
{
    return (ids + 31) >> 5;
}

static inline uint32_t feasibee_census_words(const struct feasibee_setting *setting)
{
    return feasibee_census_words_of(setting->robot_ids) + feasibee_census_words_of(setting->task_ids);
}

static inline void feasibee_census_add(uint32_t *set, uint32_t id)
{
    set[id >> 5] |= UINT32_C(1) << (id & 31);
}

static inline void feasibee_census_start(struct feasibee_robot *robot)
{
    feasibee_census_add(robot->known, robot->me.id);
}

static inline void feasibee_census_observe(struct feasibee_robot *robot, const struct feasibee_thing *thing)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    uint32_t first = thing->is_robot ? 0 : feasibee_census_words_of(setting->robot_ids);
    if (feasibee_has_id(thing, setting))
        feasibee_census_add(robot->known + first, (uint32_t)thing->id);
}

static inline void feasibee_census_encode(struct feasibee_robot *robot, uint32_t *words)
{
    for (uint32_t k = 0; k < feasibee_census_words(robot->settings->setting); k++)
        words[k] = robot->known[k];
}

static inline void feasibee_census_merge(struct feasibee_robot *robot, const uint32_t *words,
                                         feasibee_id sender)
{
    (void)sender;
    for (uint32_t k = 0; k < feasibee_census_words(robot->settings->setting); k++)
        robot->known[k] |= words[k];
}

static inline void feasibee_census_count(struct feasibee_robot *robot, uint32_t *robots, uint32_t *tasks)
{
    uint32_t first = feasibee_census_words_of(robot->settings->setting->robot_ids);
    *robots = feasibee_members(robot->known, first);
    *tasks =
        feasibee_members(robot->known + first, feasibee_census_words_of(robot->settings->setting->task_ids));
}

static inline void feasibee_census_pack(struct feasibee_writer *writer, const uint32_t *words,
                                        feasibee_id sender, const struct feasibee_setting *setting)
{
    (void)sender;
    feasibee_pack_names(writer, words, 32, setting->robot_ids, setting->id_bits);
    words += feasibee_census_words_of(setting->robot_ids);
    feasibee_pack_names(writer, words, 32, setting->task_ids, 32);
}

static inline int32_t feasibee_census_unpack(uint32_t *words, struct feasibee_reader *reader,
                                             const struct feasibee_setting *setting)
{
    feasibee_unpack_names(reader, words, 32, setting->robot_ids, setting->id_bits);
    words += feasibee_census_words_of(setting->robot_ids);
    feasibee_unpack_names(reader, words, 32, setting->task_ids, 32);
    return -1;
}

static const struct feasibee_knowledge feasibee_census_knowledge = {
    feasibee_census_start,
    feasibee_census_observe,
    feasibee_census_encode,
    feasibee_census_merge,
    feasibee_census_count,
    NULL,
    NULL,
    NULL,
    feasibee_census_words,
    feasibee_census_words,
    feasibee_census_pack,
    feasibee_census_unpack,
    0,
};

static const struct feasibee_strategy feasibee_census = {
    true,
    false,
    false,
    false,
    feasibee_share_of_robots,
    NULL,
    NULL,
    feasibee_at_least,
    &feasibee_census_knowledge,
};

#endif

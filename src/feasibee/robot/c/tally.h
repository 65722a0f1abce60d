/* Tally: totals of each robot's sightings over its life, which all robots pass on. */

#include "knowledge.h"
#include "rules.h"

#if FEASIBEE_WORDS > 0

/* A robot's row has two words: its sightings of robots and of tasks. */
static inline uint32_t feasibee_tally_words(const struct feasibee_setting *setting)
{
    return 2 * (uint32_t)setting->robots;
}

static inline void feasibee_tally_observe(struct feasibee_robot *robot, const struct feasibee_thing *thing)
{
    uint32_t *row = &robot->known[2 * (uint32_t)robot->me.id];
    if (row[0] < FEASIBEE_FULL && row[1] < FEASIBEE_FULL) /* to count one alone would change their ratio */
        row[thing->is_robot ? 0 : 1]++;
}

static inline void feasibee_tally_encode(struct feasibee_robot *robot, uint32_t *words)
{
    for (uint32_t k = 0; k < feasibee_tally_words(robot->settings->setting); k++)
        words[k] = robot->known[k];
}

/* Keep the larger of each total, except in the robot's own row. */
static inline void feasibee_tally_merge(struct feasibee_robot *robot, const uint32_t *words,
                                        feasibee_id sender)
{
    (void)sender;
    for (uint32_t k = 0; k < feasibee_tally_words(robot->settings->setting); k++)
        if (k >> 1 != robot->me.id && words[k] > robot->known[k])
            robot->known[k] = words[k];
}

static inline void feasibee_tally_count(struct feasibee_robot *robot, uint32_t *robots, uint32_t *tasks)
{
    uint64_t totals[2] = {0, 0};
    for (uint32_t k = 0; k < feasibee_tally_words(robot->settings->setting); k++)
        totals[k & 1] += robot->known[k];
    feasibee_write_counts(totals[0], totals[1], robots, tasks);
}

/* Return the width of the largest total in bits. */
static inline uint8_t feasibee_tally_width(const uint32_t *words, const struct feasibee_setting *setting)
{
    uint32_t all = 0;
    for (uint32_t k = 0; k < feasibee_tally_words(setting); k++)
        all |= words[k];
    return feasibee_bit_length(all);
}

static inline void feasibee_tally_pack(struct feasibee_writer *writer, const uint32_t *words,
                                       feasibee_id sender, const struct feasibee_setting *setting)
{
    uint8_t width = feasibee_tally_width(words, setting);
    (void)sender;
    feasibee_write(writer, width, 5);
    for (uint32_t robot = 0; robot < setting->robots; robot++) {
        const uint32_t *row = words + 2 * robot;
        if (row[0] == 0 && row[1] == 0)
            continue;
        feasibee_write_flag(writer, true);
        feasibee_write(writer, robot, setting->id_bits);
        feasibee_write(writer, row[0], width);
        feasibee_write(writer, row[1], width);
    }
    feasibee_write_flag(writer, false);
}

/* Read the rows, in rising order. */
static inline int32_t feasibee_tally_unpack(uint32_t *words, struct feasibee_reader *reader,
                                            const struct feasibee_setting *setting)
{
    uint8_t width = (uint8_t)feasibee_read(reader, 5);
    uint32_t least = 0;
    while (feasibee_read_flag(reader)) {
        uint32_t robot = feasibee_read_below(reader, setting->robots, setting->id_bits);
        uint32_t robots = feasibee_read(reader, width), tasks = feasibee_read(reader, width);
        feasibee_check(reader, robot >= least && (robots | tasks) != 0);
        if (reader->failed)
            return -1;
        words[2 * robot] = robots;
        words[2 * robot + 1] = tasks;
        least = robot + 1;
    }
    feasibee_check(reader, feasibee_tally_width(words, setting) == width);
    return -1;
}

static const struct feasibee_knowledge feasibee_tally_knowledge = {
    NULL,
    feasibee_tally_observe,
    feasibee_tally_encode,
    feasibee_tally_merge,
    feasibee_tally_count,
    NULL,
    NULL,
    NULL,
    feasibee_tally_words,
    feasibee_tally_words,
    feasibee_tally_pack,
    feasibee_tally_unpack,
    0,
};

static const struct feasibee_strategy feasibee_tally = {
    true, false, false, false, feasibee_share_of_robots, NULL, NULL, feasibee_more, &feasibee_tally_knowledge,
};

#endif

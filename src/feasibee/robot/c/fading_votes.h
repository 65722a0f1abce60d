/* Fading votes: robots vote by what they saw lately, in an id and 1 bit, for worlds that change.
 *
 * Parameters: tau, margin, ratio, sees. Needs FEASIBEE_DOUBLE. */

#include "fading.h"

#if FEASIBEE_WORDS > 0 && defined(FEASIBEE_DOUBLE)

enum { FEASIBEE_WEIGHTS = 3 }; /* place in the memory of the weight against feasible, and then for it */

/* Words of what is known: number of robots heard; then for each robot its vote, and the step when it came. */
static inline uint32_t feasibee_fading_votes_words(const struct feasibee_setting *setting)
{
    return 1 + 2 * (uint32_t)setting->robots;
}

static inline void feasibee_fading_votes_start(struct feasibee_robot *robot)
{
    robot->memory.numbers[FEASIBEE_FADE] = 1.0 - 1.0 / feasibee_fading_tau(robot->settings->setting);
}

/* Count a task in sight, or, for the ratio, a robot. */
static inline void feasibee_fading_votes_observe(struct feasibee_robot *robot,
                                                 const struct feasibee_thing *thing)
{
    bool is_other = thing->id != (int32_t)robot->me.id;
    if (!thing->is_robot)
        robot->memory.numbers[FEASIBEE_TASKS] += 1.0;
    else if (is_other && feasibee_fading_by_ratio(robot->settings->setting))
        robot->memory.numbers[FEASIBEE_LOOKS] += 1.0;
}

/* Return the robot's own vote. */
static inline uint32_t feasibee_fading_votes_own(const struct feasibee_robot *robot)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    double tasks = robot->memory.numbers[FEASIBEE_TASKS] + 0.5, looks = robot->memory.numbers[FEASIBEE_LOOKS];
    double robots = (double)feasibee_fading_robots(robot);
    if (feasibee_fading_by_ratio(setting))
        return tasks * (robots - 1.0) <= (robots + 0.5) * looks;
    return tasks <= (robots + 0.5) * feasibee_share_in_sight(setting) * looks;
}

static inline void feasibee_fading_votes_encode(struct feasibee_robot *robot, uint32_t *words)
{
    words[0] = feasibee_fading_votes_own(robot);
}

/* Subtract what is left of the vote of an id. */
static inline void feasibee_fading_votes_drop(struct feasibee_robot *robot, uint32_t place)
{
    uint32_t came = robot->known[place + 1];
    double *memory = robot->memory.numbers;
    if (came == 0)
        return;
    memory[FEASIBEE_WEIGHTS + robot->known[place]] -=
        feasibee_power(memory[FEASIBEE_FADE], feasibee_stamp_of(robot->me.step) - came);
    robot->known[place + 1] = 0;
    robot->known[0]--;
}

/* Replace the vote of an id, and what is left of it. */
static inline void feasibee_fading_votes_merge(struct feasibee_robot *robot, const uint32_t *words,
                                               feasibee_id sender)
{
    uint32_t place = 1 + 2 * (uint32_t)sender, vote = words[0] & 1;
    feasibee_fading_votes_drop(robot, place);
    robot->memory.numbers[FEASIBEE_WEIGHTS + vote] += 1.0;
    robot->known[place] = vote;
    robot->known[place + 1] = feasibee_stamp_of(robot->me.step);
    robot->known[0]++;
}

/* Return what the votes say, and let all counts and votes fade. */
static inline int8_t feasibee_fading_votes_judge(struct feasibee_robot *robot)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    double *memory = robot->memory.numbers;
    uint32_t place = 1 + 2 * (robot->me.step % setting->robots);
    if (!robot->disseminating && !feasibee_fading_by_ratio(setting))
        memory[FEASIBEE_LOOKS] += 1.0;
    if (!setting->knows_count && feasibee_fading_is_old(robot, robot->known[place + 1]))
        feasibee_fading_votes_drop(robot, place);
    double lead = memory[FEASIBEE_WEIGHTS + 1] - memory[FEASIBEE_WEIGHTS];
    lead += feasibee_fading_votes_own(robot) ? 1.0 : -1.0;
    for (uint8_t k = FEASIBEE_LOOKS; k <= FEASIBEE_WEIGHTS + 1; k++)
        memory[k] *= memory[FEASIBEE_FADE];
    if (lead == 0.0)
        return FEASIBEE_NONE;
    return lead > 0.0 ? FEASIBEE_FEASIBLE : FEASIBEE_INFEASIBLE;
}

/* Write the weights of the votes for and against feasible, the robot's own included. */
static inline void feasibee_fading_votes_count(struct feasibee_robot *robot, uint32_t *robots,
                                               uint32_t *tasks)
{
    const double *weights = robot->memory.numbers + FEASIBEE_WEIGHTS;
    uint32_t own = feasibee_fading_votes_own(robot);
    *tasks = (uint32_t)(65536.0 * ((weights[0] > 0.0 ? weights[0] : 0.0) + (own ? 0.0 : 1.0)));
    *robots = (uint32_t)(65536.0 * ((weights[1] > 0.0 ? weights[1] : 0.0) + (own ? 1.0 : 0.0)));
}

static inline void feasibee_fading_votes_pack(struct feasibee_writer *writer, const uint32_t *words,
                                              feasibee_id sender, const struct feasibee_setting *setting)
{
    feasibee_pack_word(writer, words, sender, setting, 1);
}

static inline int32_t feasibee_fading_votes_unpack(uint32_t *words, struct feasibee_reader *reader,
                                                   const struct feasibee_setting *setting)
{
    return feasibee_unpack_word(words, reader, setting, 1);
}

static const struct feasibee_knowledge feasibee_fading_votes_knowledge = {
    feasibee_fading_votes_start,
    feasibee_fading_votes_observe,
    feasibee_fading_votes_encode,
    feasibee_fading_votes_merge,
    feasibee_fading_votes_count,
    NULL,
    feasibee_fading_votes_judge,
    NULL,
    feasibee_fading_votes_words,
    feasibee_one_word,
    feasibee_fading_votes_pack,
    feasibee_fading_votes_unpack,
    4,
};

static const struct feasibee_strategy feasibee_fading_votes = {
    true,
    false,
    false,
    false,
    feasibee_share_of_robots,
    NULL,
    NULL,
    feasibee_keep_opinion,
    &feasibee_fading_votes_knowledge,
};

#endif

/* The functions of the controller, which controller.h describes. */

#include "inbox.h"
#include "knowledge.h"
#include "numbers.h"
#include "words.h"

static inline struct feasibee_settings feasibee_defaults(const struct feasibee_strategy *strategy)
{
    struct feasibee_settings settings;
    settings.strategy = strategy;
    settings.exploration = 10 * FEASIBEE_STEP;
    settings.gain = 10 * FEASIBEE_STEP;
    settings.dissemination_floor = 0;
    settings.quality_floor = 0;
    settings.listens_for = FEASIBEE_ALWAYS;
    settings.inbox_size = FEASIBEE_INBOX;
    settings.own_vote = true;
    settings.random_ties = false;
    settings.every_message = false;
    settings.first_sight = false;
    settings.stubborn = false;
    settings.declare.rounds = 0;
    settings.declare.heard = 3;
    settings.declare.quorum = 9;
    settings.declare.quorum_of = 10;
    settings.draw_duration = NULL;
    settings.draw_choice = NULL;
    settings.task_of = NULL;
    settings.setting = NULL;
    return settings;
}

static inline void feasibee_forget(struct feasibee_robot *robot)
{
    robot->robots_seen = robot->tasks_seen = 0;
#ifdef FEASIBEE_CLASSES
    for (int k = 0; k < 2 * FEASIBEE_CLASSES; k++)
        robot->seen[k] = 0;
#endif
}

/* Begin exploring: empty the inbox; reset the counts if the strategy forgets (model.md 4.2, 4.6). */
static inline void feasibee_explore(struct feasibee_robot *robot)
{
    struct feasibee_mean mean = {robot->settings->exploration, {1, 1}, false};
    robot->disseminating = false;
    if (robot->settings->strategy->forgets)
        feasibee_forget(robot);
    robot->heard = robot->heard_feasible = robot->heard_infeasible = 0;
    robot->phase_left = robot->settings->draw_duration(robot->me.context, &mean);
}

#if FEASIBEE_WORDS > 0

static inline struct feasibee_row feasibee_known(struct feasibee_robot *robot)
{
    struct feasibee_row row = {robot->known, (int16_t)robot->words};
    return row;
}

static inline struct feasibee_row feasibee_words_of(struct feasibee_robot *robot, const int32_t *words)
{
    struct feasibee_row row = {(int32_t *)(uintptr_t)words, (int16_t)robot->message_words};
    return row;
}

/* Count by what is known. Whole numbers are halved together until they fit: only their ratio matters. */
static inline void feasibee_count_known(struct feasibee_robot *robot, feasibee_amount *robots,
                                        feasibee_amount *tasks)
{
    int64_t found[2] = {0, 0};
    struct feasibee_counts counts = {found, 2};
    robot->settings->strategy->knowledge->count(feasibee_known(robot), counts, robot);
#ifndef FEASIBEE_DOUBLE
    for (; (found[0] | found[1]) >> 31; found[0] >>= 1)
        found[1] >>= 1;
#endif
    *robots = (feasibee_amount)found[0];
    *tasks = (feasibee_amount)found[1];
}

#endif

#ifdef FEASIBEE_CLASSES

/* Count robots and then tasks of each class by what is known; return whether the strategy does. */
static inline bool feasibee_count_classes(struct feasibee_robot *robot, int64_t *found)
{
#if FEASIBEE_WORDS > 0
    const struct feasibee_setting *setting = robot->settings->setting;
    struct feasibee_counts counts = {found, (int16_t)(setting->robot_classes + setting->task_classes)};
    if (robot->settings->strategy->knowledge == NULL)
        return false;
    robot->settings->strategy->knowledge->count(feasibee_known(robot), counts, robot);
    return true;
#else
    (void)robot, (void)found;
    return false;
#endif
}

/* Return what robots or tasks of all classes add to a side of a set of skills. */
static inline double feasibee_side(const uint16_t *weights, const int64_t *found, int classes)
{
    double side = 0.0;
    for (int k = 0; k < classes; k++)
        side += (double)(weights[k] * found[k]);
    return side;
}

/* Rate feasible by the least quality of all sets of skills of which something was seen (model.md 6.7). */
static inline void feasibee_rate(struct feasibee_robot *robot)
{
    const struct feasibee_settings *settings = robot->settings;
    int robots = settings->setting->robot_classes, tasks = settings->setting->task_classes;
    int64_t found[2 * FEASIBEE_CLASSES] = {0};
    double floor = settings->quality_floor;
    bool rated = false;
    if (!feasibee_count_classes(robot, found))
        for (int k = 0; k < robots + tasks; k++)
            found[k] = robot->seen[k < robots ? k : FEASIBEE_CLASSES + k - robots];
    robot->feasible_quality = settings->strategy->quality(floor, floor);
    for (uint16_t k = 0; k < settings->set_count; k++) {
        double one = feasibee_side(settings->sets[k].robots, found, robots);
        double other = feasibee_side(settings->sets[k].tasks, found + robots, tasks);
        struct feasibee_ratio quality =
            settings->strategy->quality(one < floor ? floor : one, other < floor ? floor : other);
        if (one + other > 0.0 && (!rated || feasibee_double(quality) < feasibee_double(robot->feasible_quality))) {
            robot->feasible_quality = quality;
            rated = true;
        }
    }
}

#else

/* Rate feasible by the counts (model.md 4.3). */
static inline void feasibee_rate(struct feasibee_robot *robot)
{
    feasibee_amount robots = (feasibee_amount)robot->robots_seen;
    feasibee_amount tasks = (feasibee_amount)robot->tasks_seen;
    uint16_t floor = robot->settings->quality_floor;
#if FEASIBEE_WORDS > 0
    if (robot->settings->strategy->knowledge)
        feasibee_count_known(robot, &robots, &tasks);
#endif
    robot->feasible_quality = robot->settings->strategy->quality(robots < floor ? floor : robots,
                                                                 tasks < floor ? floor : tasks);
}

#endif

/* Return the mean duration of dissemination; 1/2 is the quality of no opinion. */
static inline struct feasibee_mean feasibee_dissemination(const struct feasibee_robot *robot)
{
    struct feasibee_mean mean = {robot->settings->gain, {1, 1}, false};
    if (!robot->settings->strategy->modulates)
        return mean;
    mean.share = robot->feasible_quality;
    mean.complement = robot->opinion == FEASIBEE_INFEASIBLE;
    if (robot->opinion == FEASIBEE_NONE) {
        mean.share.part = 1;
        mean.share.whole = 2;
    }
    return mean;
}

static inline bool feasibee_keeps_opinion(const struct feasibee_robot *robot)
{
    return robot->settings->stubborn || robot->declared != FEASIBEE_NONE;
}

/* Adopt what the robot's own counts favour; keep its opinion with a tie (model.md 6.10). */
static inline void feasibee_adopt_first_sight(struct feasibee_robot *robot)
{
    feasibee_amount feasible = robot->feasible_quality.part;
    feasibee_amount infeasible = robot->feasible_quality.whole - feasible;
    if (feasible != infeasible)
        robot->opinion = feasible > infeasible;
}

/* Begin disseminating, for a time drawn by the quality of the opinion (model.md 4.3, 4.4). */
static inline void feasibee_disseminate(struct feasibee_robot *robot)
{
    const struct feasibee_strategy *strategy = robot->settings->strategy;
    feasibee_rate(robot);
    if (robot->settings->first_sight && !robot->explored && !feasibee_keeps_opinion(robot))
        feasibee_adopt_first_sight(robot);
    robot->disseminating = robot->explored = true;
    robot->said = strategy->say ? strategy->say(robot) : robot->opinion;
#if FEASIBEE_VALUES
    if (strategy->value_bits > 0)
        robot->value = strategy->value ? strategy->value(robot)
                                       : feasibee_value_of(robot->feasible_quality, strategy->value_bits);
#endif
    struct feasibee_mean mean = feasibee_dissemination(robot);
    if (strategy->lasting)
        mean.steps = strategy->lasting(robot);
    robot->phase_left = robot->settings->draw_duration(robot->me.context, &mean);
    robot->phase_left += robot->settings->dissemination_floor;
}

/* Declare if enough successive inboxes agreed with the robot's opinion (model.md 6.14). */
static inline void feasibee_declare_by_votes(struct feasibee_robot *robot,
                                             const struct feasibee_votes *votes)
{
    const struct feasibee_declare *rule = &robot->settings->declare;
    uint16_t agreeing = robot->opinion == FEASIBEE_FEASIBLE ? votes->feasible : votes->infeasible;
    uint16_t all = (uint16_t)(votes->feasible + votes->infeasible);
    bool agrees = robot->opinion != FEASIBEE_NONE && all >= rule->heard &&
                  (uint32_t)agreeing * rule->quorum_of >= (uint32_t)rule->quorum * all;
    if (!agrees)
        robot->agreed = 0;
    else if (robot->agreed < rule->rounds)
        robot->agreed++;
    if (robot->declared == FEASIBEE_NONE && robot->agreed >= rule->rounds)
        robot->declared = robot->opinion;
}

/* Decide by the inbox or the knowledge (model.md 4.6). */
static inline void feasibee_decide(struct feasibee_robot *robot)
{
    const struct feasibee_settings *settings = robot->settings;
    if (settings->strategy->knowledge)
        feasibee_rate(robot);
    struct feasibee_votes votes = feasibee_votes_of(robot, settings->draw_choice(robot->me.context));
    int8_t decided = settings->strategy->decide(robot, &votes);
    if (!feasibee_keeps_opinion(robot))
        robot->opinion = decided;
    if (settings->declare.rounds > 0)
        feasibee_declare_by_votes(robot, &votes);
}

#if FEASIBEE_WORDS > 0

/* Declare, or adopt the opinion that follows from what is known (model.md 6.11, 6.15). */
static inline void feasibee_follow(struct feasibee_robot *robot)
{
    const struct feasibee_knowledge *knowledge = robot->settings->strategy->knowledge;
    bool keeps_opinion = feasibee_keeps_opinion(robot);
    struct feasibee_row known = feasibee_known(robot);
    int8_t opinion = knowledge->judge ? (int8_t)knowledge->judge(known, robot) : (int8_t)FEASIBEE_NONE;
    if (knowledge->declare && robot->declared == FEASIBEE_NONE)
        opinion = robot->declared = (int8_t)knowledge->declare(known, robot);
    if (opinion != FEASIBEE_NONE && !keeps_opinion)
        robot->opinion = opinion;
}

#endif

static inline void feasibee_begin(struct feasibee_robot *robot, const struct feasibee_settings *settings,
                                  const struct feasibee_me *me, int8_t opinion)
{
    uint8_t *bytes = (uint8_t *)robot;
    for (size_t place = 0; place < sizeof *robot; place++)
        bytes[place] = 0;
    robot->settings = settings;
    robot->me = *me;
#ifdef FEASIBEE_DOUBLE
    robot->x = me->x;
    robot->y = me->y;
#endif
    robot->opinion = settings->strategy->starts_neutral ? (int8_t)FEASIBEE_NONE : opinion;
    robot->declared = FEASIBEE_NONE;
    robot->feasible_quality.part = 1;
    robot->feasible_quality.whole = 2;
#if FEASIBEE_WORDS > 0
    const struct feasibee_knowledge *knowledge = settings->strategy->knowledge;
    if (knowledge) {
        robot->words = (uint16_t)knowledge->words(settings->setting);
        robot->message_words = feasibee_message_words(knowledge, settings->setting);
        if (knowledge->start)
            knowledge->start(feasibee_known(robot), robot);
    }
#endif
    feasibee_explore(robot);
}

static inline void feasibee_observe(struct feasibee_robot *robot, uint16_t robots, uint16_t tasks)
{
    if (!robot->disseminating) {
        robot->robots_seen += robots;
        robot->tasks_seen += tasks;
    }
}

#ifdef FEASIBEE_CLASSES

static inline void feasibee_observe_one(struct feasibee_robot *robot, bool is_robot, uint8_t kind)
{
    if (!robot->disseminating)
        robot->seen[(is_robot ? 0 : FEASIBEE_CLASSES) + kind]++;
}

#endif

static inline void feasibee_recognise(struct feasibee_robot *robot, const struct feasibee_thing *thing)
{
#if FEASIBEE_WORDS > 0
    const struct feasibee_knowledge *knowledge = robot->settings->strategy->knowledge;
    if (!knowledge || robot->disseminating)
        return;
    struct feasibee_thing seen = *thing;
    if (!feasibee_has_id(thing, robot->settings->setting)) {
        if (knowledge->by_name)
            return;
        seen.id = -1;
    }
    knowledge->observe(feasibee_known(robot), &seen, robot);
#else
    (void)robot, (void)thing;
#endif
}

static inline bool feasibee_listens(const struct feasibee_robot *robot)
{
    int32_t last = robot->settings->listens_for;
    if (last == FEASIBEE_ALWAYS)
        return true;
    return robot->disseminating && (last == FEASIBEE_DISSEMINATION || (uint32_t)last >= robot->phase_left);
}

static inline void feasibee_hear(struct feasibee_robot *robot, feasibee_id sender,
                                 const struct feasibee_message *message)
{
#if FEASIBEE_WORDS > 0
    if (robot->settings->strategy->knowledge)
        robot->settings->strategy->knowledge->merge(
            feasibee_known(robot), feasibee_words_of(robot, message->words), (feasibee_int)sender, robot);
    if (message->opinion == FEASIBEE_NONE) /* knowledge by wire: it has no opinion */
        return;
#endif
    if (robot->settings->every_message)
        feasibee_count(robot, message->opinion);
    else
        feasibee_keep(robot, sender, message);
}

#if FEASIBEE_WORDS > 0

/* Write the words of a message: by default all that is known. */
static inline void feasibee_compose(struct feasibee_robot *robot, struct feasibee_message *message)
{
    const struct feasibee_knowledge *knowledge = robot->settings->strategy->knowledge;
    for (uint16_t k = 0; k < robot->message_words; k++)
        message->words[k] = knowledge->encode ? 0 : robot->known[k];
    if (knowledge->encode)
        knowledge->encode(feasibee_words_of(robot, message->words), feasibee_known(robot), robot);
}

#endif

static inline bool feasibee_message(struct feasibee_robot *robot, struct feasibee_message *message)
{
    if (!robot->disseminating || robot->said == FEASIBEE_NONE)
        return false;
    message->opinion = robot->said;
    message->value = robot->value;
    message->declared = robot->settings->declare.rounds > 0 && robot->declared != FEASIBEE_NONE;
#if FEASIBEE_WORDS > 0
    if (robot->settings->strategy->knowledge)
        feasibee_compose(robot, message);
#endif
    return true;
}

static inline void feasibee_end_step(struct feasibee_robot *robot)
{
#if FEASIBEE_WORDS > 0
    if (robot->settings->strategy->knowledge)
        feasibee_follow(robot);
#endif
    robot->phase_left--;
    if (robot->phase_left == 0) {
        if (robot->disseminating) {
            feasibee_decide(robot);
            feasibee_explore(robot);
        } else {
            feasibee_disseminate(robot);
        }
    }
    robot->me.step++;
}

/* Functions of knowledge whose limits no run of a test reaches; test_knowledge_numbers.py calls them. */

#define FEASIBEE_WORDS 400
#include "feasibee.h"

static const struct feasibee_strategy *const strategies[] = {
    &feasibee_tally, &feasibee_estimate, &feasibee_census, &feasibee_quiet_census};
static struct feasibee_robot robot;

static uint32_t draw_duration(void *context, const struct feasibee_mean *mean)
{
    (void)context, (void)mean;
    return 1;
}

static struct feasibee_choice draw_choice(void *context)
{
    struct feasibee_choice choice = {0, 0};
    (void)context;
    return choice;
}

static void begin(int number, double parameter)
{
    static struct feasibee_setting setting;
    static struct feasibee_settings settings;
    struct feasibee_me me = {0};
    setting.robots = setting.robot_ids = 20;
    setting.tasks = setting.task_ids = 40;
    setting.id_bits = 5;
    setting.robot_classes = setting.task_classes = 1;
#ifdef FEASIBEE_DOUBLE
    setting.width = setting.height = setting.sight = setting.radio = 20.0;
    setting.speed = setting.exploration = 20.0;
#endif
    setting.parameters[0] = FEASIBEE_REAL(parameter);
    settings = feasibee_defaults(strategies[number]);
    settings.setting = &setting;
    settings.draw_duration = draw_duration;
    settings.draw_choice = draw_choice;
    feasibee_begin(&robot, &settings, &me, 1);
}

void seen(int number, uint32_t robots, uint32_t tasks, bool is_robot, double *counts)
{
    struct feasibee_thing thing = {0};
    feasibee_amount found[2];
    begin(number, 0.0);
    robot.known[0] = (int32_t)robots;
    robot.known[1] = (int32_t)tasks;
    thing.is_robot = is_robot;
    feasibee_recognise(&robot, &thing);
    counts[0] = robot.known[0];
    counts[1] = robot.known[1];
    feasibee_count_known(&robot, &found[0], &found[1]);
    counts[2] = (double)found[0];
    counts[3] = (double)found[1];
}

uint32_t changed(int number, bool is_robot, int32_t id) /* words that seeing a thing changes */
{
    static struct feasibee_robot before;
    struct feasibee_thing thing = {0};
    uint32_t found = 0;
    begin(number, 20.0);
    before = robot;
    thing.is_robot = is_robot;
    thing.id = id;
    feasibee_recognise(&robot, &thing);
    for (uint32_t k = 0; k < FEASIBEE_WORDS; k++)
        found += robot.known[k] != before.known[k];
    return found;
}

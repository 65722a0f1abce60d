/* Functions of knowledge whose limits no run of a test reaches; test_knowledge_numbers.py calls them. */

#define FEASIBEE_WORDS 400
#include "feasibee.h"

static const struct feasibee_strategy *const strategies[] = {
    &feasibee_tally, &feasibee_estimate, &feasibee_totals, &feasibee_census, &feasibee_quiet_census,
    &feasibee_roster_turns, &feasibee_average};
enum { TOTALS = 2, AVERAGE = 6 };
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
    struct feasibee_me me = {NULL, 0, 0, 0};
    setting.robots = setting.robot_ids = 20;
    setting.tasks = setting.task_ids = 40;
    setting.id_bits = 5;
    setting.width = setting.height = setting.sight = setting.radio = 20.0;
    setting.speed = setting.exploration = 20.0;
    setting.parameters[0] = parameter;
    settings = feasibee_defaults(strategies[number]);
    settings.setting = &setting;
    settings.draw_duration = draw_duration;
    settings.draw_choice = draw_choice;
    feasibee_begin(&robot, &settings, &me, 1);
}

uint32_t row_of(uint32_t robots, uint32_t tasks)
{
    return feasibee_totals_row_of(robots, tasks);
}

void write_counts(uint64_t robots_found, uint64_t tasks_found, uint32_t *counts)
{
    feasibee_write_counts(robots_found, tasks_found, &counts[0], &counts[1]);
}

void seen(int number, uint32_t robots, uint32_t tasks, bool is_robot, uint32_t *counts)
{
    struct feasibee_thing thing = {0};
    begin(number, 0.0);
    robot.known[0] = robots;
    robot.known[1] = tasks;
    thing.is_robot = is_robot;
    feasibee_recognise(&robot, &thing);
    counts[0] = robot.known[0];
    counts[1] = robot.known[1];
    strategies[number]->knowledge->count(&robot, &counts[2], &counts[3]);
}

double kept(uint32_t robots, uint32_t tasks) /* quality after one more exploration of a life */
{
    begin(AVERAGE, 0.0);
    feasibee_end_step(&robot);
    robot.robots_seen = robots;
    robot.tasks_seen = tasks;
    feasibee_end_step(&robot);
    feasibee_observe(&robot, UINT16_MAX, UINT16_MAX);
    feasibee_end_step(&robot);
    return feasibee_double(robot.feasible_quality);
}

uint32_t changed(int number, bool is_robot, int32_t id) /* words that seeing a thing changes */
{
    static struct feasibee_robot before;
    struct feasibee_thing thing = {0};
    uint32_t found = 0;
    begin(number, number == TOTALS ? 1.0 : 20.0);
    before = robot;
    thing.is_robot = is_robot;
    thing.id = id;
    feasibee_recognise(&robot, &thing);
    for (uint32_t k = 0; k < FEASIBEE_WORDS; k++)
        found += robot.known[k] != before.known[k];
    return found;
}

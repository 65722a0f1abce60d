/* What swarm.c and frames.c share: settings and draws, read from standard input. */

#define FEASIBEE_WORDS 8192
#include "feasibee.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FRAME = 8192 };

static const struct feasibee_strategy *const strategies[] = {STRATEGIES};
static const char *const names[] = {NAMES};
static struct feasibee_settings settings;
static struct feasibee_setting setting;
static struct feasibee_wire wire;
static uint32_t memory;
static uint32_t names_of_tasks[UINT16_MAX];
static uint16_t named;

static void take(void *place, size_t size)
{
    if (fread(place, 1, size, stdin) != size)
        exit(3);
}

static void give(const void *place, size_t size)
{
    if (fwrite(place, 1, size, stdout) != size)
        exit(4);
}

static uint32_t word(void *context)
{
    uint32_t *state = context;
    *state ^= *state << 13;
    *state ^= *state >> 17;
    *state ^= *state << 5;
    return *state;
}

static uint32_t duration(void *context, const struct feasibee_mean *mean)
{
#ifdef FEASIBEE_DOUBLE
    return feasibee_exponential(mean, word(context));
#else
    (void)mean; /* as swarms.py does with whole numbers */
    return 1 + word(context) % 16;
#endif
}

static struct feasibee_choice choice(void *context)
{
    struct feasibee_choice drawn;
    drawn.chance = word(context);
    drawn.message = word(context);
    return drawn;
}

static uint8_t read_byte(void)
{
    uint8_t number;
    take(&number, 1);
    return number;
}

static uint16_t read_short(void)
{
    uint16_t number;
    take(&number, 2);
    return number;
}

static int32_t task_of(uint32_t name)
{
    for (int32_t task = named; task > 0; task--)
        if (names_of_tasks[task - 1] == name)
            return task - 1;
    return -1;
}

static uint8_t read_setting(void)
{
    uint8_t strategy = read_byte();
    setting.robots = (int16_t)read_short();
    setting.count = (int16_t)read_short();
    setting.tasks = (int16_t)read_short();
    setting.robot_ids = (int16_t)read_short();
    setting.task_ids = (int16_t)read_short();
    setting.robot_classes = read_byte();
    setting.task_classes = read_byte();
    setting.colluding = read_byte();
    setting.id_bits = read_byte();
    setting.knows_count = read_byte();
    bool walled = read_byte();
    double numbers[17];
    static uint8_t cells[64];
    take(numbers, sizeof numbers);
#ifdef FEASIBEE_DOUBLE
    setting.walled = walled;
    setting.width = numbers[0];
    setting.height = numbers[1];
    setting.sight = numbers[2];
    setting.radio = numbers[3];
    setting.speed = numbers[4];
    setting.exploration = numbers[5];
    setting.dissemination = numbers[6];
    setting.mean_run = numbers[7];
    setting.flooding = numbers[8];
    setting.delay = numbers[9];
    setting.work = numbers[10];
    setting.charge = numbers[11];
    setting.columns = read_byte();
    setting.plan = (struct feasibee_plan){cells, read_byte()};
    take(cells, (size_t)setting.plan.length);
#else
    (void)walled;
    (void)read_byte();
    take(cells, read_byte());
#endif
    for (uint8_t k = 0; k < 5; k++)
        setting.parameters[k] = FEASIBEE_REAL(numbers[12 + k]);
    settings = feasibee_defaults(strategies[strategy]);
    settings.exploration = (feasibee_steps)(numbers[5] * FEASIBEE_STEP);
    settings.gain = (feasibee_steps)(numbers[6] * FEASIBEE_STEP);
    settings.declare.rounds = read_byte();
    settings.draw_duration = duration;
    settings.draw_choice = choice;
    settings.setting = &setting;
#ifdef FEASIBEE_CLASSES
    static struct feasibee_set all; /* of the same skill */
    for (int k = 0; k < FEASIBEE_CLASSES; k++)
        all.robots[k] = all.tasks[k] = 1;
    settings.sets = &all;
    settings.set_count = 1;
#endif
    memory = read_byte();
    named = read_short();
    take(names_of_tasks, named * sizeof names_of_tasks[0]);
    settings.task_of = named > 0 ? task_of : NULL;
    wire = feasibee_wire_of(&settings, names[strategy], setting.id_bits);
    return strategy;
}

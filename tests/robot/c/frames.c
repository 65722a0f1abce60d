/* Three controllers that hear each other's frames: prints after each step what they hold.
 *
 * frames.py has the same in Python, and makes swarm.h: the strategy, its name and its setting.
 */

#include "feasibee.h"

#include "board.h"
#include "swarm.h"

enum { ROBOTS = 3 };

static uint32_t state = 17;
static struct feasibee_settings settings;
static struct feasibee_wire wire;
static struct feasibee_robot robots[ROBOTS];
static uint8_t frames[ROBOTS][FRAME];
static uint8_t lengths[ROBOTS];
static struct feasibee_message message; /* one for all: knowledge may fill the RAM */

static uint32_t random_word(void)
{
    state ^= state << 13;
    state ^= state >> 17;
    state ^= state << 5;
    return state;
}

static uint32_t draw_duration(void *context, const struct feasibee_mean *mean)
{
    (void)context, (void)mean;
    return 1 + (random_word() & 7);
}

static struct feasibee_choice draw_choice(void *context)
{
    struct feasibee_choice choice;
    (void)context;
    choice.chance = random_word();
    choice.message = random_word();
    return choice;
}

#ifdef NAMES

static int32_t task_of(uint32_t name)
{
    static const uint32_t names[] = {NAMES};
    for (uint8_t task = 0; task < sizeof names / sizeof names[0]; task++)
        if (names[task] == name)
            return task;
    return -1;
}

#endif

static void recognise(struct feasibee_robot *robot)
{
#ifdef FEASIBEE_DOUBLE
    uint32_t place = random_word();
    robot->x = (place & 255) / 16.0;
    robot->y = (place >> 8 & 255) / 16.0;
#endif
    for (uint8_t left = random_word() & 3; left > 0; left--) {
        struct feasibee_thing thing = {0};
        uint32_t word = random_word();
        thing.is_robot = word & 1;
        thing.id = (word >> 1) % (thing.is_robot ? setting.robots : setting.tasks);
        thing.hash = ((uint32_t)thing.id * 2 + thing.is_robot + 1) * UINT32_C(2654435761);
#ifdef FEASIBEE_DOUBLE
        thing.x = (thing.hash & 255) / 16.0;
        thing.y = (thing.hash >> 8 & 255) / 16.0;
#endif
        feasibee_recognise(robot, &thing);
        feasibee_observe(robot, thing.is_robot, !thing.is_robot);
    }
}

static void hear(uint8_t own)
{
    uint32_t word = random_word();
    feasibee_id sender;
    for (uint8_t other = 0; other < ROBOTS; other++)
        if (other != own && (word >> other & 1) && lengths[other] > 0) {
            bool right = feasibee_decode(&wire, frames[other], lengths[other], &sender, &message);
            if (!right)
                print_line("no frame");
            else if (feasibee_listens(&robots[own]))
                feasibee_hear(&robots[own], sender, &message);
        }
}

static void speak(uint8_t own)
{
    lengths[own] = 0;
    if (feasibee_message(&robots[own], &message))
        lengths[own] = (uint8_t)feasibee_encode(&wire, robots[own].me.id, &message, frames[own], FRAME);
}

static char *hex(char *to, uint32_t number, uint8_t digits)
{
    while (digits > 0)
        *to++ = "0123456789abcdef"[number >> (4 * --digits) & 15];
    return to;
}

static void print_robot(uint8_t number)
{
    const struct feasibee_robot *robot = &robots[number];
    char line[32];
    char *end = hex(line, (robot->opinion + 1) | (robot->declared + 1) << 2, 1);
    end = hex(end, robot->disseminating | (robot->declared != FEASIBEE_NONE) << 1, 1);
    end = hex(end, robot->phase_left, 2);
    end = hex(end, feasibee_crc(frames[number], lengths[number]), 8);
#if FEASIBEE_WORDS > 0
    end = hex(end, feasibee_crc((const uint8_t *)robot->known, sizeof robot->known), 8);
#endif
    *end = '\0';
    print_line(line);
}

int main(void)
{
    settings = feasibee_defaults(&STRATEGY);
    settings.setting = &setting;
    settings.draw_duration = draw_duration;
    settings.draw_choice = draw_choice;
#ifdef NAMES
    settings.task_of = task_of;
#endif
    wire = feasibee_wire_of(&settings, NAME, setting.id_bits);
    for (uint8_t number = 0; number < ROBOTS; number++) {
        struct feasibee_me me = {0};
        me.id = number;
        me.hash = random_word();
        feasibee_begin(&robots[number], &settings, &me, number & 1);
    }
    for (uint16_t left = STEPS; left > 0; left--) {
        for (uint8_t number = 0; number < ROBOTS; number++)
            speak(number);
        for (uint8_t number = 0; number < ROBOTS; number++) {
            recognise(&robots[number]);
            hear(number);
        }
        for (uint8_t number = 0; number < ROBOTS; number++) {
            feasibee_end_step(&robots[number]);
            print_robot(number);
        }
    }
    char line[8];
    *hex(line, stack_used(), 4) = '\0';
    print_line(line);
    stop();
    return 0;
}

/* The least program that uses the whole controller; with NOTHING, one that does nothing.
 *
 * With FRAMES, messages come and go as bytes in the radio's memory. With KNOWLEDGE, they hold knowledge. With
 * SETTING, the strategy has parameters or knowledge: robot/sizes.py makes swarm.h, which has them.
 */

#ifdef NOTHING

int run(void)
{
    return 0;
}

#else

#include "feasibee.h"
#ifdef SETTING
#include "swarm.h"
#endif

volatile uint16_t input[6]; /* what sensors and radio give */
volatile uint16_t output;
static struct feasibee_settings settings;
static struct feasibee_robot robot;
static struct feasibee_message message;
static uint32_t state = 1;

static uint32_t random_word(void)
{
    state ^= state << 13;
    state ^= state >> 17;
    state ^= state << 5;
    return state;
}

static uint32_t draw_duration(void *context, const struct feasibee_mean *mean)
{
    (void)context;
    return feasibee_exponential(mean, random_word());
}

static struct feasibee_choice draw_choice(void *context)
{
    struct feasibee_choice choice;
    (void)context;
    choice.chance = random_word();
    choice.message = random_word();
    return choice;
}

#ifdef FRAMES

static struct feasibee_wire wire;
uint8_t *volatile radio; /* its memory isn't the controller's */

static bool receive(feasibee_id *sender)
{
    return feasibee_decode(&wire, radio, input[3], sender, &message);
}

static void broadcast(void)
{
    output = (uint16_t)feasibee_encode(&wire, robot.me.id, &message, radio, input[4]);
}

#else

static bool receive(feasibee_id *sender)
{
    message.opinion = input[3] & 1;
    message.value = input[4];
    *sender = (feasibee_id)input[5];
    return true;
}

static void broadcast(void)
{
    output = message.value + message.opinion;
}

#endif

static void see(void)
{
    feasibee_observe(&robot, input[1], input[2]);
#ifdef KNOWLEDGE
    struct feasibee_thing thing = {0};
    thing.is_robot = input[1];
    thing.id = input[2];
    thing.hash = input[3];
#ifdef FEASIBEE_DOUBLE
    thing.x = robot.x = input[4];
    thing.y = robot.y = input[5];
#endif
    feasibee_recognise(&robot, &thing);
#endif
}

static void begin(void)
{
    struct feasibee_me me = {0};
    settings = feasibee_defaults(&STRATEGY);
    settings.draw_duration = draw_duration;
    settings.draw_choice = draw_choice;
#ifdef SETTING
    settings.setting = &setting;
#endif
#ifndef KNOWLEDGE
    settings.declare.rounds = 3;
#endif
#ifdef FRAMES
    wire = feasibee_wire_of(&settings, NAME, 5);
#endif
    feasibee_begin(&robot, &settings, &me, 1);
}

int run(void)
{
    feasibee_id sender;
    begin();
    while (input[0]) {
        see();
        if (receive(&sender) && feasibee_listens(&robot))
            feasibee_hear(&robot, sender, &message);
        if (feasibee_message(&robot, &message))
            broadcast();
        feasibee_end_step(&robot);
        output = robot.declared;
    }
    return robot.opinion;
}

#endif

#ifndef __wasm__
int main(void)
{
    return run();
}
#endif

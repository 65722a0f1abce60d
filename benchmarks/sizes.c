/* The least program that uses the whole controller; with NOTHING, one that does nothing. */

#ifdef NOTHING

int run(void)
{
    return 0;
}

#else

#include "feasibee.h"

volatile uint16_t input[6]; /* what sensors and radio give */
volatile uint16_t output;
static struct feasibee_settings settings;
static struct feasibee_robot robot;
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

int run(void)
{
    struct feasibee_me me = {0};
    struct feasibee_message message = {0};
    settings = feasibee_defaults(&STRATEGY);
    settings.draw_duration = draw_duration;
    settings.draw_choice = draw_choice;
    settings.commit.rounds = 3;
    feasibee_begin(&robot, &settings, &me, 1);
    while (input[0]) {
        feasibee_observe(&robot, input[1], input[2]);
        message.opinion = input[3] & 1;
        message.value = input[4];
        if (feasibee_listens(&robot))
            feasibee_hear(&robot, (feasibee_id)input[5], &message);
        if (feasibee_message(&robot, &message))
            output = message.value + message.opinion;
        feasibee_end_step(&robot);
        output = robot.committed + robot.declared;
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

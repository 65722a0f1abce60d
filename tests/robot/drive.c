/* Drives the controller by a stream: reads settings, sights and messages, writes what the robot does.
 *
 * driving.py writes the stream and has its layout: all numbers are little-endian. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "feasibee.h"

static const struct feasibee_strategy *const strategies[] = {STRATEGIES};

struct draws {
    uint32_t word;
    double mean; /* of the last duration, in steps */
};

static uint32_t read_number(unsigned bytes)
{
    uint32_t number = 0;
    for (unsigned place = 0; place < bytes; place++) {
        int byte = getchar();
        if (byte == EOF)
            exit(place > 0 || bytes != 4 ? 1 : 0);
        number |= (uint32_t)byte << 8 * place;
    }
    return number;
}

static double read_double(void)
{
    uint64_t bits = read_number(4);
    double number;
    bits |= (uint64_t)read_number(4) << 32;
    memcpy(&number, &bits, sizeof number);
    return number;
}

static void write_number(uint64_t number, unsigned bytes)
{
    for (unsigned place = 0; place < bytes; place++)
        putchar((int)(number >> 8 * place & 255));
}

static uint32_t draw_word(struct draws *draws)
{
    draws->word ^= draws->word << 13;
    draws->word ^= draws->word >> 17;
    draws->word ^= draws->word << 5;
    return draws->word;
}

static uint32_t draw_duration(void *context, const struct feasibee_mean *mean)
{
    struct draws *draws = context;
    double share = (double)mean->share.part / (double)mean->share.whole;
    uint32_t word = draw_word(draws);
    draws->mean = (double)mean->steps / (double)FEASIBEE_STEP * (mean->complement ? 1.0 - share : share);
#ifdef FEASIBEE_DOUBLE
    return feasibee_exponential(mean, word);
#else
    return 1 + word % 16;
#endif
}

static struct feasibee_choice draw_choice(void *context)
{
    struct feasibee_choice choice;
    choice.chance = draw_word(context);
    choice.message = draw_word(context);
    return choice;
}

/* Read the strategy's parameters, in the order of its file. */
static const struct feasibee_setting *read_setting(void)
{
    static struct feasibee_setting setting;
    uint32_t parameters = read_number(1);
    for (uint32_t k = 0; k < parameters; k++)
        setting.parameters[k] = FEASIBEE_REAL(read_double());
    return &setting;
}

static void read_settings(struct feasibee_settings *settings, struct draws *draws)
{
    settings->exploration = (feasibee_steps)(read_double() * FEASIBEE_STEP);
    settings->gain = (feasibee_steps)(read_double() * FEASIBEE_STEP);
    settings->dissemination_floor = (uint16_t)read_number(2);
    settings->quality_floor = (uint16_t)read_number(2);
    settings->listens_for = (int32_t)read_number(2) - 1;
    settings->inbox_size = (uint16_t)read_number(2);
    settings->own_vote = read_number(1);
    settings->random_ties = read_number(1);
    settings->first_sight = read_number(1);
    settings->every_message = read_number(1);
    settings->stubborn = read_number(1);
    settings->declare.rounds = (uint16_t)read_number(2);
    settings->declare.heard = (uint16_t)read_number(2);
    settings->declare.quorum = (uint16_t)read_number(2);
    settings->declare.quorum_of = (uint16_t)read_number(2);
    settings->setting = read_setting();
    draws->word = read_number(4);
    settings->draw_duration = draw_duration;
    settings->draw_choice = draw_choice;
}

static void step(struct feasibee_robot *robot)
{
    struct feasibee_message message = {0};
    struct draws *draws = robot->me.context;
    uint64_t mean;
    uint16_t robots = (uint16_t)read_number(1), tasks = (uint16_t)read_number(1);
    bool listens = feasibee_listens(robot);
    feasibee_observe(robot, robots, tasks);
    for (uint32_t left = read_number(1); left > 0; left--) {
        feasibee_id sender = (feasibee_id)read_number(1);
        message.opinion = (int8_t)read_number(1);
        message.value = (uint16_t)read_number(2);
        message.declared = message.value & 1;
        if (listens)
            feasibee_hear(robot, sender, &message);
    }
    bool broadcasts = feasibee_message(robot, &message);
    feasibee_end_step(robot);
    memcpy(&mean, &draws->mean, sizeof mean);
    write_number((uint64_t)(robot->opinion + 1), 1);
    write_number((uint64_t)(listens + 2 * broadcasts + 4 * robot->disseminating + 8 * (robot->declared != FEASIBEE_NONE)), 1);
    write_number(broadcasts ? (uint64_t)(message.opinion + 2 * message.declared) : 0, 1);
    write_number(broadcasts ? message.value : 0, 2);
    write_number(robot->phase_left, 4);
    write_number(mean, 8);
}

int main(void)
{
    for (;;) { /* until the stream ends */
        uint32_t steps = read_number(4);
        uint32_t strategy = read_number(1);
        struct feasibee_settings settings = feasibee_defaults(strategies[strategy]);
        struct draws draws = {0, 0.0};
        struct feasibee_me me = {.context = &draws};
        struct feasibee_robot robot;
        int8_t opinion = (int8_t)read_number(1);
        read_settings(&settings, &draws);
        feasibee_begin(&robot, &settings, &me, opinion);
        while (steps-- > 0)
            step(&robot);
    }
}

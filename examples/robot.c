/* robot.c: a robot that always sees a robot and two tasks, and hears robot 7 say infeasible. */
#include "feasibee.h"
#include <stdio.h>
#ifdef __AVR__
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

static int put(char letter, FILE *stream) /* to the serial port */
{
    (void)stream;
    UDR0 = (uint8_t)letter;
    return 0;
}
#endif

static uint32_t random_word(void)
{
    static uint32_t word = 1; /* another one on each robot */
    word ^= word << 13;
    word ^= word >> 17;
    return word ^= word << 5;
}

static uint32_t draw_duration(void *context, const struct feasibee_mean *mean)
{
    (void)context;
    return feasibee_exponential(mean, random_word());
}

static struct feasibee_choice draw_choice(void *context)
{
    struct feasibee_choice choice = {random_word(), random_word()};
    (void)context;
    return choice;
}

int main(void)
{
    static struct feasibee_robot robot;
    struct feasibee_settings settings = feasibee_defaults(&feasibee_mine);
    struct feasibee_me me = {NULL, 12, 0, 0, 0}; /* this robot is number 12 */
    struct feasibee_message message = {FEASIBEE_INFEASIBLE, false, 0}, heard = message;
    int broadcasts = 0;

    settings.draw_duration = draw_duration;
    settings.draw_choice = draw_choice;
    feasibee_begin(&robot, &settings, &me, FEASIBEE_FEASIBLE);
    for (int step = 0; step < 200; step++) {
        feasibee_observe(&robot, 1, 2); /* what the camera sees: a robot and two tasks */
        if (feasibee_listens(&robot))
            feasibee_hear(&robot, 7, &heard); /* what the radio hears: robot 7 says infeasible */
        if (feasibee_message(&robot, &message))
            broadcasts++;
        feasibee_end_step(&robot);
    }
#ifdef __AVR__
    fdevopen(put, NULL);
#endif
    printf("opinion %d after %d broadcasts\n", robot.opinion, broadcasts);
#ifdef __AVR__
    cli();
    sleep_mode(); /* the simulator ends */
#endif
    return 0;
}

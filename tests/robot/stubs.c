/* A robot for the program on the page docs/firmware.md: three others, who say feasible, for 1,000 steps. */

#include <stdio.h>

#include "feasibee.h"

bool wait_for_tick(void);
uint32_t random_word(void);
uint16_t robots_in_sight(void), tasks_in_sight(void);
bool receive(feasibee_id *sender, struct feasibee_message *message);
void broadcast(feasibee_id me, const struct feasibee_message *message);
void show(int8_t opinion);

static uint32_t word = 1;
static int steps, broadcasts, feasible;

bool wait_for_tick(void)
{
    if (steps++ < 1000)
        return true;
    printf("%d broadcasts, %d steps feasible\n", broadcasts, feasible);
    return false;
}

uint32_t random_word(void)
{
    word ^= word << 13;
    word ^= word >> 17;
    word ^= word << 5;
    return word;
}

uint16_t robots_in_sight(void)
{
    return 2;
}

uint16_t tasks_in_sight(void)
{
    return 1;
}

bool receive(feasibee_id *sender, struct feasibee_message *message)
{
    *sender = (feasibee_id)(random_word() % 4);
    message->opinion = FEASIBEE_FEASIBLE;
    message->value = 0;
    message->declared = false;
    return *sender > 0;
}

void broadcast(feasibee_id me, const struct feasibee_message *message)
{
    broadcasts += me == 12 && message->opinion >= 0;
}

void show(int8_t opinion)
{
    feasible += opinion == FEASIBEE_FEASIBLE;
}

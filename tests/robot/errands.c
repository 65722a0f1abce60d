/* The errand of a robot, driven by lines on standard input: prints after each one all that the robot knows and goes to. */

#include <inttypes.h>
#include <stdio.h>

#include "acting.h"

static uint64_t away[64]; /* how far each task is */

static uint64_t way(void *context, uint32_t name)
{
    (void)context;
    return away[name];
}

static void show(const struct feasibee_errand *errand, int answer)
{
    printf("%d %d %d %d %d", answer, (int)errand->target, (int)errand->task, (int)errand->mark,
           errand->acts ? (int)errand->began : -1);
    for (uint16_t k = 0; k < errand->known; k++)
        if (errand->tasks[k].version != FEASIBEE_UNKNOWN)
            printf(" %" PRIu32 ":%" PRId32, errand->tasks[k].name, errand->tasks[k].version);
    putchar('\n');
}

int main(void)
{
    struct feasibee_errand errand;
    struct feasibee_rules rules;
    long long a[9];
    char what;
    while (scanf(" %c %lld %lld %lld", &what, &a[0], &a[1], &a[2]) == 4) {
        int answer = 0;
        if (what == 'b') {
            for (int k = 3; k < 9; k++)
                if (scanf("%lld", &a[k]) != 1)
                    return 1;
            rules.start = (uint32_t)a[0];
            rules.number = (uint32_t)a[1];
            rules.count = (uint32_t)a[2];
            rules.rank = (uint8_t)a[3];
            rules.ranks = (uint8_t)a[4];
            rules.by_word = a[5] != 0;
            rules.by_rank = a[6] != 0;
            rules.tags = a[7] != 0;
            rules.comes_free = a[8] != 0;
            feasibee_set_out(&errand, &rules);
        } else if (what == 'w') {
            away[a[0]] = a[1] < 0 ? FEASIBEE_FAR : (uint64_t)a[1];
        } else if (what == 's') {
            feasibee_see_task(&errand, (uint32_t)a[0], (int32_t)a[1]);
        } else if (what == 'h') {
            feasibee_hear_task(&errand, (uint32_t)a[0], (int32_t)a[1]);
        } else if (what == 'c') {
            feasibee_choose_task(&errand, (uint32_t)a[0], (int8_t)a[1], way, NULL);
        } else if (what == 'a') {
            answer = feasibee_arrive(&errand, (int32_t)a[0]);
        } else if (what == 'l') {
            feasibee_lose_task(&errand);
        } else {
            feasibee_announce(&errand, (uint32_t)a[0]);
        }
        show(&errand, answer);
    }
    return 0;
}

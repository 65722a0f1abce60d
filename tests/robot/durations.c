/* Draws durations: reads a mean (1/65536 steps, part, whole, complement) and a word, writes steps. */

#include <stdio.h>

#include "feasibee.h"

int main(void)
{
    uint32_t given[5];
    while (fread(given, sizeof given[0], 5, stdin) == 5) {
        struct feasibee_mean mean = {given[0], {given[1], given[2]}, given[3]};
        uint32_t steps = feasibee_exponential(&mean, given[4]);
        fwrite(&steps, sizeof steps, 1, stdout);
    }
    return 0;
}

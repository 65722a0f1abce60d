/* One call of a strategy's function, with what the engine does where it fails. */

#include "failures.c"
#include "engine.h"

struct call {
    const struct rules *rules;
    int32_t rule; /* its number in struct rules */
    int64_t robots, tasks;
    double quality, gain;
    struct mind *mind;
    const struct inbox *inbox;
    struct known known;
    const struct setting *setting;
    double real;
    int64_t whole;
};

static int64_t work(void *given)
{
    struct call *call = given;
    const struct rules *rules = call->rules;
    switch (call->rule) {
    case 0: call->real = rules->quality(call->robots, call->tasks); return 0;
    case 1: call->real = rules->dissemination(call->quality, call->gain); return 0;
    case 2: call->whole = rules->decide(call->mind, call->inbox); return 0;
    case 3: call->whole = rules->say(call->mind); return 0;
    case 4: call->real = rules->value(call->mind); return 0;
    case 5: call->real = rules->lasting(call->mind, call->gain); return 0;
    case 6: call->real = rules->probability(call->mind, call->known, call->setting); return 0;
    default: return -1;
    }
}

int64_t call_once(struct call *call, struct failure *failure)
{
    return attempt(work, call, -1, failure);
}

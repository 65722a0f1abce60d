/* What a robot decides and broadcasts by its strategy, and what is recorded of the whole swarm (model.md 4). */

#ifndef DECISIONS_H
#define DECISIONS_H

#include "engine.h"
#include "vec.h"

enum opinion { NO_OPINION = -1, INFEASIBLE = 0, FEASIBLE = 1, UNDECIDED = -1 };

#define CERTAIN 1048576.0 /* feasibee.base.codes */

/* Columns of the account of a run: feasibee.base.outcomes.ACCOUNT. */
enum column { BITS_SENT = 0, FEASIBLE_AT_END = 4, INFEASIBLE_AT_END = 5, LAST_STEP = 6, SAID_AT_END = 7 };

/* What all runs of a call share. */
struct job {
    const struct params *params;
    const struct rules *rules;
    const struct setting *setting;
    const struct outcome *outcome;
    struct control *control;
    int64_t memory; /* floats that a robot keeps for its strategy */
};

/* Return the mean of messages' integer values as a share of the largest value, rounded once. */
ALWAYS double mean_share(const struct params *params, int64_t total, int64_t messages)
{
    const double scale = params->strategy.value_scale * (double)messages;
    return scale > 0.0 ? (double)total / scale : 0.0;
}

/* Return the quality of feasible from what a robot has seen (model.md 4.3). */
ALWAYS double rated(const struct job *job, int64_t robots, int64_t tasks)
{
    const int64_t floor = job->params->decision.quality_floor;
    return job->rules->quality(robots > floor ? robots : floor, tasks > floor ? tasks : floor);
}

ALWAYS struct mind mind_of(const struct job *job, int opinion, double quality, double *memory)
{
    return (struct mind){
        .opinion = opinion,
        .quality = opinion == FEASIBLE ? quality : opinion == INFEASIBLE ? 1.0 - quality : 0.5,
        .feasible_quality = quality,
        .own_vote = job->params->decision.own_vote,
        .random_ties = job->params->decision.random_ties,
        .memory = memory,
        .memory_count = job->memory,
        .parameters = job->setting->parameters,
        .parameter_count = job->setting->parameter_count,
    };
}

/* What a robot broadcasts after an exploration, and for how long on average, in steps (model.md 4.4). */
struct broadcast {
    bool speaks, says_feasible;
    int32_t value;
    double mean;
};

ALWAYS struct broadcast broadcast_of(const struct job *job, struct mind *mind)
{
    const struct rules *rules = job->rules;
    const double scale = job->params->strategy.value_scale, gain = job->params->decision.gain;
    const int64_t said = rules->say ? rules->say(mind) : mind->opinion;
    struct broadcast made = {.speaks = said == 0 || said == 1, .says_feasible = said == 1};
    if (scale > 0.0) {
        double value = rules->value ? rules->value(mind) : mind->feasible_quality;
        value = value < 1.0 ? value : 1.0;
        made.value = (int32_t)((value > 0.0 ? value : 0.0) * scale + 0.5);
    }
    made.mean = rules->lasting ? rules->lasting(mind, gain) : rules->dissemination(mind->quality, gain);
    return made;
}

/* Return a number below `count`, uniformly. */
ALWAYS int64_t choose(uint32_t word, int64_t count) { return (int64_t)((uint64_t)word * (uint64_t)count >> 32); }

/* Return whether robots are asked at the end how probable feasible is. */
ALWAYS bool are_asked(const struct job *job)
{
    return job->params->strategy.gives_probability && job->rules->probability;
}

/* Return what a robot says how probable feasible is, in units of 1 / CERTAIN (model.md 6.15.9). */
ALWAYS int64_t said_by(const struct job *job, struct mind *mind, struct known known)
{
    return (int64_t)(job->rules->probability(mind, known, job->setting) * CERTAIN + 0.5);
}

/* The decision of a run so far. */
struct verdict {
    int decision, step;
};

/* Record how many robots hold which opinion at a step, and the first decision (model.md 4.7). */
ALWAYS void record_step(const struct job *job, struct verdict *verdict, int64_t row, int64_t now, int64_t quorum,
                        int64_t feasible, int64_t infeasible)
{
    const struct outcome *outcome = job->outcome;
    if (outcome->curve_length > 0) {
        outcome->feasible_count[row * outcome->curve_length + now] = (int32_t)feasible;
        outcome->infeasible_count[row * outcome->curve_length + now] = (int32_t)infeasible;
    }
    if (verdict->decision == UNDECIDED && (feasible >= quorum || infeasible >= quorum))
        *verdict = (struct verdict){feasible >= quorum, (int)now};
}

ALWAYS void record_end(const struct job *job, const struct verdict *verdict, int64_t row, int64_t now,
                       int64_t feasible, int64_t infeasible, int64_t bits)
{
    int64_t *account = job->outcome->account + row * job->outcome->columns;
    job->outcome->decision[row] = (int8_t)verdict->decision;
    job->outcome->decision_step[row] = verdict->step;
    account[BITS_SENT] = bits;
    account[FEASIBLE_AT_END] = feasible;
    account[INFEASIBLE_AT_END] = infeasible;
    account[LAST_STEP] = now;
}

ALWAYS int64_t quorum_of(const struct params *params)
{
    return params->robots.count * params->decision.quorum.share / params->decision.quorum.whole + 1;
}

ALWAYS bool is_cancelled(const struct control *control)
{
    return __atomic_load_n(control->cancelled, __ATOMIC_RELAXED);
}

ALWAYS void count_steps(struct control *control, int64_t steps)
{
    __atomic_store_n(control->steps_done, *control->steps_done + steps, __ATOMIC_RELAXED);
}

#endif

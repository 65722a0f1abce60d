/* Any world, step by step: what is recorded, whether a run goes on, and runs by one thread or several. */

#include "state.h"

#include "failures.h"
#include "step.h"
#include "team.h"

ALWAYS bool may_declare(const struct params *p) { return p->strategy.declares || p->decision.declare.enabled; }

/* Count a thread's robots with opinion 1, without one, and that have declared, of the counted ones. */
static void count_opinions(const struct state *s, struct part *part)
{
    part->feasible = part->neutral = part->declared_feasible = part->declared_infeasible = 0;
    for (int64_t w = part->first; w < part->last; w++) {
        const uint32_t counted = s->sets[COUNTED][w], declared = s->sets[DECLARED][w] & counted;
        part->feasible += members(s->sets[FOR_FEASIBLE][w] & counted);
        part->neutral += members(s->sets[NEUTRAL][w] & counted);
        part->declared_feasible += members(declared & s->sets[FOR_FEASIBLE_DECLARED][w]);
        part->declared_infeasible += members(declared & ~s->sets[FOR_FEASIBLE_DECLARED][w]);
    }
}

/* Sum what all threads have counted; return whether one of them wants the run to end. */
static bool sum_counts(struct state *s)
{
    struct account *account = s->account;
    int64_t feasible = 0, neutral = 0;
    bool ended = false;
    account->declared_feasible = account->declared_infeasible = 0;
    for (const struct part *part = s->parts; part < s->parts + s->threads; part++) {
        feasible += part->feasible;
        neutral += part->neutral;
        account->bits_sent += part->bits;
        account->declared_feasible += part->declared_feasible;
        account->declared_infeasible += part->declared_infeasible;
        ended |= part->ended;
    }
    account->feasible_at_end = feasible;
    account->infeasible_at_end = s->clock->counted - feasible - neutral;
    return ended;
}

/* Record the present step of a run, and its decision if it is the first (model.md 4.7). */
static void record(struct state *s, const struct outcome *outcome, int64_t row)
{
    const int64_t now = s->clock->step, quorum = s->clock->quorum;
    struct account *account = s->account;
    const int64_t feasible = account->feasible_at_end, infeasible = account->infeasible_at_end;
    const int held = feasible >= quorum ? FEASIBLE : infeasible >= quorum ? INFEASIBLE : UNDECIDED;
    account->last_step = now;
    if (outcome->curve_length > 0) {
        outcome->feasible_count[row * outcome->curve_length + now] = (int32_t)feasible;
        outcome->infeasible_count[row * outcome->curve_length + now] = (int32_t)infeasible;
    }
    if (outcome->decision[row] == UNDECIDED && held != UNDECIDED) {
        outcome->decision[row] = (int8_t)held;
        outcome->decision_step[row] = (int32_t)now;
    }
    if (outcome->trace_length > 0) {
        const int64_t place = row * outcome->trace_length + now;
        outcome->truth[place] = (int8_t)s->clock->truth;
        outcome->held[place] = (int8_t)held;
        outcome->robots_present[place] = (int32_t)s->clock->robots;
        outcome->tasks_present[place] = (int32_t)s->clock->tasks;
    }
    if (may_declare(s->params) && account->declare_step < 0 &&
        account->declared_feasible + account->declared_infeasible >= quorum)
        account->declare_step = now;
}

/* Return whether all counted robots have declared, and none of them stops later (model.md 6.15.8). */
static bool have_all_declared(const struct state *s)
{
    const int64_t declared = s->account->declared_feasible + s->account->declared_infeasible;
    return declared == s->clock->counted && s->clock->step >= s->params->faults.stop_step;
}

/* Return whether a run is at its end, by what it is to end with. */
static bool is_over(const struct state *s, int decision)
{
    const struct run run = s->params->run;
    const struct account *account = s->account;
    if (run.stop_at_declarations && have_all_declared(s))
        return true;
    if (run.stop_when_taken && (s->params->tasks.work > 0 ? account->all_done_step : account->all_taken_step) >= 0)
        return true;
    return run.stop_at_decision && decision != UNDECIDED;
}

/* End a step, or the start, for all threads; return whether there is a next step. */
static bool end_step(struct state *s, struct part *part, const struct job *job, int64_t row, int64_t until,
                     int64_t steps)
{
    struct team *team = s->team;
    part->ended |= is_cancelled(job->control);
    count_opinions(s, part);
    if (comes_last(team)) {
        s->clock->step += steps;
        count_steps(job->control, steps);
        const bool ended = sum_counts(s);
        record(s, job->outcome, row);
        s->goes_on = !ended && s->clock->step < until && !s->clock->full && !is_over(s, job->outcome->decision[row]);
        if (team->threads > 1)
            let_go(team);
    }
    return s->goes_on;
}

/* Return the sum of what the counted robots say how probable feasible is (model.md 6.15.9). */
static int64_t sum_probabilities(struct state *s, const struct job *job)
{
    int64_t said = 0;
    for (int64_t w = 0; w < s->words; w++)
        for (uint32_t left = s->sets[COUNTED][w]; left; left = without_lowest(left)) {
            const int64_t i = lowest_member(w, left);
            if (has(s->sets[DECLARED], i)) {
                said += (int64_t)CERTAIN * has(s->sets[FOR_FEASIBLE_DECLARED], i);
            } else {
                struct mind mind = mind_in(job, s, i);
                said += said_by(job, &mind, known_by(s, i));
            }
        }
    return said;
}

struct stretch_of_run {
    struct state *s;
    struct part *part;
    const struct job *job;
    int64_t row, until;
};

/* Simulate a thread's part of a run up to a step, or to its end. */
static int64_t advance(void *given)
{
    const struct stretch_of_run *run = given;
    struct state *s = run->s;
    struct part *part = run->part;
    const struct job *job = run->job;
    bool goes_on;
    part->ended = false;
    if (s->clock->step == 0) {
        if (s->params->changes)
            change_world(s, 0);
        part->bits = 0;
        goes_on = end_step(s, part, job, run->row, run->until, 0);
    } else {
        goes_on = s->clock->step < run->until && !s->clock->full && !is_over(s, job->outcome->decision[run->row]);
    }
    for (; goes_on; goes_on = end_step(s, part, job, run->row, run->until, 1)) {
        if (s->params->together)
            step_few(s, part, job);
        else
            step_crowd(s, part, job);
    }
    if (part->thread == 0) {
        if (are_asked(job))
            s->account->said_at_end = sum_probabilities(s, job);
        memcpy(job->outcome->account + run->row * job->outcome->columns, s->account, sizeof *s->account);
    }
    return 0;
}

void feasibee_start(struct state *s, int64_t run) { start_run(s, run); }

int64_t feasibee_advance(struct state *s, int64_t row, int64_t until, const struct outcome *outcome,
                         struct control *control, int64_t thread)
{
    const struct job job = {s->params, s->rules, s->setting, outcome, control, s->memory_length};
    struct stretch_of_run run = {s, s->parts + thread, &job, row, until};
    const int64_t result = attempt(advance, &run, -1, &run.part->failure);
    if (result != 0) { /* the others end the run, too */
        control->failure = run.part->failure;
        run.part->ended = true;
        if (s->threads > 1)
            end_step(s, run.part, &job, row, until, 1);
    }
    return result;
}

int64_t feasibee_play_any(struct state *s, int64_t first_run, const struct outcome *outcome, struct control *control)
{
    for (int64_t row = 0; row < outcome->runs; row++) {
        start_run(s, first_run + row);
        outcome->decision[row] = UNDECIDED;
        outcome->decision_step[row] = -1;
        if (feasibee_advance(s, row, s->params->run.steps, outcome, control, 0) != 0 || s->clock->full ||
            is_cancelled(control))
            return row;
    }
    return outcome->runs;
}

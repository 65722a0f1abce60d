/* A step of one swarm in any world, and what robots do when their phases end (model.md 3, 4). */

#ifndef STEP_H
#define STEP_H

#include "acting.h"
#include "bodies.h"
#include "dynamics.h"
#include "knowledge.h"
#include "motion.h"
#include "phases.h"
#include "sense_crowd.h"
#include "sense_few.h"
#include "start.h"

/* --- Ends of phases --- */

ALWAYS struct mind mind_in(const struct job *job, const struct state *s, int64_t i)
{
    return mind_of(job, opinion_of(s, i), s->quality[i], s->memory + i * s->memory_length);
}

/* Let a robot adopt what its first exploration favours; a tie keeps its opinion (model.md 6.10). */
ALWAYS void adopt_first_sight(struct state *s, int64_t i)
{
    put_in(s->sets[JOINING], i, false);
    if (s->quality[i] != 0.5)
        adopt(s, i, s->quality[i] > 0.5);
}

/* Begin to broadcast, for a duration that the opinion's quality sets (model.md 4.4). */
static inline void end_exploration(struct state *s, const struct job *job, int64_t i)
{
    if (s->params->decision.first_sight && has(s->sets[JOINING], i))
        adopt_first_sight(s, i);
    struct mind mind = mind_in(job, s, i);
    const struct broadcast made = broadcast_of(job, &mind);
    put_in(s->sets[SPEAKING], i, made.speaks);
    put_in(s->sets[SAYS_FEASIBLE], i, made.says_feasible);
    if (s->params->strategy.value_scale > 0.0)
        s->robots[SENT_VALUE][i] = made.value;
    put_in(s->sets[DISSEMINATING], i, true);
    enter_phase(s, i, duration_of(present_phase(s, i), made.mean) + s->params->decision.dissemination_floor);
}

/* Let a robot declare after enough decisions in a row with which its inbox agreed (model.md 6.14). */
APART void declare_by_votes(struct state *s, int64_t i, int64_t feasible, int64_t votes)
{
    const struct declare rule = s->params->decision.declare;
    const int opinion = opinion_of(s, i);
    const int64_t agreeing = opinion == FEASIBLE ? feasible : votes - feasible;
    int32_t *agreed = &s->robots[AGREED][i];
    if (opinion == NO_OPINION || votes < rule.heard || agreeing * rule.whole < rule.share * votes)
        *agreed = 0;
    else if (++*agreed >= rule.rounds)
        set_declared(s, i, opinion);
}

/* Decide by the inbox, or by knowledge, and explore again (model.md 4.6). */
static inline void end_dissemination(struct state *s, struct part *part, const struct job *job, int64_t i)
{
    const struct phase phase = present_phase(s, i);
    const struct heard_votes heard = read_inbox(s, i, phase.tie);
    const struct inbox received = {
        .feasible_votes = heard.feasible,
        .infeasible_votes = heard.votes - heard.feasible,
        .heard_opinion = heard.opinion,
        .heard_value = mean_share(s->params, heard.value, 1),
        .mean_value = mean_share(s->params, heard.total, heard.votes),
        .chance = phase.chance,
    };
    struct mind mind = mind_in(job, s, i);
    adopt(s, i, s->rules->decide(&mind, &received));
    if (s->params->decision.declare.enabled)
        declare_by_votes(s, i, heard.feasible, heard.votes);
    forget(s, part, i);
    put_in(s->sets[DISSEMINATING], i, false);
    put_in(s->sets[SPEAKING], i, false);
    enter_phase(s, i, duration_of(phase, s->params->decision.exploration));
}

ALWAYS void end_phases(struct state *s, struct part *part, const struct job *job)
{
    for (int64_t w = part->first; w < part->last; w++)
        for (uint32_t left = s->sets[ENDING][w]; left; left = without_lowest(left)) {
            const int64_t i = lowest_member(w, left);
            if (has(s->sets[DISSEMINATING], i))
                end_dissemination(s, part, job, i);
            else
                end_exploration(s, job, i);
        }
}

/* --- Rating --- */

/* Return the least quality over the sets of skills of which anything was seen (model.md 6.7). */
static inline double scarcest(const struct state *s, const struct job *job, int64_t i)
{
    const int64_t *seen = s->seen + i * s->tables.classes, *adds = s->tables.adds;
    const int64_t robot_classes = s->params->robots.classes;
    double least = 2.0;
    for (int64_t set = 0; set < s->tables.skill_sets; set++, adds += s->tables.classes) {
        int64_t robots = 0, tasks = 0;
        for (int64_t kind = 0; kind < robot_classes; kind++)
            robots += adds[kind] * seen[kind];
        for (int64_t kind = robot_classes; kind < s->tables.classes; kind++)
            tasks += adds[kind] * seen[kind];
        const double quality = robots + tasks > 0 ? rated(job, robots, tasks) : 2.0;
        least = quality < least ? quality : least;
    }
    return least == 2.0 ? rated(job, 0, 0) : least;
}

/* Rate the quality of feasible. Knowledge grows while disseminating, so rate again before deciding. */
ALWAYS void rate(struct state *s, struct part *part, const struct job *job)
{
    const bool knows = s->params->strategy.knowledge.enabled;
    if (knows) {
        for (int64_t w = part->first; w < part->last; w++)
            for (uint32_t left = s->sets[ENDING][w]; left; left = without_lowest(left))
                defer(s, COUNT, lowest_member(w, left), 0, 0);
        update_pending(s, COUNT);
    }
    for (int64_t w = part->first; w < part->last; w++) {
        uint32_t left = s->sets[ENDING][w] & (knows ? UINT32_MAX : ~s->sets[DISSEMINATING][w]);
        for (; left; left = without_lowest(left)) {
            const int64_t i = lowest_member(w, left);
            s->quality[i] = s->seen ? scarcest(s, job, i)
                                    : rated(job, s->counts[ROBOTS_SEEN][i], s->counts[TASKS_SEEN][i]);
        }
    }
}

/* --- A step --- */

/* Let those robots know what they know when they begin that don't yet. */
static inline void begin_to_know(struct state *s)
{
    for (int64_t w = 0; w < s->words; w++) {
        for (uint32_t left = s->sets[JOINING][w]; left; left = without_lowest(left))
            defer(s, START, lowest_member(w, left), 0, 0);
        s->sets[JOINING][w] = 0;
    }
    update_pending(s, START);
}

/* Stop robots whose time has come, change the world, and let robots begin to know. */
ALWAYS void begin_step(struct state *s, struct part *part)
{
    const struct params *p = s->params;
    const int64_t now = s->clock->step + 1;
    if (p->faults.stopped > 0 && now == p->faults.stop_step) {
        for (int64_t w = part->first; w < part->last; w++)
            stop_word(s, w);
        if (part->thread == 0)
            set_quorum(s, p->robots.at_start - p->faults.byzantine - p->faults.stopped);
        wait_for_all(s);
    }
    if (p->strategy.knowledge.enabled && now == 1)
        begin_to_know(s);
    if (p->changes) {
        change_world(s, now);
        if (p->strategy.knowledge.enabled)
            begin_to_know(s);
    }
    if (p->acting.acts)
        begin_acting(s);
}

/* Ask robots whether they are sure, or for their opinions, and rate what they know. */
ALWAYS void end_sensing(struct state *s, struct part *part, const struct job *job)
{
    const struct params *p = s->params;
    if (p->radio.delay > 0)
        take_own_messages(s, part);
    if (p->strategy.declares)
        s->rules->update(s, DECLARE, p->robots.count);
    if (p->strategy.judges)
        s->rules->update(s, JUDGE, p->robots.count);
    if (p->acting.acts)
        end_acting(s);
    rate(s, part, job);
}

ALWAYS void step_few(struct state *s, struct part *part, const struct job *job)
{
    begin_step(s, part);
    move_few(s, part);
    if (s->params->acting.acts)
        moved_acting(s);
    tick(s, part);
    sense_few(s, part);
    end_sensing(s, part, job);
    turn_all(s, part);
    end_phases(s, part, job);
    if (s->params->acting.acts)
        choose_targets(s);
}

ALWAYS void step_crowd(struct state *s, struct part *part, const struct job *job)
{
    if (s->clock->step == 0)
        fill_cells_together(s); /* later ones are those of the step before */
    begin_step(s, part);
    move_crowd(s, part);
    if (s->params->acting.acts)
        moved_acting(s);
    tick(s, part);
    sense_crowd(s, part);
    wait_for_all(s);
    end_sensing(s, part, job);
    turn_all(s, part);
    end_phases(s, part, job);
    if (s->params->acting.acts)
        choose_targets(s);
}

#endif

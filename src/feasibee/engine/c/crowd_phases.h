/* How a phase of a robot in a crowd ends (model.md 4.3 to 4.6). */

#ifndef CROWD_PHASES_H
#define CROWD_PHASES_H

#include "crowd_start.h"

ALWAYS int opinion_of(uint32_t label)
{
    return label & NEUTRAL ? NO_OPINION : label & HOLDS_FEASIBLE ? FEASIBLE : INFEASIBLE;
}

/* Return a robot's label with another opinion. */
ALWAYS uint32_t with_opinion(struct worker *own, uint32_t label, int64_t opinion)
{
    const bool feasible = opinion == FEASIBLE, neutral = opinion != FEASIBLE && opinion != INFEASIBLE;
    own->feasible += feasible - ((label & HOLDS_FEASIBLE) != 0);
    own->neutral += neutral - ((label & NEUTRAL) != 0);
    return (label & ~(uint32_t)(HOLDS_FEASIBLE | NEUTRAL)) | (feasible ? HOLDS_FEASIBLE : 0) |
           (neutral ? NEUTRAL : 0);
}

ALWAYS struct mind mind_in(const struct job *job, const struct crowd *s, uint32_t i, uint32_t label)
{
    const uint32_t number = label >> NUMBER_BITS;
    return mind_of(job, opinion_of(label), s->own[i].quality, s->memory + number * (size_t)job->memory);
}

/* Return after how many steps the robot disseminates no longer. */
ALWAYS uint32_t end_exploration(const struct job *job, struct crowd *s, struct worker *own, uint32_t i,
                                const struct phases *drawn, uint32_t q)
{
    const struct counts counts = counts_of(s, i);
    uint32_t label = s->rows.labels[i];
    struct own *kept = &s->own[i];
    kept->quality = rated(job, counts.robots, counts.tasks);
    if (label & JOINS) { /* a tie keeps its opinion (model.md 6.10) */
        label = kept->quality == 0.5 ? label : with_opinion(own, label, kept->quality > 0.5);
        label &= ~(uint32_t)JOINS;
    }
    struct mind mind = mind_in(job, s, i, label);
    const struct broadcast made = broadcast_of(job, &mind);
    if (s->values)
        s->sent[label >> NUMBER_BITS] = (uint32_t)made.value;
    own->speaking += made.speaks;
    s->rows.labels[i] = label | DISSEMINATES | (made.speaks ? SPEAKS : 0) |
                        (made.says_feasible ? SAYS_FEASIBLE : 0);
    return phase_lasts(drawn, q, made.mean) + (uint32_t)job->params->decision.dissemination_floor;
}

/* Return the number of messages for an opinion, of senders below a number. */
static int64_t count_messages(const uint32_t *messages, uint32_t slots, uint32_t opinion, uint32_t senders)
{
    int64_t found = 0;
    for (uint32_t k = 0; k < slots; k++)
        found += (messages[k] & 1) == opinion && sender_of(messages[k]) < senders;
    return found;
}

/* Read the value of the message drawn, which is the k-th of its opinion by sender, and the mean of all
 * values. */
APART void read_values(const struct job *job, const struct crowd *s, uint32_t i, int64_t drawn,
                       struct inbox *inbox)
{
    const int64_t votes = inbox->feasible_votes + inbox->infeasible_votes;
    const bool in_line = votes <= LINE;
    const uint32_t *messages = in_line ? s->lines[i].messages : s->lines[i].table->messages;
    const uint32_t slots = in_line ? (uint32_t)votes : s->lines[i].table->slots;
    const uint32_t *values = in_line ? s->values + (size_t)LINE * i : messages + slots;
    uint32_t low = 0, high = s->count - 1, value = 0;
    int64_t total = 0;
    if (votes == 0)
        return;
    while (low < high) { /* the least sender up to which more than `drawn` messages have this opinion */
        const uint32_t middle = (low + high) / 2;
        if (count_messages(messages, slots, inbox->heard_opinion == FEASIBLE, middle + 1) > drawn)
            high = middle;
        else
            low = middle + 1;
    }
    for (uint32_t k = 0; k < slots; k++)
        if (messages[k] != NOBODY) {
            total += values[k];
            value = sender_of(messages[k]) == low ? values[k] : value;
        }
    inbox->heard_value = mean_share(job->params, value, 1);
    inbox->mean_value = mean_share(job->params, total, votes);
}

ALWAYS struct inbox read_inbox(const struct job *job, const struct crowd *s, uint32_t i,
                               const struct counts *counts, const struct phases *drawn, uint32_t q)
{
    struct inbox inbox = {
        .feasible_votes = counts->feasible_votes,
        .infeasible_votes = counts->votes - counts->feasible_votes,
        .heard_opinion = NO_OPINION,
        .chance = (double)drawn->chance[q] * (1.0 / 4294967296.0),
    };
    int64_t k = 0;
    if (counts->votes > 0) {
        k = choose((uint32_t)drawn->tie[q], counts->votes);
        inbox.heard_opinion = k < counts->feasible_votes;
        k -= inbox.heard_opinion == FEASIBLE ? 0 : counts->feasible_votes;
    }
    if (s->values)
        read_values(job, s, i, k, &inbox);
    return inbox;
}

/* Empty a robot's inbox, and its counts unless evidence is kept (model.md 4.6). */
ALWAYS void forget(const struct job *job, struct crowd *s, struct worker *own, uint32_t i,
                   const struct counts *counts)
{
    struct tally *tally = &s->tallies[i];
    if (s->lines && counts->votes > LINE)
        give_table(&own->tables, s->lines[i].table);
    tally->votes = tally->feasible_votes = 0;
    if (job->params->strategy.forgets)
        *tally = (struct tally){0};
    if (RARELY(s->rows.labels[i] & CARRIED)) {
        struct counts *carried = &s->carried[s->rows.labels[i] >> NUMBER_BITS];
        carried->votes = carried->feasible_votes = 0;
        if (job->params->strategy.forgets)
            s->rows.labels[i] &= ~(uint32_t)CARRIED;
    }
}

ALWAYS uint32_t end_dissemination(const struct job *job, struct crowd *s, struct worker *own, uint32_t i,
                                  const struct phases *drawn, uint32_t q)
{
    const struct counts counts = counts_of(s, i);
    const struct inbox inbox = read_inbox(job, s, i, &counts, drawn, q);
    struct mind mind = mind_in(job, s, i, s->rows.labels[i]);
    const int64_t decided = job->rules->decide(&mind, &inbox);
    forget(job, s, own, i, &counts);
    const uint32_t label = with_opinion(own, s->rows.labels[i], decided);
    own->speaking -= (label & SPEAKS) != 0;
    s->rows.labels[i] = label & ~(uint32_t)(SPEAKS | SAYS_FEASIBLE | DISSEMINATES);
    return phase_lasts(drawn, q, job->params->decision.exploration);
}

/* End the phase of listed robots, all of which explore, or all of which disseminate. */
ALWAYS void end_phases(const struct job *job, struct crowd *s, struct worker *own, const uint32_t *listed,
                       uint32_t count, uint32_t now, const bool disseminate)
{
    for (uint32_t k = 0; k < count; k += PAIRS) {
        const uint32_t most = count - k < PAIRS ? count - k : PAIRS;
        const struct phases drawn = draw_phases(s, own, listed + k, most);
        for (uint32_t q = 0; q < most; q++) {
            const uint32_t i = listed[k + q];
            s->rows.ends_at[i] = now + (disseminate ? end_dissemination(job, s, own, i, &drawn, q)
                                                    : end_exploration(job, s, own, i, &drawn, q));
        }
    }
}

#endif

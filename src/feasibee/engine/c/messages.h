/* Inboxes in any world (model.md 4.5): sets for up to 128 robots with ids of their own, else a small hash table for
 * each robot.
 *
 * Each robot has a line of 8 slots. An inbox that outgrows it takes one of the tables that lie behind all lines.
 * Most never do: so a large swarm needs little memory. Eight slots are compared at once. */

#ifndef MESSAGES_H
#define MESSAGES_H

#include "queue.h"

/* Add numbers of 32 bits to consecutive counts. */
ALWAYS void add_lanes(int64_t *counts, u32 lanes)
{
    half parts[2];
    memcpy(parts, &lanes, sizeof lanes);
    for (int k = 0; k < 2; k++) {
        u64 sums;
        memcpy(&sums, counts + k * PAIRS, sizeof sums);
        sums += __builtin_convertvector(parts[k], u64);
        memcpy(counts + k * PAIRS, &sums, sizeof sums);
    }
}

/* --- Inboxes that are sets --- */

/* Keep the values in messages that speaking robots of a word send to each robot that hears them. */
APART void keep_values(struct state *s, int64_t other, uint32_t speaking)
{
    const uint32_t *sight = s->links[IN_SIGHT] + other * s->padded;
    for (int64_t i = 0; i < s->params->robots.count; i++)
        for (uint32_t left = sight[i] & speaking; left; left = without_lowest(left)) {
            const int64_t j = lowest_member(other, left);
            s->inbox[VALUE][s->padded * i + j] = s->robots[SENT_VALUE][j];
        }
}

/* Add the messages of the speaking robots of a word in each robot's sight; those of `said` are for feasible. */
static inline void receive_together(struct state *s, const struct part *part, int64_t other, uint32_t speaking,
                                    uint32_t said)
{
    const int64_t row = other * s->padded, robots = WORD * part->last;
    const uint32_t *restrict sight = s->links[IN_SIGHT] + row;
    uint32_t *restrict heard = s->links[HEARD] + row, *restrict feasible = s->links[HEARD_FEASIBLE] + row;
    int64_t *restrict votes = s->counts[VOTES], *restrict feasible_votes = s->counts[FEASIBLE_VOTES];
    if (s->params->decision.every_message) {
        for (int64_t i = 0; i < robots; i += LANES) {
            const u32 spoken = *(const u32 *)(sight + i) & spread(speaking);
            add_lanes(votes + i, ones_of(spoken));
            add_lanes(feasible_votes + i, ones_of(spoken & spread(said)));
        }
        return;
    }
    for (int64_t i = 0; i < robots; i += LANES) {
        u32 *hears = (u32 *)(heard + i), *favours = (u32 *)(feasible + i);
        const u32 spoken = *(const u32 *)(sight + i) & spread(speaking);
        *hears |= spoken;
        *favours = (*favours & ~spoken) | (spoken & spread(said));
    }
    if (s->params->strategy.value_scale > 0.0)
        keep_values(s, other, speaking);
}

/* --- Lines and tables --- */

struct slots {
    int64_t first, count;
};

/* Return the slots of a robot's inbox, by masks: to mispredict a branch takes longer. */
ALWAYS struct slots slots_of(const struct state *s, int64_t i)
{
    const int64_t table = s->robots[TABLE][i], count = s->clock->table_slots, in_line = -(int64_t)(table == 0);
    const int64_t behind = LINE * s->padded + (table - 1) * count;
    return (struct slots){(LINE * i & in_line) | (behind & ~in_line), (LINE & in_line) | (count & ~in_line)};
}

/* Return which of 8 labels from `at` on have a number, as bits 0 to 7, and which are free, as the next 8 bits. With
 * AVX-512 a vector has 8 labels more, which belong to others. */
ALWAYS uint32_t same_or_free(const int32_t *at, int32_t sender)
{
    uint32_t same = 0, empty = 0;
    UNROLL for (int k = 0; k < LINE; k += LANES) {
        const u32 labels = vector_at(at + k);
        same |= equal((u32)((i32)labels >> 2), spread((uint32_t)sender)) << k;
        empty |= signs(labels) << k;
    }
    return (same & 0xFF) | (empty & 0xFF) << LINE;
}

/* Return the slot of a sender, or the free one that it would take: it is looked for in the eight slots that its hash
 * chooses, and then in the next eight. */
ALWAYS int64_t find_slot(const int32_t *senders, struct slots slots, int32_t sender)
{
    const uint32_t hashed = (uint32_t)sender * 0x9E3779B1u >> 8; /* Knuth's multiplicative hash */
    int64_t place = hashed & (slots.count - LINE);
    uint32_t found = same_or_free(senders + slots.first + place, sender);
    while (RARELY(found == 0)) { /* all are taken by others */
        place = (place + LINE) & (slots.count - 1);
        found = same_or_free(senders + slots.first + place, sender);
    }
    return slots.first + place + (lowest(found) & (LINE - 1));
}

/* Move an inbox from its line to a table; return whether there was one.
 *
 * If not, or if the inbox has a table already, the caller plays this run again with more room. */
APART bool take_table(struct state *s, struct part *part, int64_t i)
{
    int32_t *free_tables = part->free_tables;
    if (s->robots[TABLE][i] > 0 || free_tables[0] == 0) {
        __atomic_store_n(&s->clock->full, s->robots[TABLE][i] > 0 ? SLOTS_LACK : TABLES_LACK, __ATOMIC_RELAXED);
        return false;
    }
    s->robots[TABLE][i] = free_tables[free_tables[0]--];
    const struct slots slots = slots_of(s, i);
    for (int64_t old = LINE * i; old < LINE * i + LINE; old++) {
        const int32_t message = s->inbox[SENDER][old];
        if (message < 0)
            continue;
        const int64_t place = find_slot(s->inbox[SENDER], slots, sender_in(message));
        s->inbox[SENDER][place] = message;
        if (s->params->strategy.value_scale > 0.0)
            s->inbox[VALUE][place] = s->inbox[VALUE][old];
        if (s->params->decision.inbox_size > 0)
            s->inbox[WHEN][place] = s->inbox[WHEN][old];
        s->inbox[SENDER][old] = -1;
    }
    return true;
}

/* Keep a sender's label in a robot's inbox; return its slot, or -1 if there is no room for it. */
ALWAYS int64_t keep_label(struct state *s, struct part *part, int64_t i, int32_t message)
{
    int64_t *votes = s->counts[VOTES] + i, *feasible = s->counts[FEASIBLE_VOTES] + i;
    int32_t *senders = s->inbox[SENDER];
    struct slots slots = slots_of(s, i);
    int64_t place = find_slot(senders, slots, sender_in(message));
    const int32_t known = senders[place];
    if (known < 0) {
        if (RARELY(4 * *votes >= 3 * slots.count)) { /* nearly full */
            if (!take_table(s, part, i))
                return -1;
            place = find_slot(senders, slots_of(s, i), sender_in(message));
        }
        *votes += 1;
        *feasible += feasible_in(message);
    } else if (known != message)
        *feasible += feasible_in(message) - feasible_in(known);
    else /* most say the same again */
        return place;
    senders[place] = message;
    return place;
}

/* Add a message, the sender's label and value, to a robot's inbox. */
ALWAYS void receive(struct state *s, struct part *part, int64_t i, int32_t message, int32_t value)
{
    if (s->params->decision.every_message) {
        s->counts[VOTES][i]++;
        s->counts[FEASIBLE_VOTES][i] += feasible_in(message);
        return;
    }
    const int64_t place = keep_label(s, part, i, message);
    if (place >= 0 && s->params->strategy.value_scale > 0.0)
        s->inbox[VALUE][place] = value;
    if (place >= 0 && s->params->decision.inbox_size > 0)
        s->inbox[WHEN][place] = s->robots[MESSAGES][i]++;
}

/* --- Emptying --- */

/* Clear a robot's inbox, which then has no table. */
static inline void clear_inbox(struct state *s, int64_t i)
{
    if (s->params->decision.inbox_is_set)
        for (int64_t other = 0; other < s->words; other++)
            s->links[HEARD][other * s->padded + i] = s->links[HEARD_FEASIBLE][other * s->padded + i] = 0;
    else if (!s->params->decision.every_message) {
        const struct slots slots = slots_of(s, i);
        memset(s->inbox[SENDER] + slots.first, 0xFF, sizeof(int32_t) * (size_t)slots.count);
        s->robots[TABLE][i] = s->robots[MESSAGES][i] = 0;
    }
    s->counts[VOTES][i] = s->counts[FEASIBLE_VOTES][i] = 0;
}

/* Empty a robot's inbox (model.md 4.6); its table is free again for a thread. */
static inline void empty_inbox(struct state *s, struct part *part, int64_t i)
{
    const int32_t table = s->robots[TABLE][i];
    if (s->counts[VOTES][i] > 0 || s->params->decision.inbox_is_set)
        clear_inbox(s, i);
    if (table > 0)
        part->free_tables[++part->free_tables[0]] = table;
}

/* Give each thread its share of the tables, none of which is in use. */
static inline void free_all_tables(struct state *s)
{
    const bool none = s->params->decision.inbox_is_set;
    const int64_t tables = none ? 0 : (s->slots - LINE * s->padded) / s->clock->table_slots;
    for (int64_t thread = 0; thread < s->threads; thread++) {
        int32_t *free_tables = s->parts[thread].free_tables;
        free_tables[0] = 0;
        for (int64_t table = thread + 1; table <= tables; table += s->threads)
            free_tables[++free_tables[0]] = (int32_t)table;
    }
}

/* --- Reading --- */

/* What `decide` needs of an inbox: the votes for feasible, all votes, the opinion and value of a message drawn at
 * random, and the sum of all values. */
struct heard_votes {
    int64_t feasible, votes, opinion, value, total;
};

/* Draw a message by a word: the messages for feasible come first, each group by its senders. Set its opinion; return
 * its place among those of this opinion. */
ALWAYS int64_t draw_message(struct heard_votes *read, uint32_t word)
{
    const int64_t drawn = choose(word, read->votes);
    read->opinion = read->votes == 0 ? NO_OPINION : drawn < read->feasible ? FEASIBLE : INFEASIBLE;
    return read->opinion == INFEASIBLE ? drawn - read->feasible : drawn;
}

static inline struct heard_votes read_set(const struct state *s, int64_t i, uint32_t word)
{
    struct heard_votes read = {0, 0, NO_OPINION, 0, 0};
    const uint32_t *heard = s->links[HEARD] + i, *feasible = s->links[HEARD_FEASIBLE] + i;
    for (int64_t other = 0; other < s->words; other++) {
        read.votes += members(heard[other * s->padded]);
        read.feasible += members(feasible[other * s->padded]);
    }
    int64_t drawn = draw_message(&read, word);
    for (int64_t other = 0; other < s->words && s->params->strategy.value_scale > 0.0; other++)
        for (uint32_t left = heard[other * s->padded]; left; left = without_lowest(left)) {
            const int64_t j = lowest_member(other, left), held = s->inbox[VALUE][s->padded * i + j];
            read.total += held;
            if (has_bit(feasible[other * s->padded], j) == (read.opinion == FEASIBLE) && drawn-- == 0)
                read.value = held;
        }
    return read;
}

/* Slots of an inbox, of which messages count from the oldest one kept on. */
struct kept {
    struct slots slots;
    int64_t oldest;
};

ALWAYS bool keeps(const struct state *s, const struct kept *kept, int64_t place)
{
    const bool limited = s->params->decision.inbox_size > 0;
    return s->inbox[SENDER][place] >= 0 && (!limited || s->inbox[WHEN][place] >= kept->oldest);
}

/* Return the number of kept messages with an opinion and a sender below `senders`. */
static inline int64_t count_kept(const struct state *s, const struct kept *kept, int64_t opinion, int64_t senders)
{
    int64_t number = 0;
    for (int64_t place = kept->slots.first; place < kept->slots.first + kept->slots.count; place++) {
        const int32_t message = s->inbox[SENDER][place];
        number += keeps(s, kept, place) && feasible_in(message) == opinion && sender_in(message) < senders;
    }
    return number;
}

/* Return the number of the oldest message that an inbox of limited size keeps. */
static inline int64_t oldest_kept(const struct state *s, int64_t i, struct slots slots)
{
    int64_t low = 0, high = s->robots[MESSAGES][i];
    while (high - low > 1) {
        const int64_t middle = (low + high) / 2;
        const struct kept kept = {slots, middle};
        int64_t since = 0;
        for (int64_t place = slots.first; place < slots.first + slots.count; place++)
            since += keeps(s, &kept, place);
        *(since >= s->params->decision.inbox_size ? &low : &high) = middle;
    }
    return low;
}

/* Read an inbox whose running counts do not suffice: it keeps the newest only, or has values. */
APART struct heard_votes read_slots(const struct state *s, int64_t i, uint32_t word)
{
    struct heard_votes read = {s->counts[FEASIBLE_VOTES][i], s->counts[VOTES][i], NO_OPINION, 0, 0};
    struct kept kept = {slots_of(s, i), 0};
    const int64_t size = s->params->decision.inbox_size;
    if (0 < size && size < read.votes) {
        kept.oldest = oldest_kept(s, i, kept.slots);
        read.votes = size;
        read.feasible = count_kept(s, &kept, FEASIBLE, s->params->robots.count);
    }
    const int64_t drawn = draw_message(&read, word);
    if (s->params->strategy.value_scale <= 0.0 || read.votes == 0)
        return read;
    int64_t low = 0, high = s->params->robots.count - 1;
    while (low < high) { /* find the least sender up to which more than `drawn` messages have this opinion */
        const int64_t middle = (low + high) / 2;
        if (count_kept(s, &kept, read.opinion, middle + 1) > drawn)
            high = middle;
        else
            low = middle + 1;
    }
    for (int64_t place = kept.slots.first; place < kept.slots.first + kept.slots.count; place++)
        if (keeps(s, &kept, place)) {
            read.total += s->inbox[VALUE][place];
            if (sender_in(s->inbox[SENDER][place]) == low)
                read.value = s->inbox[VALUE][place];
        }
    return read;
}

static inline struct heard_votes read_inbox(const struct state *s, int64_t i, uint32_t word)
{
    if (s->params->decision.inbox_is_set && !s->params->decision.every_message)
        return read_set(s, i, word);
    if (s->params->decision.inbox_size > 0 || s->params->strategy.value_scale > 0.0)
        return read_slots(s, i, word);
    struct heard_votes read = {s->counts[FEASIBLE_VOTES][i], s->counts[VOTES][i], NO_OPINION, 0, 0};
    draw_message(&read, word);
    return read;
}

#endif

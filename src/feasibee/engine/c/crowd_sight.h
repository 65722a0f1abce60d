/* What the robots of a crowd see and hear (model.md 4.2, 4.5). */

#ifndef CROWD_SIGHT_H
#define CROWD_SIGHT_H

#include "crowd_state.h"

/* What a thread looks for, and where: copies, which no store can change. */
struct lens {
    struct cells cells;
    struct rows rows;
    struct reach sight, radio;
};

/* Points that a robot sees, those whose messages it hears, and those of them that are for feasible. */
struct found {
    uint32_t seen, heard, said;
};

/* What a vector of points is for a robot, whether or not they belong to its block. */
struct looked {
    uint32_t seen, close, loud, said;
    u32 doubtful;
};

ALWAYS struct lens lens_of(const struct crowd *s)
{
    return (struct lens){s->robots, s->rows, s->sight, s->radio};
}

ALWAYS struct looked look_at(const struct lens *lens, int32_t first, u32 here, u32 itself,
                             const bool as_sight, const bool every)
{
    const u32 square = squared(subtract_halves(vector_at(lens->cells.places + first), here));
    const u32 labels = vector_at(lens->cells.labels + first), beyond = square - lens->sight.band.low;
    struct looked looked = {.seen = signs_apart(beyond), .doubtful = (u32)(beyond < lens->sight.band.width)};
    looked.close = looked.seen;
    if (!as_sight) {
        const u32 far = square - lens->radio.band.low;
        looked.close = signs_apart(far);
        looked.doubtful |= (u32)(far < lens->radio.band.width);
    }
    looked.loud = signs_apart(labels << 31 & ~(u32)(labels == itself));
    looked.said = every ? signs_apart(labels << (31 - MESSAGE_BITS)) : 0;
    return looked;
}

/* Find the points of a group from `first` on, exactly where places leave them in doubt. */
ALWAYS struct found find(const struct lens *lens, int32_t first, int32_t last, uint32_t i,
                         const bool as_sight, const bool every)
{
    const uint32_t x = lens->rows.x[i], y = lens->rows.y[i], valid = first_bits(last - first);
    const u32 here = spread(place_at(&lens->cells, x, y)), itself = spread(lens->rows.labels[i]);
    uint32_t seen = 0, close = 0, loud = 0, said = 0, doubtful = 0;
    UNROLL for (int k = 0; k < VECTORS; k++) {
        const struct looked looked = look_at(lens, first + k * LANES, here, itself, as_sight, every);
        seen |= looked.seen << k * LANES;
        close |= looked.close << k * LANES;
        loud |= looked.loud << k * LANES;
        said |= looked.said << k * LANES;
        doubtful |= signs(looked.doubtful) << k * LANES;
    }
    if (RARELY((doubtful & valid) != 0)) {
        seen = near_exactly(&lens->cells, lens->sight.limit, first, last, x, y);
        close = as_sight ? seen : near_exactly(&lens->cells, lens->radio.limit, first, last, x, y);
    }
    const uint32_t heard = close & loud & valid;
    return (struct found){seen & valid, heard, heard & said};
}

APART struct found find_doubtful(const struct crowd *s, struct block block, uint32_t i, bool as_sight)
{
    const struct lens lens = lens_of(s);
    const struct found one = find(&lens, block.one.first, block.one.last, i, as_sight, true);
    const struct found other = find(&lens, block.other.first, block.other.last, i, as_sight, true);
    return (struct found){one.seen | other.seen << GROUP, one.heard | other.heard << GROUP,
                          one.said | other.said << GROUP};
}

/* Find the points of a block whose stretches are no longer than a group. */
ALWAYS struct found find_both(const struct crowd *s, const struct lens *lens, struct block block,
                              uint32_t place, uint32_t i, const bool as_sight, const bool every)
{
    const u32 here = spread(place), itself = spread(lens->rows.labels[i]);
    const uint32_t valid = bits_up_to(length_of(block.one)) | bits_up_to(length_of(block.other)) << GROUP;
    uint32_t seen = 0, close = 0, loud = 0, said = 0;
    u32 doubtful = {0};
    UNROLL for (int k = 0; k < 2 * VECTORS; k++) {
        const int32_t first = k < VECTORS ? block.one.first + k * LANES
                                          : block.other.first + (k - VECTORS) * LANES;
        const struct looked looked = look_at(lens, first, here, itself, as_sight, every);
        seen |= looked.seen << k * LANES;
        close |= looked.close << k * LANES;
        loud |= looked.loud << k * LANES;
        said |= looked.said << k * LANES;
        doubtful |= looked.doubtful;
    }
    if (RARELY(signs(doubtful) != 0))
        return find_doubtful(s, block, i, as_sight);
    const uint32_t heard = close & loud & valid;
    return (struct found){seen & valid, heard, heard & said};
}

/* Keep a message that doesn't fit in the line of an inbox. */
APART void keep_in_table(struct crowd *s, struct worker *own, uint32_t i, uint32_t message, uint32_t value)
{
    struct tally *tally = &s->tallies[i];
    const uint32_t *values = s->values ? s->values + (size_t)LINE * i : NULL;
    struct table *table = table_of(&own->tables, &s->lines[i], values, tally->votes);
    if (!table) {
        own->lacks_memory = true;
        return;
    }
    const uint32_t slot = slot_of(table, message), known = table->messages[slot];
    tally->feasible_votes += (message & 1) - (known == NOBODY ? 0 : known & 1);
    tally->votes += known == NOBODY;
    table->messages[slot] = message;
    if (own->tables.values)
        table->messages[table->slots + slot] = value;
}

/* Let robots receive the queued messages. */
ALWAYS void receive(struct crowd *s, struct worker *own, const bool values)
{
    for (uint32_t q = 0; q < own->queued; q++) {
        const uint32_t i = own->receivers[q], message = own->messages[q];
        const uint32_t value = values ? s->sent[sender_of(message)] : 0;
        struct tally *tally = &s->tallies[i];
        uint32_t *line = s->lines[i].messages, same = 0;
        UNROLL for (int k = 0; k < VECTORS; k++)
            same |= equal(vector_at(line + k * LANES) | 1, spread(message | 1)) << k * LANES;
        same &= first_bits((int)tally->votes);
        if (RARELY(tally->votes >= LINE + (same != 0))) {
            keep_in_table(s, own, i, message, value);
            continue;
        }
        const uint32_t k = same ? (uint32_t)lowest(same) : tally->votes;
        tally->feasible_votes += (message & 1) - (same ? line[k] & 1 : 0);
        tally->votes += same == 0;
        line[k] = message;
        if (values)
            s->values[(size_t)LINE * i + k] = value;
    }
    own->queued = 0;
}

APART void receive_messages(struct crowd *s, struct worker *own) { receive(s, own, false); }
APART void receive_values(struct crowd *s, struct worker *own) { receive(s, own, true); }

static void receive_queued(struct crowd *s, struct worker *own)
{
    if (s->values)
        receive_values(s, own);
    else
        receive_messages(s, own);
}

/* Queue the messages that a robot hears from the points of a group, or count them. */
ALWAYS void hear(struct crowd *s, struct worker *own, const struct lens *lens, uint32_t i, int32_t first,
                 struct found found)
{
    if (s->params.decision.every_message) {
        s->tallies[i].votes += (uint32_t)members(found.heard);
        s->tallies[i].feasible_votes += (uint32_t)members(found.said);
        return;
    }
    for (uint32_t left = found.heard; left; left &= left - 1) {
        own->receivers[own->queued] = i;
        own->messages[own->queued++] = lens->cells.labels[first + lowest(left)] >> MESSAGE_BITS;
    }
    if (own->queued > QUEUE)
        receive_queued(s, own);
}

/* Look and listen along one stretch of a robot's block, whatever its length; return how many are seen. */
APART uint32_t look_along(struct crowd *s, struct worker *own, struct stretch stretch, uint32_t i,
                          bool listens, bool as_sight)
{
    const struct lens lens = lens_of(s);
    uint32_t seen = 0;
    for (int32_t first = stretch.first; first < stretch.last; first += GROUP) {
        const struct found found = find(&lens, first, stretch.last, i, as_sight, true);
        seen += (uint32_t)members(found.seen);
        if (listens)
            hear(s, own, &lens, i, first, found);
    }
    return seen;
}

/* Return the message at a bit of both groups of a block. */
ALWAYS uint32_t message_at(const struct lens *lens, struct block block, int k)
{
    const int32_t across = (block.other.first - GROUP - block.one.first) & -(k / GROUP);
    return lens->cells.labels[block.one.first + k + across] >> MESSAGE_BITS;
}

#define AHEAD 8 /* robots whose inboxes the processor fetches meanwhile: see `fetch` in crowd.c */

/* Queue the messages that a robot hears from a block; return how many are queued.
 *
 * The first is queued without a branch, since most robots hear none or one. */
ALWAYS uint32_t queue(const struct crowd *s, struct worker *own, uint32_t queued, const struct lens *lens,
                      struct block block, uint32_t i, uint32_t heard)
{
    /* A number, for no pointer may go beyond an array, as the last robots' would. */
    __builtin_prefetch((const void *)((uintptr_t)(s->lines + i) + AHEAD * sizeof *s->lines), 1);
    own->receivers[queued] = i;
    own->messages[queued] = message_at(lens, block, lowest(heard | bit(2 * GROUP - 1)));
    queued += heard != 0;
    for (heard &= heard - 1; RARELY(heard != 0); heard &= heard - 1) {
        own->receivers[queued] = i;
        own->messages[queued++] = message_at(lens, block, lowest(heard));
    }
    return queued;
}

/* Let robots from `first` on look for robots and listen. Masks take the place of branches, which half of the
 * robots would take. */
ALWAYS void look(const struct job *job, struct crowd *s, struct worker *own, uint32_t first, uint32_t last,
                 const bool as_sight, const bool every)
{
    const struct lens lens = lens_of(s);
    struct tally *tallies = s->tallies;
    const uint32_t always = s->params.decision.listens_for < 0 ? UINT32_MAX : 0;
    const uint32_t but = 1 - (uint32_t)s->params.sensing.count_self;
    uint32_t queued = 0;
    find_blocks(&lens.cells, &own->blocks, lens.rows.x + first, lens.rows.y + first, last - first);
    for (uint32_t i = first; i < last; i++) {
        const uint32_t disseminates = -(lens.rows.labels[i] / DISSEMINATES & 1);
        const uint32_t listens = always | disseminates;
        const struct block block = block_of(&lens.cells, &own->blocks, i - first);
        uint32_t seen;
        if (RARELY(is_long(block.one) || is_long(block.other))) {
            if (is_cancelled(job->control))
                break;
            own->queued = queued;
            seen = look_along(s, own, block.one, i, listens, as_sight);
            seen += look_along(s, own, block.other, i, listens, as_sight);
            queued = own->queued;
        } else {
            const struct found found = find_both(s, &lens, block, own->blocks.places[i - first], i, as_sight,
                                                 every);
            seen = (uint32_t)members(found.seen);
            if (every) {
                tallies[i].votes += (uint32_t)members(found.heard & listens);
                tallies[i].feasible_votes += (uint32_t)members(found.said & listens);
            } else
                queued = queue(s, own, queued, &lens, block, i, found.heard & listens);
        }
        tallies[i].robots += (seen - but) & ~disseminates;
        if (RARELY(queued > QUEUE)) {
            own->queued = queued;
            receive_queued(s, own);
            queued = 0;
        }
    }
    own->queued = queued;
}

#define LOOK(name, as_sight, every)                                                                    \
    APART void look_##name(const struct job *job, struct crowd *s, struct worker *own, uint32_t first, \
                           uint32_t last)                                                              \
    {                                                                                                  \
        look(job, s, own, first, last, as_sight, every);                                               \
    }
LOOK(latest, true, false)
LOOK(every, true, true)
LOOK(latest_apart, false, false)
LOOK(every_apart, false, true)

static void look_around(const struct job *job, struct crowd *s, struct worker *own, uint32_t first,
                        uint32_t last)
{
    const bool every = s->params.decision.every_message;
    if (s->sight.limit == s->radio.limit)
        (every ? look_every : look_latest)(job, s, own, first, last);
    else
        (every ? look_every_apart : look_latest_apart)(job, s, own, first, last);
    receive_queued(s, own);
}

/* Count the tasks in sight of those robots of a chunk that explore. */
APART void count_tasks(struct crowd *s, struct worker *own, uint32_t first, uint32_t last)
{
    const struct cells cells = s->tasks;
    const struct reach reach = s->tasks_in_sight;
    const struct rows rows = s->rows;
    uint32_t listed[CHUNK + 1], count = 0;
    for (uint32_t i = first; i < last; i++) { /* without branches, which half of the robots would take */
        listed[count] = i;
        count += !(rows.labels[i] & DISSEMINATES);
    }
    find_blocks(&cells, &own->blocks, rows.x + first, rows.y + first, last - first);
    for (uint32_t k = 0; k < count; k++) {
        const uint32_t i = listed[k], place = own->blocks.places[i - first];
        const struct block block = block_of(&cells, &own->blocks, i - first);
        s->tallies[i].tasks += count_near(&cells, reach, block, place, rows.x[i], rows.y[i]);
    }
}

#endif

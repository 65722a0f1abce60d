/* Inboxes of a crowd, which keep the latest message of each robot heard (model.md 4.5).
 *
 * Each robot has a line of eight messages, in which most inboxes fit: filled in order, and compared at once.
 * An inbox that outgrows it moves to a hash table, which doubles when it is nearly full. Each thread has
 * memory for tables, which it takes in slabs and gives back when the run ends. */

#ifndef INBOX_H
#define INBOX_H

#include <stdlib.h>

#include "cells.h"

#define LINE 8
#define LEAST_SLOTS 32u
#define CLASSES 24 /* sizes of tables: from LEAST_SLOTS on, each twice the one before */
#define SLAB ((size_t)1 << 16)
#define NOBODY UINT32_MAX /* a free slot of a table */

/* A message is the number of its sender, and as the lowest bit whether it is for feasible. */
ALWAYS uint32_t sender_of(uint32_t message) { return message >> 1; }

struct table {
    struct table *next;  /* of the free ones */
    uint32_t size;       /* class */
    uint32_t slots;      /* a power of two */
    uint32_t messages[]; /* and as many values, if messages have any */
};

/* What each robot has of its inbox: the messages, or the table that they have moved to. */
union line {
    uint32_t messages[LINE];
    struct table *table;
};

struct slab {
    struct slab *before;
};

/* The memory of a thread for tables. Tables of other threads may be among the free ones. */
struct tables {
    struct table *free[CLASSES];
    struct slab *last;
    char *begin, *end; /* of what is left of the last slab */
    bool values;       /* whether tables have room for values */
};

static inline void clear_arena(struct tables *tables)
{
    while (tables->last) {
        struct slab *last = tables->last;
        tables->last = last->before;
        free(last);
    }
    *tables = (struct tables){.values = tables->values};
}

/* Take memory from a slab, a new one if need be; return NULL without memory. */
static inline void *carve(struct tables *tables, size_t size)
{
    size = (size + sizeof(struct slab) - 1) / sizeof(struct slab) * sizeof(struct slab);
    if ((size_t)(tables->end - tables->begin) < size) {
        const size_t whole = (size > SLAB ? size : SLAB) + sizeof(struct slab);
        struct slab *slab = malloc(whole);
        if (!slab)
            return NULL;
        slab->before = tables->last;
        tables->last = slab;
        tables->begin = (char *)(slab + 1);
        tables->end = (char *)slab + whole;
    }
    void *taken = tables->begin;
    tables->begin += size;
    return taken;
}

/* Return an empty table of a class, NULL without memory. */
static inline struct table *take_table(struct tables *tables, uint32_t size)
{
    const size_t slots = (size_t)LEAST_SLOTS << size;
    struct table *table = tables->free[size];
    if (table)
        tables->free[size] = table->next;
    else
        table = carve(tables, sizeof *table + (tables->values ? 2 : 1) * slots * sizeof *table->messages);
    if (table) {
        table->size = size;
        table->slots = (uint32_t)slots;
        memset(table->messages, 0xFF, slots * sizeof *table->messages);
    }
    return table;
}

ALWAYS void give_table(struct tables *tables, struct table *table)
{
    table->next = tables->free[table->size];
    tables->free[table->size] = table;
}

/* Return the slot of a sender, or the free one that it would take: it is looked for in a group of slots that
 * its hash chooses, and then in the next ones. */
ALWAYS uint32_t slot_of(const struct table *table, uint32_t message)
{
    const u32 wanted = spread(message | 1);
    uint32_t slot = (sender_of(message) * 0x9E3779B1u >> 8) &
                    (table->slots - GROUP); /* Knuth's multiplicative hash */
    for (;; slot = (slot + GROUP) & (table->slots - 1)) {
        uint32_t found = 0, empty = 0;
        UNROLL for (int k = 0; k < VECTORS; k++) {
            u32 messages = vector_at(table->messages + slot + k * LANES);
            found |= equal(messages | 1, wanted) << k * LANES;
            empty |= equal(messages, spread(NOBODY)) << k * LANES;
        }
        if (LIKELY((found | empty) != 0))
            return slot + (uint32_t)lowest(found ? found : empty);
    }
}

/* Copy messages from a line or a smaller table to a new table; return NULL without memory. */
APART struct table *moved(struct tables *tables, const uint32_t *messages, const uint32_t *values,
                          uint32_t count, uint32_t size)
{
    struct table *table = take_table(tables, size);
    for (uint32_t k = 0; table && k < count; k++)
        if (messages[k] != NOBODY) {
            const uint32_t slot = slot_of(table, messages[k]);
            table->messages[slot] = messages[k];
            if (tables->values)
                table->messages[table->slots + slot] = values[k];
        }
    return table;
}

/* Return the table of an inbox that has more messages than fit in a line, or is about to; with room for one
 * more. */
ALWAYS struct table *table_of(struct tables *tables, union line *line, const uint32_t *values, uint32_t votes)
{
    if (votes == LINE) {
        struct table *table = moved(tables, line->messages, values, LINE, 0);
        if (table)
            line->table = table;
        return table;
    }
    struct table *old = line->table;
    if (LIKELY(4 * (uint64_t)votes < 3 * (uint64_t)old->slots))
        return old;
    struct table *table = moved(tables, old->messages, old->messages + old->slots, old->slots, old->size + 1);
    if (table) {
        give_table(tables, old);
        line->table = table;
    }
    return table;
}

#endif

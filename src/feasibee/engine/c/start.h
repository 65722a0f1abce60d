/* How a run begins: who has which id, where all are, and who is faulty (model.md 1, 6.5, 6.6). */

#ifndef START_H
#define START_H

#include "acting.h"
#include "dynamics.h"

/* Find for each robot the first that has the same id, by a hash table in the room of the counts. */
static void find_equal_ids(struct state *s)
{
    int32_t *ids = s->robots[ORDER];
    int64_t *table = s->counts[0]; /* each entry is one more than a robot; the rows follow each other */
    const int64_t size = 4 * s->padded;
    memset(table, 0, (size_t)size * sizeof *table);
    for (int64_t i = 0; i < s->params->robots.count; i++) {
        const uint32_t id = draw(s, i, 0, IDENTITY_HASH) >> (32 - s->params->radio.id_bits);
        int64_t place = id * 0x9E3779B1u % size;
        ids[i] = (int32_t)id;
        while (table[place] > 0 && ids[table[place] - 1] != ids[i])
            place = (place + 1) % size;
        if (table[place] == 0)
            table[place] = i + 1;
        s->robots[IDENTITY][i] = (int32_t)(table[place] - 1);
    }
}

/* Give robots their ids, and robots, tasks and inventions their hashes, if robots pass on knowledge. */
static void assign_identities(struct state *s)
{
    const struct params *p = s->params;
    const struct knowledge *knowledge = &p->strategy.knowledge;
    const int64_t things = knowledge->enabled ? knowledge->robot_ids + knowledge->task_ids : 0;
    for (int64_t i = 0; i < p->robots.count; i++)
        s->robots[IDENTITY][i] = (int32_t)i;
    if (p->radio.random_ids)
        find_equal_ids(s);
    for (int64_t thing = 0; thing < things; thing++) {
        const int64_t holder = thing < p->robots.count ? s->robots[IDENTITY][thing] : thing;
        s->hashes[thing] = draw_words(s, holder, 0, IDENTITY_HASH).word[1];
    }
}

/* Draw the faulty robots: the first of a shuffle stop, the next lie, the next are stubborn. */
static void draw_faults(struct state *s)
{
    const struct fault *faults = &s->params->faults;
    const int64_t lying = faults->stopped, stubborn = lying + faults->byzantine, last = stubborn + faults->stubborn;
    const int32_t *order = s->robots[ORDER];
    if (last == 0)
        return;
    shuffle(s, s->robots[ORDER], s->params->robots.at_start, FAULT);
    for (int64_t k = 0; k < last; k++) {
        put_in(s->sets[k < lying ? STOPPING : k < stubborn ? BYZANTINE : STUBBORN], order[k], true);
        if (lying <= k && k < stubborn)
            put_in(s->sets[COUNTED], order[k], false);
    }
}

/* Give robots in their places a first opinion, heading and phase (model.md 2.1, 4.1). */
static void prepare_robots(struct state *s)
{
    const int64_t robots = s->params->robots.at_start;
    int32_t *who = s->parts[0].who;
    sort_tasks(s);
    for (int64_t i = 0; i < s->padded; i++) {
        s->robots[LABEL][i] = label(i, false, false);
        s->robots[WALKS][i] = s->robots[PHASES][i] = s->robots[JOINED][i] = 0;
    }
    for (int64_t i = 0; i < robots; i++)
        who[i] = (int32_t)i;
    take_headings(s, who, robots);
    for (int64_t i = 0; i < robots; i++)
        prepare_robot(s, i);
    for (int64_t i = robots; i < s->padded; i++) {
        stand_still(s, i);
        clear_inbox(s, i); /* one that had joined in the run before may have had a table */
    }
    free_all_tables(s);
}

ALWAYS void clear_sets(struct state *s)
{
    const int64_t robots = s->params->robots.at_start, tasks = s->params->tasks.at_start;
    for (int64_t w = 0; w < s->words; w++) {
        for (int kind = 0; kind < SETS; kind++)
            s->sets[kind][w] = 0;
        const uint32_t there = first_bits((int)(robots - WORD * w));
        s->sets[THERE][w] = s->sets[WORKING][w] = s->sets[COUNTED][w] = there;
        s->sets[JOINING][w] = s->sets[PRESENT][w] = there;
    }
    for (int64_t w = 0; w < s->task_words; w++)
        s->tasks_there[w] = first_bits((int)(tasks - WORD * w));
}

/* Clear what the previous run left. */
static void clear_run(struct state *s, int64_t run)
{
    const struct params *p = s->params;
    struct clock *clock = s->clock;
    *s->account = (struct account){.declare_step = -1, .first_taken_step = -1, .all_taken_step = -1};
    s->account->all_done_step = -1;
    clock->run = run;
    clock->step = clock->full = clock->pending = 0;
    clock->robots = p->robots.at_start;
    clock->tasks = p->tasks.at_start;
    clock->miss = (int64_t)p->sensing.miss;
    clock->loss = (int64_t)p->radio.loss;
    clock->truth = p->truth;
    clear_sets(s);
    for (int64_t i = 0; i < s->padded; i++)
        drop_delayed(s, i);
    set_inventions(s);
    set_quorum(s, p->robots.at_start - p->faults.byzantine);
}

/* Put the swarm of a run at step 0 (model.md 6). */
static void start_run(struct state *s, int64_t run)
{
    const struct params *p = s->params;
    clear_run(s, run);
    assign_identities(s);
    for (int64_t i = 0; i < p->tasks.at_start; i++)
        place_task(s, i);
    place_robots(s);
    draw_faults(s);
    prepare_robots(s);
    if (p->sensing.unique)
        memset(s->remembered, 0, (size_t)(s->padded * s->remembered_words) * sizeof *s->remembered);
    if (p->faults.stop_step == 0) {
        for (int64_t w = 0; w < s->words; w++)
            stop_word(s, w);
        set_quorum(s, p->robots.at_start - p->faults.byzantine - p->faults.stopped);
    }
    if (p->acting.acts)
        start_acting(s);
    if (p->changes)
        draw_dynamics(s);
}

#endif

/* Where the arrays of a swarm lie in its block of memory: see state.h. */

#include "draws.h"
#include "queue.h"
#include "team.h"

#define PIECE 64   /* bytes: arrays begin at multiples, so that no vector lies in two lines of the cache */
#define SPREAD 160 /* entries by which queues are longer than a power of two: rows 4 KiB apart hinder each other */
#define NOBODY 255 /* in all bytes of a number that is -1 */

/* A block of memory of which the first bytes are taken; without memory they are only counted. */
struct block {
    char *memory;
    int64_t taken;
};

static void *take(struct block *block, int64_t count, size_t size)
{
    char *array = block->memory ? block->memory + block->taken : NULL;
    block->taken += (count * (int64_t)size + PIECE - 1) / PIECE * PIECE;
    return array;
}

static int64_t pieces(int64_t count) { return (count + WORD - 1) / WORD; }

static int64_t larger(int64_t one, int64_t other) { return one > other ? one : other; }

static void set_lengths(struct state *s, struct room room)
{
    const struct params *p = s->params;
    const struct knowledge *knowledge = &p->strategy.knowledge;
    s->words = pieces(p->robots.count);
    s->padded = s->words * WORD;
    s->task_words = pieces(p->tasks.count);
    s->remembered_words = s->words + s->task_words;
    s->copy_words = larger(knowledge->words, knowledge->message_words);
    s->delayed_length = TOLD + knowledge->message_words;
    s->slots = p->decision.inbox_is_set ? s->padded * s->padded : s->padded * LINE + room.tables * room.slots;
}

/* Rows of robots are padded, so each begins where the one before it ends. */
static void lay_robots(struct state *s, struct block *block)
{
    const struct params *p = s->params;
    const bool classes = p->sensing.by_class || p->strategy.knowledge.enabled;
    uint32_t *sets = take(block, SETS * s->words, sizeof *sets);
    for (int row = 0; row < ROBOT_ROWS; row++)
        s->robots[row] = take(block, s->padded, sizeof(int32_t));
    for (int row = 0; row < SETS; row++)
        s->sets[row] = sets ? sets + row * s->words : NULL;
    for (int row = 0; row < COUNTS; row++)
        s->counts[row] = take(block, s->padded, sizeof(int64_t));
    for (int row = 0; row < LINKS; row++)
        s->links[row] = p->together ? take(block, s->words * s->padded, sizeof(uint32_t)) : NULL;
    s->seen = classes ? take(block, s->padded * s->tables.classes, sizeof *s->seen) : NULL;
    s->remembered = p->sensing.unique ? take(block, s->padded * s->remembered_words, sizeof *s->remembered) : NULL;
    s->heading_pools = p->together ? take(block, s->padded, sizeof(struct heading_pool)) : NULL;
    s->phase_pools = p->together ? take(block, s->padded, sizeof(struct phase_pool)) : NULL;
    s->quality = take(block, s->padded, sizeof *s->quality);
    s->memory = take(block, s->padded * s->memory_length, sizeof *s->memory);
}

/* What robots hear and know, or have said. */
static void lay_messages(struct state *s, struct block *block)
{
    const struct params *p = s->params;
    const struct knowledge *knowledge = &p->strategy.knowledge;
    const int64_t delay = p->radio.delay, things = knowledge->robot_ids + knowledge->task_ids;
    const bool lines = !p->decision.inbox_is_set, values = p->strategy.value_scale > 0.0;
    int32_t **pending[] = {&s->pending_who, &s->pending_number, &s->pending_column, &s->pending_mark};
    s->inbox[SENDER] = lines ? take(block, s->slots + WORD, sizeof(int32_t)) : NULL; /* vectors read beyond them */
    s->inbox[VALUE] = values ? take(block, s->slots, sizeof(int32_t)) : NULL;
    s->inbox[WHEN] = lines && p->decision.inbox_size > 0 ? take(block, s->slots, sizeof(int32_t)) : NULL;
    for (int copy = 0; copy < COPIES; copy++)
        s->knowledge[copy] = take(block, s->padded * s->copy_words, sizeof(int32_t));
    s->delayed = delay > 0 ? take(block, (delay + 1) * s->padded * s->delayed_length, sizeof *s->delayed) : NULL;
    for (int row = 0; row < 4; row++)
        *pending[row] = knowledge->enabled ? take(block, PENDING_ROOM, sizeof(int32_t)) : NULL;
    s->hashes = knowledge->enabled ? take(block, things, sizeof *s->hashes) : NULL;
}

/* Points have a word more than there are: vectors read beyond them. */
static void lay_cells(struct grid_cells *cells, struct block *block, int64_t points, const struct grid *grid)
{
    for (int row = 0; row < POINTS; row++)
        cells->points[row] = take(block, 2 * points + WORD, sizeof(int32_t)); /* all may be in the repeated column */
    cells->start = take(block, (grid->columns + 1) * grid->rows + 1, sizeof *cells->start);
}

static void lay_tasks(struct state *s, struct block *block)
{
    const struct params *p = s->params;
    const struct place *place = &p->arena.place;
    const int64_t count = p->tasks.count, news = s->padded * count, cells = place->columns * place->rows;
    const bool acts = p->acting.acts, ways = place->exists && place->arrived >= 0;
    for (int row = 0; row < POINTS; row++)
        s->tasks[row] = take(block, count + WORD, sizeof(int32_t));
    s->names = p->sensing.merges ? take(block, count, sizeof *s->names) : NULL;
    s->tasks_there = take(block, s->task_words, sizeof *s->tasks_there);
    s->vanish_at = p->tasks.lifetime > 0.0 ? take(block, count, sizeof *s->vanish_at) : NULL;
    s->holders = acts ? take(block, count, sizeof *s->holders) : NULL;
    s->news = acts ? take(block, news, sizeof *s->news) : NULL;
    s->told = acts ? take(block, (p->radio.delay + 1) * news, sizeof *s->told) : NULL;
    s->ways = ways ? take(block, (count + 2) * cells, sizeof *s->ways) : NULL;
    s->task_places = p->tasks.numbered ? take(block, count + WORD, sizeof *s->task_places) : NULL;
    s->tasks_seen = p->tasks.numbered ? take(block, s->task_words * s->padded, sizeof *s->tasks_seen) : NULL;
    lay_cells(&s->task_cells, block, count, &p->tasks.grid);
    lay_cells(&s->robot_cells, block, p->together ? 0 : p->robots.count, &p->robots.grid);
    s->class_of = take(block, p->robots.count + count, sizeof *s->class_of);
}

/* A queue has room for all that one robot may add, or in a small swarm for all pairs, which may meet. */
static void lay_parts(struct state *s, struct block *block, struct room room)
{
    const int64_t pairs = s->params->together ? s->padded * s->padded / 2 + PAIRS_OF_WORDS : 0;
    const int64_t others = larger(s->params->robots.count, s->params->tasks.count);
    const int64_t queue = larger(QUEUE_ROOM + others + WORD, pairs + SPREAD);
    s->team = take(block, 1, sizeof(struct team));
    s->parts = take(block, s->threads, sizeof *s->parts);
    for (int64_t thread = 0; thread < s->threads; thread++) {
        struct part part = {.thread = thread};
        part.first = s->words * thread / s->threads;
        part.last = s->words * (thread + 1) / s->threads;
        part.who = take(block, queue, sizeof *part.who);
        part.other = take(block, queue, sizeof *part.other);
        part.third = take(block, queue, sizeof *part.third);
        part.free_tables = take(block, 1 + room.tables, sizeof *part.free_tables);
        if (s->parts)
            s->parts[thread] = part;
    }
}

int64_t feasibee_lay_out(struct state *s, struct room room, char *block)
{
    struct block taken = {block, 0};
    set_lengths(s, room);
    s->clock = take(&taken, 1, sizeof *s->clock);
    s->account = take(&taken, 1, sizeof *s->account);
    lay_robots(s, &taken);
    lay_messages(s, &taken);
    lay_tasks(s, &taken);
    lay_parts(s, &taken, room);
    if (!block)
        return taken.taken;
    s->clock->table_slots = room.slots;
    ((struct team *)s->team)->threads = s->threads;
    const size_t robots = (size_t)s->params->robots.count, tasks = (size_t)s->params->tasks.count;
    memcpy(s->class_of, s->tables.class_of, (robots + tasks) * sizeof *s->class_of);
    if (s->inbox[SENDER])
        memset(s->inbox[SENDER], NOBODY, (size_t)s->slots * sizeof(int32_t));
    if (s->holders)
        memset(s->holders, NOBODY, tasks * sizeof *s->holders);
    return taken.taken;
}

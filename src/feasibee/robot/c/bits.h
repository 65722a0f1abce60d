/* Bits in a row, the most significant first, as feasibee.robot.wire in Python. */

#include "controller.h"

/* Bits that are written to bytes. failed is set for good once one has no room, or a number doesn't fit. */
struct feasibee_writer {
    uint8_t *bytes;
    uint32_t room;   /* in bits */
    uint32_t length; /* bits written */
    bool failed;
};

/* Bits that are read from bytes. failed is set for good once a rule is broken; then all that is read is 0. */
struct feasibee_reader {
    const uint8_t *bytes;
    uint32_t length; /* in bits */
    uint32_t place;  /* bits read */
    bool failed;
    int32_t (*task_of)(uint32_t name); /* returns the id of a task by its name; NULL: the name is the id */
};

static inline void feasibee_writer_flag(struct feasibee_writer *writer, bool flag)
{
    if (writer->length == writer->room)
        writer->failed = true;
    if (writer->failed)
        return;
    uint8_t *byte = &writer->bytes[writer->length >> 3], bit = (uint8_t)(128u >> (writer->length & 7));
    *byte = flag ? (uint8_t)(*byte | bit) : (uint8_t)(*byte & ~bit);
    writer->length++;
}

/* Write a number of up to 32 bits. */
static inline void feasibee_writer_number(struct feasibee_writer *writer, uint32_t number, uint8_t bits)
{
    if (bits < 32 && number >> bits != 0)
        writer->failed = true;
    while (bits > 0) {
        bits--;
        feasibee_writer_flag(writer, number >> bits & 1);
    }
}

/* Write a number in Rice's code: its upper bits in unary, then the lowest ones. */
static inline void feasibee_writer_rice(struct feasibee_writer *writer, uint32_t number, uint8_t low)
{
    for (uint32_t left = number >> low; left > 0 && !writer->failed; left--)
        feasibee_writer_flag(writer, false);
    feasibee_writer_flag(writer, true);
    feasibee_writer_number(writer, number & ((UINT32_C(1) << low) - 1), low);
}

/* Write a number as so many bits 0 and a bit 1. */
static inline void feasibee_writer_unary(struct feasibee_writer *writer, uint32_t number)
{
    feasibee_writer_rice(writer, number, 0);
}

/* Write a word with its sign. */
static inline void feasibee_writer_word(struct feasibee_writer *writer, uint32_t word)
{
    feasibee_writer_number(writer, word, 32);
}

/* See that a message keeps a rule. */
static inline void feasibee_reader_check(struct feasibee_reader *reader, bool holds)
{
    reader->failed = reader->failed || !holds;
}

static inline bool feasibee_reader_flag(struct feasibee_reader *reader)
{
    feasibee_reader_check(reader, reader->place < reader->length);
    if (reader->failed) /* as if at random, so that a loop that waits for one ends */
        return (uint16_t)((uint16_t)reader->place++ * 40503u) >> 15;
    bool flag = reader->bytes[reader->place >> 3] >> (7 - (reader->place & 7)) & 1;
    reader->place++;
    return flag;
}

/* Read a number of up to 32 bits. */
static inline uint32_t feasibee_reader_number(struct feasibee_reader *reader, uint8_t bits)
{
    uint32_t number = 0;
    while (bits > 0 && !reader->failed) {
        bits--;
        number = number << 1 | feasibee_reader_flag(reader);
    }
    return reader->failed ? 0 : number;
}

/* Read a number of up to 32 bits that must be below a limit; 0 if it isn't. */
static inline uint32_t feasibee_reader_below(struct feasibee_reader *reader, uint32_t limit, uint8_t bits)
{
    uint32_t number = feasibee_reader_number(reader, bits);
    feasibee_reader_check(reader, number < limit);
    return reader->failed ? 0 : number;
}

/* Read a number in Rice's code that must be below a limit; 0 if it isn't. */
static inline uint32_t feasibee_reader_rice(struct feasibee_reader *reader, uint32_t limit, uint8_t low)
{
    uint32_t upper = 0;
    while (!feasibee_reader_flag(reader) && !reader->failed)
        feasibee_reader_check(reader, ++upper <= limit >> low);
    uint32_t number = upper << low | feasibee_reader_number(reader, low);
    feasibee_reader_check(reader, number < limit);
    return reader->failed ? 0 : number;
}

/* Read a number in unary that must be below a limit; 0 if it isn't. */
static inline uint32_t feasibee_reader_unary(struct feasibee_reader *reader, uint32_t limit)
{
    return feasibee_reader_rice(reader, limit, 0);
}

/* Read a word with its sign. */
static inline int32_t feasibee_reader_word(struct feasibee_reader *reader)
{
    return (int32_t)feasibee_reader_number(reader, 32);
}

/* Return the id of a task by its name; it must be below a limit. */
static inline uint32_t feasibee_reader_task(struct feasibee_reader *reader, uint32_t name, uint32_t limit)
{
    uint32_t task = reader->task_of ? (uint32_t)reader->task_of(name) : name;
    feasibee_reader_check(reader, task < limit);
    return reader->failed ? 0 : task;
}

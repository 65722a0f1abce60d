/* Messages as bytes: the frames of feasibee.robot.wire in Python, bit for bit (docs/wire.md).
 *
 *   struct feasibee_wire wire = feasibee_wire_of(&settings, "dmmd", 5);
 *   uint8_t frame[FEASIBEE_FRAME];
 *   size_t length = feasibee_encode(&wire, me.id, &message, frame, sizeof frame);
 *   if (feasibee_decode(&wire, frame, length, &sender, &message) && feasibee_listens(&robot))
 *       feasibee_hear(&robot, sender, &message);
 */

#include "bits.h"
#include "knowledge.h"
#include "words.h"

enum {
    FEASIBEE_FRAME_VERSION = 1,
    FEASIBEE_FRAME_HEADER = 3,
    FEASIBEE_FRAME_OVERHEAD = 7,
    FEASIBEE_FRAME = 14 /* enough for all strategies without knowledge, with ids of up to 32 bits */
};

/* How all robots of a swarm encode their messages. */
struct feasibee_wire {
    const struct feasibee_settings *settings;
    uint8_t id_bits; /* length of an id, 1 to 32 */
    uint16_t scheme; /* tells strategy and settings from others */
};

/* Add a byte to a CRC-32 (IEEE 802.3, reflected) that began with all ones and will be inverted. */
static inline uint32_t feasibee_crc_of_byte(uint32_t crc, uint8_t byte)
{
    crc ^= byte;
    for (uint8_t bit = 0; bit < 8; bit++)
        crc = crc >> 1 ^ (crc & 1 ? UINT32_C(0xEDB88320) : 0);
    return crc;
}

static inline uint32_t feasibee_crc(const uint8_t *bytes, size_t length)
{
    uint32_t crc = UINT32_MAX;
    for (size_t place = 0; place < length; place++)
        crc = feasibee_crc_of_byte(crc, bytes[place]);
    return ~crc;
}

/* Add a number of 4 bytes to a CRC. */
static inline uint32_t feasibee_crc_of_number(uint32_t crc, uint32_t number)
{
    for (uint8_t shift = 32; shift > 0; shift = (uint8_t)(shift - 8))
        crc = feasibee_crc_of_byte(crc, (uint8_t)(number >> (shift - 8)));
    return crc;
}

#if FEASIBEE_WORDS > 0

/* Return a parameter in 1/65536. */
static inline uint32_t feasibee_parameter_code(feasibee_real number)
{
#ifdef FEASIBEE_DOUBLE
    return (uint32_t)(int64_t)(number * 65536.0);
#else
    return (uint32_t)(int32_t)(number * FEASIBEE_REAL(65536.0)); /* below 32768 */
#endif
}

/* Add the numbers to a CRC that fix the layout of knowledge. */
static inline uint32_t feasibee_crc_of_setting(uint32_t crc, const struct feasibee_knowledge *knowledge,
                                               const struct feasibee_setting *setting)
{
    crc = feasibee_crc_of_number(crc, feasibee_message_words(knowledge, setting));
    crc = feasibee_crc_of_number(crc, setting->robot_classes);
    crc = feasibee_crc_of_number(crc, setting->task_classes);
    crc = feasibee_crc_of_number(crc, setting->knows_count);
    for (uint8_t place = 0; place < knowledge->parameters; place++)
        crc = feasibee_crc_of_number(crc, feasibee_parameter_code(setting->parameters[place]));
    return crc;
}

#endif

static inline bool feasibee_declares_by_votes(const struct feasibee_settings *settings)
{
    return settings->declare.rounds > 0;
}

/* Return the wire of a strategy, by its name in Python, such as "k-unanimity". id_bits is that of the
 * setting, if the strategy has one. The settings must outlive the wire. */
static inline struct feasibee_wire feasibee_wire_of(const struct feasibee_settings *settings,
                                                    const char *name, uint8_t id_bits)
{
    struct feasibee_wire wire = {settings, id_bits, 0};
    uint32_t crc = UINT32_MAX;
    for (; *name != 0; name++)
        crc = feasibee_crc_of_byte(crc, (uint8_t)*name);
    crc = feasibee_crc_of_byte(crc, 0);
    crc = feasibee_crc_of_number(crc, id_bits);
    crc = feasibee_crc_of_number(crc, settings->strategy->value_bits);
    crc = feasibee_crc_of_number(crc, feasibee_declares_by_votes(settings));
#if FEASIBEE_WORDS > 0
    if (settings->strategy->knowledge)
        crc = feasibee_crc_of_setting(crc, settings->strategy->knowledge, settings->setting);
#endif
    wire.scheme = (uint16_t)~crc;
    return wire;
}

/* Return whether messages have id, opinion and declaration in addition to knowledge, if any. */
static inline bool feasibee_has_opinion(const struct feasibee_settings *settings)
{
    return settings->strategy->knowledge == NULL || !settings->strategy->knowledge->exact ||
           feasibee_declares_by_votes(settings);
}

#if FEASIBEE_WORDS > 0

/* Write the words of a message, or read them into words that are 0; return the sender's id, -1 if it isn't
 * sent. */
static inline feasibee_int feasibee_lay_out(struct feasibee_layout *wire, int32_t *words, feasibee_id sender,
                                            const struct feasibee_settings *settings)
{
    const struct feasibee_knowledge *knowledge = settings->strategy->knowledge;
    struct feasibee_row row = {words, (int16_t)feasibee_message_words(knowledge, settings->setting)};
    return knowledge->layout(wire, row, wire->reader ? -1 : (feasibee_int)sender, settings->setting);
}

#endif

#if FEASIBEE_WORDS > 0

static inline void feasibee_write_knowledge(struct feasibee_writer *writer,
                                            const struct feasibee_settings *settings, feasibee_id sender,
                                            struct feasibee_message *message)
{
    struct feasibee_layout layout = {writer, NULL};
    feasibee_lay_out(&layout, message->words, sender, settings);
}

#endif

/* Write the frame of a message; return its length in bytes, or 0 if the room is too small or a number of the
 * message doesn't fit its bits. */
static inline size_t feasibee_encode(const struct feasibee_wire *wire, feasibee_id sender,
                                     struct feasibee_message *message, uint8_t *frame, size_t room)
{
    const struct feasibee_settings *settings = wire->settings;
    if (room < FEASIBEE_FRAME_OVERHEAD)
        return 0;
    struct feasibee_writer writer = {frame, 8 * (uint32_t)(room - 4), 0, false};
    feasibee_writer_number(&writer, FEASIBEE_FRAME_VERSION, 8);
    feasibee_writer_number(&writer, wire->scheme, 16);
    if (feasibee_has_opinion(settings)) {
        feasibee_writer_number(&writer, sender, wire->id_bits);
        feasibee_writer_number(&writer, (uint32_t)(int32_t)message->opinion, 1);
#if FEASIBEE_VALUES
        feasibee_writer_number(&writer, message->value, settings->strategy->value_bits);
#endif
    }
    feasibee_writer_number(&writer, message->declared, feasibee_declares_by_votes(settings));
#if FEASIBEE_WORDS > 0
    if (settings->strategy->knowledge)
        feasibee_write_knowledge(&writer, settings, sender, message);
#endif
    while ((writer.length & 7) != 0 && !writer.failed)
        feasibee_writer_flag(&writer, false);
    uint32_t crc = feasibee_crc(frame, (size_t)(writer.length >> 3));
    writer.room += 32;
    feasibee_writer_number(&writer, crc, 32);
    return writer.failed ? 0 : (size_t)(writer.length >> 3);
}

/* Read what isn't knowledge. */
static inline void feasibee_read_opinion(struct feasibee_reader *reader, const struct feasibee_wire *wire,
                                         feasibee_id *sender, struct feasibee_message *message)
{
    uint32_t id = feasibee_reader_number(reader, wire->id_bits);
    *sender = (feasibee_id)id;
    feasibee_reader_check(reader, *sender == id);
    message->opinion = (int8_t)feasibee_reader_number(reader, 1);
#if FEASIBEE_VALUES
    message->value = (uint16_t)feasibee_reader_number(reader, wire->settings->strategy->value_bits);
#endif
    message->declared = feasibee_declares_by_votes(wire->settings) && feasibee_reader_flag(reader);
}

#if FEASIBEE_WORDS > 0

/* Read knowledge, and the sender's id if the strategy sends it. */
static inline void feasibee_read_knowledge(struct feasibee_reader *reader, const struct feasibee_wire *wire,
                                           feasibee_id *sender, struct feasibee_message *message)
{
    const struct feasibee_setting *setting = wire->settings->setting;
    for (uint32_t k = 0; k < FEASIBEE_MESSAGE_WORDS; k++)
        message->words[k] = 0;
    struct feasibee_layout layout = {NULL, reader};
    feasibee_int named = feasibee_lay_out(&layout, message->words, 0, wire->settings);
    if (feasibee_has_opinion(wire->settings))
        feasibee_reader_check(reader, *sender < (feasibee_id)setting->robots &&
                                          (named < 0 || named == (feasibee_int)*sender));
    else if (named >= 0)
        *sender = (feasibee_id)named;
}

#endif

/* Read a frame; return whether it is one of this wire. Otherwise sender and message mean nothing.
 *
 * Messages with knowledge have no opinion (FEASIBEE_NONE) and, for some strategies, no sender (all ones),
 * unless there is a rule to declare; feasibee_hear() takes both as they are. */
static inline bool feasibee_decode(const struct feasibee_wire *wire, const uint8_t *frame, size_t length,
                                   feasibee_id *sender, struct feasibee_message *message)
{
    if (length < FEASIBEE_FRAME_OVERHEAD || length > UINT16_MAX)
        return false;
    struct feasibee_reader reader = {frame, 8 * (uint32_t)length, 8 * (uint32_t)(length - 4), false,
                                     wire->settings->task_of};
    if (feasibee_reader_number(&reader, 32) != feasibee_crc(frame, length - 4))
        return false;
    reader.place = 0;
    reader.length -= 32;
    feasibee_reader_check(&reader, feasibee_reader_number(&reader, 8) == FEASIBEE_FRAME_VERSION);
    feasibee_reader_check(&reader, feasibee_reader_number(&reader, 16) == wire->scheme);
    *sender = (feasibee_id)-1;
    message->opinion = FEASIBEE_NONE;
    message->value = 0;
    message->declared = false;
    if (feasibee_has_opinion(wire->settings))
        feasibee_read_opinion(&reader, wire, sender, message);
#if FEASIBEE_WORDS > 0
    if (wire->settings->strategy->knowledge)
        feasibee_read_knowledge(&reader, wire, sender, message);
#endif
    feasibee_reader_check(&reader, reader.length - reader.place < 8);
    feasibee_reader_check(&reader, feasibee_reader_number(&reader, (uint8_t)((reader.length - reader.place) & 7)) == 0);
    return !reader.failed;
}

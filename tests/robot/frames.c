/* Frames, read from standard input: writes whether each is one, what it holds, and its frame made again. */

#include "stream.h"

static void answer(const uint8_t *frame, uint16_t length)
{
    static uint8_t again[FRAME];
    struct feasibee_message message = {0};
    feasibee_id sender = 0;
    uint8_t is_one = feasibee_decode(&wire, frame, length, &sender, &message);
    give(&is_one, 1);
    if (!is_one)
        return;
    uint8_t heard[3] = {(uint8_t)(message.opinion + 1), message.declared, sender == (feasibee_id)-1};
    uint32_t words = feasibee_crc((const uint8_t *)message.words, sizeof message.words);
    give(heard, 3);
    give(&sender, 2);
    give(&message.value, 2);
    give(&words, 4);
    message.opinion = message.opinion == FEASIBEE_NONE ? 0 : message.opinion;
    sender = heard[2] ? 0 : sender;
    uint16_t written = (uint16_t)feasibee_encode(&wire, sender, &message, again, FRAME);
    uint32_t same = written == length && memcmp(frame, again, length) == 0;
    give(&same, 4);
}

int main(void)
{
    for (int byte = getchar(); byte != EOF; byte = getchar()) {
        uint32_t number;
        ungetc(byte, stdin);
        read_setting();
        for (take(&number, sizeof number); number > 0; number--) {
            uint16_t length = read_short();
            uint8_t *frame = malloc(length + 1u); /* the sanitizer sees what is read beyond its end */
            if (frame == NULL)
                return 1;
            take(frame, length);
            frame = realloc(frame, length > 0 ? length : 1);
            answer(frame, length);
            free(frame);
        }
    }
    return 0;
}

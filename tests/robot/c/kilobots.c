/* Kilobots that a program meets, in place of kilolib: five robots that say infeasible, and near tasks.
 *
 * After 600 seconds it prints the color of the LED, the flags of the last message, and whether its checksum
 * was right.
 */

#include <kilolib.h>

#include "board.h"

enum { SECONDS = 600, TICKS = 32, ROBOTS = 5, TASKS = 3 };

volatile uint32_t kilo_ticks;
uint16_t kilo_uid = 300;
uint8_t kilo_turn_left = 70, kilo_turn_right = 70, kilo_straight_left = 65, kilo_straight_right = 65;
message_rx_t kilo_message_rx;
message_tx_t kilo_message_tx;
static uint8_t light, bits = 1;

uint16_t message_crc(const message_t *message)
{
    uint16_t sum = message->type;
    for (uint8_t byte = 0; byte < 9; byte++)
        sum = (uint16_t)(31 * sum + message->data[byte]);
    return sum;
}

uint8_t estimate_distance(const distance_measurement_t *distance)
{
    return (uint8_t)distance->low_gain;
}

uint8_t rand_hard(void)
{
    return bits = (uint8_t)(bits * 5 + 7);
}

void set_motors(uint8_t left, uint8_t right)
{
    (void)left, (void)right;
}

void spinup_motors(void)
{
}

void set_color(uint8_t color)
{
    light = color;
}

void kilo_init(void)
{
}

/* Let a neighbour send: 2 speaks, 1 is a task. */
static void receive(uint8_t id, uint8_t flags)
{
    message_t message = {{flags, id}, NORMAL, 0};
    distance_measurement_t near = {50, 50}, far = {150, 150};
    kilo_message_rx(&message, id == ROBOTS + TASKS ? &far : &near);
}

void kilo_start(void (*setup)(void), void (*loop)(void))
{
    char line[] = "000";
    setup();
    for (uint16_t second = 0; second < SECONDS; second++)
        for (uint8_t tick = 0; tick < TICKS; tick++) {
            kilo_ticks++;
            if (tick % 16 < ROBOTS)
                receive(tick % 16, 2);
            else if (tick % 16 <= ROBOTS + TASKS)
                receive(tick % 16, 1);
            loop();
        }
    const message_t *said = kilo_message_tx();
    line[0] = (char)('0' + light);
    line[1] = (char)('0' + said->data[0]);
    line[2] = (char)('0' + (said->crc == message_crc(said)));
    print_line(line);
    stop();
}

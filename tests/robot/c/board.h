/* What a test program needs of a board: print a line, measure the stack, stop.
 *
 * On an ATmega328P in simavr the line goes to the UART, on a Cortex-M in QEMU to the debugger (semihosting),
 * elsewhere to standard output. The stack is painted before main; what has lost its paint was used.
 */

#include <stdint.h>

#define PAINT 0xC5

#if defined(__AVR__)

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

extern uint8_t _end; /* of data and bss */

__attribute__((naked, used, section(".init3"))) void paint_stack(void)
{
    for (uint8_t *byte = &_end; byte < (uint8_t *)SP; byte++)
        *byte = PAINT;
}

static inline uint16_t stack_used(void)
{
    const uint8_t *byte = &_end;
    while (*byte == PAINT)
        byte++;
    return (uint16_t)(RAMEND + 1 - (uintptr_t)byte);
}

static inline void print_line(const char *line)
{
    UCSR0B = 1 << TXEN0;
    for (;; line++) {
        while (!(UCSR0A & (1 << UDRE0))) {
        }
        UDR0 = *line ? *line : '\n';
        if (!*line)
            return;
    }
}

static inline void stop(void)
{
    cli();
    sleep_enable();
    sleep_cpu(); /* simavr ends when a sleeping processor can't wake */
}

#elif defined(__arm__)

extern uint32_t stack_top[], data_start[], data_end[], data_load[], bss_start[], bss_end[];
int main(void);
void reset(void);

__attribute__((section(".vectors"), used)) static const struct {
    uint32_t *stack;
    void (*handlers[3])(void);
} vectors = {stack_top, {reset, reset, reset}};

static void semihost(int operation, const void *argument)
{
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}

static inline void stop(void)
{
    semihost(0x18, (const void *)0x20026); /* SYS_EXIT, the application ended */
}

void reset(void)
{
    const uint32_t *from = data_load;
    for (uint32_t *to = data_start; to < data_end;)
        *to++ = *from++;
    for (uint32_t *to = bss_start; to < bss_end;)
        *to++ = 0;
    uint8_t *top;
    __asm__ volatile("mov %0, sp" : "=r"(top));
    for (volatile uint8_t *byte = (uint8_t *)bss_end; byte < top; byte++)
        *byte = PAINT;
    main();
    stop();
    for (;;) {
    }
}

static inline uint16_t stack_used(void)
{
    const uint8_t *byte = (const uint8_t *)bss_end;
    while (*byte == PAINT)
        byte++;
    return (uint16_t)((const uint8_t *)stack_top - byte);
}

static inline void print_line(const char *line)
{
    semihost(0x04, line); /* SYS_WRITE0 */
    semihost(0x04, "\n");
}

#else

#include <stdio.h>

static inline uint16_t stack_used(void)
{
    return 0;
}

static inline void print_line(const char *line)
{
    puts(line);
}

static inline void stop(void)
{
}

#endif

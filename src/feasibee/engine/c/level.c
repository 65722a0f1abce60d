/* Which level (feasibee.engine.build) this processor and this system have. */

#include "engine.h"

#ifdef __x86_64__
#include <cpuid.h>

/* Instructions by what CPUID says of them (Intel's manual, volume 2A): bits of registers of its leaves. */
enum {
    SSE4 = 1 << 0 | 1 << 9 | 1 << 13 | 1 << 19 | 1 << 20 | 1 << 23, /* leaf 1, ecx: and what came before */
    AVX = 1 << 12 | 1 << 22 | 1 << 27 | 1 << 28 | 1 << 29,          /* the same: with FMA, MOVBE, F16C, XGETBV */
    AVX2 = 1 << 3 | 1 << 5 | 1 << 8,                                /* leaf 7, ebx: with BMI1 and BMI2 */
    LZCNT = 1 << 5,                                                 /* leaf 0x80000001, ecx */
    WIDE_STATE = 7 << 5,                                            /* XCR0: the system keeps 512 bits, and masks */
    STATE = 3 << 1                                                  /* XCR0: it keeps 256 bits */
};
static const uint32_t AVX512 = 1u << 16 | 1u << 17 | 1u << 21 | 1u << 28 | 1u << 30 | 1u << 31, /* leaf 7, ebx */
    COUNTS = 1 << 1 | 1 << 6 | 1 << 8 | 1 << 9 | 1 << 10 | 1 << 11 | 1 << 12 | 1 << 14;          /* leaf 7, ecx */

static bool has(uint32_t found, uint32_t all) { return (found & all) == all; }

int32_t feasibee_level(void)
{
    uint32_t a, b, c, d, first, state, high;
    if (!__get_cpuid(1, &a, &b, &first, &d) || !has(first, SSE4))
        return -1;
    if (!has(first, AVX))
        return 0;
    __asm__ volatile("xgetbv" : "=a"(state), "=d"(high) : "c"(0));
    if (!__get_cpuid(0x80000001, &a, &b, &c, &d) || !has(c, LZCNT) || !has(state, STATE))
        return 0;
    if (!__get_cpuid_count(7, 0, &a, &b, &c, &d) || !has(b, AVX2))
        return 0;
    return has(state, WIDE_STATE) && has(b, AVX512) && has(c, COUNTS) ? 2 : 1;
}
#else
int32_t feasibee_level(void) { return 0; }
#endif

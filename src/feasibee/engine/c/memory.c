/* The memory of a module of WebAssembly, and what else the engine calls of a C library.
 *
 * A module has no system, and the engine takes little of such a library. So there is none to compile, which would
 * take 26 s, and the module imports nothing. */

#include "memory.h"

#ifdef __wasm__

#include <stdlib.h>
#include <string.h>

#define PAGE 65536u
extern unsigned char __heap_base; /* the linker's: the end of the stack and the constants */
static uintptr_t used;            /* where the free memory begins; 0: nothing is used */

uintptr_t room_taken(void) { return used; }
void take_back(uintptr_t taken) { used = taken; }

void *aligned_alloc(size_t alignment, size_t size)
{
    const uintptr_t from = used ? used : (uintptr_t)&__heap_base;
    const uintptr_t begin = (from + alignment - 1) & ~(uintptr_t)(alignment - 1), end = begin + size;
    const uintptr_t limit = (uintptr_t)__builtin_wasm_memory_size(0) * PAGE;
    if (begin < from || end < begin)
        return NULL;
    if (end > limit && __builtin_wasm_memory_grow(0, (end - limit + PAGE - 1) / PAGE) == SIZE_MAX)
        return NULL;
    used = end;
    return (void *)begin;
}

void *malloc(size_t size) { return aligned_alloc(64, size); } /* compilers call it for calloc, too */

void *calloc(size_t count, size_t size)
{
    if (size && count > SIZE_MAX / size)
        return NULL;
    void *room = aligned_alloc(64, count * size);
    return room ? memset(room, 0, count * size) : NULL; /* it may have been used before */
}

/* Memory comes free at the end of a call that took it: see feasibee_play_flat. */
void free(void *room) { (void)room; }

/* Each is one instruction. */
void *memset(void *to, int byte, size_t size) { return __builtin_memset(to, byte, size); }
void *memcpy(void *restrict to, const void *restrict from, size_t size) { return __builtin_memcpy(to, from, size); }
void *memmove(void *to, const void *from, size_t size) { return __builtin_memmove(to, from, size); }

void abort(void) { __builtin_trap(); }

void *feasibee_room(size_t size) { return aligned_alloc(64, size); }
void feasibee_clear(void) { used = 0; }

#endif

#ifndef MEMORY_H
#define MEMORY_H

#ifdef __wasm__

#include <stddef.h>
#include <stdint.h>

#pragma GCC visibility push(default)

/* Return room of this size; NULL if the memory can't grow. */
void *feasibee_room(size_t size);

/* Take back all room, that of a page and that of the engine. */
void feasibee_clear(void);

#pragma GCC visibility pop

/* Return how much room is taken, for `take_back`, which takes back what came after. */
uintptr_t room_taken(void);
void take_back(uintptr_t taken);

#endif
#endif

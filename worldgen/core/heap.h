// A binary heap of triples, smallest first.

#ifndef WG_HEAP_H
#define WG_HEAP_H

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

typedef struct WgEntry {
    int64_t key;     // compared first
    int64_t second;  // compared second
    int64_t third;   // compared last
} WgEntry;

typedef struct WgHeap {
    WgEntry *entries;
    int64_t count;
    int64_t room;
} WgHeap;

static inline bool wg_before(WgEntry a, WgEntry b)
{
    if (a.key != b.key) {
        return a.key < b.key;
    }
    return a.second != b.second ? a.second < b.second : a.third < b.third;
}

// Returns false if memory runs out.
static inline bool wg_heap_push(WgHeap *heap, WgEntry entry)
{
    if (heap->count == heap->room) {
        int64_t room = 2 * heap->room + 1024;
        WgEntry *entries = realloc(heap->entries, (size_t)room * sizeof *entries);
        if (entries == NULL) {
            return false;
        }
        heap->entries = entries;
        heap->room = room;
    }
    int64_t at = heap->count++;
    while (at > 0 && wg_before(entry, heap->entries[(at - 1) / 2])) {
        heap->entries[at] = heap->entries[(at - 1) / 2];
        at = (at - 1) / 2;
    }
    heap->entries[at] = entry;
    return true;
}

// Removes and returns the smallest entry; the heap must not be empty.
static inline WgEntry wg_heap_pop(WgHeap *heap)
{
    WgEntry least = heap->entries[0];
    WgEntry last = heap->entries[--heap->count];
    int64_t at = 0;
    for (int64_t child = 1; child < heap->count; child = 2 * at + 1) {
        if (child + 1 < heap->count && wg_before(heap->entries[child + 1], heap->entries[child])) {
            child++;
        }
        if (!wg_before(heap->entries[child], last)) {
            break;
        }
        heap->entries[at] = heap->entries[child];
        at = child;
    }
    heap->entries[at] = last;
    return least;
}

#endif

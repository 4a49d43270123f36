// Random numbers that are a function of a seed and an index: SplitMix64.
//
// Source: Guy Steele, Doug Lea, Christine Flood, "Fast splittable pseudorandom number generators",
// OOPSLA 2014.

#ifndef WG_RANDOM_DRAW_H
#define WG_RANDOM_DRAW_H

#include <stdint.h>

// Draw number `index`, from 0, of the stream of a seed: the top 53 bits, in [0, 1).
static inline double wg_random_draw(uint64_t seed, int64_t index)
{
    uint64_t z = seed + (uint64_t)(index + 1) * 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    z = z ^ (z >> 31);
    return (double)(z >> 11) * 0x1p-53;
}

#endif

// Finds the step in which a run's complete state recurs, for any motion model.
//
// During a run, each state leaves a 64-bit fingerprint in a log. Equal states are followed by equal
// states, so once any state has recurred, every later one has occurred before. It is therefore
// enough to look up the last state of the budget: if it is new, no state of the run has recurred.
// To stop early, earlier states are looked up too, each twice as far along as the one before.
//
// Equal fingerprints only suggest equal states. A second run, up to the end of the first period,
// proves it by comparing the complete states at both ends (WG_PROVE_LOOP).
//
// A state is any object of 64-bit words; its bytes are compared, so -0.0 differs from 0.0.

#ifndef WG_RECURRENCE_H
#define WG_RECURRENCE_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "wg_episode.h"

enum {
    // words that share a fingerprint, which is recomputed only when one of them changes
    WG_BLOCK = 8,
    WG_FEW_WORDS = 32,  // a state of at most this many words has no blocks
    WG_FIRST_STEPS = 16,  // before the first look-up
};

static const uint64_t WG_STRIDE = 0x9E3779B97F4A7C15u;  // distinguishes blocks
static const uint64_t WG_MIXER = 0xBF58476D1CE4E5B9u;

static inline uint64_t wg_word(const void *state, int64_t index)
{
    uint64_t word;
    memcpy(&word, (const unsigned char *)state + index * (int64_t)sizeof word, sizeof word);
    return word;
}

// Returns the number of blocks of a state of this many words.
static inline int64_t wg_blocks(int64_t words)
{
    return (words + WG_BLOCK - 1) / WG_BLOCK;
}

// Random odd numbers, one for each word of a state of few words: SplitMix64's numbers from seed 0,
// made odd.
static const uint64_t WG_FACTORS[WG_FEW_WORDS] = {
    0xE220A8397B1DCDAFu, 0x6E789E6AA1B965F5u, 0x06C45D188009454Fu, 0xF88BB8A8724C81EDu,
    0x1B39896A51A8749Bu, 0x53CB9F0C747EA2EBu, 0x2C829ABE1F4532E1u, 0xC584133AC916AB3Du,
    0x3EE5789041C98AC3u, 0xF3B8488C368CB0A7u, 0x657EECDD3CB13D09u, 0xC2D326E0055BDEF7u,
    0x8621A03FE0BBDB7Bu, 0x8E1F7555983AA92Fu, 0xB54E0F1600CC4D19u, 0x84BB3F97971D80ABu,
    0x7D29825C75521255u, 0xC3CF17102B7F7F87u, 0x3466E9A083914F65u, 0xD81A8D2B5A4485ADu,
    0xDB01602B100B9ED7u, 0xA9038A921825F10Du, 0xEDF5F1D90DCA2F6Bu, 0x54496AD67BD2634Du,
    0xDD7C01D4F5407269u, 0x935E82F1DB4C4F7Bu, 0x69B82EBC92233301u, 0x40D29EB57DE1D511u,
    0xA2F09DABB45C6317u, 0xEE521D7A0F4D3873u, 0xF16952EE72F3454Fu, 0x377D35DEA8E40225u,
};

static inline uint64_t wg_folded(uint64_t word)
{
    return word ^ (word >> 32);
}

// The fingerprint of a state of few words. Each word's upper half is folded into its lower one,
// because in floats that are small integers only the upper half varies, and a product only spreads
// upwards. No product depends on another.
static inline uint64_t wg_fingerprint_of_few(const void *state, int64_t words)
{
    uint64_t mixed = 0;
    for (int64_t k = 0; k < words; k++) {
        mixed += wg_folded(wg_word(state, k)) * WG_FACTORS[k];
    }
    return mixed;
}

// The sum of the blocks' fingerprints; blocks that have not changed since the last call keep
// theirs.
uint64_t wg_fingerprint_of_many(WgSearch *search, const void *state);

// Begins with the state of step 0. `quiet` is the step of the last event:
// earlier states prove nothing.
void wg_search_begin(WgSearch *search, const void *state, int64_t quiet);

// Looks up the state of a step and decides when to look up the next one. Returns the fewest steps
// since it occurred before; 0 if it is new.
int64_t wg_search_look_up(WgSearch *search, int64_t step, int64_t quiet);

// Returns the first step, not before `quiet`, from which the log repeats itself up to `step`.
int64_t wg_entry_of_loop(const uint64_t *log, int64_t quiet, int64_t step, int64_t period);

// The fingerprint of a state of any size.
static inline uint64_t wg_fingerprint(WgSearch *search, const void *state)
{
    return search->words <= WG_FEW_WORDS ? wg_fingerprint_of_few(state, search->words)
                                         : wg_fingerprint_of_many(search, state);
}

// Logs the fingerprint of the state after a step, which is not before `quiet`, and looks it up if
// it is due or the last one of the budget. Returns the fewest steps since the state occurred
// before; 0 if it is new or was not looked up.
static inline int64_t wg_search_log(WgSearch *search, uint64_t fingerprint, int64_t step, int64_t quiet, int64_t budget)
{
    search->log[step] = fingerprint;
    if (step < search->next && step < budget) {
        return 0;
    }
    return wg_search_look_up(search, step, quiet);
}

// Logs a state and looks it up, like wg_search_log().
static inline int64_t wg_search_period(WgSearch *search, const void *state, int64_t step, int64_t quiet, int64_t budget)
{
    return wg_search_log(search, wg_fingerprint(search, state), step, quiet, budget);
}

// Keeps the state of step `entry`; at step `end`, returns true if it recurs, word by word.
static inline bool wg_search_is_proved(WgSearch *search, const void *state, int64_t step, int64_t entry, int64_t end)
{
    size_t size = (size_t)search->words * sizeof *search->known;
    if (step == entry) {
        memcpy(search->known, state, size);
    }
    return step == end && memcmp(search->known, state, size) == 0;
}

#endif

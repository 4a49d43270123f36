// Finds the step in which a run's complete state comes back, whatever the motion model.
//
// While a run goes on, each state leaves a 64-bit fingerprint in a log. A state that equals an earlier one is followed
// by the same states, so once any state has come back, every later one has been there before. It is therefore enough to
// look up the last state of the budget: if it is new, nothing in the run has come back. To stop early, states are
// looked up before that too, each twice as far along as the one before.
//
// Equal fingerprints are only a claim. It is proved by a second run, up to the end of the first period, that compares
// the complete states at both ends (WG_PROVE_LOOP).
//
// A state is any object of so many 64-bit words; its bytes are compared, so -0.0 is not 0.0.

#ifndef WG_RECURRENCE_H
#define WG_RECURRENCE_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "wg_episode.h"

enum {
    WG_BLOCK = 8,       // words that share a fingerprint, which is worked out again only when one of them changes
    WG_FEW_WORDS = 32,  // a state of at most so many has no blocks
    WG_FIRST_STEPS = 16,  // before the first look-up
};

static const uint64_t WG_STRIDE = 0x9E3779B97F4A7C15u;  // tells blocks apart
static const uint64_t WG_MIXER = 0xBF58476D1CE4E5B9u;

static inline uint64_t wg_word(const void *state, int64_t index)
{
    uint64_t word;
    memcpy(&word, (const unsigned char *)state + index * (int64_t)sizeof word, sizeof word);
    return word;
}

// How many blocks a state of so many words has.
static inline int64_t wg_blocks(int64_t words)
{
    return (words + WG_BLOCK - 1) / WG_BLOCK;
}

// The fingerprint of a state of few words. Turning brings a word's upper half down before the product spreads it
// upwards: of floats that are small whole numbers only that one varies. It takes three instructions a word; blocks of
// so few words took 8 ns more for each step.
static inline uint64_t wg_fingerprint_of_few(const void *state, int64_t words)
{
    uint64_t mixed = WG_STRIDE;
    for (int64_t k = 0; k < words; k++) {
        mixed ^= wg_word(state, k);
        mixed = ((mixed << 32) | (mixed >> 32)) * WG_MIXER;
    }
    return mixed;
}

// The sum of the blocks' fingerprints; blocks that have not changed since the last call keep theirs.
uint64_t wg_fingerprint_of_many(WgSearch *search, const void *state);

// Begins with the state of step 0. `quiet` is the step of the last event: earlier states prove nothing.
void wg_search_begin(WgSearch *search, const void *state, int64_t quiet);

// Looks up the state of a step and says when the next one is looked up. Steps since it was there before, the fewest; 0
// if it is new.
int64_t wg_search_look_up(WgSearch *search, int64_t step, int64_t quiet);

// The first step, not before `quiet`, from which on the log repeats itself up to `step`.
int64_t wg_entry_of_loop(const uint64_t *log, int64_t quiet, int64_t step, int64_t period);

// Logs the state after a step, which is not before `quiet`, and looks it up if it is its turn or the last one of the
// budget. Steps since the state was there before, the fewest; 0 if it is new or was not looked up.
static inline int64_t wg_search_period(WgSearch *search, const void *state, int64_t step, int64_t quiet, int64_t budget)
{
    uint64_t mixed;
    if (search->words <= WG_FEW_WORDS) {
        mixed = wg_fingerprint_of_few(state, search->words);
    } else {
        mixed = wg_fingerprint_of_many(search, state);
    }
    search->log[step] = mixed;
    if (step < search->next && step < budget) {
        return 0;
    }
    return wg_search_look_up(search, step, quiet);
}

// Keeps the state of step `entry`; at step `end`, whether it is there again, word by word.
static inline bool wg_search_is_proved(WgSearch *search, const void *state, int64_t step, int64_t entry, int64_t end)
{
    size_t size = (size_t)search->words * sizeof *search->known;
    if (step == entry) {
        memcpy(search->known, state, size);
    }
    return step == end && memcmp(search->known, state, size) == 0;
}

#endif

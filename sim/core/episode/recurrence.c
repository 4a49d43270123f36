// The parts of recurrence.h that few steps need.

#include "recurrence.h"

// Odd numbers without a pattern, one for each word of a block.
static const uint64_t FACTORS[WG_BLOCK] = {
    0xD6E8FEB86659FD93u, 0xA0761D6478BD642Fu, 0xE7037ED1A0B428DBu, 0x8EBC6AF09C88C6E3u,
    0x589965CC75374CC3u, 0x1D8E4E27C47D124Fu, 0xEB44ACCAB455D165u, 0xC2B2AE3D27D4EB4Fu,
};

static uint64_t fingerprint_of_block(const void *state, int64_t block, int64_t words)
{
    uint64_t mixed = (uint64_t)(block + 1) * WG_STRIDE;
    int64_t first = block * WG_BLOCK;
    for (int64_t k = 0; k < WG_BLOCK && first + k < words; k++) {
        uint64_t word = wg_word(state, first + k);
        mixed += (word ^ (word >> 32)) * FACTORS[k];
    }
    mixed = (mixed ^ (mixed >> 29)) * WG_MIXER;
    return mixed ^ (mixed >> 32);
}

uint64_t wg_fingerprint_of_many(WgSearch *search, const void *state)
{
    int64_t blocks = wg_blocks(search->words);
    uint64_t total = search->prints[blocks];
    for (int64_t block = 0; block < blocks; block++) {
        int64_t first = block * WG_BLOCK;
        int64_t count = search->words - first < WG_BLOCK ? search->words - first : WG_BLOCK;
        const unsigned char *now = (const unsigned char *)state + first * (int64_t)sizeof(uint64_t);
        size_t size = (size_t)count * sizeof(uint64_t);
        if (memcmp(search->known + first, now, size) != 0) {
            uint64_t mixed = fingerprint_of_block(state, block, search->words);
            total += mixed - search->prints[block];
            search->prints[block] = mixed;
            memcpy(search->known + first, now, size);
        }
    }
    search->prints[blocks] = total;
    return total;
}

void wg_search_begin(WgSearch *search, const void *state, int64_t quiet)
{
    int64_t blocks = wg_blocks(search->words);
    uint64_t total = 0;
    if (search->words > WG_FEW_WORDS) {
        for (int64_t block = 0; block < blocks; block++) {
            search->prints[block] = fingerprint_of_block(state, block, search->words);
            total += search->prints[block];
        }
        search->prints[blocks] = total;
    } else {
        total = wg_fingerprint_of_few(state, search->words);
    }
    memcpy(search->known, state, (size_t)search->words * sizeof *search->known);
    if (search->log_size > 0) {
        search->log[0] = total;
    }
    search->next = quiet + WG_FIRST_STEPS;
}

int64_t wg_search_look_up(WgSearch *search, int64_t step, int64_t quiet)
{
    search->next = 2 * step - quiet + WG_FIRST_STEPS;
    uint64_t wanted = search->log[step];
    for (int64_t earlier = step - 1; earlier >= quiet; earlier--) {
        if (search->log[earlier] == wanted) {
            return step - earlier;
        }
    }
    return 0;
}

int64_t wg_entry_of_loop(const uint64_t *log, int64_t quiet, int64_t step, int64_t period)
{
    int64_t entry = step - period;
    while (entry > quiet && log[entry - 1] == log[entry - 1 + period]) {
        entry--;
    }
    return entry;
}

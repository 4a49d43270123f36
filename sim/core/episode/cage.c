// Lets a function of a shared library act where it cannot reach the simulator's data by mistake.
//
// The first pages:   unused words, BAND words, the state, the memory.
// The second pages:  unused words, BAND words, the command, BAND words, its message, a copy of the
//                    observation, the neighbours, the beams.
//
// The pages behind both, and those before the first, cannot be touched (wg_map_fenced). After each
// step, the words next to what the function may write to are compared; the unused words are far
// away, and are compared in ever fewer steps. What it observes is written again before each step,
// so changing it has no effect.

#include <stddef.h>
#include <stdio.h>

#include "rounding.h"
#include "step.h"

enum {
    BAND = 4,          // words
    RARELY = 1 << 8,   // steps between two comparisons of all unused words
    COMMAND_WORDS = sizeof(WgCommand) / sizeof(uint64_t),
    COMMANDED_WORDS = offsetof(WgCommand, error) / sizeof(uint64_t),  // its speed, turn rate and used_random
    OBSERVATION_WORDS = sizeof(WgObservation) / sizeof(uint64_t),
    NEIGHBOUR_WORDS = sizeof(WgNeighbour) / sizeof(uint64_t),
};

// What the unused words hold: no number that a controller computes.
static const uint64_t UNUSED = 0xFFF7C0DEC0DEC0DEu;

int64_t wg_rounding(void)
{
    return wg_rounding_now();
}

void wg_set_rounding(int64_t rounding)
{
    wg_round_again(rounding);
}

void wg_cage_sizes(int64_t memory_size, int64_t beams, int64_t neighbours, int64_t sizes[2])
{
    int64_t word = (int64_t)sizeof(uint64_t);
    sizes[0] = word * (BAND + WG_STATE_WORDS + memory_size);
    sizes[1] = word * (2 * BAND + COMMAND_WORDS + WG_MOST_MESSAGE + OBSERVATION_WORDS
                       + neighbours * NEIGHBOUR_WORDS + beams);
}

static void fill(uint64_t *first, const uint64_t *end)
{
    while (first < end) {
        *first++ = UNUSED;
    }
}

WgStatus wg_cage_begin(WgCage *cage, int64_t first_size, int64_t second_size)
{
    int64_t sizes[2];
    wg_cage_sizes(cage->memory_size, cage->beam_room, cage->neighbour_room, sizes);
    if (first_size < sizes[0] || second_size < sizes[1]) {
        return WG_BAD_SIZE;
    }
    uint64_t *end = cage->first + first_size / (int64_t)sizeof(uint64_t);
    cage->memory = (double *)(end - cage->memory_size);
    fill(cage->first, end);
    memset(cage->memory, 0, (size_t)cage->memory_size * sizeof *cage->memory);

    end = cage->second + second_size / (int64_t)sizeof(uint64_t);
    fill(cage->second, end);
    cage->beams = (double *)(end - cage->beam_room);
    uint64_t *place = (uint64_t *)cage->beams - cage->neighbour_room * NEIGHBOUR_WORDS;
    cage->neighbours = (WgNeighbour *)place;
    place -= OBSERVATION_WORDS;
    cage->observation = (WgObservation *)place;
    place -= WG_MOST_MESSAGE;
    cage->message = (double *)place;
    place -= BAND + COMMAND_WORDS;
    cage->command = (WgCommand *)place;
    cage->acts = 0;
    cage->rounding = wg_rounding_now();
    return WG_OK;
}

// Returns how many words from the end of a part of the unused words the last changed one is, from
// 1; 0 if none has changed.
static int64_t changed_before(const uint64_t *first, const uint64_t *end)
{
    for (const uint64_t *word = end; word > first; word--) {
        if (word[-1] != UNUSED) {
            return end - word + 1;
        }
    }
    return 0;
}

// Returns 0 if a band of unused words is unchanged.
static inline uint64_t difference(const uint64_t *first)
{
    uint64_t differs = 0;
#pragma GCC unroll 4
    for (int64_t k = 0; k < BAND; k++) {
        differs |= first[k] ^ UNUSED;
    }
    return differs;
}

static uint64_t *state_of(const WgCage *cage)
{
    return (uint64_t *)cage->memory - WG_STATE_WORDS;
}

// Returns how many bytes before its memory a function has written; 0 if it has not.
static int64_t written_before(const WgCage *cage, const uint64_t state[WG_STATE_WORDS])
{
    const uint64_t *own = state_of(cage);
    int64_t away = 0;
    for (int64_t k = WG_STATE_WORDS; k > 0 && away == 0; k--) {
        away = own[k - 1] != state[k - 1] ? WG_STATE_WORDS - k + 1 : 0;
    }
    int64_t further = changed_before(cage->first, own);
    if (away == 0 && further > 0) {
        away = WG_STATE_WORDS + further;
    }
    return away * (int64_t)sizeof(uint64_t);
}

// Returns true if the function has left all words next to what it may write to.
static inline bool is_near_kept(const WgCage *cage, const uint64_t state[WG_STATE_WORDS])
{
    const uint64_t *own = state_of(cage);
    const uint64_t *command = (const uint64_t *)cage->command;
    const volatile uint64_t *now = own;  // word by word, as in copy_words
    uint64_t differs = difference(own - BAND) | difference(command - BAND) | difference(command + COMMAND_WORDS);
#pragma GCC unroll 8
    for (int64_t k = 0; k < WG_STATE_WORDS; k++) {
        differs |= now[k] ^ state[k];
    }
    return differs == 0;
}

// Returns true if the function has written only where it may; otherwise cage->error tells where.
static bool is_kept(WgCage *cage, const uint64_t state[WG_STATE_WORDS])
{
    const uint64_t *command = (const uint64_t *)cage->command;
    int64_t before = written_before(cage, state);
    if (before > 0) {
        (void)snprintf(cage->error, sizeof cage->error, "it wrote %lld bytes before its memory", (long long)before);
    } else if (changed_before(cage->second, command) > 0) {
        (void)snprintf(cage->error, sizeof cage->error, "it wrote before its command");
    } else if (difference(command + COMMAND_WORDS) != 0) {
        (void)snprintf(cage->error, sizeof cage->error, "it wrote after its command");
    } else {
        return true;
    }
    return false;
}

// Copies words one by one. A vector of two words that were just written one by one would have to wait
// until they have left the processor's store buffer: 40 ns a step. The number of words is known to the
// compiler at each call, and a loop over them would take longer than the copying.
static inline void copy_words(uint64_t *to, const uint64_t *from, int64_t count)
{
    volatile uint64_t *into = to;
    const volatile uint64_t *out_of = from;
#pragma GCC unroll 32
    for (int64_t k = 0; k < count; k++) {
        into[k] = out_of[k];
    }
}

// Copies what a controller observes into its cage. The beams are there.
static void show(const WgWorkspace *workspace, WgCage *cage)
{
    const WgObservation *seen = &workspace->observation;
    copy_words((uint64_t *)cage->observation, (const uint64_t *)seen, OBSERVATION_WORDS);
    if (seen->neighbours != NULL) {
        cage->observation->neighbours = cage->neighbours;
        memcpy(cage->neighbours, seen->neighbours, (size_t)seen->neighbour_count * sizeof *cage->neighbours);
    }
}

// All unused words are compared in steps 1, 2, 4, 8 and so on, then in every RARELY-th: in every
// step, that would take as long as a step of a simple controller.
static bool is_due(int64_t step)
{
    return (step & (step - 1)) == 0 || step % RARELY == 0;
}

void wg_act_caged(WgCage *cage, WgWorkspace *workspace, WgRobot *robot)
{
    // A single robot's state and memory are in the cage; those of a fleet are next to each other.
    double *memory = robot->body->memory;
    bool is_elsewhere = memory != cage->memory && cage->memory_size > 0;
    size_t size = (size_t)cage->memory_size * sizeof *memory;
    if (is_elsewhere) {
        memcpy(cage->memory, memory, size);
    }
    uint64_t state[WG_STATE_WORDS];
    copy_words(state, state_of(cage), WG_STATE_WORDS);
    show(workspace, cage);
    WgCommand *command = &workspace->command;
    WgCommand *own = cage->command;
    *own = (WgCommand){0};
    size_t message_size = command->message != NULL ? (size_t)workspace->observation.message_size * sizeof(double) : 0;
    if (message_size > 0) {
        own->message = cage->message;
        memset(cage->message, 0, message_size);
    }

    cage->acts = 1;
    cage->act(cage->observation, cage->memory, own);
    wg_round_again(cage->rounding);

    copy_words((uint64_t *)command, (const uint64_t *)own, COMMANDED_WORDS);
    bool is_to_be_searched = !is_near_kept(cage, state) || is_due(robot->report.steps);
    if (is_to_be_searched && !is_kept(cage, state)) {
        command->error = cage->error;
    } else if (own->error != NULL) {
        // Its message may be anywhere, so it is copied while an invalid address is still its fault.
        strncpy(cage->error, own->error, sizeof cage->error - 1);
        cage->error[sizeof cage->error - 1] = '\0';
        command->error = cage->error;
    }
    cage->acts = 0;
    if (is_elsewhere) {
        memcpy(memory, cage->memory, size);
    }
    if (message_size > 0) {
        memcpy(command->message, cage->message, message_size);
    }
}

int64_t wg_cage_reset(WgCage *cage, WgReset reset)
{
    uint64_t state[WG_STATE_WORDS];
    memcpy(state, state_of(cage), sizeof state);
    cage->acts = 1;
    reset(cage->memory);
    cage->acts = 0;
    wg_round_again(cage->rounding);
    return is_kept(cage, state);
}

void wg_failed_reset_act(const WgObservation *observation, double *memory, WgCommand *command)
{
    (void)observation;
    (void)memory;
    command->error = "its reset failed";
}

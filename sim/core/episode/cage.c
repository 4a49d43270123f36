// Lets a function of a shared library act where it cannot reach the simulator's data by mistake.
//
// The first pages:   unused words, BAND words, the state, the memory.
// The second pages:  unused words, BAND words, the command, its message, BAND words, the
//                    observation, the neighbours, the beams.
//
// The pages behind both, and those before the first, cannot be touched (wg_map_fenced). After each
// step, the words next to what the function may write to are compared; the unused words are far
// away, and are compared in ever fewer steps.

#include <stdio.h>

#include "step.h"

enum {
    BAND = 8,          // words
    RARELY = 1 << 8,   // steps between two comparisons of all unused words
    COMMAND_WORDS = sizeof(WgCommand) / sizeof(uint64_t),
    OBSERVATION_WORDS = sizeof(WgObservation) / sizeof(uint64_t),
    NEIGHBOUR_WORDS = sizeof(WgNeighbour) / sizeof(uint64_t),
};

// What the unused words hold: no number that a controller computes.
static const uint64_t UNUSED = 0xFFF7C0DEC0DEC0DEu;

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
    place -= BAND + WG_MOST_MESSAGE;
    cage->message = (double *)place;
    place -= COMMAND_WORDS;
    cage->command = (WgCommand *)place;
    cage->acts = 0;
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

static bool is_band(const uint64_t *first)
{
    uint64_t differs = 0;
    for (int64_t k = 0; k < BAND; k++) {
        differs |= first[k] ^ UNUSED;
    }
    return differs == 0;
}

static uint64_t *before_state(const WgCage *cage)
{
    return (uint64_t *)cage->memory - WG_STATE_WORDS;
}

// Returns true if the function has kept to its memory; otherwise cage->error tells what it did.
static bool kept_to_memory(WgCage *cage, const uint64_t state[WG_STATE_WORDS], bool thoroughly)
{
    const uint64_t *own = before_state(cage);
    bool is_kept = is_band(own - BAND) && memcmp(own, state, WG_STATE_WORDS * sizeof *own) == 0;
    if (is_kept && (!thoroughly || changed_before(cage->first, own) == 0)) {
        return true;
    }
    int64_t away = 0;
    for (int64_t k = WG_STATE_WORDS; k > 0 && away == 0; k--) {
        away = own[k - 1] != state[k - 1] ? WG_STATE_WORDS - k + 1 : 0;
    }
    if (away == 0) {
        away = WG_STATE_WORDS + changed_before(cage->first, own);
    }
    snprintf(cage->error, sizeof cage->error, "it wrote %lld bytes before its memory",
             (long long)(away * (int64_t)sizeof(uint64_t)));
    return false;
}

// Returns true if the function has changed nothing around its command, nor what it observes.
static bool kept_to_command(WgCage *cage, const WgWorkspace *workspace, bool thoroughly)
{
    const uint64_t *command = (const uint64_t *)cage->command;
    const uint64_t *message_end = (const uint64_t *)(cage->message + WG_MOST_MESSAGE);
    if (!is_band(command - BAND) || (thoroughly && changed_before(cage->second, command) != 0)) {
        snprintf(cage->error, sizeof cage->error, "it wrote before its command");
        return false;
    }
    if (!is_band(message_end)) {
        snprintf(cage->error, sizeof cage->error, "it wrote after its command");
        return false;
    }

    // Compare the observation with the simulator's own, except for the two addresses.
    const WgObservation *seen = &workspace->observation;
    WgObservation copy = *cage->observation;
    copy.beams = seen->beams;
    copy.neighbours = seen->neighbours;
    bool is_same = memcmp(&copy, seen, sizeof copy) == 0;
    if (is_same && seen->beam_count > 0) {
        is_same = memcmp(cage->beams, workspace->beams, (size_t)seen->beam_count * sizeof *cage->beams) == 0;
    }
    if (is_same && seen->neighbour_count > 0) {
        size_t size = (size_t)seen->neighbour_count * sizeof *seen->neighbours;
        is_same = memcmp(cage->neighbours, seen->neighbours, size) == 0;
    }
    if (!is_same) {
        snprintf(cage->error, sizeof cage->error, "it wrote to its observation, which is const");
    }
    return is_same;
}

// Copies what a controller observes into its cage.
static void show(const WgWorkspace *workspace, WgCage *cage)
{
    const WgObservation *seen = &workspace->observation;
    *cage->observation = *seen;
    cage->observation->beams = cage->beams;
    if (seen->beam_count > 0) {
        memcpy(cage->beams, workspace->beams, (size_t)seen->beam_count * sizeof *cage->beams);
    }
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
    size_t size = (size_t)cage->memory_size * sizeof *memory;
    if (memory != cage->memory && size > 0) {
        memcpy(cage->memory, memory, size);
    }
    uint64_t state[WG_STATE_WORDS];
    memcpy(state, before_state(cage), sizeof state);
    show(workspace, cage);
    int64_t messages = workspace->command.message != NULL ? workspace->observation.message_size : 0;
    *cage->command = (WgCommand){.message = messages > 0 ? cage->message : NULL};
    memset(cage->message, 0, WG_MOST_MESSAGE * sizeof *cage->message);

    int64_t before = wg_rounding();
    cage->acts = 1;
    cage->act(cage->observation, cage->memory, cage->command);
    wg_set_rounding(before);

    WgCommand *command = &workspace->command;
    command->speed = cage->command->speed;
    command->turn_rate = cage->command->turn_rate;
    command->used_random = cage->command->used_random;
    command->error = NULL;
    bool thoroughly = is_due(robot->report.steps);
    if (!kept_to_memory(cage, state, thoroughly) || !kept_to_command(cage, workspace, thoroughly)) {
        command->error = cage->error;
    } else if (cage->command->error != NULL) {
        // Its message may be anywhere, so it is copied while an invalid address is still its fault.
        strncpy(cage->error, cage->command->error, sizeof cage->error - 1);
        cage->error[sizeof cage->error - 1] = '\0';
        command->error = cage->error;
    }
    cage->acts = 0;
    if (memory != cage->memory && size > 0) {
        memcpy(memory, cage->memory, size);
    }
    if (messages > 0) {
        memcpy(command->message, cage->message, (size_t)messages * sizeof *cage->message);
    }
}

int64_t wg_cage_reset(WgCage *cage, WgReset reset)
{
    uint64_t state[WG_STATE_WORDS];
    memcpy(state, before_state(cage), sizeof state);
    cage->acts = 1;
    reset(cage->memory);
    cage->acts = 0;
    return kept_to_memory(cage, state, true);
}

void wg_failed_reset_act(const WgObservation *observation, double *memory, WgCommand *command)
{
    (void)observation;
    (void)memory;
    command->error = "its reset failed";
}

// Seats: robots that run in one world after another.

#include <stdlib.h>
#include <string.h>

#include "looks.h"
#include "step.h"
#include "stopwatch.h"

enum {
    LARGEST_SIDE = WG_SMALLEST_SIDE + WG_SIDES - 1,
    MOST_STEPS = 1 << 30,
    MOST_TIME = 250000000, // ns that a call takes, about, so that its caller notices Ctrl-C
};

// A seat and everything that it points to, in one block.
typedef struct Block {
    WgSeat seat;
    WgArena arena;
    WgSettings settings;
    int32_t near[WG_MOST_CELLS];
    int32_t clearance[WG_MOST_CELLS];
    uint8_t cells[WG_MOST_CELLS];
    uint8_t visited[WG_MOST_CELLS];
    uint16_t runs[(LARGEST_SIDE + 2) * (LARGEST_SIDE + 2) * 4];
    int64_t spread[]; // sized for the setting with the most beams
} Block;

int64_t wg_looks_longest(const WgLooks *looks)
{
    int64_t longest = looks->patience.most;
    for (int64_t n = 0; n < looks->count; n++) {
        longest = wg_most(longest, looks->budgets[n]);
    }
    return longest;
}

static int64_t most_beams(const WgLooks *looks)
{
    int64_t most = 0;
    for (int64_t k = 0; k < looks->setting_count; k++) {
        most = wg_most(most, looks->settings[k].beams);
    }
    return most;
}

static size_t block_size(const WgLooks *looks)
{
    return sizeof(Block) + (size_t)most_beams(looks) * sizeof(int64_t);
}

// Returns true if the numbers of a batch are consistent.
static bool fits(const WgLooks *looks)
{
    bool bytes = looks->layout_bytes == WG_LAYOUT_BYTES || looks->layout_bytes == WG_SCENE_BYTES;
    bool counts = looks->setting_count > 0 && looks->radius_count > 0 && looks->target_count > 0;
    bool patience = looks->patience.multiple >= 0 && looks->patience.multiple <= MOST_STEPS &&
                    looks->patience.fewest >= 1 && looks->patience.watched >= 0;
    if (!bytes || !counts || !patience || looks->count < 0 || looks->at < 0) {
        return false;
    }
    for (int64_t n = 0; n < looks->count; n++) {
        if (looks->kinds[n] < 0 || looks->kinds[n] >= looks->setting_count) {
            return false;
        }
    }
    if (looks->flood_reach < 0 || looks->flood_reach > WG_WIDEST) {
        return false;
    }
    for (int64_t k = 0; k < looks->radius_count; k++) {
        if (looks->discs[k].reach < 0 || looks->discs[k].reach > WG_WIDEST) {
            return false;
        }
    }
    return true;
}

// Sets up a seat in a block of zeros; its episode is created separately.
static WgSeat *prepare(Block *block, WgLooks *looks)
{
    WgSeat *seat = &block->seat;
    seat->looks = looks;
    seat->run = -1;
    seat->watch = -1;
    seat->clearance = block->clearance;
    seat->runs = block->runs;
    seat->spread = block->spread;
    seat->settings = &block->settings;
    block->settings = looks->settings[0];
    seat->arena = &block->arena;
    seat->arena->width = LARGEST_SIDE;
    seat->arena->height = LARGEST_SIDE;
    seat->arena->cells = block->cells;
    seat->arena->near = block->near;
    seat->arena->headings = looks->headings;
    seat->arena->visited = block->visited;
    seat->arena->rays = looks->rays;
    return seat;
}

WgStatus wg_seat_new(WgLooks *looks, const WgController *controller, WgSeat **made)
{
    int64_t longest = wg_looks_longest(looks);
    if (!fits(looks) || longest < 1 || longest > MOST_STEPS) {
        return WG_BAD_VALUE;
    }
    Block *block = calloc(1, block_size(looks));
    if (block == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    WgSeat *seat = prepare(block, looks);
    WgStatus status = wg_episode_new(seat->arena, seat->settings, controller, longest, &seat->episode);
    if (status != WG_OK) {
        free(block);
        return status;
    }
    *made = seat;
    return WG_OK;
}

void wg_seat_free(WgSeat *seat)
{
    if (seat != NULL) {
        wg_episode_free(seat->episode);
        free(seat); // it is the first member of its block
    }
}

WgStatus wg_seat_sizes(const WgLooks *looks, const WgController *controller, int64_t sizes[3])
{
    int64_t longest = wg_looks_longest(looks);
    if (!fits(looks) || longest < 1 || longest > MOST_STEPS) {
        return WG_BAD_VALUE;
    }
    WgArena arena = {.event_count = 0};
    sizes[0] = (int64_t)block_size(looks);
    return wg_episode_sizes(&arena, &looks->settings[0], controller, longest, &sizes[1]);
}

WgSeat *wg_seat_place(void *const blocks[3], WgLooks *looks, const WgController *controller)
{
    WgSeat *seat = prepare(blocks[0], looks);
    seat->episode = wg_episode_place(blocks[1], blocks[2], seat->arena, seat->settings, controller,
                                     wg_looks_longest(looks));
    return seat;
}

bool wg_seat_open(WgSeat *seat, int64_t run)
{
    bool opened = run >= 0 && run < seat->looks->count && wg_look_open(seat, run);
    seat->run = opened ? run : -1;
    seat->watch = -1;
    seat->fresh = 1;
    return opened;
}

int64_t wg_seat_next(WgSeat *seat)
{
    WgLooks *looks = seat->looks;
    while (looks->at < looks->count) {
        if (wg_seat_open(seat, looks->at)) {
            return looks->at;
        }
        looks->at++;
    }
    seat->run = -1;
    return -1;
}

WgStatus wg_seat_begin(WgSeat *seat)
{
    return wg_episode_begin(seat->episode);
}

// Notes a run that has ended; returns true if watching the robot longer gives more information.
static bool says_more(WgSeat *seat)
{
    wg_look_close(seat);
    int64_t ending = seat->looks->looks[seat->run].report.ending;
    return ending == WG_LOOP || ending == WG_LIMIT;
}

static int64_t watched_step(const WgSeat *seat)
{
    const WgLook *look = &seat->looks->looks[seat->run];
    return look->report.steps + look->watched + 1;
}

int64_t wg_seat_step(WgSeat *seat)
{
    WgEpisode *episode = seat->episode;
    WgWorkspace *workspace = &episode->workspace;
    if (episode->waits != 0) {
        seat->fresh = 0;
    }
    if (seat->watch < 0) {
        if (wg_episode_step(episode) == WG_ACTS) {
            return WG_ACTS;
        }
        if (!says_more(seat)) {
            return WG_OVER;
        }
        wg_look_watch(seat);
    } else if (episode->waits != 0) {
        episode->waits = 0;
        wg_take_answer(episode);
        wg_apply_command(seat->arena, seat->settings, &workspace->command, watched_step(seat), &episode->robot);
        wg_look_note_step(seat);
    }
    while (wg_look_goes_on(seat)) {
        int64_t step = watched_step(seat);
        if (wg_move_and_sense(seat->arena, seat->settings, &episode->robot, workspace, step)) {
            wg_flatten(workspace);
            episode->waits = 1;
            return WG_ACTS;
        }
        wg_look_note_step(seat);
    }
    return WG_OVER;
}

int64_t wg_seat_stop(void *subject)
{
    return wg_seat_step(subject);
}

// Notes that a controller written as a C function has failed, during its run or while it was
// watched.
static void note_crash(WgSeat *seat)
{
    WgLook *look = &seat->looks->looks[seat->run];
    look->report = seat->episode->robot.report;
    look->report.overlap_step = -1;
    look->watched = 0;
    look->bumps = 0;
    look->turned = 0;
    look->left = 0;
    look->right = 0;
    look->low = 0;
    look->high = 0;
    look->contact = 0;
    look->closer = 0;
}

// Runs the robot of a C function's controller for at most this many more steps;
// returns the number done.
static int64_t watch(WgSeat *seat, int64_t most_steps, bool *over)
{
    WgEpisode *episode = seat->episode;
    WgRobot *robot = &episode->robot;
    WgWorkspace *workspace = &episode->workspace;
    for (int64_t done = 0; done < most_steps; done++) {
        *over = !wg_look_goes_on(seat);
        if (*over) {
            return done;
        }
        int64_t step = watched_step(seat);
        bool acts = wg_move_and_sense(seat->arena, seat->settings, robot, workspace, step);
        if (acts && !wg_act(seat->arena, seat->settings, &episode->controller, workspace, step, robot)) {
            note_crash(seat);
            *over = true;
            return done + 1;
        }
        wg_look_note_step(seat);
    }
    return most_steps;
}

// Continues the run of a seat for at most this many steps; returns the number done.
static int64_t run_on(WgSeat *seat, int64_t most_steps, bool *over)
{
    WgEpisode *episode = seat->episode;
    if (seat->watch >= 0) {
        return watch(seat, most_steps, over);
    }
    int64_t before = episode->step;
    if (wg_episode_run(episode, most_steps) == WG_GOES_ON) {
        return episode->step - before;
    }
    if (episode->robot.report.ending == WG_CRASH) {
        note_crash(seat);
        *over = true;
    } else if (says_more(seat)) {
        wg_look_watch(seat);
    } else {
        *over = true;
    }
    return episode->step - before;
}

bool wg_looks_fail(WgSeat *seat)
{
    if (seat->run < 0) {
        return false;
    }
    wg_episode_fail(seat->episode);
    note_crash(seat);
    seat->run = -1;
    seat->looks->at++;
    return true;
}

int64_t wg_call_looks(const WgCall *call)
{
    return wg_looks_run(call->objects[0], call->number);
}

int64_t wg_looks_run(WgSeat *seat, int64_t most_steps)
{
    int64_t left = most_steps;
    int64_t began = wg_now();
    while (left > 0) {
        if (seat->run < 0) {
            if (wg_seat_next(seat) < 0) {
                return WG_OVER;
            }
            if (wg_seat_begin(seat) != WG_OK) {
                return WG_OVER;
            }
        }
        bool over = false;
        left -= run_on(seat, left, &over) + 1;
        if (over) {
            seat->run = -1;
            seat->looks->at++;
        }
        if (wg_now() - began > MOST_TIME) {
            return WG_GOES_ON;
        }
    }
    return WG_GOES_ON;
}

// Gives a seat one world after another until its controller must act; returns false if there are no
// more worlds.
static bool board(WgSeat *seat)
{
    while (wg_seat_next(seat) >= 0) {
        seat->looks->at++;
        if (wg_seat_begin(seat) == WG_OK && wg_seat_step(seat) == WG_ACTS) {
            return true;
        }
    }
    return false;
}

// Exchanges two seats.
static void swap(WgSeat **seats, int64_t a, int64_t b)
{
    WgSeat *seat = seats[a];
    seats[a] = seats[b];
    seats[b] = seat;
}

int64_t wg_seats_board(WgSeat **seats, int64_t count)
{
    int64_t taken = 0;
    while (taken < count && board(seats[taken])) {
        taken++;
    }
    return taken;
}

void wg_seats_sense(WgSeat **seats, int64_t count, double *observations, double *memories,
                    int64_t *numbers, uint8_t *fresh)
{
    for (int64_t n = 0; n < count; n++) {
        const WgEpisode *episode = seats[n]->episode;
        int64_t size = episode->controller.memory_size;
        int64_t seen = wg_flat_size(episode->settings, 0);
        memcpy(observations + n * seen, episode->workspace.flat, (size_t)seen * sizeof(double));
        if (size > 0) {
            memcpy(memories + n * size, episode->robot.body->memory, (size_t)size * sizeof(double));
        }
        numbers[n] = seats[n]->number;
        fresh[n] = (uint8_t)seats[n]->fresh;
    }
}

int64_t wg_seats_act(WgSeat **seats, int64_t count, const double *commands, const double *memories)
{
    int64_t kept = 0;
    for (int64_t n = 0; n < count; n++) {
        WgEpisode *episode = seats[n]->episode;
        int64_t size = episode->controller.memory_size;
        if (size > 0) {
            memcpy(episode->robot.body->memory, memories + n * size, (size_t)size * sizeof(double));
        }
        episode->workspace.command.speed = commands[3 * n];
        episode->workspace.command.turn_rate = commands[3 * n + 1];
        episode->workspace.command.used_random = commands[3 * n + 2];
        if (wg_seat_step(seats[n]) == WG_ACTS || board(seats[n])) {
            swap(seats, kept, n);
            kept++;
        }
    }
    return kept;
}

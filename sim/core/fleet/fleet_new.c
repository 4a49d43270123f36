// Makes fleets and puts their robots at their starts.

#include <stdlib.h>
#include <string.h>

#include "fleet.h"

// Words of a robot in the complete state: its own, its memory, its message,
// and whether it has parked.
static int64_t words_of(const WgFleet *fleet, int64_t robot)
{
    return WG_STATE_WORDS + fleet->members[robot]->controller.memory_size + fleet->settings->message + 1;
}

uint64_t *wg_parked_word(const WgFleet *fleet, int64_t robot)
{
    return (uint64_t *)fleet->members[robot]->robot.body + words_of(fleet, robot) - 1;
}

// Returns memory from the block, or from the heap if there is no block; NULL if it is used up.
static void *take(WgBlock *block, size_t size, bool clears)
{
    // Everything in the block begins at a multiple of 16 bytes.
    int64_t rounded = ((int64_t)size + 15) / 16 * 16;
    int64_t begin = block->used;
    block->used += rounded;
    if (block->bytes == NULL) {
        return clears ? calloc(1, size) : malloc(size);
    }
    return block->used <= block->size ? (char *)block->bytes + begin : NULL;
}

// Returns a new array of zeros; NULL if memory runs out, and then for all later calls too.
static void *array(WgBlock *block, bool *is_made, int64_t count, size_t size)
{
    void *made = *is_made ? take(block, (size_t)wg_most(count, 1) * size, true) : NULL;
    *is_made = made != NULL;
    return made;
}

static bool make_search(WgFleet *fleet, WgBlock *block, int64_t words)
{
    bool is_made = true;
    WgSearch *search = &fleet->search;
    search->words = words;
    search->prints = array(block, &is_made, wg_blocks(words) + 1, sizeof(uint64_t));
    search->known = array(block, &is_made, words, sizeof(uint64_t));
    if (fleet->settings->log_steps > 0) {
        // Not cleared, so a long log takes memory only as the run progresses.
        search->log_size = fleet->settings->log_steps + 1;
        search->log = take(block, (size_t)search->log_size * sizeof(uint64_t), false);
        is_made = is_made && search->log != NULL;
    }
    return is_made;
}

static bool make_near(WgFleet *fleet, WgBlock *block)
{
    bool is_made = true;
    int64_t count = fleet->count;
    WgNear *near = array(block, &is_made, 1, sizeof *near);
    fleet->near = near;
    if (!is_made) {
        return false;
    }
    near->buckets = 16;
    while (near->buckets < 2 * count) {
        near->buckets *= 2;
    }
    near->pairs = array(block, &is_made, count * (count - 1) / 2, sizeof *near->pairs);
    near->first = array(block, &is_made, count, sizeof *near->first);
    near->first_pair = array(block, &is_made, count, sizeof *near->first_pair);
    near->heads = array(block, &is_made, near->buckets, sizeof *near->heads);
    near->chain = array(block, &is_made, count, sizeof *near->chain);
    // The grid has at most as many cells as there are robots.
    near->grid.first = array(block, &is_made, count + 1, sizeof *near->grid.first);
    near->grid.spots = array(block, &is_made, count, sizeof *near->grid.spots);
    near->grid.found = array(block, &is_made, count + 1, sizeof *near->grid.found);
    return is_made;
}

// Allocates what robots need to sense each other, if they do.
static bool make_senses(WgFleet *fleet, WgBlock *block, const WgArena *const *arenas)
{
    bool is_made = true;
    int64_t room = 0;
    int64_t flat = 0;
    double radius = 0.0;
    int64_t row = WG_NEIGHBOUR_NUMBERS + fleet->settings->message;
    for (int64_t k = 0; k < fleet->count; k++) {
        const WgSettings *settings = fleet->members[k]->settings;
        bool beams = (settings->senses & WG_SENSE_BEAMS) != 0 && settings->beams > 0;
        bool neighbours = (settings->senses & WG_SENSE_NEIGHBOURS) != 0 && settings->neighbour_range > 0.0;
        fleet->members[k]->workspace.neighbour_room = neighbours ? settings->neighbours : 0;
        room += fleet->members[k]->workspace.neighbour_room;
        flat += wg_flat_size(settings, row * fleet->members[k]->workspace.neighbour_room);
        radius = wg_higher(radius, settings->radius / settings->metres);
        fleet->senses_others = fleet->senses_others != 0 || beams || neighbours;
        fleet->furthest = wg_higher(fleet->furthest, beams ? settings->beam_range : 0.0);
        fleet->furthest = wg_higher(fleet->furthest, neighbours ? settings->neighbour_range : 0.0);
    }
    // A beam may hit the rim of a robot whose centre is farther away.
    fleet->furthest += radius;
    fleet->around = array(block, &is_made, fleet->count, sizeof *fleet->around);
    fleet->arenas = array(block, &is_made, fleet->count, sizeof *fleet->arenas);
    fleet->seen = array(block, &is_made, room, sizeof *fleet->seen);
    fleet->flat = array(block, &is_made, flat, sizeof *fleet->flat);
    if (!is_made) {
        return false;
    }
    fleet->others.robots = fleet->around;
    WgNeighbour *seen = fleet->seen;
    double *numbers = fleet->flat;
    for (int64_t k = 0; k < fleet->count; k++) {
        WgEpisode *member = fleet->members[k];
        WgWorkspace *workspace = &member->workspace;
        fleet->arenas[k] = *arenas[k];
        fleet->arenas[k].others = &fleet->others;
        member->arena = &fleet->arenas[k];
        workspace->neighbours = seen;
        workspace->flat = numbers;
        workspace->observation.neighbours = workspace->neighbour_room > 0 ? seen : NULL;
        workspace->observation.message_size = fleet->settings->message;
        seen += workspace->neighbour_room;
        numbers += wg_flat_size(member->settings, row * workspace->neighbour_room);
    }
    return true;
}

static WgStatus make_member(WgFleet *fleet, int64_t robot, WgBlock *block, const WgArena *arena,
                            const WgSettings *settings, const WgController *controller)
{
    int64_t sizes[2];
    WgStatus status = wg_episode_sizes(arena, settings, controller, 0, sizes);
    if (status != WG_OK) {
        return status;
    }
    void *bytes = take(block, (size_t)sizes[0], true);
    if (bytes == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    fleet->members[robot] = wg_episode_place(bytes, NULL, arena, settings, controller, 0);
    return WG_OK;
}

// Makes the members, and puts their states next to each other.
static WgStatus make_members(WgFleet *fleet, WgBlock *block, const WgArena *const *arenas,
                             const WgSettings *const *robots, const WgController *const *controllers)
{
    int64_t words = 0;
    for (int64_t k = 0; k < fleet->count; k++) {
        WgStatus status = make_member(fleet, k, block, arenas[k], robots[k], controllers[k]);
        if (status != WG_OK) {
            return status;
        }
        words += words_of(fleet, k);
    }
    int64_t corners = WG_FLEET_CORNERS * (wg_most_events_of_a_step(arenas[0]) + 1);
    bool is_made = make_search(fleet, block, words) && make_near(fleet, block);
    fleet->state = array(block, &is_made, words, sizeof *fleet->state);
    fleet->chains = array(block, &is_made, fleet->count * corners, sizeof *fleet->chains);
    if (!is_made) {
        return WG_OUT_OF_MEMORY;
    }
    uint64_t *body = fleet->state;
    for (int64_t k = 0; k < fleet->count; k++) {
        WgEpisode *member = fleet->members[k];
        member->robot.body = (WgBody *)body;
        member->robot.chain = fleet->chains + k * corners;
        member->search.words = words_of(fleet, k) - 1;
        body += words_of(fleet, k);
    }
    if (!make_senses(fleet, block, arenas)) {
        return WG_OUT_OF_MEMORY;
    }
    return WG_OK;
}

static bool is_in_range(const WgFleetSettings *settings, const WgArena *const *arenas, const WgSettings *const *robots,
                        int64_t count)
{
    if (count < 1 || count > WG_MOST_ROBOTS || settings->message < 0 || settings->message > WG_MOST_MESSAGE
        || settings->log_steps < 0 || settings->kinds < 1) {
        return false;
    }
    for (int64_t k = 0; k < count; k++) {
        if (arenas[k]->cells != arenas[0]->cells || arenas[k]->near != arenas[0]->near
            || arenas[k]->events != arenas[0]->events || robots[k]->motion != settings->motion
            || robots[k]->neighbours < 0 || robots[k]->neighbours > WG_MOST_NEIGHBOURS
            || robots[k]->find_loop != WG_NO_LOOP || robots[k]->push_count > 0 || arenas[k]->wanted != NULL            || settings->kind[k] < 0 || settings->kind[k] >= settings->kinds) {
            return false;
        }
    }
    return true;
}

WgStatus wg_fleet_new(const WgFleetSettings *settings, const WgArena *const *arenas, const WgSettings *const *robots,
                      const WgController *const *controllers, int64_t count, WgBlock *block, WgFleet **made)
{
    *made = NULL;
    block->used = 0;
    if (!is_in_range(settings, arenas, robots, count)) {
        return WG_BAD_VALUE;
    }
    bool is_made = true;
    WgFleet *fleet = array(block, &is_made, 1, sizeof *fleet);
    if (fleet == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    fleet->is_in_block = block->bytes != NULL;
    fleet->settings = settings;
    fleet->count = count;
    fleet->members = (WgEpisode **)array(block, &is_made, count, sizeof *fleet->members);
    fleet->moved = array(block, &is_made, count, sizeof *fleet->moved);
    fleet->blocked = array(block, &is_made, count * count, sizeof *fleet->blocked);
    fleet->movers = array(block, &is_made, count, sizeof *fleet->movers);
    fleet->by = array(block, &is_made, count, sizeof *fleet->by);
    fleet->before = array(block, &is_made, count, sizeof *fleet->before);
    fleet->is_inside = array(block, &is_made, count, sizeof *fleet->is_inside);
    fleet->acts = array(block, &is_made, count, sizeof *fleet->acts);
    WgStatus status = is_made ? make_members(fleet, block, arenas, robots, controllers) : WG_OUT_OF_MEMORY;
    if (status != WG_OK) {
        wg_fleet_free(fleet);
        return status;
    }
    *made = fleet;
    return WG_OK;
}

void wg_fleet_free(WgFleet *fleet)
{
    if (fleet == NULL || fleet->is_in_block != 0) {
        return;
    }
    for (int64_t k = 0; fleet->members != NULL && k < fleet->count; k++) {
        wg_episode_free(fleet->members[k]);
    }
    if (fleet->near != NULL) {
        free(fleet->near->pairs);
        free(fleet->near->first);
        free(fleet->near->first_pair);
        free(fleet->near->heads);
        free(fleet->near->chain);
        free(fleet->near->grid.first);
        free(fleet->near->grid.spots);
        free(fleet->near->grid.found);
    }
    free(fleet->near);
    free(fleet->search.prints);
    free(fleet->search.known);
    free(fleet->search.log);
    free((void *)fleet->members);
    free(fleet->state);
    free(fleet->chains);
    free(fleet->moved);
    free(fleet->blocked);
    free(fleet->movers);
    free(fleet->by);
    free(fleet->before);
    free(fleet->is_inside);
    free(fleet->acts);
    free(fleet->around);
    free(fleet->arenas);
    free(fleet->seen);
    free(fleet->flat);
    free(fleet);
}

WgStatus wg_fleet_begin(WgFleet *fleet)
{
    const WgFleetSettings *settings = fleet->settings;
    if (settings->find_loop == WG_SEEK_LOOP && fleet->search.log_size <= settings->steps) {
        return WG_BAD_SIZE;  // the log is shorter than the run
    }
    memset(fleet->state, 0, (size_t)fleet->search.words * sizeof *fleet->state);
    memset(fleet->moved, 0, (size_t)fleet->count * sizeof *fleet->moved);
    for (int64_t k = 0; k < fleet->count; k++) {
        WgStatus status = wg_episode_begin(fleet->members[k]);
        if (status != WG_OK) {
            return status;
        }
    }
    fleet->report = (WgFleetReport){.entry = -1, .robot = -1, .other = -1};
    memset(fleet->blocked, 0, (size_t)(fleet->count * fleet->count) * sizeof *fleet->blocked);
    fleet->next_event = 0;
    fleet->quiet = wg_last_event(fleet->members[0]->arena, fleet->members[0]->settings);
    fleet->step = 0;
    fleet->waits = 0;
    fleet->over = 0;
    if (settings->find_loop != WG_NO_LOOP) {
        wg_search_begin(&fleet->search, fleet->state, fleet->quiet);
    }
    return WG_OK;
}

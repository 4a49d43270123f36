// Joint plans: checks, breadth-first distances, and planning one robot after the other.
//
// Erdmann, Lozano-Perez, "On Multiple Moving Objects" (1987), for planning by priority.
// Silver, "Cooperative Pathfinding" (2005), for the search in space and time with reservations.

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "heap.h"
#include "joint.h"

WgStatus wg_joint_check(const WgJoint *joint)
{
    bool sized = joint->robots >= 1 && joint->robots <= INT16_MAX && joint->classes >= 1 && joint->stride >= 3 &&
                 joint->nodes >= joint->stride && joint->nodes % joint->stride == 0 && joint->nodes < INT32_MAX &&
                 joint->rasters >= 1 && joint->ticks >= 1;
    if (!sized) {
        return WG_BAD_SIZE;
    }
    for (int64_t tick = 0; tick < joint->ticks; tick++) {
        if (joint->raster_of[tick] < 0 || joint->raster_of[tick] >= joint->rasters) {
            return WG_BAD_VALUE;
        }
    }
    for (int64_t robot = 0; robot < joint->robots; robot++) {
        bool known = joint->class_of[robot] >= 0 && joint->class_of[robot] < joint->classes &&
                     joint->starts[robot] >= 0 && joint->starts[robot] < joint->nodes;
        if (!known) {
            return WG_BAD_VALUE;
        }
    }
    for (int64_t robot = 0; robot < joint->robots; robot++) {
        if (joint->crossed_from[0] != 0 || joint->crossed_from[robot + 1] < joint->crossed_from[robot]) {
            return WG_BAD_VALUE;
        }
    }
    return WG_OK;
}

WgJointPlan *wg_joint_plan_new(int64_t robots, int64_t length)
{
    WgJointPlan *plan = malloc(sizeof *plan);
    if (plan == NULL) {
        return NULL;
    }
    plan->robots = robots;
    plan->length = length;
    plan->nodes = malloc((size_t)((length + 1) * robots) * sizeof *plan->nodes);
    if (plan->nodes == NULL) {
        free(plan);
        return NULL;
    }
    return plan;
}

int64_t wg_joint_length(const WgJointPlan *plan)
{
    return plan->length;
}

void wg_joint_nodes(const WgJointPlan *plan, int64_t *nodes)
{
    for (int64_t i = 0; i < (plan->length + 1) * plan->robots; i++) {
        nodes[i] = plan->nodes[i];
    }
}

void wg_joint_free(WgJointPlan *plan)
{
    if (plan != NULL) {
        free(plan->nodes);
        free(plan);
    }
}

WgStatus wg_joint_distances(const WgGraph *graph, const uint8_t *goals, int32_t *distances)
{
    int64_t nodes = graph->nodes;
    if (graph->stride < 3 || nodes < graph->stride || nodes % graph->stride != 0 || nodes >= INT32_MAX) {
        return WG_BAD_SIZE;
    }
    int32_t *queue = malloc((size_t)nodes * sizeof *queue);
    if (queue == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    int64_t shifts[8];
    int64_t corners[8];
    wg_eight_steps(graph->stride, shifts, corners);
    int64_t count = 0;
    for (int64_t node = 0; node < nodes; node++) {
        bool is_goal = goals[node] != 0 && graph->clear[node] != 0;
        distances[node] = is_goal ? 0 : -1;
        if (is_goal) {
            queue[count++] = (int32_t)node;
        }
    }

    // Clear nodes are never on the rim, so every step from one stays within the raster.
    for (int64_t begin = 0; begin < count; begin++) {
        int64_t node = queue[begin];
        for (int step = 0; step < 8; step++) {
            int64_t next = node + shifts[step];
            bool passes = graph->clear[next] != 0 && (step < 4 || graph->middle[node + corners[step]] != 0);
            if (passes && distances[next] < 0) {
                distances[next] = distances[node] + 1;
                queue[count++] = (int32_t)next;
            }
        }
    }
    free(queue);
    return WG_OK;
}

// A state of one robot: its node, the tick, and the parent state.
typedef struct State {
    int32_t node;
    int32_t tick;
    int32_t parent;
} State;

// A robot's path once it is planned; it waits at the end.
typedef struct Track {
    int32_t *nodes;
    int64_t length;
} Track;

// The search for one robot among the robots planned before it.
typedef struct Among {
    const WgJoint *joint;
    WgMoves moves;
    int64_t robot;
    int64_t which;
    const int32_t *distances;
    const int64_t *planned;  // robots planned so far
    int64_t planned_count;
    const Track *tracks;
    int64_t quiet;  // first tick after which nothing changes
    State *states;
    int64_t count;
    int64_t room;
    int64_t *table;  // hash of states: index + 1, or 0
    int64_t mask;
    WgHeap heap;
} Among;

static int64_t track_at(const Track *track, int64_t tick)
{
    assert(tick >= 0 && track->length >= 0);
    return track->nodes[wg_min(tick, track->length)];
}

static bool meets_planned(const Among *among, int64_t from, int64_t to, int64_t tick)
{
    for (int64_t i = 0; i < among->planned_count; i++) {
        int64_t other = among->planned[i];
        const Track *track = &among->tracks[other];
        if (wg_moves_conflict(among->joint, among->which, from, to, among->joint->class_of[other],
                              track_at(track, tick), track_at(track, tick + 1))) {
            return true;
        }
    }
    return false;
}

// Returns whether the robot can stand at a node forever, starting at a tick.
static bool can_park(const Among *among, int64_t node, int64_t tick)
{
    for (int64_t t = tick; t <= wg_max(among->quiet, tick); t++) {
        if (among->joint->clear[wg_raster_at(among->joint, t, among->which) + node] == 0 ||
            meets_planned(among, node, node, t)) {
            return false;
        }
    }
    return true;
}

static uint64_t hash_of(int64_t node, int64_t tick)
{
    uint64_t key = (uint64_t)node * 0x9E3779B97F4A7C15u ^ (uint64_t)tick * 0xC2B2AE3D27D4EB4Fu;
    return key ^ key >> 29;
}

static bool grow_table(Among *among)
{
    int64_t size = 4 * (among->mask + 1);
    int64_t *table = calloc((size_t)size, sizeof *table);
    if (table == NULL) {
        return false;
    }
    for (int64_t i = 0; i < among->count; i++) {
        uint64_t at = hash_of(among->states[i].node, wg_min(among->states[i].tick, among->quiet));
        while (table[at & (uint64_t)(size - 1)] != 0) {
            at++;
        }
        table[at & (uint64_t)(size - 1)] = i + 1;
    }
    free(among->table);
    among->table = table;
    among->mask = size - 1;
    return true;
}

// Adds a state that was not reached before; returns false if memory runs out.
static bool reach(Among *among, int64_t node, int64_t tick, int64_t parent)
{
    // After the last change only the node matters, because waiting longer opens no new path.
    int64_t moment = wg_min(tick, among->quiet);
    uint64_t at = hash_of(node, moment);
    for (; among->table[at & (uint64_t)among->mask] != 0; at++) {
        const State *known = &among->states[among->table[at & (uint64_t)among->mask] - 1];
        if (known->node == node && wg_min(known->tick, among->quiet) == moment) {
            return true;
        }
    }
    if (among->count == among->room) {
        int64_t room = 2 * among->room + 1024;
        State *states = realloc(among->states, (size_t)room * sizeof *states);
        if (states == NULL) {
            return false;
        }
        among->states = states;
        among->room = room;
    }
    among->table[at & (uint64_t)among->mask] = among->count + 1;
    among->states[among->count] = (State){(int32_t)node, (int32_t)tick, (int32_t)parent};
    among->count++;
    // Among equal estimates, the later state is nearer to the target.
    if (!wg_heap_push(&among->heap, (WgEntry){tick + among->distances[node], -tick, among->count - 1})) {
        return false;
    }
    return 2 * among->count < among->mask || grow_table(among);
}

// Stores the path that ends in a state as the robot's track; returns false if memory runs out.
static bool keep_track(const Among *among, int64_t last, Track *track)
{
    track->length = among->states[last].tick;
    track->nodes = calloc((size_t)track->length + 1, sizeof *track->nodes);
    if (track->nodes == NULL) {
        return false;
    }
    for (int64_t i = last; i >= 0; i = among->states[i].parent) {
        track->nodes[among->states[i].tick] = among->states[i].node;
    }
    return true;
}

static WgStatus search_among(Among *among, int64_t most, Track *track, bool *found)
{
    const WgJoint *joint = among->joint;
    int64_t start = joint->starts[among->robot];
    *found = false;
    if (among->distances[start] < 0) {
        return WG_OK;
    }
    if (!reach(among, start, 0, -1)) {
        return WG_OUT_OF_MEMORY;
    }
    while (among->heap.count > 0 && among->count <= most) {
        int64_t index = wg_heap_pop(&among->heap).third;
        State state = among->states[index];
        // A robot in its target has parked, so such a state is reached only if the robot can stay there.
        if (among->distances[state.node] == 0) {
            if (state.parent < 0 && !can_park(among, state.node, 0)) {
                return WG_OK;
            }
            *found = true;
            return keep_track(among, index, track) ? WG_OK : WG_OUT_OF_MEMORY;
        }
        int64_t raster = wg_raster_at(joint, state.tick, among->which);
        if (joint->clear[raster + state.node] == 0) {
            continue;
        }
        for (int move = 0; move < WG_MOVES; move++) {
            int64_t next = state.node + among->moves.shifts[move];
            bool stuck = among->distances[next] < 0 ||
                         !wg_move_is_clear(joint, &among->moves, raster, state.node, move) ||
                         wg_crosses_target(joint, among->robot, state.node, move) ||
                         meets_planned(among, state.node, next, state.tick);
            if (stuck || (among->distances[next] == 0 && !can_park(among, next, state.tick + 1))) {
                continue;
            }
            if (!reach(among, next, state.tick + 1, index)) {
                return WG_OUT_OF_MEMORY;
            }
        }
    }
    return WG_OK;
}

static WgStatus plan_one(Among *among, int64_t most, Track *track, bool *found)
{
    among->mask = 4095;
    among->table = calloc((size_t)among->mask + 1, sizeof *among->table);
    WgStatus status = among->table == NULL ? WG_OUT_OF_MEMORY : search_among(among, most, track, found);
    free(among->table);
    free(among->states);
    free(among->heap.entries);
    return status;
}

static WgStatus joined(const Track *tracks, int64_t robots, WgJointPlan **made)
{
    int64_t length = 0;
    for (int64_t robot = 0; robot < robots; robot++) {
        length = wg_max(length, tracks[robot].length);
    }
    *made = wg_joint_plan_new(robots, length);
    if (*made == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    for (int64_t tick = 0; tick <= length; tick++) {
        for (int64_t robot = 0; robot < robots; robot++) {
            (*made)->nodes[tick * robots + robot] = (int32_t)track_at(&tracks[robot], tick);
        }
    }
    return WG_OK;
}

WgStatus wg_joint_prioritised(const WgJoint *joint, const int64_t *order, int64_t most, WgJointPlan **made,
                              int64_t *failed)
{
    *made = NULL;
    *failed = -1;
    WgStatus status = wg_joint_check(joint);
    if (status != WG_OK) {
        return status;
    }
    if (most > INT32_MAX - WG_MOVES) {
        return WG_BAD_VALUE;
    }
    int64_t robots = joint->robots;
    for (int64_t i = 0; i < robots; i++) {
        if (order[i] < 0 || order[i] >= robots) {
            return WG_BAD_VALUE;
        }
    }
    Track *tracks = calloc((size_t)wg_max(robots, 1), sizeof *tracks);
    if (tracks == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    int64_t quiet = joint->ticks - 1;
    for (int64_t i = 0; i < robots && status == WG_OK && *failed < 0; i++) {
        int64_t robot = order[i];
        if (tracks[robot].nodes != NULL) {
            status = WG_BAD_VALUE;
            break;
        }
        Among among = {
            .joint = joint,
            .moves = wg_moves(joint),
            .robot = robot,
            .which = joint->class_of[robot],
            .distances = joint->distances + robot * joint->nodes,
            .planned = order,
            .planned_count = i,
            .tracks = tracks,
            .quiet = quiet,
        };
        bool found = false;
        status = plan_one(&among, most, &tracks[robot], &found);
        if (status == WG_OK && !found) {
            *failed = robot;
        }
        quiet = wg_max(quiet, tracks[robot].length);
    }
    if (status == WG_OK && *failed < 0) {
        status = joined(tracks, robots, made);
    }
    for (int64_t robot = 0; robot < robots; robot++) {
        free(tracks[robot].nodes);
    }
    free(tracks);
    return status;
}

// Joint plans by priority: one robot after the other, each around those before it.
//
// Erdmann, Lozano-Perez, "On Multiple Moving Objects" (1987), for planning by priority.
// Phillips, Likhachev, "SIPP: Safe Interval Path Planning for Dynamic Environments" (2011), for the search: a state is a
// node and an interval of ticks in which the robot can stand there, and only the earliest arrival matters.

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "heap.h"
#include "joint.h"

// A robot's path once it is planned; it waits at the end.
typedef struct Track {
    int32_t *nodes;
    int64_t length;
} Track;

// A planned robot that is near the nodes of a bucket in one tick, or from a tick on if it parks.
typedef struct Stay {
    int32_t tick;
    int32_t bucket;
    int32_t robot;
    int32_t earlier;  // the stay before it in the bucket: index + 1, or 0
    int32_t next;     // in its list in `moving`: index + 1, or 0
} Stay;

// The planned robots by bucket, a square of nodes, and tick, so that a move is compared only with those near it.
typedef struct Reservations {
    const WgJoint *joint;
    Track *tracks;
    int64_t reach;    // nodes across or up within which robots can conflict
    int64_t side;     // nodes along a bucket's side
    int64_t columns;  // buckets in a row
    int32_t *latest;  // by bucket: its last stay, from which `earlier` leads to all others
    int32_t *parked;  // by bucket: its last stay of a robot that parks, from which `next` leads to the others
    int32_t *moving;  // by hash of bucket and tick: list of the stays of moving robots
    int64_t mask;
    Stay *stays;
    int64_t count;
    int64_t room;
    int64_t moves;  // stays in lists of `moving`
    int64_t quiet;  // first tick after which nothing changes
} Reservations;

// A state of one robot: the earliest tick at which it is at a node in a safe interval, and the parent state.
typedef struct State {
    int32_t node;
    int32_t tick;
    int32_t begin;  // of the interval
    int32_t parent;
} State;

// The search for one robot among the robots planned before it.
typedef struct Among {
    const WgJoint *joint;
    const Reservations *reserved;
    WgMoves moves;
    int64_t robot;
    int64_t which;
    const int32_t *distances;
    State *states;
    int64_t count;
    int64_t room;
    int64_t *table;  // hash of nodes and intervals: index of their earliest state + 1, or 0
    int64_t mask;
    WgHeap heap;
    int32_t *rows;  // by node: number of its row in `unsafe` + 1, or 0
    uint64_t *unsafe;  // (row_count, words): bit t of a row is set if the robot cannot wait at that node in tick t
    int64_t row_count;
    int64_t row_room;
    int64_t words;
} Among;

static uint64_t mixed(int64_t one, int64_t other)
{
    uint64_t key = (uint64_t)one * 0x9E3779B97F4A7C15u ^ (uint64_t)other * 0xC2B2AE3D27D4EB4Fu;
    return key ^ key >> 29;
}

static int64_t track_at(const Track *track, int64_t tick)
{
    assert(tick >= 0 && track->length >= 0);
    return track->nodes[wg_min(tick, track->length)];
}

static WgStatus begin_reservations(Reservations *reserved, const WgJoint *joint)
{
    int64_t reach = joint->reach + 2;
    int64_t side = 2 * reach + 1;
    *reserved = (Reservations){
        .joint = joint,
        .reach = reach,
        .side = side,
        .columns = joint->stride / side + 1,
        .mask = 1023,
        .quiet = joint->ticks - 1,
    };
    int64_t buckets = reserved->columns * (joint->nodes / joint->stride / side + 1);
    reserved->tracks = calloc((size_t)joint->robots, sizeof *reserved->tracks);
    reserved->latest = calloc((size_t)buckets, sizeof *reserved->latest);
    reserved->parked = calloc((size_t)buckets, sizeof *reserved->parked);
    reserved->moving = calloc((size_t)reserved->mask + 1, sizeof *reserved->moving);
    bool fits = reserved->tracks != NULL && reserved->latest != NULL && reserved->parked != NULL &&
                reserved->moving != NULL;
    return fits ? WG_OK : WG_OUT_OF_MEMORY;
}

static void end_reservations(Reservations *reserved)
{
    for (int64_t robot = 0; reserved->tracks != NULL && robot < reserved->joint->robots; robot++) {
        free(reserved->tracks[robot].nodes);
    }
    free(reserved->tracks);
    free(reserved->latest);
    free(reserved->parked);
    free(reserved->moving);
    free(reserved->stays);
}

static int32_t *list_of_moving(const Reservations *reserved, int64_t bucket, int64_t tick)
{
    return &reserved->moving[mixed(bucket, tick) & (uint64_t)reserved->mask];
}

// Puts a stay at the head of a list and of its bucket; returns false if memory runs out.
static bool add_stay(Reservations *reserved, int32_t *list, Stay stay)
{
    if (reserved->count == reserved->room) {
        int64_t room = 2 * reserved->room + 1024;
        Stay *stays = room < INT32_MAX ? realloc(reserved->stays, (size_t)room * sizeof *stays) : NULL;
        if (stays == NULL) {
            return false;
        }
        reserved->stays = stays;
        reserved->room = room;
    }
    stay.next = *list;
    stay.earlier = reserved->latest[stay.bucket];
    reserved->stays[reserved->count] = stay;
    *list = (int32_t)++reserved->count;
    reserved->latest[stay.bucket] = *list;
    return true;
}

// Makes room for more moving robots, so that lists stay short; returns false if memory runs out.
static bool grow_moving(Reservations *reserved)
{
    int64_t size = 4 * (reserved->mask + 1);
    int32_t *moving = calloc((size_t)size, sizeof *moving);
    if (moving == NULL) {
        return false;
    }
    // Move every list's stays to the lists of the larger table.
    int32_t *old = reserved->moving;
    int64_t old_size = reserved->mask + 1;
    reserved->moving = moving;
    reserved->mask = size - 1;
    for (int64_t i = 0; i < old_size; i++) {
        for (int32_t at = old[i]; at != 0;) {
            Stay *stay = &reserved->stays[at - 1];
            int32_t next = stay->next;
            int32_t *list = list_of_moving(reserved, stay->bucket, stay->tick);
            stay->next = *list;
            *list = at;
            at = next;
        }
    }
    free(old);
    return true;
}

// Reserves a robot's whole path; returns false if memory runs out.
static bool reserve(Reservations *reserved, int64_t robot)
{
    const Track *track = &reserved->tracks[robot];
    int64_t stride = reserved->joint->stride;
    int64_t rows = reserved->joint->nodes / stride;
    int64_t side = reserved->side;
    for (int64_t tick = 0; tick <= track->length; tick++) {
        // Add the robot to every bucket with a node near enough to its own.
        int64_t x = track->nodes[tick] % stride;
        int64_t y = track->nodes[tick] / stride;
        int64_t right = wg_min(x + reserved->reach, stride - 1) / side;
        int64_t top = wg_min(y + reserved->reach, rows - 1) / side;
        for (int64_t v = wg_max(y - reserved->reach, 0) / side; v <= top; v++) {
            for (int64_t u = wg_max(x - reserved->reach, 0) / side; u <= right; u++) {
                int64_t bucket = v * reserved->columns + u;
                bool parks = tick == track->length;
                int32_t *list = parks ? &reserved->parked[bucket] : list_of_moving(reserved, bucket, tick);
                if (!add_stay(reserved, list, (Stay){(int32_t)tick, (int32_t)bucket, (int32_t)robot, 0, 0})) {
                    return false;
                }
                reserved->moves += parks ? 0 : 1;
                if (2 * reserved->moves > reserved->mask && !grow_moving(reserved)) {
                    return false;
                }
            }
        }
    }
    reserved->quiet = wg_max(reserved->quiet, track->length);
    return true;
}

// Returns true if a move in a tick of a stay comes too close to the robot that stays.
static bool conflicts(const Among *among, int64_t from, int64_t to, const Stay *stay)
{
    const Track *track = &among->reserved->tracks[stay->robot];
    return wg_moves_conflict(among->joint, among->which, from, to, among->joint->class_of[stay->robot],
                             track_at(track, stay->tick), track_at(track, (int64_t)stay->tick + 1));
}

static int64_t bucket_of(const Among *among, int64_t node)
{
    const Reservations *reserved = among->reserved;
    int64_t stride = among->joint->stride;
    return node / stride / reserved->side * reserved->columns + node % stride / reserved->side;
}

// Returns true if a move in a tick comes too close to a planned robot.
static bool meets_planned(const Among *among, int64_t from, int64_t to, int64_t tick)
{
    const Reservations *reserved = among->reserved;
    int64_t bucket = bucket_of(among, from);
    const Stay *stay;
    for (int32_t at = reserved->parked[bucket]; at != 0; at = stay->next) {
        stay = &reserved->stays[at - 1];
        if (tick >= stay->tick && conflicts(among, from, to, stay)) {
            return true;
        }
    }
    for (int32_t at = *list_of_moving(reserved, bucket, tick); at != 0; at = stay->next) {
        stay = &reserved->stays[at - 1];
        if (stay->tick == tick && stay->bucket == bucket && conflicts(among, from, to, stay)) {
            return true;
        }
    }
    return false;
}

static void mark(uint64_t *row, int64_t tick)
{
    row[tick / 64] |= (uint64_t)1 << tick % 64;
}

// Marks the ticks in which the robot cannot wait at a node; returns true if there are any.
static bool mark_unsafe_waits(const Among *among, int64_t node, uint64_t *row)
{
    const WgJoint *joint = among->joint;
    int64_t quiet = among->reserved->quiet;
    bool any = false;
    // Nothing but the last raster counts after the last change.
    for (int64_t tick = 0; tick < joint->ticks; tick++) {
        if (joint->clear[wg_raster_at(joint, tick, among->which) + node] == 0) {
            any = true;
            mark(row, tick);
            for (int64_t t = tick; tick == joint->ticks - 1 && t <= quiet; t++) {
                mark(row, t);
            }
        }
    }
    const Stay *stay;
    for (int32_t at = among->reserved->latest[bucket_of(among, node)]; at != 0; at = stay->earlier) {
        stay = &among->reserved->stays[at - 1];
        if (conflicts(among, node, node, stay)) {
            any = true;
            bool parks = stay->tick == among->reserved->tracks[stay->robot].length;
            for (int64_t t = stay->tick; t <= (parks ? quiet : stay->tick); t++) {
                mark(row, t);
            }
        }
    }
    return any;
}

// Returns the row of bits of the ticks in which the robot cannot wait at a node; NULL if memory runs out.
static const uint64_t *unsafe_waits(Among *among, int64_t node)
{
    if (among->rows[node] != 0) {
        return among->unsafe + (among->rows[node] - 1) * among->words;
    }
    // Keep a row free for the next node. The first one stays empty, for all nodes that are always safe.
    if (among->row_count + 2 > among->row_room) {
        int64_t room = 2 * among->row_room + 256;
        uint64_t *unsafe = realloc(among->unsafe, (size_t)(room * among->words) * sizeof *unsafe);
        if (unsafe == NULL) {
            return NULL;
        }
        size_t old = (size_t)(among->row_room * among->words);
        memset(unsafe + old, 0, ((size_t)(room * among->words) - old) * sizeof *unsafe);
        among->unsafe = unsafe;
        among->row_room = room;
        among->row_count = wg_max(among->row_count, 1);
    }
    if (mark_unsafe_waits(among, node, among->unsafe + among->row_count * among->words)) {
        among->rows[node] = (int32_t)++among->row_count;
    } else {
        among->rows[node] = 1;
    }
    return among->unsafe + (among->rows[node] - 1) * among->words;
}

static bool is_unsafe(const uint64_t *row, int64_t tick)
{
    return (row[tick / 64] >> tick % 64 & 1) != 0;
}

// Returns the first tick, from a tick on, in which the robot cannot wait; a later one than it and `quiet` if there is none.
static int64_t end_of_interval(const Among *among, const uint64_t *row, int64_t tick)
{
    int64_t quiet = among->reserved->quiet;
    for (int64_t t = tick; t <= quiet; t++) {
        if (t % 64 == 0 && row[t / 64] == 0) {
            t += 63;
        } else if (is_unsafe(row, t)) {
            return t;
        }
    }
    return wg_max(quiet, tick) + 1;
}

// Returns the first tick of the interval that a tick is in.
static int64_t begin_of_interval(const Among *among, const uint64_t *row, int64_t tick)
{
    for (int64_t t = wg_min(tick - 1, among->reserved->quiet); t >= 0; t--) {
        if (t % 64 == 63 && row[t / 64] == 0) {
            t -= 63;
        } else if (is_unsafe(row, t)) {
            return t + 1;
        }
    }
    return 0;
}

static bool grow_table(Among *among)
{
    int64_t size = 4 * (among->mask + 1);
    int64_t *table = calloc((size_t)size, sizeof *table);
    if (table == NULL) {
        return false;
    }
    // Of each node and interval, only the earliest state is in the table.
    for (int64_t i = 0; i <= among->mask; i++) {
        if (among->table[i] == 0) {
            continue;
        }
        const State *state = &among->states[among->table[i] - 1];
        uint64_t at = mixed(state->node, state->begin);
        while (table[at & (uint64_t)(size - 1)] != 0) {
            at++;
        }
        table[at & (uint64_t)(size - 1)] = among->table[i];
    }
    free(among->table);
    among->table = table;
    among->mask = size - 1;
    return true;
}

// Returns the entry of a node and interval in the table, which is 0 if no state of theirs was reached.
static int64_t *entry_of(const Among *among, int64_t node, int64_t begin)
{
    for (uint64_t at = mixed(node, begin);; at++) {
        int64_t *entry = &among->table[at & (uint64_t)among->mask];
        if (*entry == 0 || (among->states[*entry - 1].node == node && among->states[*entry - 1].begin == begin)) {
            return entry;
        }
    }
}

// Adds a state, unless its node and interval were reached as early; returns false if memory runs out.
static bool reach(Among *among, int64_t node, int64_t tick, int64_t parent)
{
    const uint64_t *row = unsafe_waits(among, node);
    if (row == NULL) {
        return false;
    }
    int64_t begin = begin_of_interval(among, row, tick);
    int64_t *entry = entry_of(among, node, begin);
    if (*entry != 0 && among->states[*entry - 1].tick <= tick) {
        return true;
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
    among->states[among->count] = (State){(int32_t)node, (int32_t)tick, (int32_t)begin, (int32_t)parent};
    *entry = ++among->count;
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
    // The robot waits at each node until it leaves for the next one.
    int64_t end = track->length;
    for (int64_t i = last; i >= 0; i = among->states[i].parent) {
        for (int64_t tick = among->states[i].tick; tick <= end; tick++) {
            track->nodes[tick] = among->states[i].node;
        }
        end = (int64_t)among->states[i].tick - 1;
    }
    return true;
}

// Makes a step to a neighbour at the earliest tick for each of its intervals.
static WgStatus step_to(Among *among, int64_t index, int move)
{
    const WgJoint *joint = among->joint;
    State state = among->states[index];
    int64_t next = state.node + among->moves.shifts[move];
    if (among->distances[next] < 0 || wg_crosses_target(joint, among->robot, state.node, move)) {
        return WG_OK;
    }
    const uint64_t *here = unsafe_waits(among, state.node);
    int64_t last = here == NULL ? 0 : end_of_interval(among, here, state.tick);
    const uint64_t *there = here == NULL ? NULL : unsafe_waits(among, next);
    if (there == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    int64_t first = state.tick;
    // A robot in its target parks, so it has to be able to stay there.
    if (among->distances[next] == 0) {
        int64_t quiet = among->reserved->quiet;
        if (is_unsafe(there, quiet)) {
            return WG_OK;
        }
        first = wg_max(first, begin_of_interval(among, there, quiet) - 1);
    }
    // After the last change, waiting opens no path.
    last = wg_min(last, wg_max(among->reserved->quiet, first));
    for (int64_t tick = first; tick <= last; tick++) {
        int64_t raster = wg_raster_at(joint, tick, among->which);
        if (joint->clear[raster + state.node] == 0 ||
            !wg_move_is_clear(joint, &among->moves, raster, state.node, move) ||
            meets_planned(among, state.node, next, tick)) {
            continue;
        }
        if (!reach(among, next, tick + 1, index)) {
            return WG_OUT_OF_MEMORY;
        }
        // Later arrivals in the same interval are no better; the next interval begins after its end.
        there = unsafe_waits(among, next);
        tick = end_of_interval(among, there, tick + 1) - 1;
    }
    return WG_OK;
}

static WgStatus search_among(Among *among, int64_t most, Track *track, bool *found)
{
    int64_t start = among->joint->starts[among->robot];
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
        if (*entry_of(among, state.node, state.begin) != index + 1) {
            continue;  // it was reached earlier since
        }
        // A robot in its target has parked. Steps lead there only if it can stay; a robot that starts there may not.
        if (among->distances[state.node] == 0) {
            const uint64_t *row = unsafe_waits(among, state.node);
            if (row == NULL) {
                return WG_OUT_OF_MEMORY;
            }
            if (state.parent < 0 && end_of_interval(among, row, 0) <= among->reserved->quiet) {
                return WG_OK;
            }
            *found = true;
            return keep_track(among, index, track) ? WG_OK : WG_OUT_OF_MEMORY;
        }
        for (int move = 0; move < WG_WAIT; move++) {
            WgStatus status = step_to(among, index, move);
            if (status != WG_OK) {
                return status;
            }
        }
    }
    return WG_OK;
}

static WgStatus plan_one(Among *among, int64_t most, Track *track, bool *found)
{
    among->mask = 4095;
    among->words = among->reserved->quiet / 64 + 1;
    among->table = calloc((size_t)among->mask + 1, sizeof *among->table);
    among->rows = calloc((size_t)among->joint->nodes, sizeof *among->rows);
    bool fits = among->table != NULL && among->rows != NULL;
    WgStatus status = fits ? search_among(among, most, track, found) : WG_OUT_OF_MEMORY;
    free(among->table);
    free(among->rows);
    free(among->unsafe);
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
    Reservations reserved;
    status = begin_reservations(&reserved, joint);
    for (int64_t i = 0; i < robots && status == WG_OK && *failed < 0; i++) {
        int64_t robot = order[i];
        if (reserved.tracks[robot].nodes != NULL) {
            status = WG_BAD_VALUE;
            break;
        }
        Among among = {
            .joint = joint,
            .reserved = &reserved,
            .moves = wg_moves(joint),
            .robot = robot,
            .which = joint->class_of[robot],
            .distances = joint->distances + robot * joint->nodes,
        };
        bool found = false;
        status = plan_one(&among, most, &reserved.tracks[robot], &found);
        if (status == WG_OK && !found) {
            *failed = robot;
        } else if (status == WG_OK && !reserve(&reserved, robot)) {
            status = WG_OUT_OF_MEMORY;
        }
    }
    if (status == WG_OK && *failed < 0) {
        status = joined(reserved.tracks, robots, made);
    }
    end_reservations(&reserved);
    return status;
}

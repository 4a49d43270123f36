// Joint plans by priority: one robot after another, each around those before it.
//
// A state of the search is a node and an interval of ticks in which the robot can be there. Only
// the earliest arrival in an interval matters, because the robot can wait there until the interval
// ends.
//
// Planning by priority: Erdmann, Lozano-Perez, "On Multiple Moving Objects" (1987).
// The search: Phillips, Likhachev, "SIPP: Safe Interval Path Planning for Dynamic Environments"
// (2011).

#include <stdlib.h>

#include "heap.h"
#include "reservations.h"

// A tick that never comes: the end of an interval that lasts forever.
static const int32_t NEVER = INT32_MAX;
// Spans of one search, 256 MiB: a search that needs more ends as if it had reached too many states.
static const int64_t MOST_SPANS = (int64_t)1 << 25;

// Ticks in which a robot cannot wait at a node, from the first to the last.
typedef struct Span {
    int32_t first;
    int32_t last;
} Span;

// The spans of one node, in ascending order and disjoint; they become invalid when another node's
// spans are made.
typedef struct Spans {
    const Span *items;
    int64_t count;
} Spans;

// A time in which no wall changes: it lasts until the next one begins.
typedef struct Period {
    int64_t tick;
    int64_t raster;
} Period;

// A state of one robot: the earliest tick at which it is at a node in a safe interval,
// and the parent state.
typedef struct State {
    int32_t node;
    int32_t tick;
    int32_t begin;  // begin of the interval
    int32_t parent;
} State;

// The search for one robot among the robots planned before it.
typedef struct RobotSearch {
    const WgJoint *joint;
    const WgReservations *reserved;
    const Period *periods;
    int64_t period_count;
    WgMoves moves;
    WgJointRobot robot;
    int64_t robot_class;
    const int32_t *distances;
    State *states;
    int64_t count;
    int64_t capacity;
    int64_t *table;  // hash table of nodes and intervals: index of their earliest state + 1, or 0
    int64_t mask;
    WgHeap heap;
    int64_t most;          // states that it may reach
    int64_t work;          // ticks, and spans and stays of nodes, that it examined
    int64_t *spans_from;   // by node: where its spans begin + 1, or 0 if they were not made yet
    int32_t *spans_count;  // by node
    Span *spans;
    int64_t span_count;
    int64_t span_capacity;
} RobotSearch;

// Appends a span; returns false if memory runs out.
static bool add_span(RobotSearch *search, int64_t first, int64_t last)
{
    if (search->span_count == search->span_capacity) {
        int64_t capacity = 2 * search->span_capacity;
        Span *spans = realloc(search->spans, (size_t)capacity * sizeof *spans);
        if (spans == NULL) {
            return false;
        }
        search->spans = spans;
        search->span_capacity = capacity;
    }
    search->spans[search->span_count++] = (Span){(int32_t)first, (int32_t)last};
    return true;
}

static int compare_spans(const void *one, const void *other)
{
    int32_t a = ((const Span *)one)->first;
    int32_t b = ((const Span *)other)->first;
    return (a > b) - (a < b);
}

// Sorts the spans starting at an index and joins those without a tick between them.
static void join_spans(RobotSearch *search, int64_t from)
{
    int64_t count = search->span_count - from;
    if (count < 2) {
        return;
    }
    Span *spans = search->spans + from;
    qsort(spans, (size_t)count, sizeof *spans, compare_spans);
    int64_t last = 0;
    for (int64_t i = 1; i < count; i++) {
        if (spans[last].last == NEVER || spans[i].first <= spans[last].last + 1) {
            spans[last].last = (int32_t)wg_max(spans[last].last, spans[i].last);
        } else {
            spans[++last] = spans[i];
        }
    }
    search->span_count = from + last + 1;
}

// Adds the spans of a node; returns false if memory runs out.
static bool make_spans(RobotSearch *search, int64_t node)
{
    const WgJoint *joint = search->joint;
    int64_t from = search->span_count;
    for (int64_t i = 0; i < search->period_count; i++) {
        const Period *period = &search->periods[i];
        if (joint->clear[(period->raster * joint->classes + search->robot_class) * joint->nodes + node] == 0) {
            int64_t last = i + 1 < search->period_count ? period[1].tick - 1 : NEVER;
            if (!add_span(search, period->tick, last)) {
                return false;
            }
        }
    }
    const WgReservations *reserved = search->reserved;
    int64_t x = node % joint->stride;
    int64_t y = node / joint->stride;
    const WgStay *stay;
    search->work += search->period_count;
    for (int32_t at = reserved->latest[wg_bucket_of(reserved, node)]; at != 0; at = stay->earlier) {
        stay = &reserved->stays[at - 1];
        search->work++;
        if (wg_is_near_stay(reserved, x, y, stay) &&
            wg_meets_stay(reserved, search->robot_class, node, node, stay)) {
            bool parks = stay->tick == reserved->tracks[stay->robot].length;
            if (!add_span(search, stay->tick, parks ? NEVER : stay->tick)) {
                return false;
            }
        }
    }
    join_spans(search, from);
    search->spans_from[node] = from + 1;
    search->spans_count[node] = (int32_t)(search->span_count - from);
    return true;
}

// Finds the ticks in which the robot cannot wait at a node; returns false if memory runs out.
static bool unsafe_spans(RobotSearch *search, int64_t node, Spans *found)
{
    if (search->spans_from[node] == 0 && !make_spans(search, node)) {
        return false;
    }
    *found = (Spans){search->spans + (search->spans_from[node] - 1), search->spans_count[node]};
    return true;
}

// Returns the first tick at or after the given one in which the robot cannot wait.
// If there is none, returns NEVER.
static int64_t end_of_interval(Spans unsafe, int64_t tick)
{
    for (int64_t i = 0; i < unsafe.count; i++) {
        if (unsafe.items[i].last >= tick) {
            return wg_max(unsafe.items[i].first, tick);
        }
    }
    return NEVER;
}

// Returns the first tick of the interval that a tick is in.
static int64_t begin_of_interval(Spans unsafe, int64_t tick)
{
    for (int64_t i = unsafe.count - 1; i >= 0; i--) {
        if (unsafe.items[i].first < tick) {
            return unsafe.items[i].last < tick ? (int64_t)unsafe.items[i].last + 1 : tick;
        }
    }
    return 0;
}

static bool grow_table(RobotSearch *search)
{
    int64_t size = 4 * (search->mask + 1);
    int64_t *table = calloc((size_t)size, sizeof *table);
    if (table == NULL) {
        return false;
    }
    // For each node and interval, only the earliest state is in the table.
    for (int64_t i = 0; i <= search->mask; i++) {
        if (search->table[i] == 0) {
            continue;
        }
        const State *state = &search->states[search->table[i] - 1];
        uint64_t at = wg_mixed(state->node, state->begin);
        while (table[at & (uint64_t)(size - 1)] != 0) {
            at++;
        }
        table[at & (uint64_t)(size - 1)] = search->table[i];
    }
    free(search->table);
    search->table = table;
    search->mask = size - 1;
    return true;
}

// Returns the table's entry for a node and interval, which is 0 if none of their states was
// reached.
static int64_t *entry_of(const RobotSearch *search, int64_t node, int64_t begin)
{
    for (uint64_t at = wg_mixed(node, begin);; at++) {
        int64_t *entry = &search->table[at & (uint64_t)search->mask];
        if (*entry == 0 || (search->states[*entry - 1].node == node && search->states[*entry - 1].begin == begin)) {
            return entry;
        }
    }
}

// Adds a state, unless its node and interval were reached as early;
// returns false if memory runs out.
static bool reach(RobotSearch *search, int64_t node, int64_t tick, int64_t parent)
{
    Spans unsafe;
    if (!unsafe_spans(search, node, &unsafe)) {
        return false;
    }
    int64_t begin = begin_of_interval(unsafe, tick);
    int64_t *entry = entry_of(search, node, begin);
    if (*entry != 0 && search->states[*entry - 1].tick <= tick) {
        return true;
    }
    if (search->count == search->capacity) {
        int64_t capacity = 2 * search->capacity;
        State *states = capacity < INT32_MAX ? realloc(search->states, (size_t)capacity * sizeof *states) : NULL;
        if (states == NULL) {
            return false;
        }
        search->states = states;
        search->capacity = capacity;
    }
    search->states[search->count] = (State){(int32_t)node, (int32_t)tick, (int32_t)begin, (int32_t)parent};
    *entry = ++search->count;
    // Among equal estimates, the later state is nearer to the target.
    if (!wg_heap_push(&search->heap, (WgEntry){tick + search->distances[node], -tick, search->count - 1})) {
        return false;
    }
    return 2 * search->count < search->mask || grow_table(search);
}

// Stores the path that ends in a state as the robot's track; returns false if memory runs out.
static bool keep_track(const RobotSearch *search, int64_t last, WgTrack *track)
{
    track->length = search->states[last].tick;
    track->nodes = calloc((size_t)track->length + 1, sizeof *track->nodes);
    if (track->nodes == NULL) {
        return false;
    }
    // The robot waits at each node until it leaves for the next one.
    int64_t end = track->length;
    for (int64_t i = last; i >= 0; i = search->states[i].parent) {
        for (int64_t tick = search->states[i].tick; tick <= end; tick++) {
            track->nodes[tick] = search->states[i].node;
        }
        end = (int64_t)search->states[i].tick - 1;
    }
    return true;
}

// Steps to a neighbour, as early as possible in each of its safe intervals.
static WgStatus step_to(RobotSearch *search, int64_t index, int move)
{
    const WgJoint *joint = search->joint;
    const WgReservations *reserved = search->reserved;
    State state = search->states[index];
    int64_t next = state.node + search->moves.shifts[move];
    if (search->distances[next] < 0 || wg_crosses_target(search->robot.crossings, search->robot.crossing_count, state.node, move)) {
        return WG_OK;
    }
    Spans unsafe;
    if (!unsafe_spans(search, state.node, &unsafe)) {
        return WG_OUT_OF_MEMORY;
    }
    int64_t last = end_of_interval(unsafe, state.tick);
    if (!unsafe_spans(search, next, &unsafe)) {
        return WG_OUT_OF_MEMORY;
    }
    int64_t first = state.tick;
    // A robot in its target parks, so it has to be able to stay there.
    if (search->distances[next] == 0 && unsafe.count > 0) {
        int64_t blocked_until = unsafe.items[unsafe.count - 1].last;
        if (blocked_until == NEVER) {
            return WG_OK;
        }
        first = wg_max(first, blocked_until);
    }
    // After the last change, waiting opens no path.
    last = wg_min(last, wg_max(reserved->last_change, first));
    for (int64_t tick = first; tick <= last; tick++) {
        search->work++;
        int64_t raster = wg_raster_at(joint, tick, search->robot_class);
        bool is_free = joint->clear[raster + state.node] != 0 &&
                       wg_move_is_clear(joint, &search->moves, raster, state.node, move);
        // Walls never make room after their last change, and neither does a parked robot.
        if ((!is_free && tick >= joint->ticks - 1) ||
            wg_meets_parked(reserved, search->robot_class, state.node, next, tick)) {
            break;
        }
        if (!is_free || wg_meets_moving(reserved, search->robot_class, state.node, next, tick)) {
            continue;
        }
        if (!reach(search, next, tick + 1, index) || !unsafe_spans(search, next, &unsafe)) {
            return WG_OUT_OF_MEMORY;
        }
        // Later arrivals in the same interval are no better;
        // the next interval begins after its end.
        tick = end_of_interval(unsafe, tick + 1) - 1;
    }
    return WG_OK;
}

// Continues until the search is done or has examined about ``most`` more ticks and spans.
static WgStatus search_path(RobotSearch *search, int64_t most, WgTrack *track, WgProgress *progress)
{
    int64_t enough = search->work + most;
    *progress = WG_EXHAUSTED;
    while (search->heap.count > 0) {
        if (search->count > search->most || search->span_count > MOST_SPANS) {
            *progress = WG_GAVE_UP;
            return WG_OK;
        }
        if (search->work >= enough) {
            *progress = WG_GOING;
            return WG_OK;
        }
        search->work++;
        int64_t index = wg_heap_pop(&search->heap).third;
        State state = search->states[index];
        // Skip a state that was reached earlier after it was queued.
        if (*entry_of(search, state.node, state.begin) != index + 1) {
            continue;
        }
        // A robot in its target has parked. Steps lead there only if it can stay;
        // a robot that starts there may not.
        if (search->distances[state.node] == 0) {
            if (state.parent < 0 && search->spans_count[state.node] > 0) {
                return WG_OK;
            }
            *progress = WG_FOUND;
            return keep_track(search, index, track) ? WG_OK : WG_OUT_OF_MEMORY;
        }
        for (int move = 0; move < WG_WAIT; move++) {
            WgStatus status = step_to(search, index, move);
            if (status != WG_OK) {
                return status;
            }
        }
    }
    return WG_OK;
}

static WgStatus begin_search(RobotSearch *search)
{
    search->mask = 4095;
    search->capacity = 1024;
    search->span_capacity = 1024;
    search->states = malloc((size_t)search->capacity * sizeof *search->states);
    search->spans = malloc((size_t)search->span_capacity * sizeof *search->spans);
    search->table = calloc((size_t)search->mask + 1, sizeof *search->table);
    search->spans_from = calloc((size_t)search->joint->nodes, sizeof *search->spans_from);
    search->spans_count = calloc((size_t)search->joint->nodes, sizeof *search->spans_count);
    bool fits = search->states != NULL && search->spans != NULL && search->table != NULL &&
                search->spans_from != NULL && search->spans_count != NULL;
    if (!fits) {
        return WG_OUT_OF_MEMORY;
    }
    // Without a path even on its own, there is nothing to search.
    int64_t start = search->robot.start;
    return search->distances[start] < 0 || reach(search, start, 0, -1) ? WG_OK : WG_OUT_OF_MEMORY;
}

static void end_search(RobotSearch *search)
{
    free(search->table);
    free(search->spans_from);
    free(search->spans_count);
    free(search->spans);
    free(search->states);
    free(search->heap.entries);
    *search = (RobotSearch){0};
}

// Returns the times in which no wall changes; NULL if memory runs out.
static Period *find_periods(const WgJoint *joint, int64_t *count)
{
    *count = 1;
    for (int64_t tick = 1; tick < joint->ticks; tick++) {
        *count += joint->raster_of[tick] != joint->raster_of[tick - 1] ? 1 : 0;
    }
    Period *periods = malloc((size_t)*count * sizeof *periods);
    if (periods == NULL) {
        return NULL;
    }
    periods[0] = (Period){0, joint->raster_of[0]};
    int64_t at = 1;
    for (int64_t tick = 1; tick < joint->ticks; tick++) {
        if (joint->raster_of[tick] != joint->raster_of[tick - 1]) {
            periods[at++] = (Period){tick, joint->raster_of[tick]};
        }
    }
    return periods;
}

struct WgJointOrder {
    const WgJoint *joint;
    WgReservations reserved;
    Period *periods;
    int64_t period_count;
    RobotSearch search;  // for the robot being added; all zeros between two robots
};

WgStatus wg_joint_order_new(const WgJoint *joint, WgJointOrder **made)
{
    *made = NULL;
    WgStatus status = wg_joint_check(joint);
    if (status != WG_OK) {
        return status;
    }
    WgJointOrder *order = calloc(1, sizeof *order);
    if (order == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    order->joint = joint;
    order->periods = find_periods(joint, &order->period_count);
    status = wg_begin_reservations(&order->reserved, joint);
    if (status != WG_OK || order->periods == NULL) {
        wg_joint_order_free(order);
        return WG_OUT_OF_MEMORY;
    }
    *made = order;
    return WG_OK;
}

void wg_joint_order_free(WgJointOrder *order)
{
    if (order != NULL) {
        end_search(&order->search);
        free(order->periods);
        wg_end_reservations(&order->reserved);
        free(order);
    }
}

WgStatus wg_joint_order_add(WgJointOrder *order, const WgJointRobot *robot, int64_t most)
{
    end_search(&order->search);
    const WgJoint *joint = order->joint;
    bool is_new = robot->number >= 0 && robot->number < joint->robots && robot->start >= 0 &&
                  robot->start < joint->nodes && order->reserved.tracks[robot->number].nodes == NULL;
    if (!is_new || most > INT32_MAX / 128) {
        return WG_BAD_VALUE;
    }
    order->search = (RobotSearch){
        .joint = joint,
        .reserved = &order->reserved,
        .periods = order->periods,
        .period_count = order->period_count,
        .moves = wg_moves(joint),
        .robot = *robot,
        .robot_class = joint->class_of[robot->number],
        .distances = robot->distances,
        .most = most,
    };
    WgStatus status = begin_search(&order->search);
    if (status != WG_OK) {
        end_search(&order->search);
    }
    return status;
}

WgStatus wg_joint_order_advance(WgJointOrder *order, int64_t most, WgProgress *progress)
{
    RobotSearch *search = &order->search;
    if (search->joint == NULL) {
        return WG_BAD_VALUE;
    }
    int64_t robot = search->robot.number;
    WgStatus status = search_path(search, most, &order->reserved.tracks[robot], progress);
    if (status == WG_OK && *progress == WG_FOUND && !wg_reserve(&order->reserved, robot)) {
        status = WG_OUT_OF_MEMORY;
    }
    if (status != WG_OK || *progress != WG_GOING) {
        end_search(search);
    }
    return status;
}

WgStatus wg_joint_order_plan(const WgJointOrder *order, WgJointPlan **made)
{
    int64_t robots = order->joint->robots;
    const WgTrack *tracks = order->reserved.tracks;
    int64_t length = 0;
    for (int64_t robot = 0; robot < robots; robot++) {
        if (tracks[robot].nodes == NULL) {
            return WG_BAD_VALUE;
        }
        length = wg_max(length, tracks[robot].length);
    }
    *made = wg_joint_plan_new(robots, length);
    if (*made == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    for (int64_t tick = 0; tick <= length; tick++) {
        for (int64_t robot = 0; robot < robots; robot++) {
            (*made)->nodes[tick * robots + robot] = (int32_t)wg_track_at(&tracks[robot], tick);
        }
    }
    return WG_OK;
}

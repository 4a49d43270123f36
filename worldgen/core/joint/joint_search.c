// Joint plans by search over joint states: the positions of all robots at once.
//
// One search examines every remaining joint state, which decides small cases on the lattice. The other searches depth
// first and gets the next joint state from a fast rule; because constraints are added one at a time, it tries
// everything in the end.
//
// Okumura, "LaCAM: Search-Based Algorithm for Quick Multi-Agent Pathfinding" (2023).
// Okumura et al., "Priority Inheritance with Backtracking for Iterative Multi-agent Path Finding" (2022), for the rule.

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "heap.h"
#include "joint.h"

// A joint state; its nodes are next to it in one array.
typedef struct Node {
    int32_t parent;
    int32_t tick;
    int32_t first_wish;  // LaCAM: list of constraints yet to be tried; -1 if empty
    int32_t last_wish;
} Node;

// A constraint: in the next joint state, a robot is at this node, and the constraints up the list hold too.
typedef struct Wish {
    int32_t parent;  // -1 for none
    int32_t next;    // in the queue of its state
    int32_t depth;   // robots that are constrained
    int32_t robot;
    int32_t node;
} Wish;

typedef struct States {
    const WgJoint *joint;
    WgMoves moves;
    Node *nodes;
    int32_t *places;  // (count, robots)
    int64_t count;
    int64_t room;
    int32_t *table;  // index + 1, or 0
    int64_t mask;
} States;

static const int32_t *places_of(const States *states, int64_t index)
{
    return states->places + index * states->joint->robots;
}

static uint64_t hash_of_places(const States *states, const int32_t *places, int64_t tick)
{
    uint64_t hash = (uint64_t)wg_min(tick, states->joint->ticks - 1);
    for (int64_t robot = 0; robot < states->joint->robots; robot++) {
        hash = (hash ^ (uint64_t)places[robot]) * 0x9E3779B97F4A7C15u;
        hash ^= hash >> 31;
    }
    return hash;
}

static bool grow_states_table(States *states)
{
    int64_t size = 4 * (states->mask + 1);
    int32_t *table = calloc((size_t)size, sizeof *table);
    if (table == NULL) {
        return false;
    }
    for (int64_t i = 0; i < states->count; i++) {
        uint64_t at = hash_of_places(states, places_of(states, i), states->nodes[i].tick);
        while (table[at & (uint64_t)(size - 1)] != 0) {
            at++;
        }
        table[at & (uint64_t)(size - 1)] = (int32_t)i + 1;
    }
    free(states->table);
    states->table = table;
    states->mask = size - 1;
    return true;
}

// Adds a joint state unless it is known; index receives its number, or -1 if it is known.
static WgStatus add_state(States *states, const int32_t *places, int64_t tick, int64_t parent, int64_t *index)
{
    int64_t robots = states->joint->robots;
    int64_t moment = wg_min(tick, states->joint->ticks - 1);
    uint64_t at = hash_of_places(states, places, tick);
    *index = -1;
    for (; states->table[at & (uint64_t)states->mask] != 0; at++) {
        int64_t known = states->table[at & (uint64_t)states->mask] - 1;
        assert(known < states->count && states->nodes != NULL);
        if (wg_min(states->nodes[known].tick, states->joint->ticks - 1) == moment &&
            memcmp(places_of(states, known), places, (size_t)robots * sizeof *places) == 0) {
            return WG_OK;
        }
    }
    if (states->count == states->room) {
        int64_t room = 2 * states->room + 256;
        Node *nodes = realloc(states->nodes, (size_t)room * sizeof *nodes);
        if (nodes == NULL) {
            return WG_OUT_OF_MEMORY;
        }
        states->nodes = nodes;
        int32_t *all = realloc(states->places, (size_t)(room * robots) * sizeof *all);
        if (all == NULL) {
            return WG_OUT_OF_MEMORY;
        }
        states->places = all;
        states->room = room;
    }
    *index = states->count++;
    states->table[at & (uint64_t)states->mask] = (int32_t)*index + 1;
    states->nodes[*index] = (Node){(int32_t)parent, (int32_t)tick, -1, -1};
    memcpy(states->places + *index * robots, places, (size_t)robots * sizeof *places);
    return 2 * states->count < states->mask || grow_states_table(states) ? WG_OK : WG_OUT_OF_MEMORY;
}

static WgStatus begin_states(States *states, const WgJoint *joint)
{
    *states = (States){.joint = joint, .moves = wg_moves(joint), .mask = 1023};
    states->table = calloc((size_t)states->mask + 1, sizeof *states->table);
    int32_t *places = malloc((size_t)joint->robots * sizeof *places);
    WgStatus status = WG_OUT_OF_MEMORY;
    if (states->table != NULL && places != NULL) {
        for (int64_t robot = 0; robot < joint->robots; robot++) {
            places[robot] = (int32_t)joint->starts[robot];
        }
        int64_t index;
        status = add_state(states, places, 0, -1, &index);
    }
    free(places);
    return status;
}

static void end_states(States *states)
{
    free(states->nodes);
    free(states->places);
    free(states->table);
}

static int32_t distance_of(const WgJoint *joint, int64_t robot, int64_t node)
{
    return joint->distances[robot * joint->nodes + node];
}

// Returns true if all robots have parked and no later change reaches them there.
static bool is_end(const States *states, int64_t index)
{
    const WgJoint *joint = states->joint;
    const int32_t *places = places_of(states, index);
    for (int64_t robot = 0; robot < joint->robots; robot++) {
        if (distance_of(joint, robot, places[robot]) != 0) {
            return false;
        }
    }
    for (int64_t tick = states->nodes[index].tick; tick < joint->ticks; tick++) {
        for (int64_t robot = 0; robot < joint->robots; robot++) {
            if (joint->clear[wg_raster_at(joint, tick, joint->class_of[robot]) + places[robot]] == 0) {
                return false;
            }
        }
    }
    return true;
}

static WgStatus plan_to(const States *states, int64_t last, WgJointPlan **made)
{
    int64_t robots = states->joint->robots;
    *made = wg_joint_plan_new(robots, states->nodes[last].tick);
    if (*made == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    for (int64_t i = last; i >= 0; i = states->nodes[i].parent) {
        memcpy((*made)->nodes + states->nodes[i].tick * robots, places_of(states, i),
               (size_t)robots * sizeof(int32_t));
    }
    return WG_OK;
}

// Returns true if the walls allow a robot's move in a tick and the target can still be reached. A parked robot only
// waits.
static bool is_allowed(const States *states, int64_t robot, int64_t node, int move, int64_t tick)
{
    const WgJoint *joint = states->joint;
    bool parks = distance_of(joint, robot, node) == 0 && move != WG_WAIT;
    if (parks || wg_crosses_target(joint, robot, node, move)) {
        return false;
    }
    int64_t raster = wg_raster_at(joint, tick, joint->class_of[robot]);
    return joint->clear[raster + node] != 0 && wg_move_is_clear(joint, &states->moves, raster, node, move) &&
           distance_of(joint, robot, node + states->moves.shifts[move]) >= 0;
}

static bool robots_conflict(const WgJoint *joint, int64_t one, int64_t u, int64_t v, int64_t other, int64_t w,
                            int64_t z)
{
    return wg_moves_conflict(joint, joint->class_of[one], u, v, joint->class_of[other], w, z);
}

// The search over all joint states; it tries every choice of moves, robot by robot.
typedef struct Exhaust {
    States states;
    WgHeap heap;  // (estimate, age)
    int32_t *next;
    int *chosen;  // (robots,) move of each
} Exhaust;

static int64_t joint_distance(const WgJoint *joint, const int32_t *places)
{
    int64_t sum = 0;
    for (int64_t robot = 0; robot < joint->robots; robot++) {
        sum += distance_of(joint, robot, places[robot]);
    }
    return sum;
}

// Returns true if a robot's next move is clear of the walls and of the robots that chose before it.
static bool fits_before(const Exhaust *search, const int32_t *here, int64_t robot, int move, int64_t tick)
{
    if (!is_allowed(&search->states, robot, here[robot], move, tick)) {
        return false;
    }
    int64_t to = here[robot] + search->states.moves.shifts[move];
    for (int64_t other = 0; other < robot; other++) {
        if (robots_conflict(search->states.joint, robot, here[robot], to, other, here[other], search->next[other])) {
            return false;
        }
    }
    return true;
}

static WgStatus add_successors(Exhaust *search, int64_t index)
{
    const WgJoint *joint = search->states.joint;
    int64_t robots = joint->robots;
    int64_t tick = search->states.nodes[index].tick;
    int32_t *here = malloc((size_t)robots * sizeof *here);
    if (here == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    // The states move in memory as they grow, so this one is copied.
    memcpy(here, places_of(&search->states, index), (size_t)robots * sizeof *here);
    WgStatus status = WG_OK;
    int64_t robot = 0;
    search->chosen[0] = -1;
    while (robot >= 0 && status == WG_OK) {
        // Take the next move of this robot that fits, or return to the robot before it.
        int move = search->chosen[robot] + 1;
        while (move < WG_MOVES && !fits_before(search, here, robot, move, tick)) {
            move++;
        }
        if (move >= WG_MOVES) {
            robot--;
            continue;
        }
        search->chosen[robot] = move;
        search->next[robot] = here[robot] + (int32_t)search->states.moves.shifts[move];
        if (robot + 1 < robots) {
            search->chosen[++robot] = -1;
            continue;
        }
        int64_t added;
        status = add_state(&search->states, search->next, tick + 1, index, &added);
        if (status == WG_OK && added >= 0) {
            int64_t estimate = tick + 1 + joint_distance(joint, search->next);
            status = wg_heap_push(&search->heap, (WgEntry){estimate, -tick, added}) ? WG_OK : WG_OUT_OF_MEMORY;
        }
    }
    free(here);
    return status;
}

static bool leads_nowhere(const WgJoint *joint)
{
    for (int64_t robot = 0; robot < joint->robots; robot++) {
        if (distance_of(joint, robot, joint->starts[robot]) < 0) {
            return true;
        }
    }
    return false;
}

static WgStatus exhaust(Exhaust *search, int64_t most, WgJointPlan **made, WgProgress *progress)
{
    if (!wg_heap_push(&search->heap, (WgEntry){0, 0, 0})) {
        return WG_OUT_OF_MEMORY;
    }
    while (search->heap.count > 0) {
        int64_t index = wg_heap_pop(&search->heap).third;
        if (is_end(&search->states, index)) {
            *progress = WG_FOUND;
            return plan_to(&search->states, index, made);
        }
        if (search->states.count > most) {
            *progress = WG_GOING;
            return WG_OK;
        }
        WgStatus status = add_successors(search, index);
        if (status != WG_OK) {
            return status;
        }
    }
    *progress = WG_EXHAUSTED;
    return WG_OK;
}

WgStatus wg_joint_exhaust(const WgJoint *joint, int64_t most, WgJointPlan **made, WgProgress *progress)
{
    *made = NULL;
    *progress = WG_EXHAUSTED;
    WgStatus status = wg_joint_check(joint);
    if (status != WG_OK || leads_nowhere(joint)) {
        return status;
    }
    if (most > INT32_MAX / 128) {
        return WG_BAD_VALUE;
    }
    Exhaust search = {0};
    search.next = malloc((size_t)joint->robots * sizeof *search.next);
    search.chosen = malloc((size_t)joint->robots * sizeof *search.chosen);
    status = WG_OUT_OF_MEMORY;
    if (search.next != NULL && search.chosen != NULL) {
        status = begin_states(&search.states, joint);
    }
    if (status == WG_OK) {
        status = exhaust(&search, most, made, progress);
    }
    end_states(&search.states);
    free(search.heap.entries);
    free(search.next);
    free(search.chosen);
    return status;
}

// The depth-first search, and the rule that makes the next joint state.
typedef struct Lacam {
    States states;
    int64_t robots;
    Wish *wishes;
    int64_t wish_count;
    int64_t wish_room;
    int32_t *order;     // robots, those with the longest path first
    int32_t *next;      // (robots,) node of each in the next joint state; -1 while it is open
    int32_t *trail;     // robots in the order in which they were assigned
    int64_t assigned;
    const int32_t *here;
    int64_t tick;
    int32_t *x;  // (robots,) column of each robot's node
    int32_t *y;  // (robots,) row
    int64_t *near_from;  // (robots + 1,) where the list of each robot in `near` begins
    int32_t *near;       // of each robot in turn, the others that it could meet in this tick, by number
    int64_t near_room;
} Lacam;

// Lists for each robot the others that it could meet in this tick; returns false if memory runs out.
static bool find_near(Lacam *search)
{
    const WgJoint *joint = search->states.joint;
    for (int64_t robot = 0; robot < search->robots; robot++) {
        search->x[robot] = search->here[robot] % (int32_t)joint->stride;
        search->y[robot] = search->here[robot] / (int32_t)joint->stride;
    }
    int64_t count = 0;
    for (int64_t robot = 0; robot < search->robots; robot++) {
        search->near_from[robot] = count;
        for (int64_t other = 0; other < search->robots; other++) {
            if (other == robot || !wg_could_meet(joint, search->x[robot] - search->x[other],
                                                 search->y[robot] - search->y[other])) {
                continue;
            }
            if (count == search->near_room) {
                int64_t room = 2 * search->near_room + 256;
                int32_t *near = realloc(search->near, (size_t)room * sizeof *near);
                if (near == NULL) {
                    return false;
                }
                search->near = near;
                search->near_room = room;
            }
            search->near[count++] = (int32_t)other;
        }
    }
    search->near_from[search->robots] = count;
    return true;
}

static void unassign(Lacam *search, int64_t mark)
{
    while (search->assigned > mark) {
        search->next[search->trail[--search->assigned]] = -1;
    }
}

static void assign(Lacam *search, int64_t robot, int64_t node)
{
    assert(search->assigned < search->robots);
    search->next[robot] = (int32_t)node;
    search->trail[search->assigned++] = (int32_t)robot;
}

static bool fits_assigned(const Lacam *search, int64_t robot, int64_t to)
{
    for (int64_t i = search->near_from[robot]; i < search->near_from[robot + 1]; i++) {
        int64_t other = search->near[i];
        if (search->next[other] >= 0 &&
            robots_conflict(search->states.joint, robot, search->here[robot], to, other, search->here[other],
                            search->next[other])) {
            return false;
        }
    }
    return true;
}

// Lists the allowed moves of a robot, those that lead nearest to its target first.
static int sorted_moves(const Lacam *search, int64_t robot, int moves[WG_MOVES])
{
    const WgJoint *joint = search->states.joint;
    int64_t node = search->here[robot];
    int count = 0;
    for (int move = 0; move < WG_MOVES; move++) {
        if (!is_allowed(&search->states, robot, node, move, search->tick)) {
            continue;
        }
        int32_t distance = distance_of(joint, robot, node + search->states.moves.shifts[move]);
        int at = count++;
        while (at > 0 && distance_of(joint, robot, node + search->states.moves.shifts[moves[at - 1]]) > distance) {
            moves[at] = moves[at - 1];
            at--;
        }
        moves[at] = move;
    }
    return count;
}

// Finds a move for a robot; robots that it pushes get theirs before the others. Each call assigns a robot, so the
// recursion is never deeper than the number of robots.
// NOLINTNEXTLINE(misc-no-recursion)
static bool push(Lacam *search, int64_t robot)
{
    const WgJoint *joint = search->states.joint;
    int moves[WG_MOVES];
    int count = sorted_moves(search, robot, moves);
    int64_t mark = search->assigned;
    for (int i = 0; i < count; i++) {
        int64_t to = search->here[robot] + search->states.moves.shifts[moves[i]];
        if (!fits_assigned(search, robot, to)) {
            continue;
        }
        assign(search, robot, to);
        bool all_moved = true;
        for (int64_t k = search->near_from[robot]; k < search->near_from[robot + 1] && all_moved; k++) {
            int64_t other = search->near[k];
            bool in_the_way = search->next[other] < 0 &&
                              robots_conflict(joint, robot, search->here[robot], to, other, search->here[other],
                                              search->here[other]);
            all_moved = !in_the_way || push(search, other);
        }
        if (all_moved) {
            return true;
        }
        unassign(search, mark);
    }
    return false;
}

// Makes a next joint state that satisfies a constraint; returns false if the rule finds none.
static bool make_next(Lacam *search, const Wish *wish)
{
    search->assigned = 0;
    for (int64_t robot = 0; robot < search->robots; robot++) {
        search->next[robot] = -1;
    }
    for (; wish->depth > 0; wish = &search->wishes[wish->parent]) {
        if (!fits_assigned(search, wish->robot, wish->node)) {
            return false;
        }
        assign(search, wish->robot, wish->node);
    }
    for (int64_t i = 0; i < search->robots; i++) {
        int64_t robot = search->order[i];
        if (search->next[robot] < 0 && !push(search, robot)) {
            return false;
        }
    }
    return true;
}

static bool add_wish(Lacam *search, int64_t state, Wish wish)
{
    if (search->wish_count == search->wish_room) {
        int64_t room = 2 * search->wish_room + 1024;
        Wish *wishes = room > INT32_MAX ? NULL : realloc(search->wishes, (size_t)room * sizeof *wishes);
        if (wishes == NULL) {
            return false;
        }
        search->wishes = wishes;
        search->wish_room = room;
    }
    int32_t index = (int32_t)search->wish_count++;
    wish.next = -1;
    search->wishes[index] = wish;
    Node *node = &search->states.nodes[state];
    if (node->first_wish < 0) {
        node->first_wish = index;
    } else {
        search->wishes[node->last_wish].next = index;
    }
    node->last_wish = index;
    return true;
}

static WgStatus dive(Lacam *search, int64_t most, WgJointPlan **made, WgProgress *progress)
{
    int64_t robots = search->robots;
    int32_t *here = malloc((size_t)robots * sizeof *here);
    if (here == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    search->here = here;
    WgStatus status = add_wish(search, 0, (Wish){-1, -1, 0, -1, -1}) ? WG_OK : WG_OUT_OF_MEMORY;
    int64_t at = 0;  // the state at the top; the states below it are its parents
    int64_t listed = -1;  // the state whose near robots are listed
    while (status == WG_OK && at >= 0) {
        if (is_end(&search->states, at)) {
            *progress = WG_FOUND;
            status = plan_to(&search->states, at, made);
            break;
        }
        if (search->states.count > most || search->wish_count > 64 * most) {
            *progress = WG_GOING;
            break;
        }
        int32_t index = search->states.nodes[at].first_wish;
        if (index < 0) {
            at = search->states.nodes[at].parent;
            continue;
        }
        search->states.nodes[at].first_wish = search->wishes[index].next;
        memcpy(here, places_of(&search->states, at), (size_t)robots * sizeof *here);
        search->tick = search->states.nodes[at].tick;
        // The lists of a state serve all of its constraints.
        if (at != listed && !find_near(search)) {
            status = WG_OUT_OF_MEMORY;
            break;
        }
        listed = at;

        // Its refinements come later: one more robot at each of the nodes it can reach.
        Wish wish = search->wishes[index];
        if (wish.depth < robots) {
            int32_t robot = search->order[wish.depth];
            int moves[WG_MOVES];
            int count = sorted_moves(search, robot, moves);
            for (int i = 0; i < count && status == WG_OK; i++) {
                int32_t node = here[robot] + (int32_t)search->states.moves.shifts[moves[i]];
                bool added = add_wish(search, at, (Wish){index, -1, wish.depth + 1, robot, node});
                status = added ? WG_OK : WG_OUT_OF_MEMORY;
            }
        }
        if (status != WG_OK || !make_next(search, &wish)) {
            continue;
        }
        int64_t added;
        status = add_state(&search->states, search->next, search->tick + 1, at, &added);
        if (status == WG_OK && added >= 0) {
            status = add_wish(search, added, (Wish){-1, -1, 0, -1, -1}) ? WG_OK : WG_OUT_OF_MEMORY;
            at = added;
        }
    }
    free(here);
    return status;
}

// Sort robots with the longest path first; break ties by number.
static void order_by_distance(const WgJoint *joint, int32_t *order)
{
    for (int64_t robot = 0; robot < joint->robots; robot++) {
        int64_t at = robot;
        int32_t distance = distance_of(joint, robot, joint->starts[robot]);
        while (at > 0 && distance_of(joint, order[at - 1], joint->starts[order[at - 1]]) < distance) {
            order[at] = order[at - 1];
            at--;
        }
        order[at] = (int32_t)robot;
    }
}

WgStatus wg_joint_lacam(const WgJoint *joint, int64_t most, WgJointPlan **made, WgProgress *progress)
{
    *made = NULL;
    *progress = WG_EXHAUSTED;
    WgStatus status = wg_joint_check(joint);
    if (status != WG_OK || leads_nowhere(joint)) {
        return status;
    }
    if (most > INT32_MAX / 128) {
        return WG_BAD_VALUE;
    }
    Lacam search = {.robots = joint->robots};
    size_t size = (size_t)search.robots * sizeof(int32_t);
    search.order = malloc(size);
    search.next = malloc(size);
    search.trail = malloc(size);
    search.x = malloc(size);
    search.y = malloc(size);
    search.near_from = malloc(((size_t)search.robots + 1) * sizeof *search.near_from);
    status = WG_OUT_OF_MEMORY;
    bool fits = search.order != NULL && search.next != NULL && search.trail != NULL && search.x != NULL &&
                search.y != NULL && search.near_from != NULL;
    if (fits) {
        order_by_distance(joint, search.order);
        status = begin_states(&search.states, joint);
    }
    if (status == WG_OK) {
        status = dive(&search, most, made, progress);
    }
    end_states(&search.states);
    free(search.wishes);
    free(search.order);
    free(search.next);
    free(search.trail);
    free(search.x);
    free(search.y);
    free(search.near_from);
    free(search.near);
    return status;
}

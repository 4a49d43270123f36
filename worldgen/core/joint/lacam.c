// A depth-first search that gets the next joint state from a fast rule. Because constraints are
// added one at a time, it tries everything in the end.
//
// Okumura, "LaCAM: Search-Based Algorithm for Quick Multi-Agent Pathfinding" (2023).
// The rule is from Okumura et al., "Priority Inheritance with Backtracking for Iterative
// Multi-agent Path Finding" (2022).

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "joint_states.h"

// Pushes that a search may make for each joint state that it may keep.
static const int64_t PUSHES_PER_STATE = 2000;

// A constraint: in the next joint state, a robot is at this node,
// and the constraints up the list hold too.
typedef struct Wish {
    int32_t parent;  // -1 for none
    int32_t next;    // in the queue of its state
    int32_t depth;   // robots that are constrained
    int32_t robot;
    int32_t node;
} Wish;

// The depth-first search, and the rule that makes the next joint state.
typedef struct Lacam {
    WgJointStates states;
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
    int32_t *near;       // for each robot in turn, the numbers of those it could meet in this tick
    int64_t near_room;
    int64_t pushes;  // that are left
} Lacam;

// Lists for each robot the others that it could meet in this tick;
// returns false if memory runs out.
//
// Without these lists, comparing each move with all of 100 robots took two thirds of the search.
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
            wg_robots_conflict(search->states.joint, robot, search->here[robot], to, other, search->here[other],
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
        if (!wg_is_allowed(&search->states, robot, node, move, search->tick)) {
            continue;
        }
        int32_t distance = wg_distance_of(joint, robot, node + search->states.moves.shifts[move]);
        int at = count++;
        while (at > 0 && wg_distance_of(joint, robot, node + search->states.moves.shifts[moves[at - 1]]) > distance) {
            moves[at] = moves[at - 1];
            at--;
        }
        moves[at] = move;
    }
    return count;
}

// Finds a move for a robot; robots that it pushes get theirs before the others. Each call assigns a
// robot, so the recursion is never deeper than the number of robots.
// NOLINTNEXTLINE(misc-no-recursion)
static bool push(Lacam *search, int64_t robot)
{
    // In a crowd, one rearrangement can take more pushes than anyone can wait for.
    if (search->pushes-- <= 0) {
        return false;
    }
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
                              wg_robots_conflict(joint, robot, search->here[robot], to, other, search->here[other],
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
    WgJointNode *node = &search->states.nodes[state];
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
        if (wg_is_end(&search->states, at)) {
            *progress = WG_FOUND;
            status = wg_plan_to(&search->states, at, made);
            break;
        }
        if (search->states.count > most || search->wish_count > 64 * most || search->pushes <= 0) {
            *progress = WG_GOING;
            break;
        }
        int32_t index = search->states.nodes[at].first_wish;
        if (index < 0) {
            at = search->states.nodes[at].parent;
            continue;
        }
        search->states.nodes[at].first_wish = search->wishes[index].next;
        memcpy(here, wg_places_of(&search->states, at), (size_t)robots * sizeof *here);
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
        status = wg_add_state(&search->states, search->next, search->tick + 1, at, &added);
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
        int32_t distance = wg_distance_of(joint, robot, joint->starts[robot]);
        while (at > 0 && wg_distance_of(joint, order[at - 1], joint->starts[order[at - 1]]) < distance) {
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
    if (status != WG_OK || wg_leads_nowhere(joint)) {
        return status;
    }
    if (most > INT32_MAX / 128) {
        return WG_BAD_VALUE;
    }
    Lacam search = {.robots = joint->robots, .pushes = PUSHES_PER_STATE * most};
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
        status = wg_begin_states(&search.states, joint);
    }
    if (status == WG_OK) {
        status = dive(&search, most, made, progress);
    }
    wg_end_states(&search.states);
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

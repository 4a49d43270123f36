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

// A robot that is getting its next move: the state of one call of the rule. The calls are on a stack
// of our own, so that a rearrangement of a crowd can pause.
typedef struct Push {
    int32_t robot;
    int32_t count;  // allowed moves
    int32_t tried;
    int32_t to;     // where the move that was tried last leads; -1 if it was taken back
    int32_t moves[WG_MOVES];
    int64_t mark;   // robots that were assigned before
    int64_t next_near;  // index of the next robot in `near` that could be in its way
} Push;

// The outcome of making a next joint state.
typedef enum Made {
    MADE,
    NONE_FITS,
    PAUSED,
} Made;

// The depth-first search, and the rule that makes the next joint state.
typedef struct Lacam {
    WgJointSearch search;
    WgJointStates states;
    int64_t most;       // limit on joint states kept
    int64_t at;         // the state at the top; the states below it are its parents
    int64_t listed;     // the state whose near robots are listed
    Wish wish;          // the constraint of the next joint state
    bool is_making;     // whether a next joint state is half made
    int64_t placed;     // robots in `order` that have their node in it
    Push *stack;        // (robots,) pushes that lead to one another
    int64_t depth;
    int64_t work;       // pushes, and comparisons of near robots
    int64_t enough;     // work at which to pause
    int64_t robots;
    Wish *wishes;
    int64_t wish_count;
    int64_t wish_room;
    int32_t *order;     // robots, those with the longest path first
    int32_t *next;      // (robots,) node of each in the next joint state; -1 while it is open
    int32_t *trail;     // robots in the order in which they were assigned
    int64_t assigned;
    int32_t *here;      // (robots,) nodes of the state at the top
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
    // A comparison takes a sixteenth of the time of a push.
    search->work += search->robots * search->robots / 16;
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
static int32_t sorted_moves(const Lacam *search, int64_t robot, int32_t moves[WG_MOVES])
{
    const WgJoint *joint = search->states.joint;
    int64_t node = search->here[robot];
    int32_t count = 0;
    for (int32_t move = 0; move < WG_MOVES; move++) {
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

// Starts to look for a move of a robot; returns false if it may not push any more. Each unfinished
// push has assigned a robot, so the stack is never deeper than the number of robots.
static bool begin_push(Lacam *search, int64_t robot)
{
    // In a crowd, one rearrangement can take more pushes than anyone can wait for.
    if (search->pushes-- <= 0) {
        return false;
    }
    assert(search->depth < search->robots);
    Push *top = &search->stack[search->depth++];
    top->robot = (int32_t)robot;
    top->count = sorted_moves(search, robot, top->moves);
    top->tried = 0;
    top->to = -1;
    top->mark = search->assigned;
    return true;
}

// Takes back the move of a push, and those of the robots that it pushed.
static void take_back(Lacam *search, Push *top)
{
    unassign(search, top->mark);
    top->to = -1;
}

// Assigns the next move that fits; returns false if none does.
static bool assign_next(Lacam *search, Push *top)
{
    while (top->tried < top->count) {
        int64_t to = search->here[top->robot] + search->states.moves.shifts[top->moves[top->tried++]];
        if (fits_assigned(search, top->robot, to)) {
            assign(search, top->robot, to);
            top->to = (int32_t)to;
            top->next_near = search->near_from[top->robot];
            return true;
        }
    }
    return false;
}

// Returns the next robot in the way of a push, or -1.
static int64_t next_in_the_way(const Lacam *search, Push *top)
{
    int64_t robot = top->robot;
    while (top->next_near < search->near_from[robot + 1]) {
        int64_t other = search->near[top->next_near++];
        if (search->next[other] < 0 &&
            wg_robots_conflict(search->states.joint, robot, search->here[robot], top->to, other, search->here[other],
                               search->here[other])) {
            return other;
        }
    }
    return -1;
}

// Continues the pushes on the stack: robots that one pushes get their moves before the others.
// MADE if the robot at the bottom has a move.
static Made continue_pushes(Lacam *search)
{
    Made made = MADE;
    while (search->depth > 0) {
        if (search->work >= search->enough) {
            return PAUSED;
        }
        search->work++;
        Push *top = &search->stack[search->depth - 1];
        if (top->to < 0 && !assign_next(search, top)) {
            // Whoever pushed this robot takes its next move.
            search->depth--;
            if (search->depth > 0) {
                take_back(search, &search->stack[search->depth - 1]);
            }
            made = NONE_FITS;
            continue;
        }
        int64_t other = next_in_the_way(search, top);
        if (other < 0) {
            search->depth--;
            made = MADE;
        } else if (!begin_push(search, other)) {
            take_back(search, top);
        }
    }
    return made;
}

// Begins a next joint state with the nodes of a constraint; returns false if they conflict.
static bool begin_next(Lacam *search)
{
    search->assigned = 0;
    search->placed = 0;
    search->depth = 0;
    for (int64_t robot = 0; robot < search->robots; robot++) {
        search->next[robot] = -1;
    }
    search->work++;
    for (const Wish *wish = &search->wish; wish->depth > 0; wish = &search->wishes[wish->parent]) {
        if (!fits_assigned(search, wish->robot, wish->node)) {
            return false;
        }
        assign(search, wish->robot, wish->node);
    }
    return true;
}

// Continues to make a next joint state that satisfies the constraint.
static Made make_next(Lacam *search)
{
    while (search->depth > 0 || search->placed < search->robots) {
        if (search->depth == 0) {
            int64_t robot = search->order[search->placed++];
            if (search->next[robot] >= 0) {
                continue;
            }
            if (!begin_push(search, robot)) {
                return NONE_FITS;
            }
        }
        Made made = continue_pushes(search);
        if (made != MADE) {
            return made;
        }
    }
    return MADE;
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

// Adds the refinements of the constraint in progress, which come later: one more robot at each of
// the nodes it can reach.
static bool add_refinements(Lacam *search, int32_t index)
{
    if (search->wish.depth == search->robots) {
        return true;
    }
    int32_t robot = search->order[search->wish.depth];
    int32_t moves[WG_MOVES];
    int32_t count = sorted_moves(search, robot, moves);
    for (int32_t i = 0; i < count; i++) {
        int32_t node = search->here[robot] + (int32_t)search->states.moves.shifts[moves[i]];
        if (!add_wish(search, search->at, (Wish){index, -1, search->wish.depth + 1, robot, node})) {
            return false;
        }
    }
    return true;
}

// Takes the next constraint of the state at the top, or returns to the state below it.
static WgStatus take_wish(Lacam *search)
{
    int32_t index = search->states.nodes[search->at].first_wish;
    if (index < 0) {
        search->at = search->states.nodes[search->at].parent;
        return WG_OK;
    }
    search->states.nodes[search->at].first_wish = search->wishes[index].next;
    memcpy(search->here, wg_places_of(&search->states, search->at), (size_t)search->robots * sizeof *search->here);
    search->tick = search->states.nodes[search->at].tick;
    // The lists of a state serve all of its constraints.
    if (search->at != search->listed && !find_near(search)) {
        return WG_OUT_OF_MEMORY;
    }
    search->listed = search->at;
    search->wish = search->wishes[index];
    if (!add_refinements(search, index)) {
        return WG_OUT_OF_MEMORY;
    }
    search->is_making = begin_next(search);
    return WG_OK;
}

// Puts the joint state that was made on top, unless it is known.
static WgStatus put_on_top(Lacam *search)
{
    int64_t added;
    WgStatus status = wg_add_state(&search->states, search->next, search->tick + 1, search->at, &added);
    if (status == WG_OK && added >= 0) {
        status = add_wish(search, added, (Wish){-1, -1, 0, -1, -1}) ? WG_OK : WG_OUT_OF_MEMORY;
        search->at = added;
    }
    return status;
}

static WgStatus advance(WgJointSearch *base, int64_t most, WgJointPlan **made, WgProgress *progress)
{
    Lacam *search = (Lacam *)base;
    search->enough = search->work + most;
    *progress = WG_GOING;
    while (search->is_making || search->at >= 0) {
        if (search->is_making) {
            Made next = make_next(search);
            if (next == PAUSED) {
                return WG_OK;
            }
            search->is_making = false;
            WgStatus status = next == MADE ? put_on_top(search) : WG_OK;
            if (status != WG_OK) {
                return status;
            }
            continue;
        }
        if (wg_is_end(&search->states, search->at)) {
            *progress = WG_FOUND;
            return wg_plan_to(&search->states, search->at, made);
        }
        if (search->states.count > search->most || search->wish_count > 64 * search->most || search->pushes <= 0) {
            *progress = WG_GAVE_UP;
            return WG_OK;
        }
        if (search->work >= search->enough) {
            return WG_OK;
        }
        WgStatus status = take_wish(search);
        if (status != WG_OK) {
            return status;
        }
    }
    *progress = WG_EXHAUSTED;
    return WG_OK;
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

static void end_search(WgJointSearch *base)
{
    Lacam *search = (Lacam *)base;
    wg_end_states(&search->states);
    free(search->wishes);
    free(search->order);
    free(search->next);
    free(search->trail);
    free(search->here);
    free(search->stack);
    free(search->x);
    free(search->y);
    free(search->near_from);
    free(search->near);
    free(search);
}

static bool allocate(Lacam *search)
{
    size_t size = (size_t)search->robots * sizeof(int32_t);
    search->order = malloc(size);
    search->next = malloc(size);
    search->trail = malloc(size);
    search->here = malloc(size);
    search->x = malloc(size);
    search->y = malloc(size);
    search->stack = malloc((size_t)search->robots * sizeof *search->stack);
    search->near_from = malloc(((size_t)search->robots + 1) * sizeof *search->near_from);
    return search->order != NULL && search->next != NULL && search->trail != NULL && search->here != NULL &&
           search->x != NULL && search->y != NULL && search->stack != NULL && search->near_from != NULL;
}

WgStatus wg_joint_lacam(const WgJoint *joint, int64_t most, WgJointSearch **made)
{
    *made = NULL;
    WgStatus status = wg_joint_check(joint);
    if (status != WG_OK) {
        return status;
    }
    if (most > INT32_MAX / 128) {
        return WG_BAD_VALUE;
    }
    Lacam *search = calloc(1, sizeof *search);
    if (search == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    search->search = (WgJointSearch){advance, end_search};
    search->robots = joint->robots;
    search->most = most;
    search->pushes = PUSHES_PER_STATE * most;
    search->listed = -1;
    // If some robot cannot arrive at all, no state is worth examining.
    search->at = wg_leads_nowhere(joint) ? -1 : 0;
    status = WG_OUT_OF_MEMORY;
    if (allocate(search)) {
        order_by_distance(joint, search->order);
        status = wg_begin_states(&search->states, joint);
    }
    if (status == WG_OK && !add_wish(search, 0, (Wish){-1, -1, 0, -1, -1})) {
        status = WG_OUT_OF_MEMORY;
    }
    if (status != WG_OK) {
        end_search(&search->search);
        return status;
    }
    *made = &search->search;
    return WG_OK;
}

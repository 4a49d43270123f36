// The search over all joint states, which decides small cases on the lattice.

#include <stdlib.h>
#include <string.h>

#include "heap.h"
#include "joint_states.h"

// The search over all joint states; it tries every choice of moves, robot by robot.
typedef struct Exhaust {
    WgJointSearch search;
    WgJointStates states;
    int64_t most;  // limit on joint states examined
    int64_t work;  // moves tried
    WgHeap heap;  // (estimate, age)
    int32_t *next;
    int *chosen;  // (robots,) move of each
} Exhaust;

static int64_t joint_distance(const WgJoint *joint, const int32_t *places)
{
    int64_t sum = 0;
    for (int64_t robot = 0; robot < joint->robots; robot++) {
        sum += wg_distance_of(joint, robot, places[robot]);
    }
    return sum;
}

// Returns true if a robot's next move is clear of the walls and of the robots that chose before it.
static bool fits_before(Exhaust *search, const int32_t *here, int64_t robot, int move, int64_t tick)
{
    search->work++;
    if (!wg_is_allowed(&search->states, robot, here[robot], move, tick)) {
        return false;
    }
    int64_t to = here[robot] + search->states.moves.shifts[move];
    for (int64_t other = 0; other < robot; other++) {
        if (wg_robots_conflict(search->states.joint, robot, here[robot], to, other, here[other], search->next[other])) {
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
    memcpy(here, wg_places_of(&search->states, index), (size_t)robots * sizeof *here);
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
        status = wg_add_state(&search->states, search->next, tick + 1, index, &added);
        if (status == WG_OK && added >= 0) {
            int64_t estimate = tick + 1 + joint_distance(joint, search->next);
            status = wg_heap_push(&search->heap, (WgEntry){estimate, -tick, added}) ? WG_OK : WG_OUT_OF_MEMORY;
        }
    }
    free(here);
    return status;
}

static WgStatus advance(WgJointSearch *base, int64_t most, WgJointPlan **made, WgProgress *progress)
{
    Exhaust *search = (Exhaust *)base;
    int64_t enough = search->work + most;
    *progress = WG_GOING;
    while (search->heap.count > 0 && search->work < enough) {
        int64_t index = wg_heap_pop(&search->heap).third;
        if (wg_is_end(&search->states, index)) {
            *progress = WG_FOUND;
            return wg_plan_to(&search->states, index, made);
        }
        if (search->states.count > search->most) {
            *progress = WG_GAVE_UP;
            return WG_OK;
        }
        WgStatus status = add_successors(search, index);
        if (status != WG_OK) {
            return status;
        }
    }
    if (search->heap.count == 0) {
        *progress = WG_EXHAUSTED;
    }
    return WG_OK;
}

static void end_search(WgJointSearch *base)
{
    Exhaust *search = (Exhaust *)base;
    wg_end_states(&search->states);
    free(search->heap.entries);
    free(search->next);
    free(search->chosen);
    free(search);
}

WgStatus wg_joint_exhaust(const WgJoint *joint, int64_t most, WgJointSearch **made)
{
    *made = NULL;
    WgStatus status = wg_joint_check(joint);
    if (status != WG_OK) {
        return status;
    }
    if (most > INT32_MAX / 128) {
        return WG_BAD_VALUE;
    }
    Exhaust *search = calloc(1, sizeof *search);
    if (search == NULL) {
        return WG_OUT_OF_MEMORY;
    }
    search->search = (WgJointSearch){advance, end_search};
    search->most = most;
    search->next = malloc((size_t)joint->robots * sizeof *search->next);
    search->chosen = malloc((size_t)joint->robots * sizeof *search->chosen);
    status = WG_OUT_OF_MEMORY;
    if (search->next != NULL && search->chosen != NULL) {
        status = wg_begin_states(&search->states, joint);
    }
    // If some robot cannot arrive at all, no state is worth examining.
    bool is_hopeless = wg_leads_nowhere(joint);
    if (status == WG_OK && !is_hopeless && !wg_heap_push(&search->heap, (WgEntry){0, 0, 0})) {
        status = WG_OUT_OF_MEMORY;
    }
    if (status != WG_OK) {
        end_search(&search->search);
        return status;
    }
    *made = &search->search;
    return WG_OK;
}

// Joint states, which hold the positions of all robots at once, and the functions that every search
// over them needs.

#ifndef JOINT_STATES_H
#define JOINT_STATES_H

#include "joint.h"

// A joint state; its nodes are next to it in one array.
typedef struct WgJointNode {
    int32_t parent;
    int32_t tick;
    int32_t first_wish;  // LaCAM: list of constraints yet to be tried; -1 if empty
    int32_t last_wish;
} WgJointNode;

// The head of a search over joint states, which its methods share.
struct WgJointSearch {
    WgStatus (*advance)(WgJointSearch *search, int64_t most, WgJointPlan **made, WgProgress *progress);
    void (*end)(WgJointSearch *search);
};

// The joint states that a search reached.
typedef struct WgJointStates {
    const WgJoint *joint;
    WgMoves moves;
    WgJointNode *nodes;
    int32_t *places;  // (count, robots)
    int64_t count;
    int64_t room;
    int32_t *table;  // index + 1, or 0
    int64_t mask;
} WgJointStates;

static inline const int32_t *wg_places_of(const WgJointStates *states, int64_t index)
{
    return states->places + index * states->joint->robots;
}

// Adds a joint state unless it is known; index receives its number, or -1 if it is known.
WgStatus wg_add_state(WgJointStates *states, const int32_t *places, int64_t tick, int64_t parent, int64_t *index);

// Begins with the state in which all robots are at their starts.
WgStatus wg_begin_states(WgJointStates *states, const WgJoint *joint);

void wg_end_states(WgJointStates *states);

// Returns true if all robots have parked and no later change reaches them there.
bool wg_is_end(const WgJointStates *states, int64_t index);

// Makes the plan that ends in a state.
WgStatus wg_plan_to(const WgJointStates *states, int64_t last, WgJointPlan **made);

// Returns true if some robot cannot reach its target at all.
bool wg_leads_nowhere(const WgJoint *joint);

static inline int32_t wg_distance_of(const WgJoint *joint, int64_t robot, int64_t node)
{
    return joint->distances[robot * joint->nodes + node];
}

// Returns true if the walls allow a robot's move in a tick and the target can still be reached. A
// parked robot only waits.
static inline bool wg_is_allowed(const WgJointStates *states, int64_t robot, int64_t node, int move, int64_t tick)
{
    const WgJoint *joint = states->joint;
    bool parks = wg_distance_of(joint, robot, node) == 0 && move != WG_WAIT;
    int64_t from = joint->crossed_from[robot];
    if (parks || wg_crosses_target(joint->crossings + from, joint->crossed_from[robot + 1] - from, node, move)) {
        return false;
    }
    int64_t raster = wg_raster_at(joint, tick, joint->class_of[robot]);
    return joint->clear[raster + node] != 0 && wg_move_is_clear(joint, &states->moves, raster, node, move) &&
           wg_distance_of(joint, robot, node + states->moves.shifts[move]) >= 0;
}

// Returns true if two robots come closer than allowed while one moves from u to v
// and the other from w to z.
static inline bool wg_robots_conflict(const WgJoint *joint, int64_t one, int64_t u, int64_t v, int64_t other,
                                      int64_t w, int64_t z)
{
    return wg_moves_conflict(joint, joint->class_of[one], u, v, joint->class_of[other], w, z);
}

#endif

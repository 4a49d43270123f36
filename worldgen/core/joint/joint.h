// Declarations shared by the searches for joint plans.

#ifndef JOINT_H
#define JOINT_H

#include "reach_internal.h"

struct WgJointPlan {
    int64_t robots;
    int64_t length;
    int32_t *nodes;  // (length + 1, robots)
};

// Nine moves: eight steps, and waiting last.
enum { WG_MOVES = 9, WG_WAIT = 8 };

typedef struct WgMoves {
    int64_t shifts[WG_MOVES];
    int64_t corners[WG_MOVES];
} WgMoves;

static inline WgMoves wg_moves(const WgJoint *joint)
{
    WgMoves moves = {{0}, {0}};
    wg_eight_steps(joint->stride, moves.shifts, moves.corners);
    return moves;
}

// Returns the offset of a class's raster in a tick.
static inline int64_t wg_raster_at(const WgJoint *joint, int64_t tick, int64_t which)
{
    int64_t raster = joint->raster_of[wg_min(tick, joint->ticks - 1)];
    return (raster * joint->classes + which) * joint->nodes;
}

// Returns true if the walls let a class of robot make a move in a tick;
// its node is clear in that tick.
static inline bool wg_move_is_clear(const WgJoint *joint, const WgMoves *moves, int64_t at, int64_t node, int move)
{
    if (joint->clear[at + node + moves->shifts[move]] == 0) {
        return false;
    }
    return move < 4 || move == WG_WAIT || joint->middle[at + node + moves->corners[move]] != 0;
}

// Returns true if a step takes a robot across its target, where it would park.
static inline bool wg_crosses_target(const int64_t *crossings, int64_t count, int64_t node, int move)
{
    int64_t low = 0;
    int64_t end = count;
    int64_t key = 8 * node + move;
    if (move == WG_WAIT || count == 0 || key < crossings[0] || key > crossings[count - 1]) {
        return false;
    }
    while (low < end) {
        int64_t middle = low + (end - low) / 2;
        if (crossings[middle] == key) {
            return true;
        }
        if (crossings[middle] < key) {
            low = middle + 1;
        } else {
            end = middle;
        }
    }
    return false;
}

// Returns true if two robots so many nodes apart are near enough to conflict within a tick,
// whatever their moves.
static inline bool wg_could_meet(const WgJoint *joint, int64_t across, int64_t up)
{
    return wg_abs(across) <= joint->reach + 2 && wg_abs(up) <= joint->reach + 2;
}

// Returns true if two robots of these classes come closer than allowed while one moves from u to v
// and the other from w to z.
static inline bool wg_moves_conflict(const WgJoint *joint, int64_t one, int64_t u, int64_t v, int64_t other, int64_t w,
                                     int64_t z)
{
    int64_t stride = joint->stride;
    int64_t px = u % stride - w % stride;
    int64_t py = u / stride - w / stride;
    if (!wg_could_meet(joint, px, py)) {
        return false;
    }
    int64_t qx = v % stride - z % stride;
    int64_t qy = v / stride - z / stride;
    const int64_t *limits = joint->limits + (one * joint->classes + other) * 9;
    if (px * px + py * py < limits[1] || qx * qx + qy * qy < limits[1]) {
        return true;
    }
    int64_t ex = qx - px;
    int64_t ey = qy - py;
    int64_t length_sq = ex * ex + ey * ey;
    int64_t along = -(px * ex + py * ey);
    if (along <= 0 || along >= length_sq) {
        return false;
    }
    int64_t side = px * ey - py * ex;
    return side * side < limits[length_sq];
}

// Returns true if a query's sizes and indices keep the searches within its arrays.
WgStatus wg_joint_check(const WgJoint *joint);

// Returns a plan with room for this many ticks; NULL if memory runs out.
WgJointPlan *wg_joint_plan_new(int64_t robots, int64_t length);

#endif

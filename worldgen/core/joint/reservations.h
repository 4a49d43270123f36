// The paths of the robots planned so far, by place and tick.

#ifndef RESERVATIONS_H
#define RESERVATIONS_H

#include "joint.h"

// A robot's path once it is planned; it waits at the end.
typedef struct WgTrack {
    int32_t *nodes;
    int64_t length;
} WgTrack;

// A planned robot that is near the nodes of a bucket in one tick, or starting with a tick if it
// parks.
typedef struct WgStay {
    int32_t tick;
    int32_t x;  // column and row of its node in that tick
    int32_t y;
    int32_t bucket;
    int32_t robot;
    int32_t earlier;  // the stay before it in the bucket: index + 1, or 0
    int32_t next;     // in its list in `moving` or `parked`: index + 1, or 0
} WgStay;

// The planned robots by bucket, a square of nodes, and tick. A move is compared only with the
// robots near it: with 50 robots in rooms, comparing it with all of them took half of the planning
// time.
typedef struct WgReservations {
    const WgJoint *joint;
    WgTrack *tracks;
    int64_t reach;    // nodes across or up within which robots can conflict
    int64_t side;     // nodes along a bucket's side
    int64_t columns;  // buckets in a row
    int32_t *latest;  // by bucket: its last stay, from which `earlier` leads to all others
    // by bucket: its last stay of a robot that parks, from which `next` leads to the others
    int32_t *parked;
    int32_t *moving;  // hash table of bucket and tick; each entry lists stays of moving robots
    int64_t mask;
    WgStay *stays;
    int64_t count;
    int64_t capacity;
    int64_t moves;        // stays in lists of `moving`
    int64_t last_change;  // first tick after which nothing changes
} WgReservations;

WgStatus wg_begin_reservations(WgReservations *reserved, const WgJoint *joint);

void wg_end_reservations(WgReservations *reserved);

// Reserves the track of a robot; returns false if memory runs out.
bool wg_reserve(WgReservations *reserved, int64_t robot);

// Returns where a robot is in a tick.
static inline int64_t wg_track_at(const WgTrack *track, int64_t tick)
{
    return track->nodes[wg_min(tick, track->length)];
}

static inline int64_t wg_bucket_of(const WgReservations *reserved, int64_t node)
{
    int64_t stride = reserved->joint->stride;
    return node / stride / reserved->side * reserved->columns + node % stride / reserved->side;
}

// Returns true if the robot of a stay is near enough to a node to conflict with a move from there.
// Asking this first spares most of the exact comparisons, and halves the time
// that a crowd takes to plan.
static inline bool wg_is_near_stay(const WgReservations *reserved, int64_t x, int64_t y, const WgStay *stay)
{
    return wg_could_meet(reserved->joint, x - stay->x, y - stay->y);
}

// Returns true if a robot of a class, making a move in the tick of a stay,
// comes too close to that stay's robot.
bool wg_meets_stay(const WgReservations *reserved, int64_t robot_class, int64_t from, int64_t to, const WgStay *stay);

// Returns true if a move in a tick comes too close to a robot that has parked;
// it then does in every later tick.
bool wg_meets_parked(const WgReservations *reserved, int64_t robot_class, int64_t from, int64_t to, int64_t tick);

// Returns true if a move in a tick comes too close to a robot that has not parked yet.
bool wg_meets_moving(const WgReservations *reserved, int64_t robot_class, int64_t from, int64_t to, int64_t tick);

// Returns a hash of two numbers.
static inline uint64_t wg_mixed(int64_t one, int64_t other)
{
    uint64_t key = (uint64_t)one * 0x9E3779B97F4A7C15u ^ (uint64_t)other * 0xC2B2AE3D27D4EB4Fu;
    return key ^ key >> 29;
}

#endif

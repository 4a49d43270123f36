// The paths of the robots planned so far, by place and tick.

#include <stdlib.h>

#include "reservations.h"

WgStatus wg_begin_reservations(WgReservations *reserved, const WgJoint *joint)
{
    int64_t reach = joint->reach + 2;
    int64_t side = 2 * reach + 1;
    *reserved = (WgReservations){
        .joint = joint,
        .reach = reach,
        .side = side,
        .columns = joint->stride / side + 1,
        .mask = 1023,
        .last_change = joint->ticks - 1,
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

void wg_end_reservations(WgReservations *reserved)
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

static int32_t *list_of_moving(const WgReservations *reserved, int64_t bucket, int64_t tick)
{
    return &reserved->moving[wg_mixed(bucket, tick) & (uint64_t)reserved->mask];
}

// Puts a stay at the head of a list and of its bucket; returns false if memory runs out.
static bool add_stay(WgReservations *reserved, int32_t *list, WgStay stay)
{
    if (reserved->count == reserved->capacity) {
        int64_t capacity = 2 * reserved->capacity + 1024;
        WgStay *stays = capacity < INT32_MAX ? realloc(reserved->stays, (size_t)capacity * sizeof *stays) : NULL;
        if (stays == NULL) {
            return false;
        }
        reserved->stays = stays;
        reserved->capacity = capacity;
    }
    stay.next = *list;
    stay.earlier = reserved->latest[stay.bucket];
    reserved->stays[reserved->count] = stay;
    *list = (int32_t)++reserved->count;
    reserved->latest[stay.bucket] = *list;
    return true;
}

// Makes room for more moving robots, so that lists stay short; returns false if memory runs out.
static bool grow_moving(WgReservations *reserved)
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
            WgStay *stay = &reserved->stays[at - 1];
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

bool wg_reserve(WgReservations *reserved, int64_t robot)
{
    const WgTrack *track = &reserved->tracks[robot];
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
                WgStay stay = {
                    .tick = (int32_t)tick,
                    .x = (int32_t)x,
                    .y = (int32_t)y,
                    .bucket = (int32_t)bucket,
                    .robot = (int32_t)robot,
                };
                int32_t *list = parks ? &reserved->parked[bucket] : list_of_moving(reserved, bucket, tick);
                if (!add_stay(reserved, list, stay)) {
                    return false;
                }
                reserved->moves += parks ? 0 : 1;
                if (2 * reserved->moves > reserved->mask && !grow_moving(reserved)) {
                    return false;
                }
            }
        }
    }
    reserved->last_change = wg_max(reserved->last_change, track->length);
    return true;
}

bool wg_meets_stay(const WgReservations *reserved, int64_t robot_class, int64_t from, int64_t to, const WgStay *stay)
{
    const WgTrack *track = &reserved->tracks[stay->robot];
    return wg_moves_conflict(reserved->joint, robot_class, from, to, reserved->joint->class_of[stay->robot],
                             wg_track_at(track, stay->tick), wg_track_at(track, (int64_t)stay->tick + 1));
}

bool wg_meets_parked(const WgReservations *reserved, int64_t robot_class, int64_t from, int64_t to, int64_t tick)
{
    int64_t x = from % reserved->joint->stride;
    int64_t y = from / reserved->joint->stride;
    const WgStay *stay;
    for (int32_t at = reserved->parked[wg_bucket_of(reserved, from)]; at != 0; at = stay->next) {
        stay = &reserved->stays[at - 1];
        if (tick >= stay->tick && wg_is_near_stay(reserved, x, y, stay) &&
            wg_meets_stay(reserved, robot_class, from, to, stay)) {
            return true;
        }
    }
    return false;
}

bool wg_meets_moving(const WgReservations *reserved, int64_t robot_class, int64_t from, int64_t to, int64_t tick)
{
    int64_t bucket = wg_bucket_of(reserved, from);
    int64_t x = from % reserved->joint->stride;
    int64_t y = from / reserved->joint->stride;
    const WgStay *stay;
    for (int32_t at = *list_of_moving(reserved, bucket, tick); at != 0; at = stay->next) {
        stay = &reserved->stays[at - 1];
        if (stay->tick == tick && stay->bucket == bucket && wg_is_near_stay(reserved, x, y, stay) &&
            wg_meets_stay(reserved, robot_class, from, to, stay)) {
            return true;
        }
    }
    return false;
}

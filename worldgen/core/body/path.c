// Turns a path through free boxes into one of few moves and turns.

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "heap.h"
#include "proof.h"

enum { PATIENCE = 6, PASSES = 3, MOST_PADDING = WG_UNIT / 2 };

// A free box on the path.
typedef struct Entry {
    WgBodyPose pose;  // where the path enters it
    int64_t cost;
    int32_t before;
    bool is_done;
} Entry;

typedef struct Poses {
    WgBodyPose *all;
    int64_t count;
    int64_t room;
} Poses;

static bool add_pose(Poses *poses, WgBodyPose pose)
{
    if (poses->count == poses->room) {
        int64_t room = 2 * poses->room + 64;
        WgBodyPose *all = realloc(poses->all, (size_t)room * sizeof *all);
        if (all == NULL) {
            return false;
        }
        poses->all = all;
        poses->room = room;
    }
    poses->all[poses->count++] = pose;
    return true;
}

static int64_t nearest_of(int64_t value, int64_t low, int64_t high)
{
    return wg_max(low, wg_min(value, high));
}

// The heading of a range, which repeats after each period, that is nearest to another heading.
static int64_t nearest_heading(int64_t heading, int64_t low, int64_t high, int64_t period)
{
    if (high - low >= period) {
        return heading;
    }
    int64_t base = heading - heading % period;
    int64_t best = 0;
    int64_t least = INT64_MAX;
    for (int64_t shift = -period; shift <= period; shift += period) {
        int64_t near = nearest_of(heading, base + shift + low, base + shift + high);
        if (wg_abs(near - heading) < least) {
            least = wg_abs(near - heading);
            best = near;
        }
    }
    return best & (WG_TURN - 1);
}

// The nearest of a range's middle half, so that paths keep away from the rims of boxes.
static int64_t nearest_inside(int64_t value, int64_t low, int64_t high)
{
    return nearest_of(value, low + (high - low) / 4, high - (high - low) / 4);
}

// A pose that two boxes share, near another.
static WgBodyPose shared_pose(const WgBoxes *boxes, const WgRange *a, const WgRange *b, WgBodyPose from)
{
    WgBodyPose pose = {
        nearest_inside(from.x, wg_max(a->low[0], b->low[0]), wg_min(a->high[0], b->high[0])),
        nearest_inside(from.y, wg_max(a->low[1], b->low[1]), wg_min(a->high[1], b->high[1])),
        0,
    };
    int64_t low = wg_max(a->low[2], b->low[2]);
    int64_t high = wg_min(a->high[2], b->high[2]);
    // Ranges at both ends of the period share its end.
    if (low > high) {
        low = 0;
        high = 0;
    }
    bool is_all = high - low >= boxes->period;
    int64_t rim = is_all ? 0 : (high - low) / 4;
    pose.heading = nearest_heading(from.heading, low + rim, high - rim, boxes->period);
    return pose;
}

static int64_t cost_between(const WgBoxes *boxes, WgBodyPose a, WgBodyPose b)
{
    double turn = (double)wg_abs(wg_turn_between(a.heading, b.heading)) * WG_RADIANS * boxes->discs.outer;
    return (int64_t)(hypot((double)(b.x - a.x), (double)(b.y - a.y)) + turn) + 1;
}

// The pose at which a path that enters a box of the target ends.
static WgBodyPose last_pose(const WgBoxes *boxes, const WgRange *range, WgBodyPose from)
{
    WgBodyPose pose = from;
    if (!wg_goal_pose(boxes, range, &pose)) {
        return from;
    }
    if (boxes->goal.headings >= WG_TURN - 1) {
        pose.heading = from.heading;
        return pose;
    }
    // Keep the heading if it is one of the target's.
    bool is_in = ((from.heading - boxes->goal.heading) & (WG_TURN - 1)) <= boxes->goal.headings;
    pose.heading = is_in ? from.heading : pose.heading;
    return pose;
}

// Searches the free boxes for a short path; lists its poses.
static WgStatus find_path(const WgBoxes *boxes, int32_t start, WgBodyPose from, Poses *poses)
{
    Entry *entries = malloc((size_t)boxes->count * sizeof *entries);
    WgHeap heap = {0};
    WgStatus status = WG_OUT_OF_MEMORY;
    int64_t end = -1;
    if (entries == NULL) {
        return status;
    }
    for (int64_t k = 0; k < boxes->count; k++) {
        entries[k] = (Entry){.cost = INT64_MAX, .before = -1};
    }
    entries[start] = (Entry){from, 0, -1, false};
    if (!wg_heap_push(&heap, (WgEntry){0, start, 0})) {
        goto done;
    }
    while (heap.count > 0) {
        int64_t number = wg_heap_pop(&heap).second;
        if (entries[number].is_done) {
            continue;
        }
        entries[number].is_done = true;
        const WgBox *box = &boxes->all[number];
        if (box->is_goal) {
            end = number;
            break;
        }
        for (int32_t at = 0; at < box->near_count; at++) {
            int32_t next = box->near[at];
            const WgBox *other = &boxes->all[next];
            if (other->kind != WG_FREE || entries[next].is_done) {
                continue;
            }
            WgBodyPose pose = shared_pose(boxes, &box->range, &other->range, entries[number].pose);
            int64_t cost = entries[number].cost + cost_between(boxes, entries[number].pose, pose);
            if (cost < entries[next].cost) {
                entries[next] = (Entry){pose, cost, (int32_t)number, false};
                if (!wg_heap_push(&heap, (WgEntry){cost, next, 0})) {
                    goto done;
                }
            }
        }
    }
    status = WG_OK;
    if (end >= 0) {
        bool is_added = add_pose(poses, last_pose(boxes, &boxes->all[end].range, entries[end].pose));
        for (int64_t at = end; at >= 0 && is_added; at = entries[at].before) {
            is_added = add_pose(poses, entries[at].pose);
        }
        status = is_added ? WG_OK : WG_OUT_OF_MEMORY;
        for (int64_t k = 0; k < poses->count / 2; k++) {
            WgBodyPose pose = poses->all[k];
            poses->all[k] = poses->all[poses->count - 1 - k];
            poses->all[poses->count - 1 - k] = pose;
        }
    }
done:
    free(entries);
    free(heap.entries);
    return status;
}

// What a leg is tested with.
typedef struct Space {
    const WgWalls *walls;
    const WgBody *body;
    const WgGoal *goal;
} Space;

// How to get from one pose to another.
typedef enum Leg {
    NONE = 0,
    TURN_FIRST = 1,
    MOVE_FIRST = 2,
} Leg;

static Leg leg_between(const Space *space, WgBodyPose a, WgBodyPose b)
{
    int64_t turn = wg_turn_between(a.heading, b.heading);
    WgBodyPose turned = {a.x, a.y, b.heading};
    if (wg_clear_along(space->walls, space->body, turned, b.x, b.y)
        && (turn == 0 || wg_clear_turning(space->walls, space->body, a, turn))) {
        return TURN_FIRST;
    }
    WgBodyPose moved = {b.x, b.y, a.heading};
    if (turn != 0 && wg_clear_along(space->walls, space->body, a, b.x, b.y)
        && wg_clear_turning(space->walls, space->body, moved, turn)) {
        return MOVE_FIRST;
    }
    return NONE;
}

// Leaves out poses where a leg skips them.
static void leave_out(const Space *space, Poses *poses)
{
    int64_t kept = 1;
    for (int64_t at = 0; at + 1 < poses->count;) {
        int64_t next = at + 1;
        int64_t failed = 0;
        for (int64_t to = at + 2; to < poses->count && failed < PATIENCE; to++) {
            if (leg_between(space, poses->all[at], poses->all[to]) != NONE) {
                next = to;
                failed = 0;
            } else {
                failed++;
            }
        }
        // All that is kept is before what is read.
        poses->all[kept] = poses->all[next];
        WgBodyPose end = poses->all[next];
        poses->all[kept++] = end;
        at = next;
    }
    poses->count = kept;
}

// Gives poses the heading of those before or after them, which saves turns.
static void save_turns(const Space *space, Poses *poses)
{
    for (int64_t k = 1; k + 1 < poses->count; k++) {
        for (int64_t other = k - 1; other <= k + 1; other += 2) {
            WgBodyPose tried = poses->all[k];
            if (tried.heading == poses->all[other].heading) {
                continue;
            }
            tried.heading = poses->all[other].heading;
            int64_t saved = wg_abs(wg_turn_between(poses->all[k - 1].heading, poses->all[k].heading))
                            + wg_abs(wg_turn_between(poses->all[k].heading, poses->all[k + 1].heading))
                            - wg_abs(wg_turn_between(poses->all[k - 1].heading, tried.heading))
                            - wg_abs(wg_turn_between(tried.heading, poses->all[k + 1].heading));
            if (saved >= 0 && leg_between(space, poses->all[k - 1], tried) != NONE
                && leg_between(space, tried, poses->all[k + 1]) != NONE) {
                poses->all[k] = tried;
                break;
            }
        }
    }
    // The last one may have another heading if it is the target's, too.
    WgBodyPose *last = &poses->all[poses->count - 1];
    WgBodyPose tried = *last;
    if (poses->count > 1) {
        tried.heading = poses->all[poses->count - 2].heading;
        bool is_goal = ((tried.heading - space->goal->heading) & (WG_TURN - 1)) <= space->goal->headings;
        bool is_clear = is_goal && leg_between(space, poses->all[poses->count - 2], tried) != NONE;
        *last = is_clear ? tried : *last;
    }
}

static bool is_same_pose(WgBodyPose a, WgBodyPose b)
{
    return a.x == b.x && a.y == b.y && a.heading == b.heading;
}

// Adds a turn and a move; half a turn is made in two parts, because its direction is not defined.
static bool add_leg(const Space *space, Poses *path, WgBodyPose to)
{
    WgBodyPose from = path->all[path->count - 1];
    WgBodyPose corner = {to.x, to.y, from.heading};
    if (leg_between(space, from, to) == TURN_FIRST) {
        corner = (WgBodyPose){from.x, from.y, to.heading};
    }
    const WgBodyPose ends[2] = {corner, to};
    for (int which = 0; which < 2; which++) {
        WgBodyPose last = path->all[path->count - 1];
        if (wg_turn_between(last.heading, ends[which].heading) == WG_TURN / 2) {
            WgBodyPose half = last;
            half.heading = (last.heading + WG_TURN / 4) & (WG_TURN - 1);
            if (!add_pose(path, half)) {
                return false;
            }
        }
        if (!is_same_pose(last, ends[which]) && !add_pose(path, ends[which])) {
            return false;
        }
    }
    return true;
}

// Leaves out the ends of turns and of moves that continue straight ahead.
static void join_equal(Poses *path)
{
    int64_t kept = 1;
    for (int64_t k = 1; k < path->count; k++) {
        WgBodyPose next = path->all[k];
        if (kept > 1) {
            WgBodyPose last = path->all[kept - 1];
            WgBodyPose before = path->all[kept - 2];
            int64_t ux = last.x - before.x;
            int64_t uy = last.y - before.y;
            int64_t vx = next.x - last.x;
            int64_t vy = next.y - last.y;
            bool moves = before.heading == last.heading && last.heading == next.heading;
            bool is_straight = moves && ux * vy == uy * vx && ux * vx + uy * vy > 0;
            int64_t first = wg_turn_between(before.heading, last.heading);
            int64_t second = wg_turn_between(last.heading, next.heading);
            bool turns = ux == 0 && uy == 0 && vx == 0 && vy == 0 && (first > 0) == (second > 0)
                         && wg_abs(first + second) < WG_TURN / 2;
            kept -= is_straight || turns;
        }
        path->all[kept++] = next;
    }
    path->count = kept;
}

// Moves all sides of a body out. Corners are rounded; false if that makes a body that isn't one.
static bool pad(const WgWalls *walls, const WgBody *body, int64_t padding, int64_t *corners, WgBody *padded)
{
    for (int64_t k = 0; k < body->count; k++) {
        const int64_t *before = body->corners + 2 * ((k + body->count - 1) % body->count);
        const int64_t *corner = body->corners + 2 * k;
        const int64_t *after = body->corners + 2 * ((k + 1) % body->count);
        double ux = (double)(corner[0] - before[0]);
        double uy = (double)(corner[1] - before[1]);
        double vx = (double)(after[0] - corner[0]);
        double vy = (double)(after[1] - corner[1]);
        double u = hypot(ux, uy);
        double v = hypot(vx, vy);
        // Both normals reach the padding from there.
        double share = (double)padding / (1.0 + (ux * vx + uy * vy) / (u * v));
        corners[2 * k] = corner[0] + (int64_t)floor(share * (uy / u + vy / v) + 0.5);
        corners[2 * k + 1] = corner[1] - (int64_t)floor(share * (ux / u + vx / v) + 0.5);
    }
    *padded = (WgBody){corners, body->count, body->cosines};
    return wg_body_is_valid(walls, padded);
}

static bool is_path_clear(const Space *space, const Poses *poses)
{
    for (int64_t k = 0; k + 1 < poses->count; k++) {
        if (leg_between(space, poses->all[k], poses->all[k + 1]) == NONE) {
            return false;
        }
    }
    return true;
}

WgStatus wg_write_path(WgBoxes *boxes, int32_t start, WgBodyQuery *query)
{
    Poses poses = {0};
    Poses path = {0};
    WgStatus status = find_path(boxes, start, query->start, &poses);
    if (status != WG_OK || poses.count == 0) {
        free(poses.all);
        return status;
    }
    // The path is shortened for a body that is as much larger as the path allows, so that it doesn't
    // come nearer to walls than it has to.
    Space space = {boxes->walls, boxes->body, &boxes->goal};
    WgBody padded;
    int64_t corners[2 * WG_MOST_CORNERS];
    for (int64_t padding = MOST_PADDING; padding > 0; padding /= 2) {
        const Space larger = {boxes->walls, &padded, &boxes->goal};
        if (pad(boxes->walls, boxes->body, padding, corners, &padded) && is_path_clear(&larger, &poses)) {
            space = larger;
            break;
        }
    }
    for (int pass = 0; pass < PASSES; pass++) {
        leave_out(&space, &poses);
        save_turns(&space, &poses);
    }
    leave_out(&space, &poses);
    bool is_added = add_pose(&path, poses.all[0]);
    for (int64_t k = 1; k < poses.count && is_added; k++) {
        is_added = add_leg(&space, &path, poses.all[k]);
    }
    free(poses.all);
    status = WG_OUT_OF_MEMORY;
    if (is_added) {
        join_equal(&path);
        query->count = path.count;
        query->rows = malloc((size_t)(3 * path.count) * sizeof *query->rows);
    }
    for (int64_t k = 0; query->rows != NULL && k < path.count; k++) {
        query->rows[3 * k] = path.all[k].x;
        query->rows[3 * k + 1] = path.all[k].y;
        query->rows[3 * k + 2] = path.all[k].heading;
        status = WG_OK;
    }
    free(path.all);
    if (status == WG_OK) {
        status = wg_body_clearance(boxes->walls, boxes->body, query->rows, query->count, 0.5, &query->clearance);
    }
    return status;
}

// Measures how far a body on its path stays from the walls.

#include <math.h>
#include <stdlib.h>

#include "solids.h"

// Floats give a distance with a smaller error, lu.
#define ROUNDING 1e-6

typedef struct Corners {
    int64_t count;
    double x[WG_MOST_HULL];
    double y[WG_MOST_HULL];
} Corners;

// Distance from a point to the segment from a to b, all relative.
static double to_segment(double px, double py, double ax, double ay, double bx, double by)
{
    double ex = bx - ax;
    double ey = by - ay;
    double length_sq = ex * ex + ey * ey;
    double share = length_sq > 0.0 ? ((px - ax) * ex + (py - ay) * ey) / length_sq : 0.0;
    share = share < 0.0 ? 0.0 : share > 1.0 ? 1.0 : share;
    return hypot(px - ax - share * ex, py - ay - share * ey);
}

static double outside(double value, double low, double high)
{
    return value < low ? low - value : value > high ? value - high : 0.0;
}

// Distance between a polygon and a rectangle that don't overlap.
static double distance_to(const Corners *polygon, const WgSolid *solid)
{
    double x[2] = {(double)solid->low[0], (double)solid->high[0]};
    double y[2] = {(double)solid->low[1], (double)solid->high[1]};
    double least = INFINITY;
    for (int64_t k = 0; k < polygon->count; k++) {
        int64_t after = k + 1 < polygon->count ? k + 1 : 0;
        double corner = hypot(outside(polygon->x[k], x[0], x[1]), outside(polygon->y[k], y[0], y[1]));
        least = corner < least ? corner : least;
        for (int which = 0; which < 4; which++) {
            double side = to_segment(x[which % 2], y[which / 2], polygon->x[k], polygon->y[k], polygon->x[after],
                                     polygon->y[after]);
            least = side < least ? side : least;
        }
    }
    return least;
}

// Distance from a polygon to the nearest rectangle, if it is below a bound.
static double nearest_solid(const WgSolids *solids, const Corners *polygon, double bound)
{
    double low[2] = {INFINITY, INFINITY};
    double high[2] = {-INFINITY, -INFINITY};
    for (int64_t k = 0; k < polygon->count; k++) {
        low[0] = polygon->x[k] < low[0] ? polygon->x[k] : low[0];
        high[0] = polygon->x[k] > high[0] ? polygon->x[k] : high[0];
        low[1] = polygon->y[k] < low[1] ? polygon->y[k] : low[1];
        high[1] = polygon->y[k] > high[1] ? polygon->y[k] : high[1];
    }
    for (int64_t k = 0; k < solids->count; k++) {
        const WgSolid *solid = &solids->all[k];
        bool is_far = false;
        for (int axis = 0; axis < 2; axis++) {
            is_far = is_far || (double)solid->low[axis] - high[axis] >= bound
                     || low[axis] - (double)solid->high[axis] >= bound;
        }
        if (solid->in_cover && !is_far) {
            double distance = distance_to(polygon, solid);
            bound = distance < bound ? distance : bound;
        }
    }
    return bound;
}

static void corners_of(const WgBody *body, WgBodyPose pose, Corners *corners)
{
    WgHull hull;
    wg_body_hull(body, pose.x, pose.y, pose.heading, &hull);
    corners->count = hull.count;
    for (int64_t k = 0; k < hull.count; k++) {
        corners->x[k] = (double)hull.x[k] / WG_ONE;
        corners->y[k] = (double)hull.y[k] / WG_ONE;
    }
}

// Measures the body over a move: the distance of a moving side from a point is least at an end or beside
// one of the lines on which its corners move.
static double along(const WgSolids *solids, const WgBody *body, WgBodyPose pose, int64_t x, int64_t y, double bound)
{
    Corners ends[2];
    corners_of(body, pose, &ends[0]);
    ends[1] = ends[0];
    double dx = (double)(x - pose.x);
    double dy = (double)(y - pose.y);
    for (int64_t k = 0; k < ends[1].count; k++) {
        ends[1].x[k] += dx;
        ends[1].y[k] += dy;
    }
    for (int end = 0; end < 2; end++) {
        bound = nearest_solid(solids, &ends[end], bound);
    }
    for (int64_t k = 0; k < ends[0].count; k++) {
        Corners line = {2, {ends[0].x[k], ends[1].x[k]}, {ends[0].y[k], ends[1].y[k]}};
        bound = nearest_solid(solids, &line, bound);
    }
    return bound;
}

// A range of headings: the first, and how many follow.
typedef struct Headings {
    int64_t first;
    int64_t following;
} Headings;

// Measures the body over a turn: from a heading to another no corner moves farther than its arc.
static double turning(const WgSolids *solids, const WgBody *body, WgBodyPose pose, int64_t turn, double slack,
                      double bound)
{
    double reach = wg_body_reach(body);
    Corners corners;
    Headings left[2 * WG_HEADING_BITS + 2];
    int64_t count = 1;
    left[0] = (Headings){pose.heading, turn};
    while (count > 0) {
        Headings now = left[--count];
        int64_t half = now.following / 2;
        pose.heading = (now.first + half) & (WG_TURN - 1);
        corners_of(body, pose, &corners);
        double swing = reach * (double)(now.following - half) * WG_RADIANS;
        double distance = nearest_solid(solids, &corners, bound + swing);
        bound = distance < bound ? distance : bound;
        if (now.following == 0 || distance - swing >= bound - slack) {
            continue;
        }
        if (now.following > half) {
            left[count++] = (Headings){now.first + half + 1, now.following - half - 1};
        }
        left[count++] = (Headings){now.first, half};
    }
    return bound;
}

WgStatus wg_body_clearance(const WgWalls *walls, const WgBody *body, const int64_t *poses, int64_t count,
                           double slack, double *clearance)
{
    if (!wg_body_is_valid(walls, body) || count < 1 || !(slack > ROUNDING)) {
        return WG_BAD_VALUE;
    }
    WgSolids solids;
    WgStatus status = wg_solids_make(&solids, walls);
    // The outside is nearer than this.
    double bound = (double)(wg_max(walls->width, walls->height) * WG_UNIT);
    for (int64_t k = 0; k < count && status == WG_OK; k++) {
        const int64_t *at = poses + 3 * k;
        const int64_t *next = k + 1 < count ? at + 3 : at;
        WgBodyPose pose = {at[0], at[1], at[2]};
        int64_t around = wg_turn_between(at[2], next[2]);
        if (around != 0) {
            pose.heading = around > 0 ? at[2] : next[2];
            bound = turning(&solids, body, pose, wg_abs(around), slack - ROUNDING, bound);
        } else {
            bound = along(&solids, body, pose, next[0], next[1], bound);
        }
    }
    wg_solids_free(&solids);
    *clearance = bound > slack ? bound - slack : 0.0;
    return status;
}

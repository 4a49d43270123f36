// Exact tests of a body against cells: at a pose, along a line, and through a turn.

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "body.h"

// A cell's side in 2^-30 lu.
#define SIDE ((int64_t)1 << 40)
enum { SIDE_BITS = 40 };

// Nearer than this to a border between cells, in cells, only fractions decide; the floats are off by
// less than 1e-8.
#define DOUBT 1e-6

typedef __int128 Wide;

bool wg_body_is_valid(const WgWalls *walls, const WgBody *body)
{
    if (walls->height < 1 || walls->width < 1 || walls->height > 20000 || walls->width > 20000 || body->count < 3
        || body->count > WG_MOST_CORNERS) {
        return false;
    }
    for (int64_t k = 0; k < body->count; k++) {
        const int64_t *a = body->corners + 2 * k;
        const int64_t *b = body->corners + 2 * ((k + 1) % body->count);
        const int64_t *c = body->corners + 2 * ((k + 2) % body->count);
        if (wg_abs(a[0]) > WG_MOST_REACH || wg_abs(a[1]) > WG_MOST_REACH) {
            return false;
        }
        if ((b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]) <= 0) {
            return false;
        }
    }
    return true;
}

static bool is_pose(const WgBodyPose *pose)
{
    int64_t most = (int64_t)20000 * WG_UNIT + WG_MOST_REACH + 1;
    return wg_abs(pose->x) <= most && wg_abs(pose->y) <= most && pose->heading >= 0 && pose->heading < WG_TURN;
}

double wg_body_reach(const WgBody *body)
{
    int64_t most = 0;
    for (int64_t k = 0; k < body->count; k++) {
        int64_t x = body->corners[2 * k];
        int64_t y = body->corners[2 * k + 1];
        most = wg_max(most, x * x + y * y);
    }
    return sqrt((double)most);
}

void wg_body_hull(const WgBody *body, int64_t x, int64_t y, int64_t heading, WgHull *hull)
{
    int64_t c = wg_cosine(body, heading);
    int64_t s = wg_sine(body, heading);
    hull->count = body->count;
    for (int64_t k = 0; k < body->count; k++) {
        int64_t cx = body->corners[2 * k];
        int64_t cy = body->corners[2 * k + 1];
        hull->x[k] = x * ((int64_t)1 << 30) + cx * c - cy * s;
        hull->y[k] = y * ((int64_t)1 << 30) + cx * s + cy * c;
    }
}

// The cell in which the side from p to q is at height y: the one on the left of a border if ``up``.
static int64_t cell_at(const WgHull *hull, int64_t p, int64_t q, int64_t y, bool up)
{
    int64_t rise = hull->y[q] - hull->y[p];
    int64_t run = hull->x[q] - hull->x[p];
    double share = (double)(y - hull->y[p]) / (double)rise;
    double cells = ((double)hull->x[p] + share * (double)run) / (double)SIDE;
    double below = floor(cells);
    if (cells - below > DOUBT && below + 1.0 - cells > DOUBT) {
        return (int64_t)below;
    }
    Wide over = (Wide)hull->x[p] * rise + (Wide)run * (y - hull->y[p]);
    Wide under = (Wide)rise * SIDE;
    if (under < 0) {
        over = -over;
        under = -under;
    }
    if (up) {
        over -= 1;
    }
    Wide quotient = over / under;
    return (int64_t)(over % under < 0 ? quotient - 1 : quotient);
}

// Widens the range of cells in a row to those that one side's part in that row touches.
static void widen(const WgHull *hull, int64_t p, int64_t q, int64_t row, int64_t *first, int64_t *last)
{
    int64_t low = row * SIDE;
    const int64_t ends[2] = {p, q};
    for (int end = 0; end < 2; end++) {
        int64_t y = hull->y[ends[end]];
        if (y >= low && y <= low + SIDE) {
            *first = wg_min(*first, hull->x[ends[end]] >> SIDE_BITS);
            *last = wg_max(*last, (hull->x[ends[end]] - 1) >> SIDE_BITS);
        }
    }
    for (int border = 0; border < 2; border++) {
        int64_t y = low + border * SIDE;
        if ((hull->y[p] < y) != (hull->y[q] < y) && hull->y[p] != y && hull->y[q] != y) {
            *first = wg_min(*first, cell_at(hull, p, q, y, false));
            *last = wg_max(*last, cell_at(hull, p, q, y, true));
        }
    }
}

bool wg_hull_is_clear(const WgWalls *walls, const WgHull *hull)
{
    int64_t low = hull->y[0];
    int64_t high = low;
    int64_t left = hull->x[0];
    int64_t right = left;
    for (int64_t k = 1; k < hull->count; k++) {
        low = wg_min(low, hull->y[k]);
        high = wg_max(high, hull->y[k]);
        left = wg_min(left, hull->x[k]);
        right = wg_max(right, hull->x[k]);
    }
    if (low < 0 || left < 0 || high > walls->height * SIDE || right > walls->width * SIDE) {
        return false;
    }
    // In each row of cells, the part of a convex polygon covers one range of cells.
    for (int64_t row = low >> SIDE_BITS; row <= (high - 1) >> SIDE_BITS; row++) {
        int64_t first = INT64_MAX;
        int64_t last = INT64_MIN;
        for (int64_t k = 0; k < hull->count; k++) {
            widen(hull, k, k + 1 < hull->count ? k + 1 : 0, row, &first, &last);
        }
        const uint8_t *cells = walls->solid + row * walls->width;
        for (int64_t column = first; column <= last; column++) {
            if (cells[column] != 0) {
                return false;
            }
        }
    }
    return true;
}

bool wg_clear_at(const WgWalls *walls, const WgBody *body, WgBodyPose pose)
{
    WgHull hull;
    wg_body_hull(body, pose.x, pose.y, pose.heading, &hull);
    return wg_hull_is_clear(walls, &hull);
}

bool wg_clear_along(const WgWalls *walls, const WgBody *body, WgBodyPose pose, int64_t x, int64_t y)
{
    WgHull at;
    wg_body_hull(body, pose.x, pose.y, pose.heading, &at);
    int64_t dx = (x - pose.x) * ((int64_t)1 << 30);
    int64_t dy = (y - pose.y) * ((int64_t)1 << 30);
    if (dx == 0 && dy == 0) {
        return wg_hull_is_clear(walls, &at);
    }
    // A corner is at the front of the move if the side after it looks ahead and the one before it
    // doesn't, or the other way around; such a corner is in the hull at both ends of the move.
    WgHull hull = {.count = 0};
    for (int64_t k = 0; k < at.count; k++) {
        int64_t before = k > 0 ? k - 1 : at.count - 1;
        int64_t after = k + 1 < at.count ? k + 1 : 0;
        Wide in = (Wide)(at.y[k] - at.y[before]) * dx - (Wide)(at.x[k] - at.x[before]) * dy;
        Wide out = (Wide)(at.y[after] - at.y[k]) * dx - (Wide)(at.x[after] - at.x[k]) * dy;
        // ``in`` and ``out`` say how far ahead the sides look: their normals times the move.
        bool first_moved = in > 0;
        bool last_moved = out > 0;
        const bool moved[2] = {first_moved, last_moved};
        for (int turn = 0; turn < (first_moved == last_moved ? 1 : 2); turn++) {
            hull.x[hull.count] = at.x[k] + (moved[turn] ? dx : 0);
            hull.y[hull.count] = at.y[k] + (moved[turn] ? dy : 0);
            hull.count++;
        }
    }
    return wg_hull_is_clear(walls, &hull);
}

typedef struct Point {
    int64_t x;
    int64_t y;
} Point;

static int compare_points(const void *a, const void *b)
{
    const Point *p = a;
    const Point *q = b;
    if (p->x != q->x) {
        return p->x < q->x ? -1 : 1;
    }
    return (p->y > q->y) - (p->y < q->y);
}

static bool bends_left(const WgHull *hull, Point p)
{
    int64_t n = hull->count;
    Wide ax = hull->x[n - 1] - hull->x[n - 2];
    Wide ay = hull->y[n - 1] - hull->y[n - 2];
    return ax * (p.y - hull->y[n - 1]) - ay * (p.x - hull->x[n - 1]) > 0;
}

// The hull of points. Andrew, Another efficient algorithm for convex hulls in two dimensions (1979).
static void hull_of(Point *points, int64_t count, WgHull *hull)
{
    qsort(points, (size_t)count, sizeof *points, compare_points);
    hull->count = 0;
    for (int half = 0; half < 2; half++) {
        int64_t begin = hull->count;
        for (int64_t k = 0; k < count; k++) {
            Point p = points[half == 0 ? k : count - 1 - k];
            while (hull->count - begin >= 2 && !bends_left(hull, p)) {
                hull->count--;
            }
            hull->x[hull->count] = p.x;
            hull->y[hull->count] = p.y;
            hull->count++;
        }
        hull->count--;
    }
}

// Returns true if the body is certainly clear at all headings between two ends, at most a sixteenth of a
// turn apart.
static bool is_surely_clear(const WgWalls *walls, const WgBody *body, WgBodyPose pose, int64_t turn)
{
    // An arc is between its chord and the tangents at its ends. All corners are moved out by more than
    // what rounding the cosines changes.
    Point points[WG_MOST_HULL];
    double half = (double)turn * WG_RADIANS / 2.0;
    double out = (1.0 + 0x1p-28);
    double stretch = out / cos(half);
    WgHull ends[2];
    wg_body_hull(body, 0, 0, pose.heading, &ends[0]);
    wg_body_hull(body, 0, 0, pose.heading + turn, &ends[1]);
    for (int64_t k = 0; k < body->count; k++) {
        double mx = 0.0;
        double my = 0.0;
        for (int end = 0; end < 2; end++) {
            double x = (double)ends[end].x[k];
            double y = (double)ends[end].y[k];
            points[3 * k + end] = (Point){(int64_t)(x * out), (int64_t)(y * out)};
            mx += x;
            my += y;
        }
        // The middle of the chord is at the cosine of half the turn.
        double grow = stretch / cos(half) / 2.0;
        points[3 * k + 2] = (Point){(int64_t)(mx * grow), (int64_t)(my * grow)};
    }
    for (int64_t k = 0; k < 3 * body->count; k++) {
        points[k].x += pose.x * ((int64_t)1 << 30);
        points[k].y += pose.y * ((int64_t)1 << 30);
    }
    // Andrew's scan keeps one point more than the hull has at a time.
    WgHull hull;
    hull_of(points, 3 * body->count, &hull);
    return wg_hull_is_clear(walls, &hull);
}

// A range of headings: the first, and how many follow.
typedef struct Headings {
    int64_t first;
    int64_t following;
} Headings;

// Tests the headings strictly between the ends of a counter-clockwise turn.
static bool clear_between(const WgWalls *walls, const WgBody *body, WgBodyPose pose, int64_t turn)
{
    // Halves of halves wait here, at most one of each size and its sibling.
    Headings left[2 * WG_HEADING_BITS];
    int64_t count = 1;
    left[0] = (Headings){pose.heading, turn};
    while (count > 0) {
        Headings now = left[--count];
        pose.heading = now.first & (WG_TURN - 1);
        bool is_small = now.following <= WG_TURN / 16;
        if (now.following < 2 || (is_small && is_surely_clear(walls, body, pose, now.following))) {
            continue;
        }
        int64_t half = now.following / 2;
        pose.heading = (now.first + half) & (WG_TURN - 1);
        if (!wg_clear_at(walls, body, pose)) {
            return false;
        }
        left[count++] = (Headings){now.first + half, now.following - half};
        left[count++] = (Headings){now.first, half};
    }
    return true;
}

bool wg_clear_turning(const WgWalls *walls, const WgBody *body, WgBodyPose pose, int64_t turn)
{
    WgBodyPose other = pose;
    other.heading = (pose.heading + turn) & (WG_TURN - 1);
    return wg_clear_at(walls, body, pose) && wg_clear_at(walls, body, other)
           && clear_between(walls, body, turn < 0 ? other : pose, wg_abs(turn));
}

WgStatus wg_body_is_clear(const WgWalls *walls, const WgBody *body, const WgBodyPose *pose, int64_t *clear)
{
    if (!wg_body_is_valid(walls, body) || !is_pose(pose)) {
        return WG_BAD_VALUE;
    }
    *clear = wg_clear_at(walls, body, *pose);
    return WG_OK;
}

WgStatus wg_body_may_move(const WgWalls *walls, const WgBody *body, const WgBodyPose *pose, int64_t x, int64_t y,
                          int64_t *clear)
{
    WgBodyPose end = {x, y, 0};
    if (!wg_body_is_valid(walls, body) || !is_pose(pose) || !is_pose(&end)) {
        return WG_BAD_VALUE;
    }
    *clear = wg_clear_along(walls, body, *pose, x, y);
    return WG_OK;
}

WgStatus wg_body_may_turn(const WgWalls *walls, const WgBody *body, const WgBodyPose *pose, int64_t turn,
                          int64_t *clear)
{
    if (!wg_body_is_valid(walls, body) || !is_pose(pose) || wg_abs(turn) > WG_TURN / 2) {
        return WG_BAD_VALUE;
    }
    *clear = wg_clear_turning(walls, body, *pose, turn);
    return WG_OK;
}

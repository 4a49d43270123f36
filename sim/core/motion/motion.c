// Turns a commanded displacement into a path on the pose lattice: swept and endpoint.
//
// `swept` never tunnels, for any controller, because every segment that it takes has passed the
// exact test of geometry.c, or polygon.c; floating point only suggests where to stop.

#include <math.h>
#include <stddef.h>

#include "motion.h"
#include "polygon.h"

// straight pieces that a move may have: ahead, and two slides (face, then corner)
enum { TRIES = 3 };

// lattice units squared by which a path may cut a circle's square and graze it
static const double GRAZE = 1e-6;
// lattice units that a body may go into a cell and only graze it
static const double BODY_GRAZE = 1e-3;
static const double TIME_UNIT = 0x1p32;   // units of WgCorner.time per step

// What moves: a polygon, or a disc. The functions that ask for it are inlined for each, so a disc's moves take
// as long as if there were nothing else.
typedef struct Shape {
    WgDisc disc;
    const WgPolygon *polygon;  // NULL for a disc
} Shape;

#define FOR_EACH_SHAPE __attribute__((always_inline)) static inline

typedef struct Stop {
    WgContact contact;
    WgPlace place;
} Stop;

static WgSegment segment(WgPlace from, WgPlace to)
{
    return (WgSegment){from.x, from.y, to.x, to.y};
}

FOR_EACH_SHAPE bool is_clear(WgGrid grid, Shape shape, WgPlace from, WgPlace to)
{
    if (shape.polygon != NULL) {
        return !wg_polygon_first_not_clear(grid, WG_SOLID, shape.polygon, segment(from, to)).found;
    }
    return !wg_first_not_clear(grid, WG_SOLID, shape.disc, segment(from, to)).found;
}

// Returns the time in [0, 1) at which a point moving by d from m meets the circle around the
// origin; 2 if it doesn't.
//
// One that only grazes the circle doesn't, unless `graze` is 0.
//
// Source: moving point against sphere, Ericson, Real-Time Collision Detection (2005), 5.3.2.
static double contact_with_corner(double radius_sq, double mx, double my, double dx, double dy, double graze)
{
    double approach = mx * dx + my * dy;
    if (approach >= 0.0) {
        return 2.0;
    }
    double a = dx * dx + dy * dy;
    double inside = approach * approach - a * (mx * mx + my * my - radius_sq);
    if (inside < graze * a) {
        return 2.0;
    }
    return wg_higher(0.0, (-approach - sqrt(inside)) / a);
}

// Keeps the earliest contact: the best so far, or one of a disc at the origin, moving by d, with a
// cell.
//
double wg_touch_time(double radius_sq, WgPlace from, WgVector by)
{
    return contact_with_corner(radius_sq, (double)from.x, (double)from.y, (double)by.x, (double)by.y, 0.0);
}

// left, low: the cell's corner.
static void touch_cell(double left, double low, double radius, double dx, double dy, double graze, WgContact *best)
{
    const double side = WG_UNIT;
    // Its faces, moved out by the radius, against the centre.
    if (dx != 0.0) {
        double t = dx > 0.0 ? (left - radius) / dx : (left + side + radius) / dx;
        if (-1e-9 <= t && t < best->time && low <= t * dy && t * dy <= low + side) {
            *best = (WgContact){wg_higher(t, 0.0), {-dx, 0.0}};
        }
    }
    if (dy != 0.0) {
        double t = dy > 0.0 ? (low - radius) / dy : (low + side + radius) / dy;
        if (-1e-9 <= t && t < best->time && left <= t * dx && t * dx <= left + side) {
            *best = (WgContact){wg_higher(t, 0.0), {0.0, -dy}};
        }
    }
    // Circles around its corners.
    for (int corner = 0; corner < 4; corner++) {
        double mx = -left - (double)((corner & 1) * WG_UNIT);
        double my = -low - (double)((corner >> 1) * WG_UNIT);
        double t = contact_with_corner(radius * radius, mx, my, dx, dy, graze);
        if (t < best->time) {
            *best = (WgContact){t, {mx + t * dx, my + t * dy}};
        }
    }
}

// Finds when a disc moving by (dx, dy) first touches a solid cell.
static WgContact first_contact(WgGrid grid, double radius, int64_t reach, WgPlace from, int64_t dx, int64_t dy,
                             double graze)
{
    WgContact best = {2.0, {0.0, 0.0}};
    int64_t low = wg_most(wg_cell_of(wg_least(from.y, from.y + dy) - reach - 1), -1);
    int64_t high = wg_least(wg_cell_of(wg_most(from.y, from.y + dy) + reach), grid.height);
    int64_t left = wg_most(wg_cell_of(wg_least(from.x, from.x + dx) - reach - 1), -1);
    int64_t right = wg_least(wg_cell_of(wg_most(from.x, from.x + dx) + reach), grid.width);
    for (int64_t iy = low; iy <= high; iy++) {
        for (int64_t ix = left; ix <= right; ix++) {
            if (wg_cell_state(grid, ix, iy) == WG_SOLID) {
                touch_cell((double)(ix * WG_UNIT - from.x), (double)(iy * WG_UNIT - from.y), radius, (double)dx,
                           (double)dy, graze, &best);
            }
        }
    }
    return best;
}

WgContact wg_wall_contact(WgGrid grid, WgDisc disc, WgPlace from, WgVector by)
{
    double radius = sqrt((double)disc.clear_sq);
    WgContact contact = first_contact(grid, radius, disc.reach, from, by.x, by.y, GRAZE);
    if (contact.time > 1.0) {
        contact = first_contact(grid, radius, disc.reach, from, by.x, by.y, 0.0);
    }
    if (contact.time > 1.0) {
        contact = (WgContact){1.0, {-(double)by.x, -(double)by.y}};
    }
    return contact;
}

// Finds when a shape first touches a solid cell; with `graze`, one that it only grazes does not count.
FOR_EACH_SHAPE WgContact contact_of(WgGrid grid, Shape shape, WgPlace from, int64_t dx, int64_t dy, bool graze)
{
    if (shape.polygon != NULL) {
        return wg_polygon_contact(grid, shape.polygon, from, (WgVector){dx, dy}, graze ? BODY_GRAZE : 0.0);
    }
    double radius = sqrt((double)shape.disc.clear_sq);
    return first_contact(grid, radius, shape.disc.reach, from, dx, dy, graze ? GRAZE : 0.0);
}

// A clear end of a slide: its destination, or one or two lattice units farther from the wall.
FOR_EACH_SHAPE bool step_aside(WgGrid grid, Shape shape, WgPlace from, WgPlace to, WgNormal normal, WgPlace *end)
{
    int64_t sx = (normal.x > 0.0) - (normal.x < 0.0);
    int64_t sy = (normal.y > 0.0) - (normal.y < 0.0);
    int64_t main_x = fabs(normal.x) >= fabs(normal.y) ? sx : 0;
    int64_t main_y = fabs(normal.y) >= fabs(normal.x) ? sy : 0;
    for (int64_t away = 0; away < 4; away++) {
        WgPlace aside = {to.x + (away < 3 ? away * main_x : sx), to.y + (away < 3 ? away * main_y : sy)};
        if (is_clear(grid, shape, from, aside)) {
            *end = aside;
            return true;
        }
    }
    *end = from;
    return false;
}

// Returns a lattice point near a contact that a clear segment leads to,
// or the start if there is none.
//
// Try the nearest to the contact, then points slightly away from the wall in case rounding is
// inside it, then farther back.
FOR_EACH_SHAPE WgPlace stop_at(WgGrid grid, Shape shape, WgPlace from, int64_t dx, int64_t dy, WgContact contact)
{
    double length = sqrt((double)dx * (double)dx + (double)dy * (double)dy);
    for (int back = 0; back < 4; back++) {
        double share = (contact.time * length - (double)back) / length;
        if (share <= 0.0) {
            break;
        }
        WgPlace goal = {from.x + wg_round_away(share * (double)dx), from.y + wg_round_away(share * (double)dy)};
        // The robot is clear where it is. Nine of ten contacts of a robot that pushes along walls
        // end here, which is a fifth faster.
        if (goal.x == from.x && goal.y == from.y) {
            break;
        }
        WgPlace end;
        if (step_aside(grid, shape, from, goal, contact.normal, &end)) {
            return end;
        }
    }
    return from;
}

// Finds the first contact of a path that isn't clear, and where it lets the shape stop.
//
// Corners that the path only grazes count if nothing else explains why the path isn't clear: they
// play no part in a slide along a wall, however near they are.
FOR_EACH_SHAPE Stop first_stop(WgGrid grid, Shape shape, WgPlace from, int64_t dx, int64_t dy)
{
    WgContact contact = contact_of(grid, shape, from, dx, dy, true);
    if (contact.time <= 1.0) {
        WgPlace place = stop_at(grid, shape, from, dx, dy, contact);
        bool moved = place.x != from.x || place.y != from.y;
        if (moved || contact.time * (double)(wg_abs(dx) + wg_abs(dy)) < 1.0) {
            return (Stop){contact, place};
        }
    }
    contact = contact_of(grid, shape, from, dx, dy, false);
    if (contact.time > 1.0) {
        // A touch that only exact arithmetic detects.
        contact = (WgContact){1.0, {-(double)dx, -(double)dy}};
    }
    return (Stop){contact, stop_at(grid, shape, from, dx, dy, contact)};
}

static int64_t append(WgCorner *chain, int64_t count, WgPlace place, double time)
{
    chain[count] = (WgCorner){place.x, place.y, wg_floor(time * TIME_UNIT + 0.5)};
    return count + 1;
}

FOR_EACH_SHAPE WgMoved swept_move(WgGrid grid, Shape shape, WgSegment way, double begin, double end,
                                  double wall_friction, WgCorner *chain, int64_t count)
{
    WgPlace place = {way.px, way.py};
    int64_t dx = way.qx - way.px;
    int64_t dy = way.qy - way.py;
    double now = begin;
    WgNormal normal = {0.0, 0.0};
    for (int attempt = 0; attempt < TRIES && (dx != 0 || dy != 0); attempt++) {
        // Go all the way if it is clear.
        WgPlace goal = {place.x + dx, place.y + dy};
        WgPlace clear_end = goal;
        bool is_free = attempt == 0 ? is_clear(grid, shape, place, goal)
                                    : step_aside(grid, shape, place, goal, normal, &clear_end);
        if (is_free) {
            count = append(chain, count, clear_end, end);
            break;
        }

        // Otherwise go as far as the first wall.
        Stop stop = first_stop(grid, shape, place, dx, dy);
        WgNormal wall = stop.contact.normal;
        now += (end - now) * stop.contact.time;
        if (stop.place.x != place.x || stop.place.y != place.y) {
            count = append(chain, count, stop.place, now);
            place = stop.place;
        }

        // Spend the rest of the displacement along that wall.
        double left_x = (1.0 - stop.contact.time) * (double)dx;
        double left_y = (1.0 - stop.contact.time) * (double)dy;
        double into = (left_x * wall.x + left_y * wall.y) / (wall.x * wall.x + wall.y * wall.y);
        if (into < 0.0) {
            left_x = left_x - into * wall.x;
            left_y = left_y - into * wall.y;
        }
        bool is_wedged = attempt > 0 && left_x * normal.x + left_y * normal.y < 0.0;
        normal = wall;
        if (is_wedged) {
            break;  // the second wall pushes back into the first
        }
        dx = wg_round_away((1.0 - wall_friction) * left_x);
        dy = wg_round_away((1.0 - wall_friction) * left_y);
    }
    return (WgMoved){count, normal};
}

WgMoved wg_swept_move(WgGrid grid, WgDisc disc, WgSegment way, double begin, double end, double wall_friction,
                      WgCorner *chain, int64_t count)
{
    return swept_move(grid, (Shape){disc, NULL}, way, begin, end, wall_friction, chain, count);
}

WgMoved wg_swept_body_move(WgGrid grid, const int64_t *headings, const WgFootprint *footprint, int64_t heading,
                           WgSegment way, double begin, double end, double wall_friction, WgCorner *chain,
                           int64_t count)
{
    WgPolygon polygon;
    wg_polygon_turned(headings, footprint, heading, &polygon);
    return swept_move(grid, (Shape){{0, 0}, &polygon}, way, begin, end, wall_friction, chain, count);
}

FOR_EACH_SHAPE bool is_clear_at(WgGrid grid, Shape shape, WgPlace place)
{
    if (shape.polygon != NULL) {
        return is_clear(grid, shape, place, place);
    }
    return wg_disc_is_clear(grid, WG_SOLID, shape.disc, place.x, place.y);
}

FOR_EACH_SHAPE WgMoved endpoint_move(WgGrid grid, Shape shape, WgSegment way, WgCorner *chain, int64_t count)
{
    WgPlace goal = {way.qx, way.qy};
    if (goal.x == way.px && goal.y == way.py) {
        return (WgMoved){count, {0.0, 0.0}};
    }
    if (is_clear_at(grid, shape, goal)) {
        return (WgMoved){append(chain, count, goal, 1.0), {0.0, 0.0}};
    }
    return (WgMoved){count, {-(double)(goal.x - way.px), -(double)(goal.y - way.py)}};
}

WgMoved wg_endpoint_move(WgGrid grid, WgDisc disc, WgSegment way, WgCorner *chain, int64_t count)
{
    return endpoint_move(grid, (Shape){disc, NULL}, way, chain, count);
}

WgMoved wg_endpoint_body_move(WgGrid grid, const int64_t *headings, const WgFootprint *footprint, int64_t heading,
                              WgSegment way, WgCorner *chain, int64_t count)
{
    WgPolygon polygon;
    wg_polygon_turned(headings, footprint, heading, &polygon);
    return endpoint_move(grid, (Shape){{0, 0}, &polygon}, way, chain, count);
}

// Optimal reciprocal collision avoidance: chooses, among the velocities that stay clear of all
// others for a while if each robot does half, the one nearest to driving straight at the target.
//
// Each neighbour forbids a cone of relative velocities, truncated by the time for which clearance
// is required. The smallest change that leads out of it (or would lead into it) is shared: it
// defines a half-plane of allowed own velocities. The nearest velocity in all half-planes and
// within the top speed is found by trying all candidate points. If there is none, as in a dense
// crowd, all half-planes are relaxed by the smallest common amount.
//
// It does not see walls; the robot slides along them.
//
// Source: Jur van den Berg, Stephen J. Guy, Ming Lin and Dinesh Manocha, "Reciprocal n-body
// collision avoidance", in Robotics Research (2011), sections 4 and 5.

#include <stdbool.h>

#include "directions.h"
#include "library.h"

// bisections of the amount by which half-planes are relaxed, which make it exact to 1e-12
enum { HALVINGS = 40 };

static const double HORIZON = 2.0;    // s: time for which the robots must stay clear
// times the sum of the radii, so that rounding to the lattice causes no touch
static const double MARGIN = 1.05;
// m/s by which a velocity may miss a half-plane, to allow for rounding
static const double CLOSE = 1e-9;
// fraction of the top speed below which the robot stops and keeps its heading
static const double STANDING = 1e-3;

// Velocity or place, m/s or m, in the robot's frame: x ahead, y to the left.
typedef struct Vector {
    double x;
    double y;
} Vector;

// The velocities v with normal * v >= least.
typedef struct HalfPlane {
    Vector normal;
    double least;
} HalfPlane;

// The constraints on a velocity.
typedef struct Allowed {
    HalfPlane planes[WG_MOST_NEIGHBOURS];
    int64_t count;
    double top_speed;
    double slack;  // amount by which all half-planes are relaxed
} Allowed;

static double dot(Vector a, Vector b)
{
    return a.x * b.x + a.y * b.y;
}

static double length(Vector a)
{
    return sqrt(a.x * a.x + a.y * a.y);
}

static Vector scaled(Vector a, double by)
{
    return (Vector){a.x * by, a.y * by};
}

static Vector sum(Vector a, Vector b)
{
    return (Vector){a.x + b.x, a.y + b.y};
}

static Vector difference(Vector a, Vector b)
{
    return (Vector){a.x - b.x, a.y - b.y};
}

// Returns the half-plane that a neighbour leaves free.
//
// own:       the robot's velocity.
// relative:  that minus the neighbour's.
// place:     the neighbour's.
static HalfPlane plane_of(Vector own, Vector relative, Vector place, double radii, double time_step)
{
    double far = length(place);
    // robots that touch must separate within a step
    double horizon = far > radii ? HORIZON : time_step;
    Vector from_cap = difference(relative, scaled(place, 1.0 / horizon));
    double depth = length(from_cap);
    Vector normal = depth > 0.0 ? scaled(from_cap, 1.0 / depth) : (Vector){-1.0, 0.0};
    double out = radii / horizon - depth;
    if (far > radii) {
        // Beyond the points at which its sides touch the cap, the cone's side is nearest.
        double leg = sqrt(far * far - radii * radii);
        Vector ahead = scaled(place, 1.0 / far);
        bool is_left = ahead.x * relative.y - ahead.y * relative.x >= 0.0;
        double cosine = leg / far;
        double sine = is_left ? radii / far : -radii / far;
        Vector side = {ahead.x * cosine - ahead.y * sine, ahead.x * sine + ahead.y * cosine};
        if (dot(relative, side) >= leg / horizon) {
            normal = is_left ? (Vector){-side.y, side.x} : (Vector){side.y, -side.x};
            out = -dot(relative, normal);
        }
    }
    return (HalfPlane){normal, dot(normal, own) + 0.5 * out};
}

static bool is_allowed(const Allowed *allowed, Vector velocity)
{
    double most = allowed->top_speed + CLOSE;
    if (dot(velocity, velocity) > most * most) {
        return false;
    }
    for (int64_t k = 0; k < allowed->count; k++) {
        const HalfPlane *plane = &allowed->planes[k];
        if (dot(plane->normal, velocity) < plane->least - allowed->slack - CLOSE) {
            return false;
        }
    }
    return true;
}

// Keeps a velocity if it is allowed and nearer to the preferred one than the best so far.
static void consider(const Allowed *allowed, Vector velocity, Vector wanted, double *best_sq, Vector *best)
{
    Vector off = difference(velocity, wanted);
    double off_sq = dot(off, off);
    if (off_sq < *best_sq && is_allowed(allowed, velocity)) {
        *best_sq = off_sq;
        *best = velocity;
    }
}

// Tries the candidate points on the border of a half-plane: the projection of the preferred
// velocity, the points at top speed, and the intersections with earlier borders.
static void consider_border(const Allowed *allowed, int64_t which, Vector wanted, double *best_sq, Vector *best)
{
    const HalfPlane *plane = &allowed->planes[which];
    Vector normal = plane->normal;
    double least = plane->least - allowed->slack;
    consider(allowed, sum(wanted, scaled(normal, least - dot(normal, wanted))), wanted, best_sq, best);
    double across_sq = allowed->top_speed * allowed->top_speed - least * least;
    if (across_sq >= 0.0) {
        double across = sqrt(across_sq);
        Vector along = {-normal.y, normal.x};
        Vector foot = scaled(normal, least);
        consider(allowed, sum(foot, scaled(along, across)), wanted, best_sq, best);
        consider(allowed, sum(foot, scaled(along, -across)), wanted, best_sq, best);
    }
    for (int64_t k = 0; k < which; k++) {
        const HalfPlane *other = &allowed->planes[k];
        double determinant = normal.x * other->normal.y - normal.y * other->normal.x;
        if (determinant != 0.0) {
            double others = other->least - allowed->slack;
            Vector meeting = {(least * other->normal.y - others * normal.y) / determinant,
                              (normal.x * others - other->normal.x * least) / determinant};
            consider(allowed, meeting, wanted, best_sq, best);
        }
    }
}

// Finds the allowed velocity nearest to the preferred one; returns false if there is none.
static bool nearest_allowed(const Allowed *allowed, Vector wanted, Vector *best)
{
    double best_sq = INFINITY;
    consider(allowed, wanted, wanted, &best_sq, best);
    for (int64_t k = 0; k < allowed->count && best_sq > 0.0; k++) {
        consider_border(allowed, k, wanted, &best_sq, best);
    }
    return best_sq < INFINITY;
}

// Does the same, but relaxes the half-planes if necessary.
static Vector safest(Allowed *allowed, Vector wanted)
{
    Vector best = {0.0, 0.0};
    if (nearest_allowed(allowed, wanted, &best)) {
        return best;
    }
    // Standing still is allowed if all of them are relaxed by the amount that excludes it.
    double enough = 0.0;
    for (int64_t k = 0; k < allowed->count; k++) {
        enough = wg_higher(enough, allowed->planes[k].least);
    }
    double little = 0.0;
    for (int halving = 0; halving < HALVINGS; halving++) {
        Vector found = {0.0, 0.0};
        allowed->slack = 0.5 * (little + enough);
        if (nearest_allowed(allowed, wanted, &found)) {
            enough = allowed->slack;
            best = found;
        } else {
            little = allowed->slack;
        }
    }
    return best;
}

void wg_orca_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgOrcaMemory *kept = (WgOrcaMemory *)memory;
    Vector own = {kept->speed, 0.0};
    Allowed allowed;
    allowed.count = wg_least(seen->neighbour_count, WG_MOST_NEIGHBOURS);
    allowed.top_speed = seen->top_speed;
    allowed.slack = 0.0;
    for (int64_t k = 0; k < allowed.count; k++) {
        const WgNeighbour *other = &seen->neighbours[k];
        Vector theirs = {other->speed * wg_cos(other->heading), other->speed * wg_sin(other->heading)};
        Vector place = {other->x, other->y};
        double radii = MARGIN * (seen->radius + other->radius);
        allowed.planes[k] = plane_of(own, difference(own, theirs), place, radii, seen->time_step);
    }
    double bearing = wg_target_bearing(seen);
    Vector wanted = {seen->top_speed * wg_cos(bearing), seen->top_speed * wg_sin(bearing)};
    Vector velocity = safest(&allowed, wanted);
    double speed = length(velocity);
    kept->speed = speed > STANDING * seen->top_speed ? speed : 0.0;
    wg_steer(seen, command, kept->speed > 0.0 ? wg_angle_of(velocity.x, velocity.y) : 0.0, kept->speed);
}

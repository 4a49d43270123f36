// Finds runs of poses in which a body may meet a rectangle, and in which it must.

#include <math.h>
#include <stddef.h>

#include "runs.h"

// Rounding the cosines of a body of 257 cells moves a corner by less than 1.8e-4 lu.
#define SAFETY 1e-3
// Floats give the ends of runs with smaller errors, lu.
#define ROUNDING 1e-6

static double larger(double a, double b)
{
    return a > b ? a : b;
}

static double smaller(double a, double b)
{
    return a < b ? a : b;
}

WgDiscs wg_discs_of(const WgBody *body)
{
    double inner = INFINITY;
    for (int64_t k = 0; k < body->count; k++) {
        const int64_t *a = body->corners + 2 * k;
        const int64_t *b = body->corners + 2 * ((k + 1) % body->count);
        double across = (double)(a[0] * b[1] - a[1] * b[0]);
        inner = smaller(inner, across / hypot((double)(b[0] - a[0]), (double)(b[1] - a[1])));
    }
    return (WgDiscs){wg_body_reach(body) + SAFETY, larger(0.0, inner - SAFETY)};
}

// Returns true if no corner is farther back than one, along the line through that one and the axle.
static bool is_foremost(const WgBody *body, int64_t corner)
{
    int64_t x = body->corners[2 * corner];
    int64_t y = body->corners[2 * corner + 1];
    for (int64_t k = 0; k < body->count; k++) {
        if (body->corners[2 * k] * x + body->corners[2 * k + 1] * y < x * x + y * y) {
            return false;
        }
    }
    return true;
}

// Widens what a corner reaches. If the axle is outside, such a corner can be what reaches farthest when
// it is straight behind the axle.
static void reach_of_corner(WgSpan *span, const double begin[2], const double end[2], bool is_first)
{
    double far = hypot(begin[0], begin[1]);
    for (int toward = 0; toward < 4; toward++) {
        int axis = toward / 2;
        double sign = toward % 2 == 0 ? -1.0 : 1.0;
        // The rate at which it gets ahead while it turns.
        double rate = sign * (axis == 0 ? -begin[1] : begin[0]);
        double later = sign * (axis == 0 ? -end[1] : end[0]);
        double reached = larger(sign * begin[axis], sign * end[axis]);
        span->outer[toward] = larger(span->outer[toward], rate > 0.0 && later < 0.0 ? far : reached);
        if (is_first && rate < 0.0 && later > 0.0) {
            span->inner[toward] = smaller(span->inner[toward], -far);
        }
    }
}

// Returns true if a normal passes a direction between both ends of the range.
static bool passes(double normal[2][2], int toward)
{
    int axis = toward / 2;
    double sign = toward % 2 == 0 ? -1.0 : 1.0;
    // Turning to the left, the other coordinate rises through 0 at +x, and falls at +y.
    double turn = axis == 0 ? sign : -sign;
    double before = turn * normal[0][1 - axis];
    double after = turn * normal[1][1 - axis];
    return before <= 0.0 && after >= 0.0 && sign * (normal[0][axis] + normal[1][axis]) > 0.0;
}

void wg_span_make(const WgBody *body, int64_t heading, int64_t turn, WgSpan *span)
{
    const int64_t headings[2] = {heading, heading + turn};
    double places[2][WG_MOST_CORNERS][2];
    span->safety = turn == 0 ? 0.0 : SAFETY;
    span->shrink = turn == 0 ? 1.0 : cos((double)turn * WG_RADIANS / 2.0);
    for (int toward = 0; toward < 4; toward++) {
        span->outer[toward] = -INFINITY;
        span->inner[toward] = INFINITY;
    }
    // Corners at both ends, and the most that they reach between them.
    for (int64_t k = 0; k < body->count; k++) {
        double cx = (double)body->corners[2 * k];
        double cy = (double)body->corners[2 * k + 1];
        for (int end = 0; end < 2; end++) {
            double c = (double)wg_cosine(body, headings[end]) / WG_ONE;
            double s = (double)wg_sine(body, headings[end]) / WG_ONE;
            places[end][k][0] = cx * c - cy * s;
            places[end][k][1] = cx * s + cy * c;
        }
        reach_of_corner(span, places[0][k], places[1][k], is_foremost(body, k));
    }
    // What the body reaches at every heading is least at an end, or where a side faces that way.
    for (int end = 0; end < 2; end++) {
        for (int toward = 0; toward < 4; toward++) {
            double most = -INFINITY;
            for (int64_t k = 0; k < body->count; k++) {
                double place = places[end][k][toward / 2];
                most = larger(most, toward % 2 == 0 ? -place : place);
            }
            span->inner[toward] = smaller(span->inner[toward], most);
        }
    }
    for (int64_t k = 0; k < body->count; k++) {
        int64_t after = k + 1 < body->count ? k + 1 : 0;
        double distance = 0.0;
        for (int end = 0; end < 2; end++) {
            double ex = places[end][after][0] - places[end][k][0];
            double ey = places[end][after][1] - places[end][k][1];
            // Exact ranges keep whole numbers.
            double length = turn == 0 ? 1.0 : hypot(ex, ey);
            span->sides[k].normal[end][0] = ey / length;
            span->sides[k].normal[end][1] = -ex / length;
            distance = (ey * places[end][k][0] - ex * places[end][k][1]) / length;
        }
        // Between two ends the normal's product with a point is least at an end, unless it is negative;
        // and it is most at an end, but for the share that the shorter of both loses in between.
        double both = 2.0 * span->shrink * span->shrink - 1.0;
        span->sides[k].outer = (distance < 0.0 ? distance * both : distance) + span->safety;
        span->sides[k].inner = (distance > 0.0 ? distance * span->shrink : distance) - span->safety;
        for (int toward = 0; toward < 4; toward++) {
            if (turn > 0 && passes(span->sides[k].normal, toward)) {
                span->inner[toward] = smaller(span->inner[toward], distance);
            }
        }
    }
    for (int toward = 0; toward < 4; toward++) {
        span->outer[toward] += span->safety;
        span->inner[toward] -= span->safety;
    }
}

// An interval of places; open or closed does not matter until it is rounded.
typedef struct Interval {
    double begin;
    double end;
} Interval;

// Places p with factor * p <= bound.
static Interval at_most(double factor, double bound)
{
    if (factor > 0.0) {
        return (Interval){-INFINITY, bound / factor};
    }
    if (factor < 0.0) {
        return (Interval){bound / factor, INFINITY};
    }
    return bound >= 0.0 ? (Interval){-INFINITY, INFINITY} : (Interval){INFINITY, -INFINITY};
}

// Places p with factor * p > bound.
static Interval above(double factor, double bound)
{
    if (factor == 0.0) {
        return bound < 0.0 ? (Interval){-INFINITY, INFINITY} : (Interval){INFINITY, -INFINITY};
    }
    return at_most(-factor, -bound);
}

static Interval both_of(Interval a, Interval b)
{
    return (Interval){larger(a.begin, b.begin), smaller(a.end, b.end)};
}

// The rectangle and the box relative to the box's low corner, by axis along the run and across it.
typedef struct Local {
    double low[2];
    double high[2];
    double side;  // of the box, across
    double most;  // and along
    int axis;
} Local;

// Cuts off the places at which one of the body's sides separates it from the rectangle for the whole box.
static Interval without_apart(const WgSpan *span, int64_t k, const Local *local, Interval may)
{
    Interval apart = {-INFINITY, INFINITY};
    for (int end = 0; end < 2; end++) {
        double along = span->sides[k].normal[end][local->axis];
        double across = span->sides[k].normal[end][1 - local->axis];
        double nearest = along * (along > 0.0 ? local->low[0] : local->high[0])
                         + across * (across > 0.0 ? local->low[1] - local->side : local->high[1]);
        apart = both_of(apart, at_most(along, nearest - span->sides[k].outer));
    }
    if (apart.begin <= may.begin) {
        may.begin = larger(may.begin, apart.end);
    } else if (apart.end >= may.end) {
        may.end = smaller(may.end, apart.begin);
    }
    return may;
}

// Places at which the body's side has a point of the rectangle on its inner side throughout the box: a
// point that stays ``at`` along, or moves with the body there; and that stays ``across`` or moves with it.
static Interval within_side(const WgSpan *span, int64_t k, const Local *local, const double point[2],
                            bool moves_across)
{
    Interval within = {-INFINITY, INFINITY};
    for (int end = 0; end < 2; end++) {
        double along = span->sides[k].normal[end][local->axis];
        double across = span->sides[k].normal[end][1 - local->axis];
        double farthest = across < 0.0 && !moves_across ? point[1] - local->side : point[1];
        within = both_of(within, above(along, along * point[0] + across * farthest - span->sides[k].inner));
    }
    return within;
}

// The longer of two runs, or their union if they meet.
static Interval longer(Interval a, Interval b)
{
    if (!(a.begin < a.end)) {
        return b;
    }
    if (!(b.begin < b.end)) {
        return a;
    }
    if (a.begin < b.end && b.begin < a.end) {
        return (Interval){smaller(a.begin, b.begin), larger(a.end, b.end)};
    }
    return a.end - a.begin >= b.end - b.begin ? a : b;
}

// Narrows a run to the places at which one side of the body does not separate it from the rectangle.
static Interval with_inside(const WgSpan *span, int64_t k, const Local *local, Interval must)
{
    double point[2][2];
    bool same[2];
    for (int which = 0; which < 2; which++) {
        int axis = which == 0 ? local->axis : 1 - local->axis;
        bool first = span->sides[k].normal[0][axis] > 0.0;
        bool last = span->sides[k].normal[1][axis] > 0.0;
        point[0][which] = first ? local->low[which] : local->high[which];
        point[1][which] = last ? local->low[which] : local->high[which];
        same[which] = first == last;
    }
    Interval inside = both_of(within_side(span, k, local, point[0], false), must);
    if (same[0] && same[1]) {
        return inside;
    }
    // The side becomes parallel to one of the rectangle's within the range: a point of that one that
    // moves with the body is better than a corner, and joins the runs of both corners.
    if (!same[1]) {
        double shift = larger(smaller(0.0, local->high[1] - local->side), local->low[1]);
        if (local->low[1] <= shift && shift + local->side <= local->high[1]) {
            const double moving[2] = {point[0][0], shift};
            inside = longer(inside, both_of(within_side(span, k, local, moving, true), must));
        }
    } else {
        // Along the run it moves with the body from one corner to the other.
        bool is_inside = true;
        for (int end = 0; end < 2; end++) {
            double across = span->sides[k].normal[end][1 - local->axis];
            double farthest = across < 0.0 ? point[0][1] - local->side : point[0][1];
            is_inside = is_inside && across * farthest < span->sides[k].inner;
        }
        if (is_inside) {
            const Interval between = {local->low[0], local->high[0]};
            inside = longer(inside, both_of(between, must));
        }
    }
    return longer(inside, both_of(within_side(span, k, local, point[1], false), must));
}

// Rounds both runs to whole lu, each to its safe side.
static WgRun rounded(Interval may, Interval must, const Local *local, int64_t origin, double safety)
{
    WgRun run = {1, 0, 1, 0};
    double margin = safety > 0.0 ? ROUNDING : 0.0;
    if (may.begin < may.end && may.begin < local->most && may.end > 0.0) {
        run.may_begin = origin + (int64_t)floor(larger(may.begin, -1.0) - margin);
        run.may_end = origin + (int64_t)ceil(smaller(may.end, local->most + 1.0) + margin);
    }
    if (must.begin < must.end && must.begin < local->most && must.end > 0.0) {
        run.must_begin = origin + (int64_t)floor(larger(must.begin, -1.0) + margin) + 1;
        run.must_end = origin + (int64_t)ceil(smaller(must.end, local->most + 1.0) - margin) - 1;
    }
    return run;
}

// The same for all headings, by the discs.
static WgRun run_of_discs(const WgDiscs *discs, const Local *local, int64_t origin)
{
    Interval may = {1.0, 0.0};
    Interval must = {1.0, 0.0};
    double near = larger(0.0, larger(local->low[1] - local->side, -local->high[1]));
    double far = larger(0.0, larger(local->low[1], local->side - local->high[1]));
    if (near < discs->outer) {
        double half = sqrt(discs->outer * discs->outer - near * near);
        may = (Interval){local->low[0] - half, local->high[0] + half};
    }
    if (far < discs->inner) {
        double half = sqrt(discs->inner * discs->inner - far * far);
        must = (Interval){local->low[0] - half, local->high[0] + half};
    }
    return rounded(may, must, local, origin, SAFETY);
}

WgRun wg_run_along(const WgBody *body, const WgSpan *span, const WgDiscs *discs, const WgRange *range,
                   const WgSolid *solid, int axis)
{
    int64_t origin = range->low[axis];
    Local local = {.axis = axis};
    for (int which = 0; which < 2; which++) {
        int at = which == 0 ? axis : 1 - axis;
        local.low[which] = (double)(solid->low[at] - range->low[at]);
        local.high[which] = (double)(solid->high[at] - range->low[at]);
    }
    local.most = (double)(range->high[axis] - range->low[axis]);
    local.side = (double)(range->high[1 - axis] - range->low[1 - axis]);
    if (span == NULL) {
        return run_of_discs(discs, &local, origin);
    }
    // The rectangle's sides.
    const double *outer = span->outer + 2 * axis;
    const double *inner = span->inner + 2 * axis;
    const double *outer_across = span->outer + 2 * (1 - axis);
    const double *inner_across = span->inner + 2 * (1 - axis);
    Interval may = {local.low[0] - outer[1], local.high[0] + outer[0]};
    Interval must = {local.low[0] - inner[1], local.high[0] + inner[0]};
    if (local.side + outer_across[1] <= local.low[1] || -outer_across[0] >= local.high[1]) {
        return (WgRun){1, 0, 1, 0};
    }
    if (!(inner_across[1] > local.low[1] && local.side - inner_across[0] < local.high[1])) {
        must = (Interval){1.0, 0.0};
    }
    // The body's sides.
    for (int64_t k = 0; k < body->count && may.begin < may.end; k++) {
        may = without_apart(span, k, &local, may);
        if (must.begin < must.end) {
            must = with_inside(span, k, &local, must);
        }
    }
    // What may not meet the rectangle anywhere need not have been narrowed to the end.
    if (!(may.begin < may.end)) {
        return (WgRun){1, 0, 1, 0};
    }
    return rounded(may, must, &local, origin, span->safety);
}

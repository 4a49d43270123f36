// Shortest paths of a car between two poses in the open.
//
// Sources: L. E. Dubins, "On curves of minimal length with a constraint on average curvature",
// American Journal of Mathematics 79 (1957), in the form of A. M. Shkel and V. Lumelsky,
// "Classification of the Dubins set", Robotics and Autonomous Systems 34 (2001); J. A. Reeds and
// L. A. Shepp, "Optimal paths for a car that goes both forwards and backwards", Pacific Journal of
// Mathematics 145 (1990), whose numbers of formulas are given below.

#include <stdbool.h>
#include <stddef.h>

#include "angles.h"
#include "wg_car.h"

enum { LEFT = 1, STRAIGHT = 0, RIGHT = -1 };

// Rounding errors below this are no reason to drop a curve.
static const double TINY = 1e-9;
// Circles as near as this are one, and an arc that lacks as little of a whole turn is none: roots
// of rounding errors are larger than these.
static const double SAME = 1e-7;

// The goal, seen from the start, in turning radii.
typedef struct Goal {
    double x;
    double y;
    double heading;
} Goal;

// The three free lengths of a word.
typedef struct Lengths {
    double t;
    double u;
    double v;
} Lengths;

typedef struct Polar {
    double radius;
    double angle;
} Polar;

static Polar polar(double x, double y)
{
    return (Polar){sqrt(x * x + y * y), wg_car_atan2(y, x)};
}

// Appends a curve, with arcs and lines of no length left out, in order of length.
static void insert(WgCurve *found, int64_t *count, WgCurve curve)
{
    WgCurve kept = {0};
    for (int64_t part = 0; part < curve.count; part++) {
        if (fabs(curve.amount[part]) > TINY) {
            kept.steer[kept.count] = curve.steer[part];
            kept.amount[kept.count] = curve.amount[part];
            kept.length += fabs(curve.amount[part]);
            kept.count++;
        }
    }
    int64_t at = (*count)++;
    while (at > 0 && found[at - 1].length > kept.length + TINY) {
        found[at] = found[at - 1];
        at--;
    }
    found[at] = kept;
}

// The angle in [0, 2 pi), and 0 for what rounding put just below 2 pi.
static double forward(double angle)
{
    double turn = 2.0 * WG_CAR_PI;
    double wrapped = angle - turn * floor(angle / turn);
    return wrapped > turn - SAME ? 0.0 : wrapped;
}

static void insert_dubins(WgCurve *found, int64_t *count, const int64_t steer[3], Lengths lengths)
{
    WgCurve curve = {3, {steer[0], steer[1], steer[2]}, {lengths.t, lengths.u, lengths.v}, 0.0};
    insert(found, count, curve);
}

int64_t wg_dubins(double x, double y, double heading, WgCurve *found)
{
    Polar goal = polar(x, y);
    double d = goal.radius;
    double alpha = -goal.angle;
    double beta = heading - goal.angle;
    WgAngle a = wg_car_angle(alpha);
    WgAngle b = wg_car_angle(beta);
    double cosine = wg_car_angle(heading).cosine;
    int64_t count = 0;

    // Two arcs of the same side, joined by a line.
    double square = 2.0 + d * d - 2.0 * cosine + 2.0 * d * (a.sine - b.sine);
    if (square > -TINY) {
        double u = sqrt(fmax(0.0, square));
        double turn = u > SAME ? wg_car_atan2(b.cosine - a.cosine, d + a.sine - b.sine) : beta;
        Lengths lengths = {forward(turn - alpha), u, forward(beta - turn)};
        insert_dubins(found, &count, (const int64_t[]){LEFT, STRAIGHT, LEFT}, lengths);
    }
    square = 2.0 + d * d - 2.0 * cosine + 2.0 * d * (b.sine - a.sine);
    if (square > -TINY) {
        double u = sqrt(fmax(0.0, square));
        double turn = u > SAME ? wg_car_atan2(a.cosine - b.cosine, d - a.sine + b.sine) : beta;
        Lengths lengths = {forward(alpha - turn), u, forward(turn - beta)};
        insert_dubins(found, &count, (const int64_t[]){RIGHT, STRAIGHT, RIGHT}, lengths);
    }

    // Arcs of different sides, joined by a line.
    square = d * d - 2.0 + 2.0 * cosine + 2.0 * d * (a.sine + b.sine);
    if (square > -TINY) {
        double u = sqrt(fmax(0.0, square));
        double turn = wg_car_atan2(-a.cosine - b.cosine, d + a.sine + b.sine) - wg_car_atan2(-2.0, u);
        Lengths lengths = {forward(turn - alpha), u, forward(turn - beta)};
        insert_dubins(found, &count, (const int64_t[]){LEFT, STRAIGHT, RIGHT}, lengths);
    }
    square = d * d - 2.0 + 2.0 * cosine - 2.0 * d * (a.sine + b.sine);
    if (square > -TINY) {
        double u = sqrt(fmax(0.0, square));
        double turn = wg_car_atan2(a.cosine + b.cosine, d - a.sine - b.sine) - wg_car_atan2(2.0, u);
        Lengths lengths = {forward(alpha - turn), u, forward(beta - turn)};
        insert_dubins(found, &count, (const int64_t[]){RIGHT, STRAIGHT, LEFT}, lengths);
    }

    // Three arcs; the one in the middle is longer than half a circle.
    double middle = (6.0 - d * d + 2.0 * cosine + 2.0 * d * (a.sine - b.sine)) / 8.0;
    if (fabs(middle) <= 1.0) {
        double u = forward(2.0 * WG_CAR_PI - wg_car_acos(middle));
        double t = forward(alpha - wg_car_atan2(a.cosine - b.cosine, d - a.sine + b.sine) + 0.5 * u);
        Lengths lengths = {t, u, forward(alpha - beta - t + u)};
        insert_dubins(found, &count, (const int64_t[]){RIGHT, LEFT, RIGHT}, lengths);
    }
    middle = (6.0 - d * d + 2.0 * cosine + 2.0 * d * (b.sine - a.sine)) / 8.0;
    if (fabs(middle) <= 1.0) {
        double u = forward(2.0 * WG_CAR_PI - wg_car_acos(middle));
        double t = forward(wg_car_atan2(b.cosine - a.cosine, d + a.sine - b.sine) - alpha + 0.5 * u);
        Lengths lengths = {t, u, forward(beta - alpha - t + u)};
        insert_dubins(found, &count, (const int64_t[]){LEFT, RIGHT, LEFT}, lengths);
    }
    return count;
}

// L+ S+ L+ (8.1)
static bool left_straight_left(Goal goal, Lengths *lengths)
{
    WgAngle end = wg_car_angle(goal.heading);
    Polar line = polar(goal.x - end.sine, goal.y - 1.0 + end.cosine);
    double t = line.radius > SAME ? line.angle : goal.heading;
    *lengths = (Lengths){t, line.radius, wg_car_wrap(goal.heading - t)};
    return lengths->t >= -TINY && lengths->v >= -TINY;
}

// L+ S+ R+ (8.2)
static bool left_straight_right(Goal goal, Lengths *lengths)
{
    WgAngle end = wg_car_angle(goal.heading);
    Polar centres = polar(goal.x + end.sine, goal.y - 1.0 - end.cosine);
    double square = centres.radius * centres.radius - 4.0;
    if (square < 0.0) {
        return false;
    }
    double u = sqrt(square);
    double t = wg_car_wrap(centres.angle + wg_car_atan2(2.0, u));
    *lengths = (Lengths){t, u, wg_car_wrap(t - goal.heading)};
    return t >= -TINY && lengths->v >= -TINY;
}

// L+ R- L (8.3, 8.4)
static bool left_right_left(Goal goal, Lengths *lengths)
{
    WgAngle end = wg_car_angle(goal.heading);
    Polar centres = polar(goal.x - end.sine, goal.y - 1.0 + end.cosine);
    if (centres.radius > 4.0) {
        return false;
    }
    double u = -2.0 * wg_car_asin(0.25 * centres.radius);
    double t = wg_car_wrap(centres.angle + 0.5 * u + WG_CAR_PI);
    *lengths = (Lengths){t, u, wg_car_wrap(goal.heading - t + u)};
    return t >= -TINY && u <= TINY;
}

// The first and the last arc of four, the two in the middle being known.
static void outer_arcs(double u, double v, Goal centres, Lengths *lengths)
{
    double delta = wg_car_wrap(u - v);
    WgAngle first = wg_car_angle(u);
    WgAngle second = wg_car_angle(v);
    WgAngle both = wg_car_angle(delta);
    double across = first.sine - both.sine;
    double along = first.cosine - both.cosine - 1.0;
    double t = wg_car_atan2(centres.y * across - centres.x * along, centres.x * across + centres.y * along);
    double side = 2.0 * (both.cosine - second.cosine - first.cosine) + 3.0;
    lengths->t = wg_car_wrap(side < 0.0 ? t + WG_CAR_PI : t);
    lengths->v = wg_car_wrap(lengths->t - u + v - centres.heading);
}

static Goal outer_centres(Goal goal)
{
    WgAngle end = wg_car_angle(goal.heading);
    return (Goal){goal.x + end.sine, goal.y - 1.0 - end.cosine, goal.heading};
}

// L+ R+u L-u R- (8.7)
static bool four_with_a_cusp(Goal goal, Lengths *lengths)
{
    Goal centres = outer_centres(goal);
    double rho = 0.25 * (2.0 + polar(centres.x, centres.y).radius);
    if (rho > 1.0) {
        return false;
    }
    lengths->u = wg_car_acos(rho);
    outer_arcs(lengths->u, -lengths->u, centres, lengths);
    return lengths->t >= -TINY && lengths->v <= TINY;
}

// L+ R-u L-u R+ (8.8)
static bool four_with_two_cusps(Goal goal, Lengths *lengths)
{
    Goal centres = outer_centres(goal);
    double rho = (20.0 - centres.x * centres.x - centres.y * centres.y) / 16.0;
    if (rho < 0.0 || rho > 1.0) {
        return false;
    }
    lengths->u = -wg_car_acos(rho);
    outer_arcs(lengths->u, lengths->u, centres, lengths);
    return lengths->u >= -0.5 * WG_CAR_PI && lengths->t >= -TINY && lengths->v >= -TINY;
}

// L+ R-(pi/2) S- L- (8.9)
static bool quarter_then_left(Goal goal, Lengths *lengths)
{
    WgAngle end = wg_car_angle(goal.heading);
    Polar centres = polar(goal.x - end.sine, goal.y - 1.0 + end.cosine);
    if (centres.radius < 2.0) {
        return false;
    }
    double r = sqrt(centres.radius * centres.radius - 4.0);
    double t = wg_car_wrap(centres.angle + wg_car_atan2(r, -2.0));
    *lengths = (Lengths){t, 2.0 - r, wg_car_wrap(goal.heading - 0.5 * WG_CAR_PI - t)};
    return t >= -TINY && lengths->u <= TINY && lengths->v <= TINY;
}

// L+ R-(pi/2) S- R- (8.10)
static bool quarter_then_right(Goal goal, Lengths *lengths)
{
    Goal centres = outer_centres(goal);
    Polar line = polar(-centres.y, centres.x);
    if (line.radius < 2.0) {
        return false;
    }
    *lengths = (Lengths){line.angle, 2.0 - line.radius,
                         wg_car_wrap(line.angle + 0.5 * WG_CAR_PI - goal.heading)};
    return lengths->t >= -TINY && lengths->u <= TINY && lengths->v <= TINY;
}

// L+ R-(pi/2) S- L-(pi/2) R+ (8.11)
static bool two_quarters(Goal goal, Lengths *lengths)
{
    Goal centres = outer_centres(goal);
    Polar line = polar(centres.x, centres.y);
    if (line.radius < 2.0) {
        return false;
    }
    double u = 4.0 - sqrt(line.radius * line.radius - 4.0);
    double t = wg_car_wrap(wg_car_atan2((4.0 - u) * centres.x - 2.0 * centres.y,
                                        -2.0 * centres.x + (u - 4.0) * centres.y));
    *lengths = (Lengths){t, u, wg_car_wrap(t - goal.heading)};
    return u <= TINY && t >= -TINY && lengths->v >= -TINY;
}

// Which of a word's lengths a part has: t, u, v, less u, or a quarter of a circle backwards.
typedef enum Amount { AMOUNT_T, AMOUNT_U, AMOUNT_V, AMOUNT_LESS_U, AMOUNT_QUARTER } Amount;

// A word: its formula, its parts, and whether it is another word if driven from the end.
typedef struct Word {
    bool (*solve)(Goal goal, Lengths *lengths);
    int64_t count;
    int64_t steer[5];
    Amount amount[5];
    bool has_reverse;
} Word;

static const Word WORDS[] = {
    {left_straight_left, 3, {LEFT, STRAIGHT, LEFT}, {AMOUNT_T, AMOUNT_U, AMOUNT_V}, false},
    {left_straight_right, 3, {LEFT, STRAIGHT, RIGHT}, {AMOUNT_T, AMOUNT_U, AMOUNT_V}, false},
    {left_right_left, 3, {LEFT, RIGHT, LEFT}, {AMOUNT_T, AMOUNT_U, AMOUNT_V}, true},
    {four_with_a_cusp, 4, {LEFT, RIGHT, LEFT, RIGHT}, {AMOUNT_T, AMOUNT_U, AMOUNT_LESS_U, AMOUNT_V}, false},
    {four_with_two_cusps, 4, {LEFT, RIGHT, LEFT, RIGHT}, {AMOUNT_T, AMOUNT_U, AMOUNT_U, AMOUNT_V}, false},
    {quarter_then_left, 4, {LEFT, RIGHT, STRAIGHT, LEFT}, {AMOUNT_T, AMOUNT_QUARTER, AMOUNT_U, AMOUNT_V}, true},
    {quarter_then_right, 4, {LEFT, RIGHT, STRAIGHT, RIGHT}, {AMOUNT_T, AMOUNT_QUARTER, AMOUNT_U, AMOUNT_V}, true},
    {two_quarters, 5, {LEFT, RIGHT, STRAIGHT, LEFT, RIGHT},
     {AMOUNT_T, AMOUNT_QUARTER, AMOUNT_U, AMOUNT_QUARTER, AMOUNT_V}, false},
};

static double amount_of(Lengths lengths, Amount which)
{
    const double amounts[] = {lengths.t, lengths.u, lengths.v, -lengths.u, -0.5 * WG_CAR_PI};
    return amounts[which];
}

int64_t wg_reeds_shepp(double x, double y, double heading, WgCurve *found)
{
    int64_t count = 0;
    double turn = wg_car_wrap(heading);
    WgAngle end = wg_car_angle(turn);
    // The goal of the same word driven from its end.
    Goal from_end = {x * end.cosine + y * end.sine, x * end.sine - y * end.cosine, turn};
    for (size_t w = 0; w < sizeof WORDS / sizeof WORDS[0]; w++) {
        const Word *word = &WORDS[w];
        // Every word also exists with forwards and backwards exchanged, and left and right.
        for (int which = 0; which < (word->has_reverse ? 8 : 4); which++) {
            double gear = (which & 1) != 0 ? -1.0 : 1.0;
            double side = (which & 2) != 0 ? -1.0 : 1.0;
            bool reversed = (which & 4) != 0;
            Goal goal = reversed ? from_end : (Goal){x, y, turn};
            goal = (Goal){gear * goal.x, side * goal.y, gear * side * goal.heading};
            Lengths lengths;
            if (!word->solve(goal, &lengths)) {
                continue;
            }
            WgCurve curve = {word->count, {0}, {0}, 0.0};
            for (int64_t part = 0; part < word->count; part++) {
                int64_t from = reversed ? word->count - 1 - part : part;
                curve.steer[part] = (int64_t)side * word->steer[from];
                curve.amount[part] = gear * amount_of(lengths, word->amount[from]);
            }
            insert(found, &count, curve);
        }
    }
    return count;
}

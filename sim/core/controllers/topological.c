// A topological map: places where the robot made decisions, joined by the paths that it drove. It
// explores from place to place, the most promising exit first, and drives back along its map when a
// place has no exits left.
//
// Sources: Benjamin Kuipers and Yung-Tai Byun, "A robot exploration and mapping strategy based on a
// semantic hierarchy of spatial representations", Robotics and Autonomous Systems 8 (1991), for
// places that the sensors single out, joined by paths that the robot can repeat; Brian Yamauchi, "A
// frontier-based approach for autonomous exploration", IEEE International Symposium on
// Computational Intelligence in Robotics and Automation (1997), for exits into what is unexplored.
// The shortest way is Dijkstra's. Departures: places have coordinates,
// because the robot knows where it is.

#include <stdbool.h>

#include "directions.h"
#include "library.h"

enum {
    DIRECTIONS = 16,          // in the world's frame
    TO_TARGET = DIRECTIONS,   // the exit straight to the target
    EXITS = DIRECTIONS + 1,
    LINKS = 5,                // neighbours of a place
    LINK_BITS = 10,           // bits of each link
    MOST_PLACES = 1000,
    LEVELS = 3,
};

static const double START = 0.0;
static const double EXPLORE = 1.0;
static const double TRAVEL = 2.0;

static const double STRIDE = 3.5;  // radii of the robot that must be free for an exit to be open
// fractions of a stride, by how fine the map is
static const double SCALE[LEVELS] = {1.0, 0.6, 0.35};
static const double REACH = 4.0;   // strides from one place to the next, at most
// fraction of a stride: points nearer than this to a driven path count as explored
static const double NEAR = 0.6;
// strides within which two places are joined if nothing is between them
static const double SEES = 1.5;
// radii: half the width that must be free; below 1 to slide along walls
static const double CLOSE = 0.95;
// radii: no new place is made within this distance of the place that it left
static const double APART = 0.25;
static const double THERE = 0.02;  // radii: within this distance the robot is at a place
static const double STANDS = 0.1;  // radii: also within this distance, if it gets no nearer
static const double ALONG = 0.9;   // minimum progress, in steps, if a wall deflected the step
// an exit opens at the side if the cosine from the direction of driving is at most this
static const double ACROSS = 0.5;

// The shortest paths from a place.
typedef struct Ways {
    double length[MOST_PLACES];  // m; INFINITY: there is none
    int64_t first[MOST_PLACES];  // the place after the first one
} Ways;

// An exit of a place.
typedef struct Choice {
    int64_t place;  // -1: there is none
    int64_t exit;
} Choice;

static double stride_of(const WgObservation *seen, const WgTopologicalMemory *own)
{
    return STRIDE * SCALE[(int64_t)own->level] * seen->radius;
}

static double target_x(const WgObservation *seen)
{
    return seen->x + seen->target_distance * wg_cos(seen->target_heading);
}

static double target_y(const WgObservation *seen)
{
    return seen->y + seen->target_distance * wg_sin(seen->target_heading);
}

static bool has_bit(double bits, int64_t place)
{
    return (((int64_t)bits >> place) & 1) != 0;
}

static double without_bit(double bits, int64_t place)
{
    return (double)((int64_t)bits & ~((int64_t)1 << place));
}

// ---- The graph

static int64_t link_of(const WgMapPlace *place, int64_t slot)
{
    return (((int64_t)place->links >> (LINK_BITS * slot)) & ((1 << LINK_BITS) - 1)) - 1;
}

static void set_link(WgMapPlace *place, int64_t slot, int64_t to)
{
    int64_t mask = (int64_t)((1 << LINK_BITS) - 1) << (LINK_BITS * slot);
    place->links = (double)(((int64_t)place->links & ~mask) | ((to + 1) << (LINK_BITS * slot)));
}

// Returns the slot of the link from a place to another; -1 if there is none.
static int64_t slot_of(const WgMapPlace *place, int64_t to)
{
    for (int64_t slot = 0; slot < LINKS; slot++) {
        if (link_of(place, slot) == to) {
            return slot;
        }
    }
    return -1;
}

// Removes the links between two places, which may exist in one direction only.
static void part(WgTopologicalMemory *own, int64_t one, int64_t other)
{
    int64_t slot = slot_of(&own->places[one], other);
    if (slot >= 0) {
        set_link(&own->places[one], slot, -1);
    }
    slot = slot_of(&own->places[other], one);
    if (slot >= 0) {
        set_link(&own->places[other], slot, -1);
    }
}

// Joins two places if both have room for it; returns whether they are joined.
static bool join(WgTopologicalMemory *own, int64_t one, int64_t other)
{
    if (slot_of(&own->places[one], other) >= 0) {
        return true;
    }
    int64_t here = slot_of(&own->places[one], -1);
    int64_t there = slot_of(&own->places[other], -1);
    if (here < 0 || there < 0) {
        return false;
    }
    set_link(&own->places[one], here, other);
    set_link(&own->places[other], there, one);
    return true;
}

// Returns whether a point is near a place or a path of the map.
static bool is_explored(const WgTopologicalMemory *own, double x, double y, double near)
{
    for (int64_t k = 0; k < (int64_t)own->count; k++) {
        const WgMapPlace *place = &own->places[k];
        if (wg_distance(x, y, place->x, place->y) < near) {
            return true;
        }
        for (int64_t slot = 0; slot < LINKS; slot++) {
            int64_t to = link_of(place, slot);
            if (to > k &&
                wg_distance_to_path(x, y, place->x, place->y, own->places[to].x, own->places[to].y) < near) {
                return true;
            }
        }
    }
    return false;
}

// Finds the shortest paths from the robot's place along the map.
static void find_ways(const WgTopologicalMemory *own, Ways *ways)
{
    bool done[MOST_PLACES] = {false};
    int64_t count = (int64_t)own->count;
    for (int64_t k = 0; k < count; k++) {
        ways->length[k] = INFINITY;
        ways->first[k] = -1;
    }
    ways->length[(int64_t)own->here] = 0.0;
    for (int64_t round = 0; round < count; round++) {
        // The nearest place that is not done.
        int64_t at = -1;
        for (int64_t k = 0; k < count; k++) {
            if (!done[k] && ways->length[k] < INFINITY && (at < 0 || ways->length[k] < ways->length[at])) {
                at = k;
            }
        }
        if (at < 0) {
            return;
        }
        done[at] = true;
        for (int64_t slot = 0; slot < LINKS; slot++) {
            int64_t to = link_of(&own->places[at], slot);
            if (to < 0) {
                continue;
            }
            double length = ways->length[at] +
                            wg_distance(own->places[at].x, own->places[at].y, own->places[to].x, own->places[to].y);
            if (length < ways->length[to]) {
                ways->length[to] = length;
                ways->first[to] = at == (int64_t)own->here ? to : ways->first[at];
            }
        }
    }
}

// ---- What is open

// Returns whether the disc can drive straight on so far, m,
// in a world direction given by its cosine and sine.
static bool is_free(const WgPoints *points, double cosine, double sine, double radius, double far)
{
    for (int64_t k = 0; k < points->count; k++) {
        double along = points->x[k] * cosine + points->y[k] * sine;
        double across = points->y[k] * cosine - points->x[k] * sine;
        double short_by = radius * radius - across * across;
        if (along > 0.0 && short_by > 0.0 && along - sqrt(short_by) < far) {
            return false;
        }
    }
    return true;
}

static double direction_of(const WgObservation *seen, int64_t exit)
{
    return exit == TO_TARGET ? seen->target_heading : WG_WHOLE_TURN * (double)exit / (double)DIRECTIONS;
}

// How far an exit looks, m: not beyond the target.
static double look_of(const WgObservation *seen, int64_t exit, double stride)
{
    return exit == TO_TARGET ? wg_lower(stride, seen->target_distance) : stride;
}

// Bits of the exits that are free for a whole stride.
static double open_exits(const WgObservation *seen, const WgPoints *points, double stride)
{
    int64_t bits = 0;
    for (int64_t exit = 0; exit < EXITS; exit++) {
        double direction = direction_of(seen, exit);
        double far = look_of(seen, exit, stride);
        if (exit == TO_TARGET && far < APART * seen->radius) {
            continue;  // it is there; if the run continues, so does the exploration
        }
        if (is_free(points, wg_cos(direction), wg_sin(direction), CLOSE * seen->radius, far)) {
            bits |= (int64_t)1 << exit;
        }
    }
    return (double)bits;
}

// Returns true if an exit leads somewhere new: away from the map, and from the path driven since
// the last place. The target itself is always new.
static bool is_new(const WgObservation *seen, const WgTopologicalMemory *own, int64_t exit, double stride)
{
    double far = look_of(seen, exit, stride);
    if (far < stride) {
        return true;
    }
    double x = seen->x + far * wg_cos(direction_of(seen, exit));
    double y = seen->y + far * wg_sin(direction_of(seen, exit));
    const WgMapPlace *here = &own->places[(int64_t)own->here];
    if (own->count > 0.0 && wg_distance_to_path(x, y, here->x, here->y, seen->x, seen->y) < NEAR * stride) {
        return false;
    }
    return !is_explored(own, x, y, NEAR * stride);
}

// Bits of the exits among some that are new.
static double new_exits(const WgObservation *seen, const WgTopologicalMemory *own, double open, double stride)
{
    for (int64_t exit = 0; exit < EXITS; exit++) {
        if (has_bit(open, exit) && !is_new(seen, own, exit, stride)) {
            open = without_bit(open, exit);
        }
    }
    return open;
}

// Returns whether an exit has opened at the robot's side since the step before, or the path to the
// target has, and whether it leads somewhere new.
static bool has_opened(const WgObservation *seen, const WgTopologicalMemory *own, double open, double stride)
{
    double opened = (double)((int64_t)open & ~(int64_t)own->open);
    for (int64_t exit = 0; exit < EXITS; exit++) {
        bool beside = exit == TO_TARGET || fabs(wg_cos(direction_of(seen, exit) - own->heading)) <= ACROSS;
        if (beside && has_bit(opened, exit) && is_new(seen, own, exit, stride)) {
            return true;
        }
    }
    return false;
}

// ---- Places

// The place that an exit leads to, as seen from the exit's own place.
static void look_point(const WgObservation *seen, const WgMapPlace *place, int64_t exit, double stride, double *x, double *y)
{
    double direction = direction_of(seen, exit);
    double far = stride;
    if (exit == TO_TARGET) {
        double dx = target_x(seen) - place->x;
        double dy = target_y(seen) - place->y;
        direction = wg_angle_of(dx, dy);
        far = wg_lower(stride, sqrt(dx * dx + dy * dy));
    }
    *x = place->x + far * wg_cos(direction);
    *y = place->y + far * wg_sin(direction);
}

// Closes the exits that lead to the path just driven, which is explored now.
static void close_exits(const WgObservation *seen, WgTopologicalMemory *own, int64_t one, int64_t other, double stride)
{
    const WgMapPlace *from = &own->places[one];
    const WgMapPlace *to = &own->places[other];
    for (int64_t k = 0; k < (int64_t)own->count; k++) {
        WgMapPlace *place = &own->places[k];
        for (int64_t exit = 0; exit < EXITS; exit++) {
            if (!has_bit(place->exits, exit)) {
                continue;
            }
            double x;
            double y;
            look_point(seen, place, exit, stride, &x, &y);
            if (wg_distance_to_path(x, y, from->x, from->y, to->x, to->y) < NEAR * stride) {
                place->exits = without_bit(place->exits, exit);
            }
        }
    }
}

// Returns the number of a new place. If the map is full, the oldest place is forgotten,
// unless the robot comes from it.
static int64_t make_place(WgTopologicalMemory *own)
{
    int64_t most = (int64_t)own->most;
    if (own->count < own->most) {
        own->count += 1.0;
        return (int64_t)own->count - 1;
    }
    int64_t number = (int64_t)own->next;
    if (number == (int64_t)own->here) {
        number = (number + 1) % most;
    }
    own->next = (double)((number + 1) % most);
    for (int64_t k = 0; k < most; k++) {
        part(own, k, number);
    }
    return number;
}

// Makes the robot's position a place, joined to the place that it comes from and to those in sight
// nearby. If the robot has hardly moved, it stays at the place that it comes from.
static void settle(const WgObservation *seen, WgTopologicalMemory *own, const WgPoints *points, double open)
{
    double stride = stride_of(seen, own);
    int64_t from = (int64_t)own->here;
    bool is_first = own->count == 0.0;
    if (!is_first && wg_distance(seen->x, seen->y, own->places[from].x, own->places[from].y) < APART * seen->radius) {
        return;
    }
    double exits = new_exits(seen, own, open, stride);
    int64_t number = make_place(own);
    WgMapPlace *place = &own->places[number];
    *place = (WgMapPlace){seen->x, seen->y, exits, 0.0};
    own->here = (double)number;
    if (is_first) {
        return;
    }

    // If the other place has no free slot, it loses a link, so that a path back always exists.
    if (!join(own, from, number)) {
        part(own, from, link_of(&own->places[from], LINKS - 1));
        join(own, from, number);
    }
    close_exits(seen, own, from, number, stride);
    for (int64_t k = 0; k < (int64_t)own->count; k++) {
        double dx = own->places[k].x - seen->x;
        double dy = own->places[k].y - seen->y;
        double far = sqrt(dx * dx + dy * dy);
        bool is_near = k != number && k != from && far > 0.0 && far < SEES * stride;
        if (is_near && is_free(points, dx / far, dy / far, CLOSE * seen->radius, far)) {
            join(own, number, k);
        }
    }
}

// ---- Decisions

// Returns the exit with the shortest known path to the target: along the map to its place,
// and then straight on.
static Choice best_exit(const WgObservation *seen, const WgTopologicalMemory *own, const Ways *ways, double stride)
{
    Choice best = {-1, 0};
    double least = INFINITY;
    for (int64_t k = 0; k < (int64_t)own->count; k++) {
        if (ways->length[k] == INFINITY) {
            continue;
        }
        for (int64_t exit = 0; exit < EXITS; exit++) {
            if (!has_bit(own->places[k].exits, exit)) {
                continue;
            }
            double x;
            double y;
            look_point(seen, &own->places[k], exit, stride, &x, &y);
            double length = ways->length[k] + wg_distance(x, y, target_x(seen), target_y(seen));
            if (length < least) {
                least = length;
                best = (Choice){k, exit};
            }
        }
    }
    return best;
}

// Leaves the robot's place by an exit.
static void leave(const WgObservation *seen, WgTopologicalMemory *own, int64_t exit, double open)
{
    WgMapPlace *here = &own->places[(int64_t)own->here];
    here->exits = without_bit(here->exits, exit);
    own->mode = EXPLORE;
    own->exit = (double)exit;
    own->heading = direction_of(seen, exit);
    own->open = open;
}

// Chooses where to go from the robot's place. When the map has no exits left, it is forgotten, and
// the next map is finer; the coarsest follows the finest.
static void decide(const WgObservation *seen, WgTopologicalMemory *own, const WgPoints *points, double open)
{
    Ways ways = {0};
    find_ways(own, &ways);
    Choice best = best_exit(seen, own, &ways, stride_of(seen, own));
    if (best.place < 0) {
        for (int64_t k = 0; k < (int64_t)own->most; k++) {
            own->places[k] = (WgMapPlace){0};
        }
        own->count = 0.0;
        own->next = 0.0;
        own->level = own->level + 1.0 < (double)LEVELS ? own->level + 1.0 : 0.0;
        open = open_exits(seen, points, stride_of(seen, own));
        settle(seen, own, points, open);
        find_ways(own, &ways);
        best = best_exit(seen, own, &ways, stride_of(seen, own));
        if (best.place < 0) {
            best = (Choice){(int64_t)own->here, TO_TARGET};
        }
    }
    if (best.place == (int64_t)own->here) {
        leave(seen, own, best.exit, open);
        return;
    }
    own->mode = TRAVEL;
    own->to = (double)ways.first[best.place];
}

// Returns whether a wall stopped or bent the last step.
static bool is_barred(const WgObservation *seen, const WgTopologicalMemory *own)
{
    double along = (seen->x - own->x) * wg_cos(own->heading) + (seen->y - own->y) * wg_sin(own->heading);
    return seen->bump != 0.0 && along < ALONG * own->step;
}

// Returns true if the robot is at a place, or as near as its steps allow.
static bool is_at(const WgObservation *seen, const WgTopologicalMemory *own, const WgMapPlace *place)
{
    double left = wg_distance(seen->x, seen->y, place->x, place->y);
    double moved = wg_distance(seen->x, seen->y, own->x, own->y);
    bool stands = moved < THERE * seen->radius && left < STANDS * seen->radius;
    return left < THERE * seen->radius || stands;
}

// Evaluates the last step, and decides if it has come to a place.
static void continue_leg(const WgObservation *seen, WgTopologicalMemory *own, const WgPoints *points)
{
    double stride = stride_of(seen, own);
    double open = open_exits(seen, points, stride);
    const WgMapPlace *here = &own->places[(int64_t)own->here];
    if (own->mode == TRAVEL) {
        if (is_at(seen, own, &own->places[(int64_t)own->to])) {
            own->here = own->to;
            decide(seen, own, points, open);
        } else if (is_barred(seen, own)) {
            part(own, (int64_t)own->here, (int64_t)own->to);
            settle(seen, own, points, open);
            decide(seen, own, points, open);
        }
        return;
    }
    double driven = wg_distance(seen->x, seen->y, here->x, here->y);
    bool is_there = (int64_t)own->exit == TO_TARGET && seen->target_distance < THERE * seen->radius;
    bool ends = is_barred(seen, own) || is_there || driven >= REACH * stride;
    ends = ends || (driven >= APART * seen->radius && has_opened(seen, own, open, stride));
    own->open = open;
    if (ends) {
        settle(seen, own, points, open);
        decide(seen, own, points, open);
    }
}

// Commands the next step of the leg: to the place that it travels to, or straight on.
static void drive(const WgObservation *seen, WgTopologicalMemory *own, WgCommand *command)
{
    double length = seen->top_speed * seen->time_step;
    if (own->mode == TRAVEL) {
        const WgMapPlace *to = &own->places[(int64_t)own->to];
        own->heading = wg_angle_of(to->x - seen->x, to->y - seen->y);
        length = wg_lower(length, wg_distance(seen->x, seen->y, to->x, to->y));
    } else if ((int64_t)own->exit == TO_TARGET) {
        length = wg_lower(length, seen->target_distance);
    }
    wg_steer(seen, command, wg_wrap(own->heading - seen->heading), length / seen->time_step);
    own->x = seen->x;
    own->y = seen->y;
    own->step = length;
}

void wg_topological_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgTopologicalMemory *own = (WgTopologicalMemory *)memory;
    if (seen->beam_count == 0) {
        // Python's error for dividing a whole turn by the number of beams
        command->error = "ZeroDivisionError: division by zero";
        return;
    }
    WgPoints points;
    wg_beam_ends(seen, seen->heading, &points);
    if (own->mode == START) {
        double open = open_exits(seen, &points, stride_of(seen, own));
        settle(seen, own, &points, open);
        decide(seen, own, &points, open);
    } else {
        continue_leg(seen, own, &points);
    }
    drive(seen, own, command);
}

// How bodies turn, and how cars drive: the parts of a step in which these differ from a disc that
// turns on the spot.

#include "step.h"

enum {
    MOST_LEGS = 32,  // straight legs of a car's step
    // lattice units times heading units: the product of the length and the turn of a leg that
    // leaves its arc by at most 1/64 of a cell. A chord of length l leaves the arc on which it turns
    // by the angle a by l a / 8, so it is 8 * 16 * 65536 / (2 pi).
    LEG_PRODUCT = 1335088,
};

// The largest curvature of a car, as it is stored.
static const int64_t FULL_LOCK = (int64_t)1 << 30;

// The steps of an arc: how many legs keep it within the bound.
static int64_t legs_of(int64_t length, int64_t turn)
{
    int64_t legs = 1;
    while (legs < MOST_LEGS && legs * legs * LEG_PRODUCT < length * turn) {
        legs++;
    }
    return legs;
}

// The turn on a length of a car's path at its curvature, heading units, rounded towards zero.
static int64_t turn_on(const WgSettings *settings, int64_t steering, int64_t length)
{
    double share = (double)steering / (double)FULL_LOCK;
    double turn = share * (double)length * settings->turn_per_unit;
    double limit = settings->turn_limit * settings->turn + 1e-9;
    double most = wg_lower(WG_MOST_BODY_TURN, limit);
    return (int64_t)wg_clamp(turn, -most, most);
}

int64_t wg_most_legs(const WgSettings *settings)
{
    if (settings->turn_per_unit <= 0.0) {
        return 1;
    }
    int64_t fastest = (int64_t)(settings->top_speed * settings->speed) + 1;
    int64_t legs = settings->motion == WG_SWEPT ? legs_of(fastest, turn_on(settings, FULL_LOCK, fastest) + 1) : 1;
    // The last one may be undone.
    return legs + 1;
}

void wg_steer(const WgSettings *settings, const WgCommand *command, WgRobot *robot)
{
    WgCarriage *carriage = robot->carriage;
    // The curvature of the commanded arc, as a share of the largest one. A car that is to turn on the
    // spot turns its wheels as far as they go.
    double limit = settings->turn_limit;
    double turn_rate = wg_clamp(command->turn_rate, -limit, limit);
    double wanted = 0.0;
    if (command->speed != 0.0) {
        wanted = wg_clamp(turn_rate / command->speed * settings->turning_radius, -1.0, 1.0);
    } else if (turn_rate != 0.0) {
        wanted = turn_rate > 0.0 ? 1.0 : -1.0;
    }
    int64_t steering = (int64_t)(wanted * (double)FULL_LOCK);
    if (settings->steering_rate < INFINITY) {
        int64_t most = (int64_t)wg_lower(settings->steering_rate * settings->time_step * (double)FULL_LOCK,
                                         2.0 * (double)FULL_LOCK);
        steering = wg_most(carriage->steering - most, wg_least(carriage->steering + most, steering));
    }
    carriage->steering = steering;
}

// Notes which way a wall is that has cut a turn short, and ends the run if none may be touched.
static void note_stop(const WgSettings *settings, int64_t step, const WgStopped *stopped, WgRobot *robot)
{
    WgReport *report = &robot->report;
    int64_t x = (int64_t)(stopped->away.x * (double)WG_UNIT);
    int64_t y = (int64_t)(stopped->away.y * (double)WG_UNIT);
    robot->carriage->bumped = 1 + wg_heading_of(x, y, 0);
    if (settings->contact == WG_CONTACT_FAIL && report->ending == WG_LIMIT) {
        robot->contact = stopped->away;  // there is no step after this one to sense it in
        report->ending = WG_CONTACT;
        report->hit_step = step;
        report->hit_ix = stopped->cell.ix;
        report->hit_iy = stopped->cell.iy;
    }
}

// Ends the run as WG_BURNED if a turn sweeps over a burning cell.
static void turn_through_fire(const WgArena *arena, const WgSettings *settings, int64_t step, int64_t turn,
                              WgRobot *robot)
{
    const WgState *state = &robot->body->state;
    WgStopped burnt = {{false, 0, 0}, {0.0, 0.0}};
    int64_t unburnt = wg_clear_turn(wg_grid(arena), WG_BURNING, arena->headings, &settings->footprint, state->x,
                                    state->y, state->heading, turn, &burnt);
    if (unburnt != turn && robot->report.ending == WG_LIMIT) {
        wg_burn(robot, step, burnt.cell, WG_BURNING);
    }
}

// Returns how far of a turn a robot's body is clear, and notes what stops it.
static int64_t clear_part(const WgArena *arena, const WgSettings *settings, const WgState *state, int64_t turn,
                          WgStopped *stopped)
{
    const WgFootprint *footprint = &settings->footprint;
    if (footprint->count == 0 || turn == 0 || wg_nothing_near(arena, settings, state, 0, 0)) {
        return turn;
    }
    if (settings->motion == WG_SWEPT) {
        return wg_clear_turn(wg_grid(arena), WG_SOLID, arena->headings, footprint, state->x, state->y, state->heading,
                             turn, stopped);
    }
    // `endpoint` only looks at the end, and refuses what is not clear there.
    int64_t heading = wg_reduced_heading(state->heading + turn);
    WgSegment here = {state->x, state->y, state->x, state->y};
    stopped->cell = wg_body_first_not_clear(wg_grid(arena), WG_SOLID, arena->headings, footprint, here, heading);
    stopped->away.x = (double)(state->x - stopped->cell.ix * WG_UNIT) - WG_UNIT / 2;
    stopped->away.y = (double)(state->y - stopped->cell.iy * WG_UNIT) - WG_UNIT / 2;
    return stopped->cell.found ? 0 : turn;
}

// Turns a robot whose body is clear.
static void turn_freely(const WgArena *arena, const WgSettings *settings, int64_t step, int64_t turn, WgRobot *robot)
{
    WgState *state = &robot->body->state;
    if (arena->event_count > 0 && settings->motion == WG_SWEPT && settings->footprint.count > 0 && turn != 0) {
        turn_through_fire(arena, settings, step, turn, robot);
    }
    robot->carriage->bumped = 0;
    state->heading = wg_reduced_heading(state->heading + turn);
}

int64_t wg_turn_body(const WgArena *arena, const WgSettings *settings, int64_t step, int64_t turn, WgRobot *robot)
{
    WgStopped stopped = {{false, 0, 0}, {0.0, 0.0}};
    int64_t turned = clear_part(arena, settings, &robot->body->state, turn, &stopped);
    turn_freely(arena, settings, step, turned, robot);
    if (turned != turn) {
        note_stop(settings, step, &stopped, robot);
    }
    return turned;
}

WgNormal wg_bump_of_turn(const WgArena *arena, const WgCarriage *carriage)
{
    if (carriage->bumped == 0) {
        return (WgNormal){0.0, 0.0};
    }
    int64_t away = carriage->bumped - 1;
    return (WgNormal){(double)arena->headings[away],
                      (double)arena->headings[(away - WG_TURN / 4) & (WG_TURN - 1)]};
}

// The part of a whole that belongs to one of `count` equal parts, rounded towards zero.
static int64_t part_of(int64_t whole, int64_t part, int64_t count)
{
    return whole * (part + 1) / count - whole * part / count;
}

// Returns which share of a displacement a robot has made.
static double share_made(WgVector by, int64_t dx, int64_t dy)
{
    double length_sq = (double)(by.x * by.x + by.y * by.y);
    return length_sq > 0.0 ? wg_clamp((double)(by.x * dx + by.y * dy) / length_sq, 0.0, 1.0) : 0.0;
}

static void note_turn(const WgSettings *settings, int64_t step, int64_t turned, WgRobot *robot)
{
    robot->turned += turned;
    if (settings->measures != 0) {
        wg_measure_turn(settings, step, turned, robot);
    }
}

// Turns a car while it drives a leg, and returns how far.
static int64_t turn_car(const WgArena *arena, const WgSettings *settings, int64_t step, int64_t turn, WgRobot *robot)
{
    int64_t turned = wg_turn_body(arena, settings, step, turn, robot);
    note_turn(settings, step, turned, robot);
    return turned;
}

// Undoes a leg on which a wall stopped a car so soon that it has turned by more than its way allows, and
// where it cannot turn back.
static void undo_leg(const WgArena *arena, const WgSettings *settings, int64_t step, const WgSegment *way, int64_t turned,
                     int64_t time, WgRobot *robot)
{
    WgState *state = &robot->body->state;
    int64_t x = state->x;
    int64_t y = state->y;
    int64_t before = robot->corners;
    wg_move(arena, settings, step, way->px - x, way->py - y, time, time, robot);
    wg_note_headings(robot, before);
    if (settings->measures != 0) {
        wg_measure_move(arena, settings, step, state->x - x, state->y - y, robot);
    }
    turn_car(arena, settings, step, -turned, robot);
}

WgNormal wg_drive_car(const WgArena *arena, const WgSettings *settings, int64_t step, int64_t drive, WgRobot *robot)
{
    WgState *state = &robot->body->state;
    int64_t turn = turn_on(settings, robot->carriage->steering, drive);
    int64_t legs = settings->motion == WG_SWEPT ? legs_of(wg_abs(drive), wg_abs(turn)) : 1;
    robot->turned = 0;
    for (int64_t leg = 0; leg < legs; leg++) {
        // Turn by half, so that the leg is a chord of its arc. Where a wall is in the way of that, the car
        // first has to drive away from it.
        WgStopped stopped = {{false, 0, 0}, {0.0, 0.0}};
        int64_t turns = part_of(turn, leg, legs);
        int64_t half = turns / 2;
        half = clear_part(arena, settings, state, half, &stopped) == half ? half : 0;
        turn_freely(arena, settings, step, half, robot);
        note_turn(settings, step, half, robot);
        if (robot->report.ending != WG_LIMIT) {
            return (WgNormal){0.0, 0.0};
        }

        // Drive straight.
        WgVector by = {0, 0};
        int64_t ahead = part_of(drive, leg, legs);
        if (ahead != 0) {
            by = wg_displacement(arena->headings, state->heading, ahead);
        }
        WgVector drift = {0, 0};
        if (settings->disturbed != 0) {
            drift = (WgVector){part_of(settings->drift_x, leg, legs), part_of(settings->drift_y, leg, legs)};
        }
        by = (WgVector){by.x + drift.x, by.y + drift.y};
        WgSegment way = {state->x, state->y, state->x + by.x, state->y + by.y};
        int64_t before = robot->corners;
        WgNormal contact = wg_move_during(arena, settings, step, by, WG_STEP_TIME * leg / legs,
                                          WG_STEP_TIME * (leg + 1) / legs, robot);
        wg_note_headings(robot, before);
        bool touches = wg_is_contact(contact);
        if (settings->measures != 0) {
            WgVector missed = touches ? (WgVector){0, 0} : drift;
            wg_measure_move(arena, settings, step, state->x - way.px - missed.x, state->y - way.py - missed.y, robot);
        }
        if (robot->report.ending != WG_LIMIT) {
            return contact;
        }

        // Where it has not moved, it can turn back; to test that would take most of the time of a step.
        if (touches && state->x == way.px && state->y == way.py && arena->event_count == 0) {
            state->heading = wg_reduced_heading(state->heading - half);
            note_turn(settings, step, -half, robot);
            return contact;
        }

        // And turn by the rest; in all by the share of the leg that was driven.
        if (touches) {
            turns = (int64_t)((double)turns * share_made(by, state->x - way.px, state->y - way.py));
        }
        int64_t turned = turn_car(arena, settings, step, turns - half, robot);
        if (turned != turns - half) {
            contact = wg_bump_of_turn(arena, robot->carriage);
            if (wg_abs(half + turned) > wg_abs(turns)) {
                undo_leg(arena, settings, step, &way, half + turned, WG_STEP_TIME * (leg + 1) / legs, robot);
            }
            robot->carriage->bumped = 0;  // it is sensed in this step
        }
        if (wg_is_contact(contact)) {
            return contact;
        }
    }
    return (WgNormal){0.0, 0.0};
}

void wg_end_move(const WgArena *arena, const WgSettings *settings, int64_t step, WgRobot *robot)
{
    const WgGoal *goal = robot->goal;
    if (goal->arrival == WG_ARRIVAL_STEP && robot->report.ending == WG_LIMIT
        && wg_is_at_goal(goal, &robot->body->state)) {
        wg_meet_goal(settings, robot);
    }
    // At most one goal counts in a step: the rest of the move is not judged for the next one.
    if (robot->meets != 0) {
        wg_pass_waypoint(settings, step, robot);
    }
    // A turn that was cut short shows in the step after it.
    if (wg_has_carriage(settings) && !wg_is_contact(robot->contact)) {
        robot->contact = wg_bump_of_turn(arena, robot->carriage);
    }
}

void wg_apply_to_any(const WgArena *arena, const WgSettings *settings, const WgCommand *command, int64_t step,
                     WgRobot *robot)
{
    wg_apply(arena, settings, command, step, false, robot);
}

// How bodies turn, and how cars drive: the parts of a step in which these differ from a disc that
// turns on the spot.

#include "step.h"

enum {
    MOST_LEGS = 1024,  // straight legs of a car's step
    MOST_TRIES = 14,   // legs of a step that a wall may cut short before the car stops where it is
    MOST_DRIVE = (1 << 25) - 1,  // lattice units of a step: more than any world is wide
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
    int64_t fastest = (int64_t)wg_lower(settings->top_speed * settings->speed, MOST_DRIVE - 1) + 1;
    int64_t legs = settings->motion == WG_SWEPT ? legs_of(fastest, turn_on(settings, FULL_LOCK, fastest) + 1) : 1;
    // Each has one corner, and after each try that fails there are at most two more. There is room for four a leg.
    return legs + MOST_TRIES / 2 + 1;
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

static void note_turn(const WgSettings *settings, int64_t step, int64_t turned, WgRobot *robot)
{
    robot->turned += turned;
    if (settings->measures != 0) {
        wg_measure_turn(settings, step, turned, robot);
    }
}

// What a car does in a step, or in a stretch of it: the length that it drives, lattice units, the turn on it,
// heading units, and how far the floor drifts.
typedef struct Way {
    int64_t ahead;
    int64_t turn;
    WgVector drift;
} Way;

// When a car turns on a stretch. All lead to the same pose; where a wall is in the way of one of them, another may
// be clear.
typedef enum Order {
    HALF_AND_HALF,  // by half before it drives straight, and by the rest after that
    ALL_LATE,
    ALL_EARLY,
    ORDERS,
} Order;

// A stretch of a car's arc: it turns by `before`, drives the straight chord, and turns by `after`.
typedef struct Leg {
    int64_t before;
    int64_t after;
    WgVector by;
    WgVector drift;  // the part of `by` that the wheels don't make
    int64_t off_x;   // of the carriage after it
    int64_t off_y;
} Leg;

// The part of a whole that belongs to a stretch of the step, rounded so that all parts make the whole.
static int64_t part_of(int64_t whole, int64_t from, int64_t until)
{
    return (int64_t)((__int128)whole * until / WG_STEP_TIME) - (int64_t)((__int128)whole * from / WG_STEP_TIME);
}

// The turn on the first part of a step's way: never more than its share, so that no stretch is driven with more than
// the car's curvature.
static int64_t turn_after(const Way *way, int64_t until)
{
    return way->turn != 0 ? way->turn * part_of(way->ahead, 0, until) / way->ahead : 0;
}

static Way stretch_of(const Way *way, int64_t from, int64_t until)
{
    return (Way){
        part_of(way->ahead, from, until),
        turn_after(way, until) - turn_after(way, from),
        {part_of(way->drift.x, from, until), part_of(way->drift.y, from, until)},
    };
}

// How many lattice units a stretch has at most.
static int64_t units_of(const Way *stretch)
{
    return wg_abs(stretch->ahead) + wg_abs(stretch->drift.x) + wg_abs(stretch->drift.y);
}

// Returns the leg of a stretch: the chord of the arc that begins at the car's exact place, at its heading.
static Leg leg_of(const WgArena *arena, const WgRobot *robot, const Way *stretch, Order order)
{
    int64_t half = stretch->turn / 2;
    int64_t along = wg_reduced_heading(robot->body->state.heading + half);
    int64_t x = robot->carriage->off_x
                + wg_scaled_cosine(stretch->ahead * WG_OFF_UNIT, arena->headings[along]);
    int64_t y = robot->carriage->off_y
                + wg_scaled_cosine(stretch->ahead * WG_OFF_UNIT,
                                   arena->headings[wg_reduced_heading(along - WG_TURN / 4)]);
    WgVector by = {wg_floor_div(x + WG_OFF_UNIT / 2, WG_OFF_UNIT), wg_floor_div(y + WG_OFF_UNIT / 2, WG_OFF_UNIT)};
    int64_t before = order == HALF_AND_HALF ? half : order == ALL_LATE ? 0 : stretch->turn;
    return (Leg){
        before,
        stretch->turn - before,
        {by.x + stretch->drift.x, by.y + stretch->drift.y},
        stretch->drift,
        x - by.x * WG_OFF_UNIT,
        y - by.y * WG_OFF_UNIT,
    };
}

static WgSegment way_of(const WgState *state, const Leg *leg)
{
    return (WgSegment){state->x, state->y, state->x + leg->by.x, state->y + leg->by.y};
}

// Returns true if a turn is clear; if not, notes what stops it.
static bool turn_is_clear(const WgArena *arena, const WgSettings *settings, const WgState *state, int64_t turn,
                          WgStopped *stopped)
{
    return turn == 0
           || wg_clear_turn(wg_grid(arena), WG_SOLID, arena->headings, &settings->footprint, state->x, state->y,
                            state->heading, turn, stopped)
                  == turn;
}

// Returns true if a car can drive all of a leg. If a turn is what stops it, `stopped` says where.
static bool leg_is_clear(const WgArena *arena, const WgSettings *settings, const WgState *state, const Leg *leg,
                         WgStopped *stopped)
{
    WgSegment way = way_of(state, leg);
    WgState there = *state;
    there.heading = wg_reduced_heading(state->heading + leg->before);
    stopped->cell.found = false;
    if (settings->motion != WG_SWEPT) {
        // `endpoint` only looks at the end.
        way = (WgSegment){way.qx, way.qy, way.qx, way.qy};
        int64_t heading = wg_reduced_heading(there.heading + leg->after);
        return !wg_robot_first_not_clear(wg_grid(arena), WG_SOLID, arena->headings, settings, way, heading).found;
    }
    bool is_body = settings->footprint.count > 0;
    if (is_body && !turn_is_clear(arena, settings, state, leg->before, stopped)) {
        return false;
    }
    if (wg_robot_first_not_clear(wg_grid(arena), WG_SOLID, arena->headings, settings, way, there.heading).found) {
        return false;
    }
    there.x = way.qx;
    there.y = way.qy;
    return !is_body || turn_is_clear(arena, settings, &there, leg->after, stopped);
}

// Drives a leg that is clear.
static void drive_leg(const WgArena *arena, const WgSettings *settings, int64_t step, const Leg *leg, int64_t until,
                      bool is_near, WgRobot *robot)
{
    WgState *state = &robot->body->state;
    turn_freely(arena, settings, step, leg->before, robot);
    note_turn(settings, step, leg->before, robot);
    if (robot->report.ending != WG_LIMIT) {
        return;
    }
    int64_t first = robot->corners;
    int64_t x = state->x + leg->by.x;
    int64_t y = state->y + leg->by.y;
    if (leg->by.x != 0 || leg->by.y != 0) {
        wg_add_corner(robot, x, y, until);
    }
    if (is_near) {
        wg_arrive_closely(arena, settings, step, x, y, robot);
    } else {
        wg_arrive(settings, x, y, robot);
    }
    wg_note_headings(robot, first);
    if (settings->measures != 0) {
        wg_measure_move(arena, settings, step, leg->by.x - leg->drift.x, leg->by.y - leg->drift.y, robot);
    }
    robot->carriage->off_x = leg->off_x;
    robot->carriage->off_y = leg->off_y;
    if (robot->report.ending == WG_LIMIT) {
        turn_freely(arena, settings, step, leg->after, robot);
        note_turn(settings, step, leg->after, robot);
    }
}

// Drives a stretch if the whole of it is clear; returns true if it does.
static bool drive_stretch(const WgArena *arena, const WgSettings *settings, int64_t step, const Way *stretch,
                          int64_t until, WgRobot *robot)
{
    const WgState *state = &robot->body->state;
    Leg leg = leg_of(arena, robot, stretch, HALF_AND_HALF);
    bool is_near = !wg_nothing_near(arena, settings, state, leg.by.x, leg.by.y);
    WgStopped stopped;
    // A disc's turns are clear, and `endpoint` sees none, so that for them all orders are the same.
    int orders = settings->footprint.count > 0 && settings->motion == WG_SWEPT && stretch->turn != 0 ? ORDERS : 1;
    bool is_clear = !is_near || (units_of(stretch) == 0 && stretch->turn == 0)
                    || leg_is_clear(arena, settings, state, &leg, &stopped);
    for (int order = 1; order < orders && !is_clear; order++) {
        leg = leg_of(arena, robot, stretch, (Order)order);
        is_clear = leg_is_clear(arena, settings, state, &leg, &stopped);
    }
    if (is_clear) {
        drive_leg(arena, settings, step, &leg, until, is_near, robot);
    }
    return is_clear;
}

// Returns the contact that stops a car on a stretch which is not clear, and ends the run if there may be none.
static WgNormal stop_car(const WgArena *arena, const WgSettings *settings, int64_t step, const Way *stretch,
                         WgRobot *robot)
{
    WgStopped stopped;
    Leg leg = leg_of(arena, robot, stretch, HALF_AND_HALF);
    (void)leg_is_clear(arena, settings, &robot->body->state, &leg, &stopped);
    if (!stopped.cell.found) {
        int64_t turn = settings->motion == WG_SWEPT ? leg.before : leg.before + leg.after;
        return wg_touch(arena, settings, step, way_of(&robot->body->state, &leg), turn, robot);
    }
    note_stop(settings, step, &stopped, robot);
    WgNormal contact = wg_bump_of_turn(arena, robot->carriage);
    robot->carriage->bumped = 0;  // it is sensed in this step
    return contact;
}

// Drives a car between two times of a step in which the world is static: in one leg, or up to a wall in ever
// shorter ones. It stands on its arc, and the next lattice unit of that is not clear.
static WgNormal drive_until(const WgArena *arena, const WgSettings *settings, int64_t step, const Way *way,
                            int64_t from, int64_t until, int64_t *tries, WgRobot *robot)
{
    int64_t size = until - from;
    bool is_blocked = false;
    while (from < until && robot->report.ending == WG_LIMIT) {
        int64_t end = wg_least(from + size, until);
        Way stretch = stretch_of(way, from, end);
        if (drive_stretch(arena, settings, step, &stretch, end, robot)) {
            from = end;
            continue;
        }
        int64_t units = units_of(&stretch);
        if (units <= 1 || *tries == 0 || settings->motion != WG_SWEPT) {
            return stop_car(arena, settings, step, &stretch, robot);
        }
        --*tries;
        // Most cars at walls are held by them, and the first unit shows that.
        if (!is_blocked) {
            is_blocked = true;
            int64_t unit = wg_least(from + size / units + 1, until);
            Way first = stretch_of(way, from, unit);
            if (!drive_stretch(arena, settings, step, &first, unit, robot)) {
                return stop_car(arena, settings, step, &first, robot);
            }
            from = unit;
        }
        size /= 2;
    }
    return (WgNormal){0.0, 0.0};
}

// Lets the events of a step happen whose time has come, and returns the time of the next one in it.
static int64_t pass_events(const WgArena *arena, const WgSettings *settings, int64_t step, int64_t now,
                           WgRobot *robot)
{
    while (robot->next_event < arena->event_count && robot->report.ending == WG_LIMIT) {
        const WgEvent *event = &arena->events[robot->next_event];
        if (event->step != step) {
            break;
        }
        // `endpoint` checks the world only at the end of a step, so all events come first.
        if (event->time > now && settings->motion == WG_SWEPT) {
            return event->time;
        }
        // The robot waits for the event.
        if (now > 0 && (robot->corners == 0 || robot->chain[robot->corners - 1].time < now)) {
            wg_add_corner(robot, robot->body->state.x, robot->body->state.y, now);
            wg_note_headings(robot, robot->corners - 1);
        }
        robot->next_event = wg_change_cells(arena, step, robot->next_event);
        wg_catch(arena, settings, step, robot);
    }
    return WG_STEP_TIME;
}

WgNormal wg_drive_car(const WgArena *arena, const WgSettings *settings, int64_t step, int64_t drive, WgRobot *robot)
{
    int64_t ahead = wg_most(wg_least(drive, MOST_DRIVE), -MOST_DRIVE);
    Way way = {ahead, turn_on(settings, robot->carriage->steering, ahead), {settings->drift_x, settings->drift_y}};
    if (settings->disturbed == 0) {
        way.drift = (WgVector){0, 0};
    }
    int64_t legs = settings->motion == WG_SWEPT ? legs_of(wg_abs(ahead), wg_abs(way.turn)) : 1;
    int64_t tries = MOST_TRIES;
    WgNormal contact = {0.0, 0.0};
    robot->turned = 0;
    int64_t leg = 0;
    for (int64_t now = 0; now < WG_STEP_TIME;) {
        int64_t next_event = pass_events(arena, settings, step, now, robot);
        if (robot->report.ending != WG_LIMIT) {
            break;
        }
        int64_t end = WG_STEP_TIME * (leg + 1) / legs;
        int64_t until = wg_least(end, next_event);
        if (!wg_is_contact(contact)) {
            contact = drive_until(arena, settings, step, &way, now, until, &tries, robot);
        }
        leg += until == end;
        now = until;
    }
    return contact;
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

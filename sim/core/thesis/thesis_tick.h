// A tick of the thesis's robot: the move at the current speed, then the arbiter, whose turn takes
// effect immediately and whose speed drives the next tick.
//
// Source: the thesis's listing, robot.update, robot.turnS and the three behaviours.

#ifndef WG_THESIS_TICK_H
#define WG_THESIS_TICK_H

#include "fdlibm.h"
#include "random_draw.h"
#include "thesis_arbiter.h"
#include "thesis_parts.h"

static const double THESIS_TURN_STEP = 0.08; // rad per tick
static const double THESIS_TURN_SNAP =
    0.2; // rad; closer than this the robot takes the heading immediately

// Heading after one tick of turning.
static inline double thesis_turn(double heading, double target)
{
    if (!(fabs(target - heading) > THESIS_TURN_SNAP)) {
        return target;
    }
    if (target < heading) {
        double turned =
            target + THESIS_PI > heading ? heading - THESIS_TURN_STEP : heading + THESIS_TURN_STEP;
        return thesis_wrap(turned);
    }
    double turned = heading + THESIS_PI > target ? heading + THESIS_TURN_STEP
                                                 : THESIS_TWO_PI + heading - THESIS_TURN_STEP;
    return thesis_wrap(turned);
}

// The speed at which the robot rolls in this tick: inertia and friction keep it
// from the requested speed.
static inline double thesis_rolling(const WgThesisSettings *settings, double rolling, double wanted)
{
    if (rolling < wanted) {
        double gained = rolling + settings->acceleration * settings->time_step;
        bool at_once = settings->acceleration * settings->time_step == 0.0;
        return at_once || wanted < gained ? wanted : gained;
    }
    if (rolling > wanted) {
        double kept = rolling - settings->friction * settings->time_step;
        bool at_once = settings->friction * settings->time_step == 0.0;
        return at_once || wanted > kept ? wanted : kept;
    }
    return rolling;
}

// The tick's move; sets the rolling speed.
static inline WgThesisMove thesis_move(const ThesisGrid *grid, const WgThesisSettings *settings,
                                       WgThesisState *state, int64_t step)
{
    double rolling = thesis_rolling(settings, state->rolling, state->speed);
    state->rolling = rolling;

    // Most ticks only turn.
    if (rolling == 0.0) {
        WgThesisMove stays = {state->x, state->y, 0, WG_STRAIGHT, 0.0, 0.0};
        thesis_clamp(grid, settings->radius, &stays.x, &stays.y);
        stays.before_x = stays.x;
        stays.before_y = stays.y;
        return stays;
    }
    double path = rolling;
    if (settings->slip > 0.0) {
        path *= 1.0 - settings->slip *
                          wg_random_draw(settings->seed, step * THESIS_READINGS + THESIS_SLIP);
    }
    double goal_x = state->x - wg_cos(state->heading) * path * settings->time_step;
    double goal_y = state->y - wg_sin(state->heading) * path * settings->time_step;
    WgThesisMove move = thesis_advance(grid, state->x, state->y, goal_x, goal_y, settings->radius,
                                       settings->repairs, settings->wall_friction);

    // Only a robot with inertia or friction remembers a wall's effect on its speed.
    bool has_forces = settings->acceleration > 0.0 || settings->friction > 0.0;
    if (move.collision != 0 && has_forces) {
        state->rolling = move.ending == WG_SLIDE ? rolling * (1.0 - settings->wall_friction) : 0.0;
    }
    return move;
}

// Lets the controlling behaviour act: changes the headings, the speed, the behaviour in control,
// and its counter.
static inline void thesis_act(WgThesisState *state, double signal, double top_speed)
{
    if (state->behaviour == WG_SEEK) {
        state->target_heading = signal;
    }
    bool turned = state->heading == state->target_heading;
    WgAction action =
        wg_run_behaviour(state->behaviour, state->ticks_left, state->collision != 0, turned);
    state->behaviour = action.behaviour;
    state->ticks_left = action.ticks;
    switch (action.wheels) {
    case WG_WHEELS_TURN:
        state->heading = thesis_turn(state->heading, state->target_heading);
        state->speed = 0.0;
        break;
    case WG_WHEELS_HALT:
        state->speed = 0.0;
        break;
    case WG_WHEELS_GO:
        state->speed = top_speed;
        break;
    case WG_WHEELS_RESUME:
        state->speed = state->old_speed;
        break;
    case WG_WHEELS_COAST:
        break;
    }
}

// Begins an escape: remembers the speed, stops, and sets the target heading by the rule.
static inline void thesis_escape(const WgThesisSettings *settings, WgThesisState *state,
                                 const double *draws)
{
    // A robot that is coasting, or is interrupted while it turns, still needs its previous speed.
    if (state->speed > 0.0 ||
        (settings->friction == 0.0 && settings->reading != WG_INTERRUPTIBLE)) {
        state->old_speed = state->speed;
    }
    state->speed = 0.0;
    if (settings->rule == WG_RULE_ADD) {
        state->target_heading = thesis_wrap(state->heading + settings->turn_angle);
    } else if (settings->rule == WG_RULE_SUBTRACT) {
        state->target_heading = thesis_wrap(state->heading - settings->turn_angle);
    } else {
        state->target_heading = draws[state->draws_used++] * THESIS_TWO_PI;
    }
}

// Moves the robot and lets the behaviours act in tick `step`, from 1.
//
// draws:   (draw_count,) random numbers in [0, 1) for WG_RULE_RANDOM, in order.
// before:  receives the centre before a wall changed the move.
//
// Returns false if the tick needs a draw and none is left; then the state is unusable.
static inline bool thesis_tick(const ThesisGrid *grid, const WgThesisSettings *settings,
                               const double *draws, int64_t draw_count, WgThesisState *state,
                               int64_t step, ThesisPoint *before)
{
    int64_t reading = settings->reading;
    int64_t old = state->behaviour;

    // Move.
    WgThesisMove move = thesis_move(grid, settings, state, step);
    state->x = move.x;
    state->y = move.y;
    state->collision = move.collision;
    state->move = move.ending;
    state->active = WG_IDLE;
    bool collision = move.collision != 0;
    *before = (ThesisPoint){move.before_x, move.before_y};

    // Sense, if a behaviour may need it.
    double signal = 0.0;
    if (old == WG_SEEK || (!collision && (old == WG_IDLE || reading >= WG_A2))) {
        signal = thesis_sensed(grid, settings, state->x, state->y, state->heading, step);
    }

    // Some readings act before they select the next behaviour.
    if (old != WG_IDLE && (reading == WG_A2 || reading == WG_A3)) {
        state->active = old;
        thesis_act(state, signal, settings->speed);
        if (state->behaviour == WG_IDLE && !collision) {
            signal = thesis_sensed(grid, settings, state->x, state->y, state->heading, step);
        }
    }

    // Select.
    int64_t behaviour = state->behaviour;
    bool at_signal = state->target_heading == signal &&
                     (reading != WG_INTERRUPTIBLE || state->heading == signal);
    WgCharge charge =
        wg_select_behaviour(reading, behaviour, state->ticks_left, collision, at_signal,
                            settings->collide_ticks, settings->drive_ticks);
    bool escapes = charge.taken && charge.behaviour == WG_COLLIDE;
    if (escapes) {
        if (settings->rule == WG_RULE_RANDOM && state->draws_used >= draw_count) {
            return false;
        }
        thesis_escape(settings, state, draws);
    }
    state->behaviour = charge.behaviour;
    state->ticks_left = charge.ticks;
    state->escapes = escapes;

    // Act.
    bool waits = reading == WG_A2 || (reading == WG_A1 && charge.taken) ||
                 (reading == WG_A3 && behaviour != WG_IDLE);
    if (!waits) {
        state->active = charge.behaviour;
        thesis_act(state, signal, settings->speed);
    }
    return true;
}

#endif

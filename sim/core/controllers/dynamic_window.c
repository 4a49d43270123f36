// Dynamic window: of the speeds and turn rates the robot can reach next, choose the best that lets
// it stop in time.
//
// Source: Dieter Fox, Wolfram Burgard and Sebastian Thrun, "The dynamic window approach to
// collision avoidance", IEEE Robotics & Automation Magazine 4(1), 1997: admissible velocities
// (equation 14), the dynamic window (equation 15) and the objective (equation 13). Departures:
// obstacles are the ends of range beams, arcs are judged for the whole disc,
// and the objective is not smoothed over the window.

#include "directions.h"
#include "library.h"

// commands are whole 1/1024 m/s and rad/s, so that states can recur
static const double GRAIN = 1024.0;

const WgDynamicWindow wg_dynamic_window_default = {
    .margin = 0.003,
    .gain = 20.0,
    .turn_gain = 400.0,
    .fastest_turn = 12.0,
    .speeds = 5.0,
    .turns = 11.0,
    .ahead = 0.1,
    .least = 0.02,
    .far = 0.25,
    .to_target = 1.0,
    .to_free = 0.8,
    .to_speed = 0.3,
};

// A speed, m/s, and a turn rate, rad/s.
typedef struct Arc {
    double speed;
    double turn_rate;
} Arc;

double wg_arc_to_contact(double x, double y, double speed, double turn_rate, double radius)
{
    if (x * x + y * y < radius * radius) {
        return x > 0.0 ? 0.0 : INFINITY;
    }
    if (fabs(turn_rate) < 1e-6) {
        if (x <= 0.0 || fabs(y) >= radius) {
            return INFINITY;
        }
        return x - sqrt(radius * radius - y * y);
    }

    // The circle that the robot drives on, mirrored so that it always bends to the left.
    double bend = speed / fabs(turn_rate);
    double off = turn_rate > 0.0 ? bend - y : bend + y;  // from the point up to the circle's centre
    double away = sqrt(x * x + off * off);
    if (fabs(away - bend) >= radius || bend == 0.0) {
        return INFINITY;
    }
    double cosine = (bend * bend + away * away - radius * radius) / (2.0 * bend * away);
    double share = wg_lower(wg_higher(cosine, -1.0), 1.0);
    double to_point = wg_remainder(wg_angle_of(off, x), WG_WHOLE_TURN);
    double turned = to_point - wg_angle_of(share, sqrt(1.0 - share * share));
    return wg_higher(turned, 0.0) * bend;
}

// Returns the length of an arc, m, until a disc meets the first beam's end; at most `far`.
static double free_path(const WgPoints *points, Arc arc, double radius, double far)
{
    double free = far;
    for (int64_t beam = 0; beam < points->count; beam++) {
        double x = points->x[beam];
        double y = points->y[beam];
        double reach = free + radius;
        if (x * x + y * y < reach * reach) {
            free = wg_lower(free, wg_arc_to_contact(x, y, arc.speed, arc.turn_rate, radius));
        }
    }
    return free;
}

// Returns how well an arc faces the target after a while: 1 straight at it, 0 away from it.
static double facing(const WgObservation *seen, Arc arc, const WgDynamicWindow *tuned)
{
    double turned = arc.turn_rate * tuned->ahead;
    double path = arc.speed * tuned->ahead;
    // on an arc, the direction to the place differs from the heading by half the turn
    double half = 0.5 * turned;
    double towards = wg_target_bearing(seen);
    double far = seen->target_distance;
    double x = far * wg_cos(towards) - path * wg_cos(half);
    double y = far * wg_sin(towards) - path * wg_sin(half);
    return 1.0 - fabs(wg_wrap(wg_angle_of(x, y) - turned)) / WG_PI;
}

// Makes one step: judges every pair in the window and commands the best;
// brakes and turns if none is admissible.
static void drive(const WgObservation *seen, WgDynamicWindowMemory *own, WgCommand *command,
                  const WgDynamicWindow *tuned)
{
    WgPoints points;
    wg_beam_ends(seen, 0.0, &points);
    double step = seen->time_step;
    double top = seen->top_speed;
    double radius = seen->radius + tuned->margin;
    if (seen->bump != 0.0) {
        own->speed = 0.0;  // the wall has stopped the wheels
    }

    // Find the window: the speeds and turn rates the wheels can reach within a step.
    double slow = wg_higher(own->speed - tuned->gain * step, 0.0);
    double fast = wg_lower(own->speed + tuned->gain * step, top);
    double right = wg_higher(own->turn_rate - tuned->turn_gain * step, -tuned->fastest_turn);
    double left = wg_lower(own->turn_rate + tuned->turn_gain * step, tuned->fastest_turn);

    double best = -1.0;
    Arc best_arc = {slow, tuned->fastest_turn};
    for (double i = 0.0; i < tuned->speeds; i += 1.0) {
        double speed = slow + (fast - slow) * i / (tuned->speeds - 1.0);
        for (double j = 0.0; j < tuned->turns; j += 1.0) {
            Arc arc = {speed, right + (left - right) * j / (tuned->turns - 1.0)};
            double free = speed > 0.0 ? free_path(&points, arc, radius, tuned->far) : 0.0;
            if (free < tuned->least || speed * speed > 2.0 * free * tuned->gain) {
                continue;  // it could not brake in time
            }
            double worth = tuned->to_target * facing(seen, arc, tuned);
            worth += tuned->to_free * free / tuned->far + tuned->to_speed * speed / top;
            if (worth > best) {
                best = worth;
                best_arc = arc;
            }
        }
    }
    own->speed = (double)wg_floor(best_arc.speed * GRAIN) / GRAIN;
    own->turn_rate = (double)wg_floor(best_arc.turn_rate * GRAIN + 0.5) / GRAIN;
    command->speed = own->speed;
    command->turn_rate = own->turn_rate;
}

void wg_dynamic_window_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    drive(seen, (WgDynamicWindowMemory *)memory, command, &wg_dynamic_window_default);
}

void wg_dynamic_window_tuned_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgDynamicWindowTunedMemory *own = (WgDynamicWindowTunedMemory *)memory;
    drive(seen, &own->state, command, &own->tuned);
}

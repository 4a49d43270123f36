// Behaviours by signal, by sight, by knowing the target, and by chance.
//
// Sources: wander is layer 1 of Rodney A. Brooks, "A robust layered control system for a mobile
// robot", IEEE Journal of Robotics and Automation 2 (1986); approach and swerve are vehicles 2 and
// 3 of Valentino Braitenberg, "Vehicles: experiments in synthetic psychology" (1984).

#include "behaviours.h"
#include "directions.h"

// rad: beams this near to the heading look ahead
static const double AHEAD = 60.0 * (3.14159265358979323846 / 180.0);
// rad: the robot turns until an obstacle is this far to the side
static const double ASIDE = 75.0 * (3.14159265358979323846 / 180.0);

static void drive_towards(const WgSituation *now, double direction, double speed)
{
    wg_steer(now->seen, now->command, wg_wrap(direction - now->seen->heading), speed);
}

static int64_t always(const WgSituation *now)
{
    (void)now;
    return 1;
}

static int64_t receives(const WgSituation *now)
{
    return now->seen->signal > 0.0;
}

static int64_t approach_on(const WgSituation *now)
{
    drive_towards(now, now->seen->signal_heading, now->seen->top_speed);
    return 0;
}

static int64_t home_on(const WgSituation *now)
{
    double most = now->seen->target_distance / now->seen->time_step;
    drive_towards(now, now->seen->target_heading, wg_lower(now->seen->top_speed, most));
    return 0;
}

typedef struct Wander {
    double left;       // m: remainder of the leg
    double direction;  // rad
} Wander;

// options[0]: length of a leg, m.
static int64_t wander_on(const WgSituation *now)
{
    Wander *own = (Wander *)now->state;
    if (own->left <= 0.0 || now->seen->bump != 0.0) {
        own->direction = wg_wrap(now->seen->random * WG_WHOLE_TURN);
        own->left = now->options[0];
        now->command->used_random = 1.0;
    }
    own->left -= now->seen->top_speed * now->seen->time_step;
    drive_towards(now, own->direction, now->seen->top_speed);
    return 0;
}

// Returns the nearest beam ahead that is shorter than the robot's radius plus options[0], m;
// -1 if there is none.
static int64_t beam_in_the_way(const WgSituation *now)
{
    const WgObservation *seen = now->seen;
    double nearest = seen->radius + now->options[0];
    int64_t found = -1;
    for (int64_t beam = 0; beam < seen->beam_count; beam++) {
        double bearing = wg_wrap(wg_bearing_of(beam, seen->beam_count));
        if (fabs(bearing) <= AHEAD && seen->beams[beam] < nearest) {
            nearest = seen->beams[beam];
            found = beam;
        }
    }
    return found;
}

static int64_t sees_wall(const WgSituation *now)
{
    return beam_in_the_way(now) >= 0;
}

// options[1]: share of the top speed.
static int64_t swerve_on(const WgSituation *now)
{
    int64_t beam = beam_in_the_way(now);
    double turn = 0.0;
    if (beam >= 0) {
        double bearing = wg_wrap(wg_bearing_of(beam, now->seen->beam_count));
        turn = bearing + (bearing >= 0.0 ? -ASIDE : ASIDE);
    }
    wg_steer(now->seen, now->command, turn, now->options[1] * now->seen->top_speed);
    return 0;
}

typedef struct Escape {
    double best;       // strongest signal since the last escape
    double since;      // steps since then
    double side;       // 1 if the last escape went left, -1 right
    double direction;  // rad
} Escape;

// options[0]: steps without a stronger signal after which it applies.
static void watch_signal(const WgSituation *now)
{
    Escape *own = (Escape *)now->state;
    if (now->seen->signal > own->best) {
        own->best = now->seen->signal;
        own->since = 0.0;
    } else {
        own->since = wg_lower(own->since + 1.0, now->options[0]);  // otherwise no state would recur
    }
}

static int64_t makes_no_progress(const WgSituation *now)
{
    const Escape *own = (const Escape *)now->state;
    return own->since >= now->options[0];
}

// options[1]: angle between the signal and the direction to drive, rad.
static void begin_to_escape(const WgSituation *now)
{
    Escape *own = (Escape *)now->state;
    own->side = own->side > 0.0 ? -1.0 : 1.0;
    own->best = 0.0;
    own->since = 0.0;
    own->direction = wg_wrap(now->seen->signal_heading + own->side * now->options[1]);
}

static int64_t drive_away(const WgSituation *now)
{
    Escape *own = (Escape *)now->state;
    if (now->seen->bump != 0.0) {
        own->direction = wg_wrap(own->direction + own->side * 0.5 * WG_PI);
    }
    drive_towards(now, own->direction, now->seen->top_speed);
    return 0;
}

const WgBehaviour wg_approach = {.name = "approach", .trigger = receives, .action = approach_on};
const WgBehaviour wg_home = {.name = "home", .trigger = always, .action = home_on};
const WgBehaviour wg_swerve = {.name = "swerve", .trigger = sees_wall, .action = swerve_on};
const WgBehaviour wg_wander = {
    .name = "wander", .trigger = always, .action = wander_on, .state_size = sizeof(Wander) / sizeof(double)};
const WgBehaviour wg_escape = {.name = "escape",
                               .trigger = makes_no_progress,
                               .action = drive_away,
                               .watch = watch_signal,
                               .begin = begin_to_escape,
                               .state_size = sizeof(Escape) / sizeof(double)};

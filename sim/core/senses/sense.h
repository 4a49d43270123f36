// The senses of a robot on the pose lattice, and the lattice's trigonometry: what every step needs.

#ifndef WG_SENSE_H
#define WG_SENSE_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "geometry.h"
#include "random_draw.h"
#include "wg_episode.h"

// Channels of the simulator's own random numbers in one step; each number is drawn independently.
enum {
    WG_NOISE_SLIP = 0,
    WG_NOISE_WAY = 1,
    WG_NOISE_TURN = 2,
    WG_NOISE_SIGNAL = 8,
    WG_NOISE_BEAMS = 1024,
    WG_NOISE_CHANNELS = 4096,
};

// Heading units in [0, WG_TURN) of any heading. A turn is a power of two.
static inline int64_t wg_reduced_heading(int64_t heading)
{
    return heading & (WG_TURN - 1);
}

// Signed units, in (-half a turn, half a turn], from one heading to another.
static inline int64_t wg_turn_towards(int64_t heading, int64_t target)
{
    int64_t turn = wg_reduced_heading(target - heading);
    return turn > WG_TURN / 2 ? turn - WG_TURN : turn;
}

// A length times a cosine of the table, rounded to the nearest integer, halves away from zero.
static inline int64_t wg_scaled_cosine(int64_t length, int64_t cosine)
{
    const int64_t half = INT64_C(1) << 29;
    int64_t product = length * cosine;
    return product >= 0 ? (product + half) >> 30 : -((half - product) >> 30);
}

// Displacement of a drive.
static inline WgVector wg_displacement(const int64_t *headings, int64_t heading, int64_t distance)
{
    return (WgVector){
        wg_scaled_cosine(distance, headings[wg_reduced_heading(heading)]),
        wg_scaled_cosine(distance, headings[wg_reduced_heading(heading - WG_TURN / 4)]),
    };
}

// Prefetches what a displacement in a direction needs, because the table is larger than the nearest
// cache. A loop of plain steps takes 4 % less time.
static inline void wg_prefetch_displacement(const int64_t *headings, int64_t heading)
{
    __builtin_prefetch(&headings[wg_reduced_heading(heading)]);
    __builtin_prefetch(&headings[wg_reduced_heading(heading - WG_TURN / 4)]);
}

// Returns true if a normal is set: not (0, 0). Without its sign, zero has no bits; comparing them
// takes a third of the instructions of two comparisons of doubles.
static inline bool wg_is_contact(WgNormal contact)
{
    uint64_t bits[2];
    memcpy(bits, &contact, sizeof bits);
    return ((bits[0] | bits[1]) << 1) != 0;
}

// Number of the random draw of a channel in a step.
static inline int64_t wg_noise_channel(int64_t step, int64_t channel)
{
    return step * WG_NOISE_CHANNELS + channel;
}

// One of the simulator's own random numbers, in [0, 1), separate from the controller's.
static inline double wg_noise_draw(const WgSettings *settings, int64_t draw)
{
    return wg_random_draw(settings->seed ^ 0x5DEECE66D1CE4E5Bu, draw);
}

// Strength of the signal at the robot.
double wg_signal_here(const WgArena *arena, const WgSettings *settings, const WgRobot *robot, int64_t step);

// Heading towards the strongest signal around the robot.
int64_t wg_strongest_heading(const WgArena *arena, const WgSettings *settings, const WgRobot *robot, int64_t step);

// Fills the range beams, m; a beam that hits nothing, or is lost, returns its maximum range.
void wg_sense_beams(const WgArena *arena, const WgSettings *settings, const WgState *state, int64_t step,
                    double *beams);

// The senses that usually take longest; in sense.c.
void wg_sense_more(const WgArena *arena, const WgSettings *settings, const WgRobot *robot, int64_t step,
                   WgObservation *observation, double *beams);

// Returns true if any of them is declared. A single test for all of them saves 16 instructions in a
// step without them.
static inline bool wg_senses_more(const WgSettings *settings)
{
    const int64_t others = WG_SENSE_RANDOM | WG_SENSE_NOTHING_ELSE | WG_SENSE_GOAL_HEADING | WG_SENSE_TILT;
    return (settings->senses & ~others) != 0;
}

// Heading of an observation, rad.
static inline double wg_sensed_heading(const WgSettings *settings, const WgState *state)
{
    return (double)wg_turn_towards(0, state->heading) * settings->radians;
}

// The heading that a goal asks for, rad; NaN if it asks for none.
static inline double wg_sensed_goal_heading(const WgSettings *settings, const WgGoal *goal)
{
    bool has_one = goal->has_heading != 0;
    return has_one ? (double)wg_turn_towards(0, goal->heading) * settings->radians : (double)NAN;
}

// Fills in how the floor is tilted, as the speed and the heading of the drift that it causes.
void wg_sense_tilt(const WgSettings *settings, WgObservation *observation);

// Number of numbers that follow everything else in a flat array: the goal's heading if it is
// declared; before it, if the tilt is declared, the tilt and its heading.
static inline int64_t wg_tail(const WgSettings *settings)
{
    if ((settings->senses & WG_SENSE_TILT) != 0) {
        return 3;
    }
    return (settings->senses & WG_SENSE_GOAL_HEADING) != 0 ? 1 : 0;
}

// The controller's next random number.
static inline double wg_sensed_random(const WgSettings *settings, const WgState *state)
{
    return wg_random_draw(settings->seed, state->draws);
}

// Fills the observation; senses that cost time only if they are in WgSettings.senses.
// Constants do not change.
//
// robot:  its state, odometry, last contact and goal count.
// beams:  target of observation->beams.
static inline void wg_sense(const WgArena *arena, const WgSettings *settings, const WgRobot *robot, int64_t step,
                            WgObservation *observation, double *beams)
{
    const WgState *state = &robot->body->state;
    observation->bump = wg_is_contact(robot->contact) ? 1.0 : 0.0;
    observation->heading = wg_sensed_heading(settings, state);
    observation->x = (double)state->x * settings->metres;
    observation->y = (double)state->y * settings->metres;
    if ((settings->senses & WG_SENSE_RANDOM) != 0) {
        observation->random = wg_sensed_random(settings, state);
    }
    if (wg_senses_more(settings)) {
        wg_sense_more(arena, settings, robot, step, observation, beams);
    }
    if (settings->waypoint_count > 0) {
        observation->goal_heading = wg_sensed_goal_heading(settings, robot->goal);
    }
}

#endif

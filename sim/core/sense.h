// What a robot on the pose lattice senses, and the lattice's trigonometry: what every step needs.

#ifndef WG_SENSE_H
#define WG_SENSE_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "geometry.h"
#include "random_draw.h"
#include "wg_episode.h"

// Channels of the simulator's own random numbers in one step; each number is drawn for itself alone.
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

// Whether a normal is one: not (0, 0). Without its sign, zero has no bits; comparing them takes a third of the
// instructions of two comparisons of doubles.
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

// One of the simulator's own random numbers, in [0, 1), apart from those that the controller gets.
static inline double wg_noise_draw(const WgSettings *settings, int64_t draw)
{
    return wg_random_draw(settings->seed ^ 0x5DEECE66D1CE4E5Bu, draw);
}

// Strength of the signal at the robot.
double wg_signal_here(const WgArena *arena, const WgSettings *settings, const WgState *state, int64_t step);

// Heading towards the strongest signal around the robot.
int64_t wg_strongest_heading(const WgArena *arena, const WgSettings *settings, const WgState *state, int64_t step);

// Fills the range beams, m; a beam that meets nothing, or is lost, gives its longest distance.
void wg_sense_beams(const WgArena *arena, const WgSettings *settings, const WgState *state, int64_t step,
                    double *beams);

// Fills the observation: of the senses that cost time only those in WgSettings.senses. Constants are not touched.
//
// contact:  normal of the robot's last contact.
// step:     its number.
// beams:    what observation->beams points to.
static inline void wg_sense(const WgArena *arena, const WgSettings *settings, const WgState *state,
                            const WgOdometry *odometry, WgNormal contact, int64_t step, WgObservation *observation,
                            double *beams)
{
    double radians = settings->radians;
    double metres = settings->metres;
    int64_t senses = settings->senses;
    bool bumped = wg_is_contact(contact);

    // What is always there.
    observation->bump = bumped ? 1.0 : 0.0;
    observation->heading = (double)wg_turn_towards(0, state->heading) * radians;
    observation->x = (double)state->x * metres;
    observation->y = (double)state->y * metres;

    if ((senses & WG_SENSE_BUMP_BEARING) != 0) {
        observation->bump_bearing = 0.0;
        if (bumped) {
            int64_t wall =
                wg_heading_of((int64_t)(-contact.x * 1024.0), (int64_t)(-contact.y * 1024.0), state->heading);
            observation->bump_bearing = (double)wg_turn_towards(state->heading, wall) * radians;
        }
    }

    // The target and its signal.
    int64_t dx = settings->target_x - state->x;
    int64_t dy = settings->target_y - state->y;
    if ((senses & WG_SENSE_TARGET_DISTANCE) != 0) {
        observation->target_distance = sqrt((double)(dx * dx + dy * dy)) * metres;
    }
    if ((senses & WG_SENSE_TARGET_HEADING) != 0) {
        observation->target_heading = (double)wg_turn_towards(0, wg_heading_of(dx, dy, state->heading)) * radians;
    }
    if ((senses & WG_SENSE_SIGNAL) != 0) {
        observation->signal = wg_signal_here(arena, settings, state, step);
    }
    if ((senses & WG_SENSE_SIGNAL_HEADING) != 0) {
        int64_t strongest = wg_strongest_heading(arena, settings, state, step);
        observation->signal_heading = (double)wg_turn_towards(0, strongest) * radians;
    }

    // The controller's random number, and the clock.
    if ((senses & WG_SENSE_RANDOM) != 0) {
        double drawn = wg_random_draw(settings->seed, state->draws);
        double coin = (double)settings->coin;
        observation->random = settings->coin == 0 ? drawn : (double)wg_floor(drawn * coin) / coin;
    }
    if ((senses & WG_SENSE_TIME) != 0) {
        observation->time = (double)step * settings->time_step;
    }

    // Where the wheels say that it is: the truth, if they have no noise.
    if ((senses & WG_SENSE_ODOMETRY) != 0) {
        if (settings->odometry_noise > 0.0) {
            observation->odometry_x = odometry->x * metres;
            observation->odometry_y = odometry->y * metres;
            observation->odometry_heading =
                (double)wg_turn_towards(0, wg_floor(odometry->heading + 0.5)) * radians;
        } else {
            observation->odometry_x = observation->x;
            observation->odometry_y = observation->y;
            observation->odometry_heading = observation->heading;
        }
    }
    if ((senses & WG_SENSE_BEAMS) != 0) {
        wg_sense_beams(arena, settings, state, step, beams);
    }
}

#endif

// Episodes of many robots in lockstep whose commands come from outside, as in environments for
// reinforcement learning: act, move, sense, reward, and restart, in one call.
//
// Each robot's steps are those of a controller in an episode: a first move at standstill before
// anything is sensed, then alternating commands and moves. Arrays belong to the caller.

#ifndef WG_NAVIGATE_H
#define WG_NAVIGATE_H

#include <stdint.h>

#include "wg_episode.h"
#include "wg_sim.h"

// The senses that an environment shows, in its own order.
enum {
    WG_SHOW_BUMP = 0,
    WG_SHOW_BUMP_DIRECTION = 1,
    WG_SHOW_SIGNAL = 2,
    WG_SHOW_SIGNAL_DIRECTION = 3,
    WG_SHOW_TARGET_DIRECTION = 4,
    WG_SHOW_TARGET_DISTANCE = 5,
    WG_SHOW_HEADING = 6,
    WG_SHOW_POSITION = 7,
    WG_SHOW_ODOMETRY = 8,
    WG_SHOW_BEAMS = 9,
    WG_SHOW_GOAL_DIRECTION = 10,
    WG_SHOW_TILT = 11,
};

// When the next episode begins: in the step after the last one, in the same step,
// or on the caller's request.
enum { WG_NEXT_STEP = 0, WG_SAME_STEP = 1, WG_NO_AUTORESET = 2 };

// Constants for the numbers of observations, commands and rewards.
typedef struct WgRules {
    double extent;      // m: length that counts as 1 in distances
    double beam_range;  // m: length that counts as 1 in range beams
    double turn_rate;   // rad/s: turn rate that counts as 1 in actions
    double slowest;     // smallest share of the top speed that an action may request
    double progress;    // reward per metre of progress towards the target
    double time;        // for a second
    double contact;     // reward for a step in which a wall stopped or bent the move
    double reached;
    double burned;
    int64_t limit;      // steps until an episode is cut off; 0: never
    int64_t autoreset;  // WG_NEXT_STEP, ...
} WgRules;

// A world for robots.
typedef struct WgPlace {
    WgArena arena;        // before its first event; not changed
    WgSettings settings;  // the seed is each robot's own
    // (waypoints + 1, 2 height + 1, 2 width + 1) m, length of the shortest path to each goal from each
    // node at half a cell, infinite if there is none; NULL: distances are straight
    const float *ways;
} WgPlace;

// Settings shared by n robots, and the robots' own data.
typedef struct WgCrew {
    int64_t count;
    const WgRules *rules;
    const int64_t *sensors;   // (sensor_count,) WG_SHOW_BUMP, ...
    int64_t sensor_count;
    int64_t size;             // numbers of an observation
    // (choice_count, 2) discrete actions: shares of the turn rate and of the top speed
    const double *choices;
    int64_t choice_count;     // 0 for continuous actions
    WgPlace *places;
    int64_t place_count;
    WgWorkspace workspace;
    uint8_t *cells;           // (count, page) if worlds change: each robot's own; else NULL
    int32_t *near;            // same
    int64_t page;             // cells of the largest world
    WgRobot *robots;          // (count,) without memories
    int64_t *world;           // (count,)
    uint64_t *seed;           // (count,) seed of each robot's episodes
    int64_t *episode;         // (count,) number of the episode
    int64_t *run;             // (count,) seed of its run
    int64_t *clock;           // (count,) steps of the simulator
    int64_t *elapsed;         // (count,) actions in this episode
    double *distance;         // (count,) m, to the target, through the waypoints that are left
    int64_t *passed;          // (count,) waypoints that it has arrived at
    uint8_t *over;            // (count,) 1 if the episode has ended
} WgCrew;

// The results of a step for each robot.
typedef struct WgTold {
    float *observation;   // (count, size)
    double *reward;       // (count,)
    uint8_t *terminated;  // (count,) 1 if it arrived, burned, or touched a wall that it may not touch
    uint8_t *truncated;   // (count,) 1 if its time is over
    uint8_t *reached;     // (count,) 1 if it arrived
    uint8_t *began;       // (count,) 1 if the observation is the first of an episode
    // (count, size) the last observation of an episode after which the next began in the same step;
    // only for WG_SAME_STEP
    float *last;
} WgTold;

// Fills an environment's observation, (size,), with the simulator's senses that it shows.
void wg_show(const WgObservation *seen, const int64_t *sensors, int64_t sensor_count, const WgRules *rules, float *shown);

// Returns the index of the world that an episode is in.
int64_t wg_world_of_episode(uint64_t seed, int64_t episode, int64_t count);

// Seed of an episode's run, from which noise is drawn: 53 bits.
int64_t wg_run_of_episode(uint64_t seed, int64_t episode);

// Gives the robots their states (count,), and one chain that is long enough for any step of any
// robot.
void wg_crew_robots(WgCrew *crew, WgState *states, WgCarriage *carriages, WgCorner *chain);

// Puts a robot at the start of its episode in a world, and observes: (size,).
void wg_crew_begin(WgCrew *crew, int64_t robot, int64_t world, float *observation);

// The same for each robot whose entry in `which` (count,) isn't 0, in the world that its seed
// chooses. Seeds and episode numbers must be set. Their rows of (count, size) observations are
// filled.
void wg_crew_begin_many(WgCrew *crew, const uint8_t *which, float *observations);

// One action of each robot: (count,) discrete ones, or (count, 2) continuous ones;
// the other is NULL.
WgStatus wg_crew_step(WgCrew *crew, const int64_t *chosen, const float *moves, const WgTold *told);

#endif

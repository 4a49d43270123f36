// The C core of the simulator.
//
// A robot moves on a lattice of poses: WG_UNIT units per cell, WG_TURN headings per turn. x runs
// right, y up; cells are stored row by row, from the lowest. Arrays belong to the caller, and no
// function keeps an address after it returns.

#ifndef WG_SIM_H
#define WG_SIM_H

#include <stdint.h>

#include "wg_types.h"
#include "worldgen_controller.h"

enum {
    WG_UNIT = 1024,         // lattice units per cell
    WG_UNIT_BITS = 10,
    WG_TURN = 65536,        // heading units per turn
    WG_SPEED_UNIT = 65536,  // speed of one lattice unit per step
    WG_NEAR = 2,            // number of cells that a mask of WgArena.near covers to each side
    WG_MOST_FOOTPRINT = 16,  // corners of a body
    WG_MOST_WAYPOINTS = 64,  // goals before the target
};

// The state of a cell.
enum { WG_FREE = 0, WG_SOLID = 1, WG_BURNING = 2 };

// How an episode ends.
enum {
    WG_LIMIT = 0,  // the budget is spent
    WG_REACHED = 1,
    WG_LOOP = 2,
    WG_TUNNEL = 3,
    WG_BURNED = 4,
    WG_INVALID_COMMAND = 5,
    // the controller set WgCommand.error; that step ends there, neither recorded nor hashed
    WG_CRASH = 6,
    WG_COVERED = 7,  // the robot's centre has been in every cell of WgArena.wanted
    WG_COLLISION = 8,  // fleets under WG_ENDPOINT only: two robots' paths crossed
    WG_CONTACT = 9,    // a wall cut a move short, which WG_CONTACT_FAIL forbids
};

// Motion models on the lattice.
enum { WG_SWEPT = 0, WG_ENDPOINT = 1 };

// When the robot has arrived. In all cases it heads within the goal's tolerance, if the goal has a
// heading.
enum {
    WG_ARRIVAL_TOUCH = 0,  // its path meets the target's disc
    WG_ARRIVAL_STEP = 1,   // a step ends in the target's disc
    // it is in the target's disc when the controller has acted, and hardly moves or turns
    WG_ARRIVAL_STOP = 2,
};

// What a wall does to a move that it cuts short.
enum {
    WG_CONTACT_SLIDE = 0,  // the robot spends the rest along the wall
    WG_CONTACT_STOP = 1,   // the rest is lost
    WG_CONTACT_FAIL = 2,   // the same, and the run ends as WG_CONTACT
};

// The effect of walls on the target's signal.
enum { WG_SIGNAL_OPEN = 0, WG_SIGNAL_WEAKENED = 1, WG_SIGNAL_BLOCKED = 2 };

// How a recurrence of the complete state ends an episode.
enum {
    WG_NO_LOOP = 0,     // it is not searched
    WG_SEEK_LOOP = 1,   // when it is found, in the last step of the budget at the latest
    // in the last step of the budget, if its state is that of step WgSettings.loop_entry
    WG_PROVE_LOOP = 2,
};

// A change of one cell. As rows of (n, 5) int64 in Python.
typedef struct WgEvent {
    int64_t step;   // the step in which it happens
    int64_t time;   // its time in that step, 2^-32 steps
    int64_t ix;
    int64_t iy;
    int64_t state;  // what the cell becomes
} WgEvent;

// A push: the robot is displaced, only along a clear path, and turned. As rows of (n,
// 6) int64 in Python.
typedef struct WgPush {
    // the step at whose end it happens; 0: each step that ends with the centre in a cell
    int64_t step;
    int64_t ix;    // that cell; -1 for a push at a time
    int64_t iy;
    int64_t dx;    // lattice units
    int64_t dy;
    int64_t turn;  // heading units
} WgPush;

// Another source of the signal, which is not the target.
typedef struct WgDecoy {
    int64_t x;  // lattice units
    int64_t y;
    double strength;  // the target's is 1
} WgDecoy;

// A corner of the path of one step.
typedef struct WgCorner {
    int64_t x;     // lattice units
    int64_t y;
    int64_t time;   // in the step, 2^-32 steps
} WgCorner;

// Direction away from the obstacle that the robot touched, of any length; (0, 0) if none.
typedef struct WgNormal {
    double x;
    double y;
} WgNormal;

// A corner of a recorded path. As rows of (n, 4) int64 in Python.
typedef struct WgPathPoint {
    int64_t step;
    int64_t time;   // in the step, 2^-32 steps
    int64_t x;     // lattice units
    int64_t y;
} WgPathPoint;

// A direction in the first eighth of a turn.
typedef struct WgRay {
    double share[2];  // share of a length along the x axis, and across it
    int64_t slope;    // the first divided by the second, 2^-32, rounded down; 0 on the axis
} WgRay;

// Another robot, as sensors see it.
typedef struct WgOther {
    int64_t x;         // lattice units
    int64_t y;
    int64_t away_sq;   // squared distance to the robot that senses it
    double radius;     // lattice units
    int64_t spot;      // its index among the robots sorted for sensing
} WgOther;

// The robots around a robot.
typedef struct WgOthers {
    const WgOther *robots;  // (count,)
    int64_t count;
} WgOthers;

// A convex polygonal body: its corners in the robot's frame, counter-clockwise, lattice units. The
// origin is the point that the pose is about, x is ahead and y to the left.
typedef struct WgFootprint {
    int64_t count;  // corners; 0: the robot is a disc
    int64_t x[WG_MOST_FOOTPRINT];
    int64_t y[WG_MOST_FOOTPRINT];
} WgFootprint;

// A goal: a disc for the robot's centre, and what counts as arriving there.
typedef struct WgGoal {
    int64_t x;  // lattice units
    int64_t y;
    int64_t radius_sq;
    int64_t arrival;            // WG_ARRIVAL_TOUCH, ...
    int64_t has_heading;        // 1: it asks for a heading
    int64_t heading;            // heading units
    int64_t heading_tolerance;  // same
    int64_t arrival_speed;      // for WG_ARRIVAL_STOP: largest speed, units of speed
    int64_t arrival_turn;       // and largest turn in a step, heading units
} WgGoal;

// The robot's surroundings. `cells`, `near` and `visited` change during an episode.
typedef struct WgArena {
    int64_t width;   // cells
    int64_t height;
    uint8_t *cells;            // (height, width) WG_FREE, WG_SOLID or WG_BURNING
    int32_t *near;             // (height, width) masks of the neighbourhood: wg_near_masks
    // (height, width) chessboard distance to cells that are ever not free; NULL where the masks
    // reach as far as any step
    int32_t *clearance;
    const WgEvent *events;     // sorted by step and time
    int64_t event_count;
    const int64_t *headings;   // (131072,) cosines and sines, 2^-30: sim/motion's heading table
    uint8_t *visited;          // (height, width) 1 where the centre has been
    // (height, width) 1: a coverage task wants the centre to be there; NULL for other tasks
    const uint8_t *wanted;

    // Tables for range beams in a world that does not change; with them a run takes a third of the
    // time. Otherwise all three are NULL.
    const WgRay *rays;      // (8193,) wg_ray_table
    const int64_t *spread;  // (beams,) wg_beam_spread
    const uint16_t *runs;   // (height + 2, width + 2, 4) wg_free_runs

    const WgOthers *others;  // the robots that range beams may hit; NULL for a single robot
} WgArena;

// The settings of an episode, and the robot's dynamics and sensors. A limit that is off is
// infinite.
typedef struct WgSettings {
    // The start, lattice and heading units.
    int64_t start_x;
    int64_t start_y;
    int64_t start_heading;

    WgGoal target;           // the last goal
    int64_t waypoint_count;  // the number of goals before it: `waypoints`, below

    int64_t contact;  // WG_CONTACT_SLIDE, ...
    int64_t reverse;  // 1: a car may drive backwards

    // The disc: its squared radius, lattice units; the radius rounded up.
    int64_t clear_sq;
    int64_t reach;
    WgFootprint footprint;  // its body; then the disc is the smallest about the origin that holds it

    // The run.
    int64_t motion;      // WG_SWEPT or WG_ENDPOINT
    int64_t steps;       // budget
    int64_t find_loop;   // WG_NO_LOOP, WG_SEEK_LOOP or WG_PROVE_LOOP
    int64_t loop_entry;  // for WG_PROVE_LOOP
    uint64_t seed;       // seed of the draws
    int64_t digest;      // 1: compute the digest of the trace
    int64_t senses;      // WG_SENSE_ bits: what the controller senses

    // What moves the robot besides its wheels: see wg_disturb.
    int64_t disturbed;     // 1: something does
    int64_t measures;      // 1: odometry may differ from the pose
    int64_t drift_x;       // what a tilted floor adds to each step, lattice units
    int64_t drift_y;
    int64_t drift_reach;   // its length, rounded up
    const WgPush *pushes;  // (push_count,) first those at places, then those at times, by step
    int64_t push_count;
    int64_t place_count;   // number of pushes at places

    // Sensors.
    const WgDecoy *decoys;  // (decoy_count,)
    int64_t decoy_count;
    int64_t sensor_cells;  // number of cells around it that the signal sensor sees
    int64_t signal;        // WG_SIGNAL_OPEN, ...
    int64_t beams;
    int64_t neighbours;    // limit on the other robots that it senses
    int64_t plain_sensor;  // 1: the signal sensor is the thesis's, without noise or limits
    int64_t smoke_reach;   // cells around a burning one that its smoke fills

    // Between the lattice and SI units.
    double metres;          // m per lattice unit
    double speed;           // lattice units per step at 1 m/s
    double turn;            // heading units per step at 1 rad/s
    double radians;         // rad per heading unit
    double time_step;       // s
    double top_speed;       // m/s
    double turning_radius;  // m, of a car; 0: it turns on the spot
    double turn_per_unit;   // heading units that a car turns, at most, on a lattice unit of its path; 0: it is no car
    double steering_rate;   // largest change of a car's curvature, as a share of the largest, 1/s
    double radius;          // m, of the robot
    double start_speed;     // m/s during the first step, before the controller has sensed anything
    double tolerance;       // overlap that is not reported, lattice units

    // Dynamics.
    double turn_limit;      // rad/s
    double gain;            // largest gain of speed in a step, units of speed
    double loss;            // largest loss, same
    double wall_friction;   // share of a slide that is lost to a wall
    double slip;            // largest share of a step that is lost to slip
    double odometry_noise;  // largest share by which a measured distance or turn is wrong

    // Sensors, continued.
    double sensor_range;  // lattice units
    double sensor_field;  // half the angle that the signal sensor looks into, heading units
    double sensor_noise;  // largest share by which a reading is wrong
    double smoke;         // share of the signal that a cell in smoke absorbs
    double neighbour_range;  // lattice units, from centre to centre; 0: no other robot is sensed
    double beam_range;    // lattice units
    // angle between the first and the last beam, heading units; a whole turn: evenly all around
    double beam_field;
    double beam_noise;    // largest share by which a distance is wrong
    double beam_dropout;  // probability that a beam returns nothing

    // Goals before the target, in the order in which the robot must arrive at them.
    WgGoal waypoints[WG_MOST_WAYPOINTS];
} WgSettings;

// The complete state after a step, without the controller's memory: what a recurrence must repeat.
typedef struct WgState {
    int64_t x;        // lattice units
    int64_t y;
    int64_t heading;  // heading units, in [0, WG_TURN)
    int64_t speed;    // speed of the wheels, WG_SPEED_UNIT per lattice unit and step
    int64_t draws;    // random numbers that the controller has used so far
} WgState;

// The result of an episode.
typedef struct WgReport {
    int64_t ending;  // WG_LIMIT, ...
    int64_t steps;
    int64_t period;
    int64_t collisions;
    int64_t last_new_cell;  // the last step that entered a cell for the first time
    int64_t points;         // points of the path after the start
    int64_t cells_visited;  // cells that the centre has been in, including the start's
    int64_t cells_left;     // cells that a coverage task still requires
    int64_t goals;          // goals that the robot has arrived at
    uint64_t digest;        // rolling FNV-1a hash of every state
    int64_t hit_step;       // step of a WG_TUNNEL, WG_BURNED or WG_CONTACT; otherwise -1
    int64_t hit_ix;
    int64_t hit_iy;
    // WG_SOLID (debris) or WG_BURNING of the cell that ended the run as WG_BURNED
    int64_t hit_state;
    int64_t overlap_step;   // first cut that is deeper than the tolerance; -1
    int64_t overlap_ix;
    int64_t overlap_iy;
    // for WG_CRASH: the controller's WgCommand.error if it set one, else NULL
    const char *error;
    double path_length;     // lattice units
    double overlap;         // deepest cut, lattice units
} WgReport;

// fdlibm.c

// Sine, cosine and arc tangent of many numbers, with fdlibm's bits. All arrays: (count,).
void wg_trigonometry(const double *x, int64_t count, double *sines, double *cosines, double *arc_tangents);

#endif

// The interface of a controller written in C or C++: what it observes and what it commands.
//
// A shared library offers a controller with WG_CONTROLLER, and it runs as
// `--controller lib:./robot.so:act`:
//
//     cc -std=c17 -O2 -shared -fPIC -I"$(worldgen --include)" robot.c -o robot.so
//
// Unless noted otherwise, angles are radians, counter-clockwise, in (-pi, pi], and 0 is the x axis.
// x points right, y points up, and positions are metres in the world's frame.

#ifndef WORLDGEN_CONTROLLER_H
#define WORLDGEN_CONTROLLER_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

// The version of this interface. A library built with another version is refused.
enum { WG_CONTROLLER_ABI = 1 };

// The largest number of range beams that a robot can have.
enum { WG_MOST_BEAMS = 1000 };

// The largest number of other robots that a robot can sense, and of numbers in a message.
enum { WG_MOST_NEIGHBOURS = 64, WG_MOST_MESSAGE = 8 };

// Senses that take time to compute, or that rule out proofs. All other fields are always available.
enum {
    WG_SENSE_BUMP_BEARING = 1,
    WG_SENSE_SIGNAL = 2,
    WG_SENSE_SIGNAL_HEADING = 4,
    WG_SENSE_TARGET_HEADING = 8,
    WG_SENSE_TARGET_DISTANCE = 16,
    WG_SENSE_RANDOM = 32,
    WG_SENSE_TIME = 64,
    WG_SENSE_ODOMETRY = 128,
    WG_SENSE_BEAMS = 256,
    WG_SENSE_NOTHING_ELSE = 512,  // only the fields that are always available
    WG_SENSE_NEIGHBOURS = 1024,   // and the messages that they sent
    WG_SENSE_GOAL_HEADING = 2048, // always available here; a flat array ends with it if declared
    WG_SENSE_TILT = 4096,         // the same: a flat array ends with tilt, its heading and the goal's
};

// Another robot within the range that a run gives this sense, relative to the robot that senses it.
typedef struct WgNeighbour {
    double x;                         // m: ahead of the robot
    double y;                         // m: to its left
    double heading;                   // rad: the neighbour's heading, relative to the robot's
    double speed;                     // m/s: of the neighbour along its heading
    double radius;                    // m: of the neighbour
    // sent by the neighbour in the step before; zeros without a channel
    double message[WG_MOST_MESSAGE];
} WgNeighbour;

// What a controller observes after each step. A sense that it does not declare may be NaN.
typedef struct WgObservation {
    double bump;              // 1 if a wall or a robot stopped or bent the last move, else 0
    double bump_bearing;      // rad: direction of that contact, relative to the robot's heading
    // strength of the target's signal: 1 / (1 + squared distance in cells)
    double signal;
    // rad: world heading towards the neighbouring cell with the strongest signal
    double signal_heading;
    double heading;           // rad: the robot's world heading
    double x;                 // m: the robot's centre
    double y;                 // m
    double target_heading;    // rad: world heading towards the target
    double target_distance;   // m: distance to the target's centre
    // the next random number in [0, 1); set WgCommand.used_random to use it up
    double random;
    double time_step;         // s: duration of a step
    double top_speed;         // m/s: the robot's speed limit
    double radius;            // m: the robot's radius
    double time;              // s: time since the start of the episode
    double odometry_x;        // m: the robot's position as its wheels measure it
    double odometry_y;        // m
    double odometry_heading;  // rad: its heading as its wheels measure it
    // m: distance to the first wall or robot along each range beam, counter-clockwise
    const double *beams;
    int64_t beam_count;       // length of `beams`
    // other robots within range, the nearest first; NULL if there can be none
    const WgNeighbour *neighbours;
    int64_t neighbour_count;        // length of `neighbours`
    int64_t message_size;           // numbers that a message has; 0 without a channel
    double goal_heading;      // rad: world heading that the robot must have on arrival; NaN if any
    double tilt;              // m/s: speed at which the tilted floor carries the robot; 0 if level
    double tilt_heading;      // rad: world heading in which it does; 0 if level
} WgObservation;

// What a controller commands. All fields are zero (NULL) when the controller is called.
typedef struct WgCommand {
    double speed;        // m/s along the heading, negative for backwards; clamped to the top speed
    // rad/s, counter-clockwise; takes effect before the next move. A step turns by at most half a
    // turn either way, or by the run's turn_limit, so wrap an angle before you divide it by the
    // time step.
    double turn_rate;
    double used_random;  // 1 if WgObservation.random was used, so that the next one must be new
    // NULL, or "Name: sentence" that outlives the run, which then ends as a crash of that name
    const char *error;
    // (WgObservation.message_size,) zeros, to be sent to the neighbours, finite; NULL without a
    // channel
    double *message;
} WgCommand;

// Acts for one step. All of the controller's state is in `memory`, whose size it declares;
// only then are loops proved.
typedef void (*WgAct)(const WgObservation *observation, double *memory, WgCommand *command);

// Fills the memory at the start of an episode, the same each time.
// The memory is all zeros when this is called.
typedef void (*WgReset)(double *memory);

// What a library declares about a controller. Fields that it omits are 0,
// with the meaning given here.
typedef struct WgControllerInfo {
    uint32_t abi;         // WG_CONTROLLER_ABI
    uint32_t size;        // sizeof(WgControllerInfo)
    WgAct act;            // called once per step
    WgReset reset;        // NULL: the memory begins as zeros
    int64_t memory_size;  // length of the memory, in doubles
    // WG_SENSE_ bits of the fields that it reads; 0: all but the time. The loops of a controller
    // that reads the time cannot be proved
    int64_t senses;
    // number of range beams that it needs, at most WG_MOST_BEAMS; a run can override it
    int64_t beams;
    double beam_range;    // m: range of beams that it needs; 0: the simulator's default
    double start_speed;   // m/s: speed in the first step, before it has observed anything
    double neighbour_range;  // m: range within which it needs to sense other robots; 0: not at all
    int64_t message;         // numbers in each message that it sends, at most WG_MOST_MESSAGE
} WgControllerInfo;

#ifdef __cplusplus
}
#endif

#if defined(_WIN32)
#define WG_VISIBLE __declspec(dllexport)
#else
#define WG_VISIBLE __attribute__((visibility("default")))
#endif
#ifdef __cplusplus
#define WG_EXPORT extern "C" WG_VISIBLE
#else
#define WG_EXPORT WG_VISIBLE
#endif

// Offers the function `name`, a WgAct, as the controller `lib:./robot.so:name`. The other arguments
// set fields of WgControllerInfo, in their order:
//
//     WG_CONTROLLER(act, .memory_size = 2, .senses = WG_SENSE_TARGET_HEADING | WG_SENSE_BEAMS, .beams = 36)
//
// In C++ this needs C++20.
#define WG_CONTROLLER(name, ...)                              \
    WG_EXPORT const WgControllerInfo *name##_controller(void) \
    {                                                         \
        static const WgControllerInfo info = {                \
            .abi = WG_CONTROLLER_ABI,                         \
            .size = sizeof(WgControllerInfo),                 \
            .act = name,                                      \
            __VA_ARGS__                                       \
        };                                                    \
        return &info;                                         \
    }

#endif

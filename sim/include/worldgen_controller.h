// What a controller written in C or C++ sees and commands.
//
// A shared library offers one with WG_CONTROLLER, and runs as `--controller lib:./robot.so:act`:
//
//     cc -std=c17 -O2 -shared -fPIC -I"$(worldgen --include)" robot.c -o robot.so
//
// Angles are radians, counter-clockwise, in (-pi, pi] where not said otherwise; 0 is the x axis. x runs right, y up.

#ifndef WORLDGEN_CONTROLLER_H
#define WORLDGEN_CONTROLLER_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

// The version of this interface. A library that was built with another one is refused.
enum { WG_CONTROLLER_ABI = 1 };

// Range beams that a robot can have.
enum { WG_MOST_BEAMS = 1000 };

// Senses that cost time, or proofs. The others are always there: bump, heading, x, y, and what the robot is.
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
    WG_SENSE_NOTHING_ELSE = 512,  // only what is always there
};

// What a controller senses after each step. A sense that it does not declare may be NaN.
typedef struct WgObservation {
    double bump;              // 1 if a wall stopped or bent the last move, else 0
    double bump_bearing;      // rad: direction of that contact, relative to the robot's heading
    double signal;            // strength of the target's signal: 1 / (1 + squared distance in cells)
    double signal_heading;    // rad: world heading towards the neighbouring cell with the strongest signal
    double heading;           // rad: the robot's own
    double x;                 // m
    double y;                 // m
    double target_heading;    // rad: world heading towards the target
    double target_distance;   // m, to the target's centre
    double random;            // the next random number in [0, 1); set WgCommand.used_random to use it up
    double time_step;         // s: duration of a step
    double top_speed;         // m/s: the robot's limit
    double radius;            // m: the robot's
    double time;              // s since the start
    double odometry_x;        // m: own pose, as the wheels measure it
    double odometry_y;        // m
    double odometry_heading;  // rad
    const double *beams;      // m: distance to the first wall along each range beam
    int64_t beam_count;
} WgObservation;

// What a controller asks for. All zero (NULL) when the controller is called.
typedef struct WgCommand {
    double speed;        // m/s along the heading, negative for backwards; clamped to the top speed
    double turn_rate;    // rad/s, counter-clockwise; takes effect before the next move
    double used_random;  // 1 if WgObservation.random was used, so that the next one is fresh
    const char *error;   // set to a sentence that outlives the run, it ends the run as a crash
} WgCommand;

// One step of a controller. All of its state is in `memory`, whose size it declares; a loop is proved only then.
typedef void (*WgAct)(const WgObservation *observation, double *memory, WgCommand *command);

// Fills the memory at the start of an episode, the same each time; it is all zero when this is called.
typedef void (*WgReset)(double *memory);

// What a library says about a controller. Fields that it leaves out are 0, and mean what is said here.
typedef struct WgControllerInfo {
    uint32_t abi;         // WG_CONTROLLER_ABI
    uint32_t size;        // sizeof(WgControllerInfo)
    WgAct act;
    WgReset reset;        // NULL: the memory begins as zeros
    int64_t memory_size;  // numbers
    int64_t senses;       // WG_SENSE_ bits of what it looks at; 0: all but the time. A loop of a controller that looks at
                          // the time cannot be proved
    int64_t beams;        // range beams that it needs, at most WG_MOST_BEAMS; a run can say otherwise
    double beam_range;    // m, that it needs; 0: the simulator's default
    double start_speed;   // m/s in the first step, before it has sensed anything
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

// Offers the function `name`, a WgAct, as the controller `lib:./robot.so:name`. What follows are fields of
// WgControllerInfo, in their order:
//
//     WG_CONTROLLER(act, .memory_size = 2, .senses = WG_SENSE_TARGET_HEADING | WG_SENSE_BEAMS, .beams = 36)
//
// In C++ this takes C++20.
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

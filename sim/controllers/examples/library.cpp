// A controller in C++, as fast as the simulator itself. Build it and try it with:
//
//     c++ -std=c++20 -O2 -shared -fPIC -I"$(worldgen --include)" example.cpp -o example.so
//     worldgen run w.grid --controller lib:./example.so:example --picture run.png

#include <cmath>
#include <numbers>

#include "worldgen_controller.h"

namespace {

constexpr double pi = std::numbers::pi;
constexpr double turn_after_bump = 1.5;  // rad, counter-clockwise
constexpr double patience = 20.0;        // steps to drive straight on before heading for the target again

// All of its state. A static variable would hide state, and make proofs of loops wrong.
struct Memory {
    double waiting;  // steps left to drive straight on
};

// Drive one step: head for the target, and after a bump turn away for a while. It must not throw.
void example(const WgObservation *seen, double *memory, WgCommand *command) noexcept
{
    auto &own = *reinterpret_cast<Memory *>(memory);

    // After a bump, turn away, and then drive straight on for some steps.
    double turn = 0.0;
    if (seen->bump != 0.0) {
        turn = turn_after_bump;
        own.waiting = patience;
    } else if (own.waiting > 0.0) {
        own.waiting -= 1.0;
    } else {
        // Turn towards the target, the shorter way around.
        turn = std::remainder(seen->target_heading - seen->heading, 2.0 * pi);
    }

    // A turn rate of turn / time_step completes the turn within this step.
    command->speed = seen->top_speed;
    command->turn_rate = turn / seen->time_step;
}

}  // namespace

// It senses the target's heading and what costs no time. For another sense, such as target_distance, add
// its WG_SENSE_ bit: a sense that is not declared is NaN. Without .senses, it senses everything.
WG_CONTROLLER(example, .memory_size = sizeof(Memory) / sizeof(double), .senses = WG_SENSE_TARGET_HEADING)

// A controller in C++: as fast as the simulator itself. Build it, try it, change it, try it again:
//
//     c++ -std=c++20 -O2 -shared -fPIC -I"$(worldgen --include)" example.cpp -o example.so
//     worldgen run w.grid --controller lib:./example.so:example --trail run.png

#include <cmath>
#include <numbers>

#include "worldgen_controller.h"

namespace {

constexpr double pi = std::numbers::pi;
constexpr double turn_after_bump = 1.5;  // rad, counter-clockwise
constexpr double patience = 20.0;        // steps for which it drives on before it looks at the target again

// All of its state: a variable that outlives the function would make proofs of loops wrong.
struct Memory {
    double waiting;  // steps still to drive on
};

// One step: drives to the target; after a bump turns away and drives straight on for a while. It must not throw.
void example(const WgObservation *seen, double *memory, WgCommand *command) noexcept
{
    auto &own = *reinterpret_cast<Memory *>(memory);
    double turn = 0.0;
    if (seen->bump != 0.0) {
        turn = turn_after_bump;
        own.waiting = patience;
    } else if (own.waiting > 0.0) {
        own.waiting -= 1.0;
    } else {
        turn = std::remainder(seen->target_heading - seen->heading, 2.0 * pi);
    }
    command->speed = seen->top_speed;
    command->turn_rate = turn / seen->time_step;
}

}  // namespace

WG_CONTROLLER(example, .memory_size = sizeof(Memory) / sizeof(double), .senses = WG_SENSE_TARGET_HEADING)

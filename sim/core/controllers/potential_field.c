// Potential field: the target attracts, walls repel, and the robot drives down the slope.
//
// Source: Oussama Khatib, "Real-time obstacle avoidance for manipulators and mobile robots", The
// International Journal of Robotics Research 5(1), 1986: the attraction of equation 10 with the
// limited speed of equation 13, and the repulsion "FIRAS" of equation 18, summed over obstacles. A
// robot with range beams treats the ends of those beams that are shorter than their neighbours as
// its obstacles.

#include "directions.h"
#include "library.h"

// m: the repulsion stops growing at this gap, so that it is never infinite
static const double NEAREST = 0.004;

const WgPotentialField wg_potential_field_default = {
    .pull = 1.0,
    .far = 0.5,
    .push = 2.5e-5,
    .influence = 0.15,
    .full_force = 0.25,
};

// Khatib's equation 18 for a gap in m.
static double push_of(double gap, const WgPotentialField *tuned)
{
    if (gap >= tuned->influence) {
        return 0.0;
    }
    double near = wg_higher(gap, NEAREST);
    return tuned->push * (1.0 / near - 1.0 / tuned->influence) / (near * near);
}

// One step: sums the forces in the robot's frame and drives along the sum.
static void drive(const WgObservation *seen, WgCommand *command, const WgPotentialField *tuned)
{
    int64_t beams = seen->beam_count;
    double towards = wg_target_bearing(seen);
    double pull = tuned->pull * wg_lower(seen->target_distance, tuned->far);
    double force_x = pull * wg_cos(towards);
    double force_y = pull * wg_sin(towards);
    double nearest = INFINITY;
    for (int64_t beam = 0; beam < beams; beam++) {
        double distance = seen->beams[beam];
        double before = seen->beams[beam > 0 ? beam - 1 : beams - 1];
        double after = seen->beams[beam + 1 < beams ? beam + 1 : 0];
        nearest = wg_lower(nearest, distance);
        if (distance < before && distance <= after) {
            double push = push_of(distance - seen->radius, tuned);
            double angle = wg_bearing_of(beam, beams);
            force_x -= push * wg_cos(angle);
            force_y -= push * wg_sin(angle);
        }
    }

    // Move at most half the gap in a step, because the slope of the repulsion changes within
    // millimetres there.
    double force = sqrt(force_x * force_x + force_y * force_y);
    double careful = wg_higher(nearest - seen->radius, NEAREST) / (2.0 * seen->time_step);
    double speed = seen->top_speed * wg_lower(force / tuned->full_force, 1.0);
    wg_steer(seen, command, wg_angle_of(force_x, force_y), wg_lower(speed, careful));
}

void wg_potential_field_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    (void)memory;
    drive(seen, command, &wg_potential_field_default);
}

void wg_potential_field_tuned_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    drive(seen, command, (const WgPotentialField *)memory);
}

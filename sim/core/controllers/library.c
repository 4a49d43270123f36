#include "library.h"

#include <stddef.h>
#include <string.h>

typedef struct Named {
    const char *name;
    WgAct act;
} Named;

static const Named LIBRARY[] = {
    {"bug1", wg_bug1_act},
    {"bug2", wg_bug2_act},
    {"composition", wg_composition_act},
    {"dynamic-window", wg_dynamic_window_act},
    {"dynamic-window-tuned", wg_dynamic_window_tuned_act},
    {"gestalt", wg_gestalt_act},
    {"mapper", wg_mapper_act},
    {"naive", wg_naive_act},
    {"orca", wg_orca_act},
    {"odometry-bug", wg_odometry_bug_act},
    {"potential-field", wg_potential_field_act},
    {"potential-field-tuned", wg_potential_field_tuned_act},
    {"q-learner", wg_q_learner_act},
    {"q-learning", wg_q_learning_act},
    {"q-learning-tuned", wg_q_learning_tuned_act},
    {"random-walk", wg_random_walk_act},
    {"right-hand", wg_right_hand_act},
    {"signal-mapper", wg_signal_mapper_act},
    {"signal-three-layer", wg_signal_three_layer_act},
    {"tangent-bug", wg_tangent_bug_act},
    {"three-layer", wg_three_layer_act},
    {"three-layer-tuned", wg_three_layer_tuned_act},
    {"topological", wg_topological_act},
    {"turn-left", wg_turn_left_act},
    {"turn-random", wg_turn_random_act},
    {"turn-right", wg_turn_right_act},
    {"vfh", wg_vfh_act},
    {"vfh-tuned", wg_vfh_tuned_act},
    {"wall", wg_wall_act},
};

WgAct wg_library_act(const char *name)
{
    for (size_t k = 0; k < sizeof LIBRARY / sizeof LIBRARY[0]; k++) {
        if (strcmp(LIBRARY[k].name, name) == 0) {
            return LIBRARY[k].act;
        }
    }
    return NULL;
}

// The acts of the library's controllers.

#ifndef WG_LIBRARY_H
#define WG_LIBRARY_H

#include "wg_controllers.h"

// The name of each controller, and its act.
#define WG_LIBRARY(ENTRY)                                        \
    ENTRY("bug1", wg_bug1_act)                                   \
    ENTRY("bug2", wg_bug2_act)                                   \
    ENTRY("composition", wg_composition_act)                     \
    ENTRY("dynamic-window", wg_dynamic_window_act)               \
    ENTRY("dynamic-window-tuned", wg_dynamic_window_tuned_act)   \
    ENTRY("gestalt", wg_gestalt_act)                             \
    ENTRY("mapper", wg_mapper_act)                               \
    ENTRY("naive", wg_naive_act)                                 \
    ENTRY("orca", wg_orca_act)                                   \
    ENTRY("odometry-bug", wg_odometry_bug_act)                   \
    ENTRY("potential-field", wg_potential_field_act)             \
    ENTRY("potential-field-tuned", wg_potential_field_tuned_act) \
    ENTRY("q-learner", wg_q_learner_act)                         \
    ENTRY("q-learning", wg_q_learning_act)                       \
    ENTRY("q-learning-tuned", wg_q_learning_tuned_act)           \
    ENTRY("random-walk", wg_random_walk_act)                     \
    ENTRY("right-hand", wg_right_hand_act)                       \
    ENTRY("scan-mapper", wg_scan_mapper_act)                     \
    ENTRY("signal-mapper", wg_signal_mapper_act)                 \
    ENTRY("signal-three-layer", wg_signal_three_layer_act)       \
    ENTRY("tangent-bug", wg_tangent_bug_act)                     \
    ENTRY("team-mapper", wg_team_mapper_act)                     \
    ENTRY("three-layer", wg_three_layer_act)                     \
    ENTRY("three-layer-tuned", wg_three_layer_tuned_act)         \
    ENTRY("topological", wg_topological_act)                     \
    ENTRY("turn-left", wg_turn_left_act)                         \
    ENTRY("turn-random", wg_turn_random_act)                     \
    ENTRY("turn-right", wg_turn_right_act)                       \
    ENTRY("vfh", wg_vfh_act)                                     \
    ENTRY("vfh-tuned", wg_vfh_tuned_act)                         \
    ENTRY("wall", wg_wall_act)

#define WG_DECLARE(name, act) void act(const WgObservation *seen, double *memory, WgCommand *command);
WG_LIBRARY(WG_DECLARE)
#undef WG_DECLARE

#endif

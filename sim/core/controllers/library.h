// The acts of the library's controllers.

#ifndef WG_LIBRARY_H
#define WG_LIBRARY_H

#include "wg_controllers.h"

void wg_bug1_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_bug2_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_composition_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_dynamic_window_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_dynamic_window_tuned_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_gestalt_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_mapper_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_naive_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_orca_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_odometry_bug_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_potential_field_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_potential_field_tuned_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_q_learner_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_q_learning_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_q_learning_tuned_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_random_walk_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_right_hand_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_signal_mapper_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_signal_three_layer_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_tangent_bug_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_three_layer_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_three_layer_tuned_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_topological_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_turn_left_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_turn_random_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_turn_right_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_vfh_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_vfh_tuned_act(const WgObservation *seen, double *memory, WgCommand *command);
void wg_wall_act(const WgObservation *seen, double *memory, WgCommand *command);

#endif

"""The library's controllers in plain Python: what each function of the core does, step by step."""

from tests.reference.sim.controllers import (
    behaviours,
    bug1,
    bug2,
    dynamic_window,
    mapper,
    potential_field,
    q_learner,
    q_learning,
    random_walk,
    reckoning,
    tangent_bug,
    thesis,
    three_layer,
    vfh,
    wall,
)

ACTS = {
    "bug1": bug1._act,
    "bug2": bug2._act,
    "composition": behaviours.act,
    "dynamic-window": dynamic_window.act,
    "mapper": mapper._act,
    "odometry-bug": reckoning.act_bug,
    "potential-field": potential_field.act,
    "q-learner": q_learner.act,
    "q-learning": q_learning.act,
    "random-walk": random_walk._act,
    "signal-mapper": reckoning.act_mapper,
    "signal-three-layer": reckoning.act_layers,
    "tangent-bug": tangent_bug._act,
    "three-layer": three_layer.act,
    "turn-left": thesis._act_left,
    "turn-random": thesis._act_random,
    "turn-right": thesis._act_right,
    "vfh": vfh.act,
    "wall": wall._act,
}
"""By the name that the core gives them."""

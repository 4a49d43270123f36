"""The trained policy as a controller.

It has the sensors of training, its weights, and chooses the action with the highest score.
"""

from pathlib import Path

import numpy as np

from worldgen_plugins.for_gymnasium import Interface

SEES = Interface(
    sensors=("target_direction", "target_distance", "bump", "beams"),
    actions="discrete",
    robot={"beams": 16, "beam_range": 2.0},
)


class Policy:
    """Two hidden layers, and the best of five actions."""

    senses = SEES.senses
    needs = SEES.needs

    def __init__(self):
        with np.load(Path(__file__).with_name("policy.npz")) as file:
            self.layers = [(file[f"w{k}"], file[f"b{k}"]) for k in (1, 2, 3)]

    def reset(self):
        return ()

    def act(self, observation, memory):
        (w1, b1), (w2, b2), (w3, b3) = self.layers
        hidden = np.maximum(w2 @ np.maximum(w1 @ SEES.observe(observation) + b1, 0.0) + b2, 0.0)
        return SEES.command(np.argmax(w3 @ hidden + b3), observation), memory

"""Adapt Gymnasium's vector environments to Stable-Baselines3.

Stable-Baselines3 has its own interface.
"""

import gymnasium
import numpy as np
from stable_baselines3.common.vec_env import VecEnv


class Vectorised(VecEnv):
    """A vector environment with autoreset in the same step."""

    def __init__(self, envs: gymnasium.vector.VectorEnv):
        assert envs.metadata["autoreset_mode"] is gymnasium.vector.AutoresetMode.SAME_STEP
        self.envs = envs
        self.actions = None
        super().__init__(envs.num_envs, envs.single_observation_space, envs.single_action_space)
        self.returns, self.lengths = np.zeros(self.num_envs), np.zeros(self.num_envs, int)

    def reset(self):
        self.returns[:] = 0.0
        self.lengths[:] = 0
        return self.envs.reset(seed=self._seeds[0], options=self._options[0] or None)[0]

    def step_async(self, actions):
        self.actions = actions

    def step_wait(self):
        observations, rewards, terminated, truncated, information = self.envs.step(self.actions)
        self.returns += rewards
        self.lengths += 1
        over = terminated | truncated
        told = [{} for _ in range(self.num_envs)]
        # Stable-Baselines3 expects the last observation and the episode's figures here.
        for k in np.flatnonzero(over):
            told[k] = {
                "terminal_observation": information["final_obs"][k],
                "TimeLimit.truncated": bool(truncated[k] and not terminated[k]),
                "is_success": bool(information["final_info"]["is_success"][k]),
                "episode": {"r": float(self.returns[k]), "l": int(self.lengths[k])},
            }
            self.returns[k] = 0.0
            self.lengths[k] = 0
        return observations, rewards.astype(np.float32), over, told

    def close(self):
        self.envs.close()

    def get_attr(self, attr_name, indices=None):
        return [getattr(self.envs, attr_name)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name, value, indices=None):
        setattr(self.envs, attr_name, value)

    def env_method(self, method_name, *method_args, indices=None, **method_kwargs):
        result = getattr(self.envs, method_name)(*method_args, **method_kwargs)
        return [result] * len(list(self._get_indices(indices)))

    def env_is_wrapped(self, wrapper_class, indices=None):
        return [False] * len(list(self._get_indices(indices)))

"""The single environment."""

from __future__ import annotations

from typing import Any, Unpack

import gymnasium
import numpy as np

from worldgen.domain import MASK64
from worldgen.random_streams import GAMMA, mix64
from worldgen.support.arrays import Bytes
from worldgen.world import World
from worldgen_plugins.for_gymnasium.actions import checked_actions
from worldgen_plugins.for_gymnasium.interface import Interface
from worldgen_plugins.for_gymnasium.lockstep import Lockstep
from worldgen_plugins.for_gymnasium.options import Options, resolve, sources_in
from worldgen_plugins.for_gymnasium.picture import RENDER_MODES, check_render_mode, frame_of
from worldgen_plugins.for_gymnasium.spaces import action_space, observation_space, shown

__all__ = ["NavigateEnv"]


class NavigateEnv(gymnasium.Env[Any, Any]):
    """A disc robot that should reach the target, in worlds in which it can.

    An episode ends when the robot arrives or burns. To truncate it, ``gymnasium.make`` wraps a time
    limit around the environment. ``docs/reference/environments.md`` describes observations
    and rewards.

    Args:
        render_mode: ``rgb_array``, ``ansi`` or ``None``.
        **options: See :class:`worldgen_plugins.for_gymnasium.options.Options`.

    Raises:
        WorldgenError: If an option is unknown or out of range, or a world cannot be read or made.
    """

    metadata: dict[str, Any] = {"render_modes": list(RENDER_MODES), "render_fps": 30}  # noqa: RUF012 - as in the base

    def __init__(self, render_mode: str | None = None, **options: Unpack[Options]) -> None:
        self._rules, self._supply = resolve(options)
        self.render_mode = check_render_mode(render_mode)
        self.observation_space = observation_space(self._rules)
        self.action_space = action_space(self._rules.interface)
        self._lockstep = Lockstep(self._rules, 1)
        self._places: list[tuple[float, float]] = []
        self._is_seeded = False

    @property
    def interface(self) -> Interface:
        """Sensors and actions, to give a controller the same ones."""
        return self._rules.interface

    @property
    def world(self) -> World:
        """The episode's world.

        Raises:
            gymnasium.error.ResetNeeded: Before the first reset.
        """
        if not self._lockstep.worlds:
            raise gymnasium.error.ResetNeeded("no episode has begun; call reset() first")
        return self._lockstep.worlds[0]

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin an episode.

        A seed starts a new series of episodes, which the seed decides; without one, this begins the
        next episode of the series.

        Args:
            seed: Seed for the choice of worlds and for the simulator's noise.
            options: The source of worlds from now on: ``{"world": w}``,
                ``{"difficulty": (0.4, 0.6)}``, ...

        Returns:
            The observation, and a dict with ``world``, the world's index, and ``run_seed``, the
            seed with which ``sim.simulate`` gives the same run.
        """
        super().reset(seed=seed)
        self._supply = self._supply.changed(sources_in(options))
        crew = self._lockstep.crew
        if seed is not None or not self._is_seeded:
            crew.seed[0] = seed_of(self.np_random)
            crew.episode[0] = 0
            self._is_seeded = True
        else:
            crew.episode[0] += 1

        # Only this episode's world is loaded, so it is number 0 for the core.
        index = world_of_episode(int(crew.seed[0]), int(crew.episode[0]), len(self._supply))
        self._lockstep.load([self._supply[index]])
        out = self._lockstep.begin(0, 0)
        self._places = []
        self._note_place()
        return shown(self._rules, out), {
            "world": index,
            "run_seed": int(self._lockstep.crew.run[0]),
        }

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Simulate one step; the information ``is_success`` tells whether the robot has arrived.

        Raises:
            gymnasium.error.ResetNeeded: Before the first reset.
            InvalidParameter: If the action is not valid.
        """
        if not self._places:
            raise gymnasium.error.ResetNeeded("no episode has begun; call reset() before step()")
        result = self._lockstep.step(
            checked_actions(self.interface, np.asarray(action)[np.newaxis], 1)
        )
        self._note_place()
        information = {"is_success": bool(result.reached[0])}
        seen = shown(self._rules, result.observation[0])
        return seen, float(result.reward[0]), bool(result.terminated[0]), False, information

    def render(self) -> Bytes | str | None:
        """Return the world with the path so far, as a picture, (height, width, 3) uint8, or text.

        ``None`` without a render mode.
        """
        if self.render_mode is None:
            gymnasium.logger.warn(
                'render() without a render mode shows nothing; make(..., render_mode="rgb_array")'
            )
            return None
        frame: Bytes | str = frame_of(self.world, [self._places], self.render_mode)
        return frame

    def _note_place(self) -> None:
        if self.render_mode is not None or not self._places:
            self._places.append(self._lockstep.place_of(0))


def seed_of(generator: np.random.Generator) -> int:
    """Return a 64-bit seed from a generator's raw stream, which NumPy promises not to change."""
    return int(generator.bit_generator.random_raw())


def world_of_episode(seed: int, episode: int, count: int) -> int:
    """Return the index of an episode's world among ``count`` worlds, as the core chooses it."""
    drawn = (mix64((seed + (2 * episode + 1) * GAMMA) & MASK64) >> 11) * 2.0**-53
    return min(int(drawn * count), count - 1)

"""The vector environment: many robots, stepped together in one compiled call."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Unpack

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from sim._core import lib
from sim.options.run import whole
from worldgen.errors import InvalidParameter
from worldgen.support.arrays import Bools, Floats
from worldgen.support.progress import working
from worldgen_plugins.for_gymnasium.actions import checked_actions
from worldgen_plugins.for_gymnasium.interface import Interface
from worldgen_plugins.for_gymnasium.lockstep import Lockstep, StepResult
from worldgen_plugins.for_gymnasium.options import Options, resolve, sources_in
from worldgen_plugins.for_gymnasium.picture import RENDER_MODES, check_render_mode, frame_of
from worldgen_plugins.for_gymnasium.single import seed_of
from worldgen_plugins.for_gymnasium.spaces import action_space, observation_space, shown

__all__ = ["NavigateVectorEnv"]


MAX_ENVS = 1_000_000
MAX_STEPS = 100_000_000
_MODES = {
    AutoresetMode.NEXT_STEP: lib.WG_NEXT_STEP,
    AutoresetMode.SAME_STEP: lib.WG_SAME_STEP,
    AutoresetMode.DISABLED: lib.WG_NO_AUTORESET,
}
_MASK = "reset_mask"


class NavigateVectorEnv(gymnasium.vector.VectorEnv[Any, Any, Any]):
    """Many robots that should reach the targets of their worlds.

    Robot i with seed s behaves exactly like the single environment with seed s + i.

    Args:
        num_envs: Number of robots.
        max_episode_steps: Steps after which an episode is truncated; ``None``, 0, or -1 as in
            ``gymnasium.make``, for never.
        autoreset_mode: When the next episode begins: ``NextStep``, ``SameStep`` or ``Disabled``.
        render_mode: ``rgb_array``, ``ansi`` or ``None``.
        **options: The same as of the single environment.

    Raises:
        WorldgenError: If an option is unknown or out of range, or a world cannot be read or made.
    """

    def __init__(
        self,
        num_envs: int = 1,
        max_episode_steps: int | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        **options: Unpack[Options],
    ) -> None:
        self._rules, self._supply = resolve(options)
        self.num_envs = whole("num_envs", num_envs, 1, MAX_ENVS)
        # TimeLimit and gymnasium.make write "no limit" as None or -1; the core writes it as 0.
        limit = whole(
            "max_episode_steps",
            0 if max_episode_steps in (None, -1) else max_episode_steps,
            0,
            MAX_STEPS,
        )
        self._mode = _mode_of(autoreset_mode)
        self.render_mode = check_render_mode(render_mode)
        self.metadata = {
            "render_modes": list(RENDER_MODES),
            "render_fps": 30,
            "autoreset_mode": self._mode,
        }
        # Gymnasium asks for the spaces of one environment and of the batch.
        self.single_observation_space = observation_space(self._rules)
        self.single_action_space = action_space(self._rules.interface)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._lockstep = Lockstep(self._rules, self.num_envs, limit, _MODES[self._mode])
        self._places: list[list[tuple[float, float]]] = [[] for _ in range(self.num_envs)]
        self._seen: npt.NDArray[np.float32] | None = None

    @property
    def interface(self) -> Interface:
        """Sensors and actions, to give a controller the same ones."""
        return self._rules.interface

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Any, dict[str, Any]]:
        """Begin an episode of each robot.

        See :meth:`worldgen_plugins.for_gymnasium.single.NavigateEnv.reset`.

        Args:
            seed: Seed of the first robot; the others get the next ones. Or a list of seeds, one for
                each robot.
            options: The source of worlds from now on. ``reset_mask``, (n,) bool, selects the robots
                whose episodes begin.

        Returns:
            The observations, and the information on each robot's world and run.
        """
        super().reset(seed=seed if isinstance(seed, int) else None)
        which = _mask_of(options, self.num_envs)
        if self._seen is None and not which.all():
            raise InvalidParameter(
                "conflict", "the first reset must include all robots", "omit reset_mask"
            )
        supply = self._supply.changed(sources_in(options, _MASK))
        if supply is not self._supply or not self._lockstep.worlds:
            if not which.all():
                raise InvalidParameter(
                    "conflict",
                    "a reset of some robots cannot change the worlds of all robots",
                    "omit reset_mask",
                )
            with working(f"preparing {len(supply):,} worlds for {self.num_envs:,} robots") as work:
                self._lockstep.load(
                    supply.all(lambda done: work.count(done, len(supply), "worlds"))
                )
            self._supply = supply

        # Begin the episodes; the other robots keep their last observation.
        self._number_episodes(_seeds_of(seed, self.num_envs), which)
        result = self._lockstep.begin_many(which)
        if self._seen is not None:
            result.observation[~which] = self._seen[~which]
        self._seen = result.observation
        self._note_places(which)
        return shown(self._rules, result.observation.copy()), self._of_worlds(which)

    def _number_episodes(self, seeds: Sequence[int | None], which: Bools) -> None:
        """Set the seed of each robot whose episode begins, and the number of that episode."""
        crew = self._lockstep.crew
        for robot in np.flatnonzero(which).tolist():
            seed = seeds[robot]
            if seed is not None or self._seen is None:
                generator, _ = gymnasium.utils.seeding.np_random(seed)
                crew.seed[robot] = seed_of(generator)
                crew.episode[robot] = 0
            else:
                crew.episode[robot] += 1

    def step(self, actions: Any) -> tuple[Any, Floats, Bools, Bools, dict[str, Any]]:
        """Step all robots.

        The information ``is_success`` tells which robots have arrived. Where an episode begins, it
        also has ``world`` and ``run_seed``, and with ``SameStep`` the ``final_obs`` and
        ``final_info`` of the previous episode.

        Raises:
            gymnasium.error.ResetNeeded: Before the first reset; with ``Disabled``, if an episode is
                over.
            InvalidParameter: If the actions are not valid.
        """
        crew = self._lockstep.crew
        # Report misuse as Gymnasium's own vector environments do.
        if self._seen is None:
            raise gymnasium.error.ResetNeeded("no episode has begun; call reset() before step()")
        if self._mode is AutoresetMode.DISABLED and crew.over.any():
            over = int(np.flatnonzero(crew.over)[0])
            raise gymnasium.error.ResetNeeded(
                f"the episode of robot {over} is over; reset it, with reset_mask"
            )
        result = self._lockstep.step(checked_actions(self.interface, actions, self.num_envs))
        self._seen = result.observation
        # Places are collected only for rendering, because they cost a copy per step.
        if self.render_mode is not None:
            self._note_places(result.began)
        information = self._information(result)
        # Callers may keep the observation, so they get a copy of the core's buffer.
        seen = shown(self._rules, result.observation.copy())
        return seen, result.reward, result.terminated, result.truncated, information

    def render(self) -> tuple[Any, ...] | None:
        """Return a frame for each robot; ``None`` without a render mode.

        Raises:
            gymnasium.error.ResetNeeded: Before the first reset.
        """
        if self.render_mode is None:
            gymnasium.logger.warn(
                'render() without a render mode shows nothing; make_vec(..., render_mode="ansi")'
            )
            return None
        if self._seen is None:
            raise gymnasium.error.ResetNeeded("no episode has begun; call reset() before render()")
        worlds = self._lockstep.worlds
        crew = self._lockstep.crew
        return tuple(
            frame_of(worlds[world], [places], self.render_mode)
            for world, places in zip(crew.world.tolist(), self._places, strict=True)
        )

    def _information(self, result: StepResult) -> dict[str, Any]:
        """Return the information in the form of Gymnasium's own vector environments."""
        if self._mode is AutoresetMode.SAME_STEP:
            # In this mode the last observation of a finished episode travels in the information.
            information: dict[str, Any] = {}
            if result.began.any():
                information = self._finals(result)
            running = ~result.began
            if running.any():
                information |= {"is_success": result.reached & running, "_is_success": running}
        else:
            running = ~result.began
            information = (
                {"is_success": result.reached, "_is_success": running} if running.any() else {}
            )
        return information | self._of_worlds(result.began) if result.began.any() else information

    def _finals(self, result: StepResult) -> dict[str, Any]:
        """Return the last observation and information of episodes that were reset in this step."""
        last = np.full(self.num_envs, None, dtype=object)
        for robot in np.flatnonzero(result.began).tolist():
            last[robot] = shown(self._rules, result.last[robot].copy())
        ended = result.began
        final = {"is_success": result.reached & ended, "_is_success": ended.copy()}
        return {
            "final_obs": last,
            "_final_obs": ended.copy(),
            "final_info": final,
            "_final_info": ended.copy(),
        }

    def _of_worlds(self, which: Bools) -> dict[str, Any]:
        """Return the worlds in which episodes begin, and the seeds of their runs."""
        crew = self._lockstep.crew
        return {
            "world": np.where(which, crew.world, 0),
            "_world": which.copy(),
            "run_seed": np.where(which, crew.run, 0),
            "_run_seed": which.copy(),
        }

    def _note_places(self, began: Bools) -> None:
        if self.render_mode is None:
            return
        for robot, fresh in enumerate(began.tolist()):
            places = self._places[robot]
            if fresh:
                places.clear()
            places.append(self._lockstep.place_of(robot))


def _mode_of(mode: object) -> AutoresetMode:
    try:
        return AutoresetMode(mode)
    except ValueError:
        raise InvalidParameter(
            "unknown-name",
            "autoreset_mode={mode} is unknown",
            "there are {known!l}",
            mode=repr(mode),
            known=[repr(one.value) for one in AutoresetMode],
        ) from None


def _seeds_of(seed: object, count: int) -> Sequence[int | None]:
    if seed is None:
        return [None] * count
    if isinstance(seed, int):
        return range(seed, seed + count)
    seeds = list(seed) if isinstance(seed, Sequence) else []
    if len(seeds) != count:
        raise InvalidParameter(
            "wrong-count",
            "seed={given}: use one number, or one for each of {count} robots",
            given=repr(seed),
            count=count,
        )
    return seeds


def _mask_of(options: dict[str, Any] | None, count: int) -> Bools:
    mask = None if options is None else options.get(_MASK)
    if mask is None:
        return np.ones(count, np.bool_)
    if (
        not isinstance(mask, np.ndarray)
        or mask.dtype != np.bool_
        or mask.shape != (count,)
        or not mask.any()
    ):
        raise InvalidParameter(
            "wrong-shape",
            "reset_mask is not an array of {count} booleans, of which at least one is true",
            "use such an array",
            count=count,
        )
    return mask

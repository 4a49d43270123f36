"""A PettingZoo environment: several robots in one world, each to its own target.

``from worldgen_plugins.for_pettingzoo import FleetEnv``. The robots move as in ``worldgen run``:
all at the same time, with exact contacts. One that has reached its target parks there, is done, and
stays in the way of the others.
"""

from __future__ import annotations

import functools
import math
from typing import Any, Unpack

import gymnasium
import numpy as np
import numpy.typing as npt
from pettingzoo import ParallelEnv

from sim import Observation
from sim._core import lib
from sim.controllers.base import Neighbour
from sim.fleet import FleetRun
from sim.fleet.core_calls import CoreFleet
from sim.options.run import MAX_STEPS, whole
from sim.runners.controller_host import OutsideHost
from sim.runners.core_calls import Workspace
from worldgen.errors import InvalidParameter
from worldgen.lattice import lattice_to_metres
from worldgen.support.arrays import Bytes
from worldgen.world import World
from worldgen_plugins.for_gymnasium.interface import Interface
from worldgen_plugins.for_gymnasium.options import Options, resolve
from worldgen_plugins.for_gymnasium.picture import RENDER_MODES, check_render_mode, frame_of
from worldgen_plugins.for_gymnasium.single import seed_of, world_of_episode
from worldgen_plugins.for_gymnasium.spaces import action_space
from worldgen_plugins.for_gymnasium.supply import SOURCES

__all__ = ["TIME_LIMIT", "FleetEnv"]

Singles = npt.NDArray[np.float32]

TIME_LIMIT = 1000
"""Steps after which an episode is truncated, unless the environment is told otherwise."""

# Numbers in an observation for each other robot: whether there is one, its place, its heading.
_OF_NEIGHBOUR = 5

# The core never runs out of steps by itself; the environment counts them.
_ENDLESS = 1 << 40


class FleetEnv(ParallelEnv[str, Any, Any]):  # type: ignore[misc]  # PettingZoo has no types
    """Disc robots that should all reach their targets, in worlds in which they can.

    Agents are called ``robot_1``, ``robot_2``, ... An agent terminates when its robot arrives or
    burns; the others go on. All worlds of an environment have the same number of robots.

    Args:
        render_mode: ``rgb_array``, ``ansi`` or ``None``.
        time_limit: Steps after which an episode is truncated.
        **options: See :class:`worldgen_plugins.for_gymnasium.options.Options`. With
            ``robot={"neighbour_range": 2.0}`` the agents also observe the robots nearby.

    Attributes:
        arrived: (n,) bool, which robots have reached their targets: a mask for training.

    Raises:
        WorldgenError: If an option is unknown or out of range, or a world cannot be read or made.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 - as in the base
        "name": "worldgen_fleet_v0",
        "render_modes": list(RENDER_MODES),
        "render_fps": 30,
        "is_parallelizable": True,
    }

    def __init__(
        self,
        render_mode: str | None = None,
        time_limit: int = TIME_LIMIT,
        **options: Unpack[Options],
    ) -> None:
        self._rules, self._supply = resolve(options)
        self.render_mode = check_render_mode(render_mode)
        self._time_limit = whole("time_limit", time_limit, 1, MAX_STEPS)
        self._seed = 0
        self._episode = -1
        self._world = self._supply[0]
        self.possible_agents = [f"robot_{k + 1}" for k in range(len(self._world.robots))]
        self.agents: list[str] = []
        self.arrived = np.zeros(len(self.possible_agents), np.bool_)

    @property
    def interface(self) -> Interface:
        """Sensors and actions of each agent, to give a controller the same ones."""
        return self._rules.interface

    @property
    def world(self) -> World:
        """The episode's world."""
        return self._world

    @functools.cache  # noqa: B019 - PettingZoo requires the same object for an agent every time
    def observation_space(self, agent: str) -> gymnasium.Space[Any]:
        """Return the space of an agent's observations, a flat float32 box."""
        bounds = self.interface.bounds().values()
        low, high = (np.concatenate(parts) for parts in zip(*bounds, strict=True))
        extra = np.ones(_OF_NEIGHBOUR * self._neighbour_slots, np.float32)
        return gymnasium.spaces.Box(
            np.concatenate([low, -extra]), np.concatenate([high, extra]), dtype=np.float32
        )

    @functools.cache  # noqa: B019 - same
    def action_space(self, agent: str) -> gymnasium.Space[Any]:
        """Return the space of an agent's actions, as for the Gymnasium environments."""
        return action_space(self.interface)

    @property
    def _neighbour_slots(self) -> int:
        robot = self.interface.needs
        return robot.neighbours if robot.neighbour_range > 0.0 else 0

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Singles], dict[str, dict[str, Any]]]:
        """Begin an episode.

        A seed starts a new series of episodes, which the seed decides; without one, this begins the
        next episode of the series.

        Args:
            seed: Seed for the choice of worlds and for the simulator's noise.
            options: The source of worlds from now on: ``{"world": w}``, ... Others are ignored.

        Returns:
            The observations and information by agent.

        Raises:
            InvalidParameter: If a world has another number of robots than the first one.
        """
        # PettingZoo's own test passes an option that no environment knows, so others are ignored.
        known = {name: one for name, one in (options or {}).items() if name in SOURCES}
        supply = self._supply.changed(known)
        if seed is not None or self._episode < 0:
            generator = gymnasium.utils.seeding.np_random(seed)[0]
            self._seed = seed_of(generator)
            self._episode = 0
        else:
            self._episode += 1
        world = supply[world_of_episode(self._seed, self._episode, len(supply))]
        self._check_robots(world)
        self._supply = supply
        self._world = world

        # The robots stand still in the first step, after which they are asked for the first time.
        self._begin()
        self.agents = [
            agent
            for agent, member in zip(self.possible_agents, self._fleet.members, strict=True)
            if member.c.waits
        ]
        self._steps = 0
        self._places: list[list[tuple[float, float]]] = [[] for _ in self.possible_agents]
        self._note_places()
        return self._observations(self.agents), self._information(self.agents)

    def step(
        self, actions: dict[str, Any]
    ) -> tuple[
        dict[str, Singles],
        dict[str, float],
        dict[str, bool],
        dict[str, bool],
        dict[str, dict[str, Any]],
    ]:
        """Simulate one step of all robots at the same time.

        Args:
            actions: An action for each agent that is not done.

        Returns:
            Observations, rewards, terminations, truncations and information by agent.
        """
        # What rewards are measured against, before anything moves.
        asked = self.agents
        distances = dict(zip(self.possible_agents, self._distances(), strict=True))
        touched = [member.report.collisions for member in self._fleet.members]
        for agent in asked:
            self._command(agent, actions[agent])
        self._fleet.run(1)
        self._steps += 1
        self._note_arrivals()
        self._note_places()

        # Each agent is rewarded for its own progress, time, contacts and ending.
        after = self._distances()
        reward = self._rules.reward
        rewards = {}
        terminations = {}
        for agent in asked:
            number = self._number(agent)
            member = self._fleet.members[number]
            has_burned = int(member.report.ending) == lib.WG_BURNED
            terminations[agent] = bool(self.arrived[number]) or has_burned
            rewards[agent] = (
                reward["progress"] * (distances[agent] - after[number])
                + reward["time"] * self._rules.time_step
                + reward["contact"] * (member.report.collisions > touched[number])
                + reward["reached"] * bool(self.arrived[number])
                + reward["burned"] * has_burned
            )
        # An episode is cut off for all agents at once; those that are done had terminated.
        is_late = self._steps >= self._time_limit
        is_over = bool(self._fleet.c.over)
        truncations = {agent: (is_late or is_over) and not terminations[agent] for agent in asked}
        self.agents = [agent for agent in asked if not (terminations[agent] or truncations[agent])]
        return (
            self._observations(asked),
            rewards,
            terminations,
            truncations,
            self._information(asked),
        )

    def render(self) -> Bytes | str | None:
        """Return the world as a picture, (height, width, 3) uint8, or text; None without a mode."""
        if self.render_mode is None:
            gymnasium.logger.warn('render() shows nothing; use render_mode="rgb_array"')
            return None
        frame: Bytes | str = frame_of(self._world, self._places, self.render_mode)
        return frame

    def state(self) -> Singles:
        """Return all robots' observations and the mask of arrivals, for a central critic."""
        seen = self._observations(self.possible_agents)
        return np.concatenate([*seen.values(), self.arrived.astype(np.float32)])

    def close(self) -> None:
        """Free nothing: Python does."""

    def _check_robots(self, world: World) -> None:
        count = len(world.robots)
        if count != len(self.possible_agents):
            raise InvalidParameter(
                "wrong-number-of-robots",
                "a world has {count} robots, and the environment began with {expected}",
                "use worlds with the same number of robots",
                count=count,
                expected=len(self.possible_agents),
            )

    def _begin(self) -> None:
        """Put the robots at their starts, and let them sense."""
        outside = OutsideHost(self.interface.senses)
        count = len(self._world.robots)
        run = FleetRun(self._world, [outside] * count, [self._rules.run_options()] * count)
        drivers = [outside.driver((), one.settings) for one in run.runs]
        self._fleet = CoreFleet(run.runs, drivers, _ENDLESS, lib.WG_NO_LOOP)
        self._fleet.run(1)
        self._workspaces = [Workspace(member) for member in self._fleet.members]
        self.arrived = np.zeros(count, np.bool_)
        self._note_arrivals()

    def _note_arrivals(self) -> None:
        for number, member in enumerate(self._fleet.members):
            self.arrived[number] = int(member.report.ending) == lib.WG_REACHED

    def _note_places(self) -> None:
        """Keep where the robots are, for pictures."""
        for places, place in zip(self._places, self._now(), strict=True):
            if self.render_mode is not None or not places:
                places.append(place)

    def _number(self, agent: str) -> int:
        return self.possible_agents.index(agent)

    def _command(self, agent: str, action: Any) -> None:
        number = self._number(agent)
        workspace = self._workspaces[number]
        asked = self.interface.command(action, Observation.of(workspace.observation))
        workspace.command[:] = (asked.speed, asked.turn_rate, 0.0)

    def _observations(self, agents: list[str]) -> dict[str, Singles]:
        return {agent: self._observation(self._number(agent)) for agent in agents}

    def _observation(self, number: int) -> Singles:
        own = self.interface.observe(Observation.of(self._workspaces[number].observation))
        slots = self._neighbour_slots
        if slots == 0:
            return own
        seen = np.zeros((slots, _OF_NEIGHBOUR), np.float32)
        for slot, one in enumerate(self._fleet.members[number].neighbours()[:slots]):
            seen[slot] = self._shown(one)
        return np.concatenate([own, seen.ravel()])

    def _shown(self, one: Neighbour) -> tuple[float, ...]:
        extent = self.interface.extent
        across = min(max(one.x / extent, -1.0), 1.0)
        up = min(max(one.y / extent, -1.0), 1.0)
        return 1.0, across, up, math.cos(one.heading), math.sin(one.heading)

    def _information(self, agents: list[str]) -> dict[str, dict[str, Any]]:
        return {
            agent: {
                "is_success": bool(self.arrived[self._number(agent)]),
                "arrived": self.arrived.copy(),
            }
            for agent in agents
        }

    def _distances(self) -> list[float]:
        """Return each robot's straight distance to its target, m."""
        return [
            math.hypot(robot.target.x - x, robot.target.y - y)
            for robot, (x, y) in zip(self._world.robots, self._now(), strict=True)
        ]

    def _now(self) -> list[tuple[float, float]]:
        """Return where each robot's centre is, m."""
        side = self._world.cell_size
        return [
            (
                lattice_to_metres(int(member.state.x), side),
                lattice_to_metres(int(member.state.y), side),
            )
            for member in self._fleet.members
        ]

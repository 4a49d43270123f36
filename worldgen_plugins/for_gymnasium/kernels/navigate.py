"""Episodes of many robots in lockstep: act, move, sense, reward, and begin again, in one call.

Each robot's steps are those of a controller that :func:`sim.simulate` runs: a first move before anything was seen, at
a stand; then, in turns, the command and the next move.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from sim.kernels import layout
from sim.kernels._views import page, part, row
from sim.kernels.fdlibm import cos, sin
from sim.kernels.lattice_sense import random_draw, sense
from sim.kernels.lattice_state import Arena, Robot, Room, set_out
from sim.kernels.lattice_step import move_and_sense, obey
from sim.kernels.layout import UNIT
from sim.kernels.recurrence import Search
from worldgen_plugins.for_gymnasium.kernels import layout as at
from worldgen_plugins.for_gymnasium.kernels._jit import kernel, rare_kernel

__all__ = ["Crew", "Told", "Worlds", "begin", "begin_many", "choice_of_world", "encode", "run_of_episode", "step"]

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]
Singles = npt.NDArray[np.float32]
Bools = npt.NDArray[np.bool_]

_HALF = UNIT // 2


class Worlds(NamedTuple):
    """w worlds, before their first events; each array holds the parts of all, one behind the other.

    Args:
        cells: uint8, cell states.
        near: int32, as in :class:`sim.kernels.lattice_state.Arena`.
        clearance: int32, likewise; none for a world whose masks reach as far as any step.
        events: (e, EVENT_SIZE) int64.
        headings: (131072,) int64.
        place: (w, PLACE_SIZE) int64, where the parts of each lie.
        settings: (w, SET_SIZE) int64; the seed is written anew for each robot.
        scales: (w, SCALE_SIZE).
        way: float32, m, length of the shortest way to the target from each node at half a cell; inf if there is none.
    """

    cells: npt.NDArray[np.uint8]
    near: npt.NDArray[np.int32]
    clearance: npt.NDArray[np.int32]
    events: Ints
    headings: Ints
    place: Ints
    settings: Ints
    scales: Floats
    way: Singles


class Crew(NamedTuple):
    """n robots, and what all of them share.

    Args:
        cells: uint8, cell states now: those of the worlds, or a copy for each robot if worlds change.
        near: int32, likewise.
        visited: (0, 0) uint8: nobody asks where they have been.
        chain: (points, 3) int64, shared.
        memory: (0,), shared, and so is all up to ``command``.
        words: (0,) int64.
        seen: (OBS_SIZE + beams,).
        command: (CMD_SIZE,).
        search: For loops, which no environment looks for.
        rules: (RULE_SIZE,).
        sensors: (k,) int64, what an observation shows, in this order.
        choices: (m, 2) the discrete actions: shares of the turn rate and of the top speed; none for continuous ones.
        page: (n,) int64, where a robot's cells begin.
        world: (n,) int64.
        seed: (n,) int64, bits of the seed of a robot's episodes.
        episode: (n,) int64, number of the episode.
        run: (n,) int64, seed of its run.
        clock: (n,) int64, steps of the simulator.
        event: (n,) int64, the next event.
        elapsed: (n,) int64, actions in this episode.
        distance: (n,) m, to the target.
        over: (n,) whether the episode has ended.
        state: (n, STATE_MEMORY) int64.
        odometry: (n, 3).
        counts: (n, OUT_SIZE) int64.
        sums: (n, SUM_SIZE).
    """

    cells: npt.NDArray[np.uint8]
    near: npt.NDArray[np.int32]
    visited: npt.NDArray[np.uint8]
    chain: Ints
    memory: Floats
    words: Ints
    seen: Floats
    command: Floats
    search: Search
    rules: Floats
    sensors: Ints
    choices: Floats
    page: Ints
    world: Ints
    seed: Ints
    episode: Ints
    run: Ints
    clock: Ints
    event: Ints
    elapsed: Ints
    distance: Floats
    over: Bools
    state: Ints
    odometry: Floats
    counts: Ints
    sums: Floats


class Told(NamedTuple):
    """What a call says of each robot; made anew for each.

    Args:
        observation: (n, size) float32.
        reward: (n,).
        terminated: (n,) whether it arrived, or burned.
        truncated: (n,) whether its time is over.
        reached: (n,) whether it arrived.
        began: (n,) whether the observation is the first of an episode.
        last: (n, size) float32, the last observation of an episode after which the next began in the same step; of
            no rows where that does not happen.
    """

    observation: Singles
    reward: Floats
    terminated: Bools
    truncated: Bools
    reached: Bools
    began: Bools
    last: Singles


@kernel
def _arena(worlds: Worlds, crew: Crew, robot: int) -> Arena:
    place, first = row(worlds.place, crew.world[robot]), crew.page[robot]
    height, width = place[at.PLACE_HEIGHT], place[at.PLACE_WIDTH]
    last, table = first + height * width, place[at.PLACE_CLEARANCE]
    rows, columns = place[at.PLACE_ROWS], place[at.PLACE_COLUMNS]
    return Arena(
        page(part(crew.cells, first, last), height, width),
        page(part(crew.near, first, last), height, width),
        page(part(worlds.clearance, table, table + rows * columns), rows, columns),
        part(worlds.events, place[at.PLACE_EVENT], place[at.PLACE_LAST_EVENT]),
        worlds.headings,
        crew.visited,
    )


@kernel
def _take_seed(worlds: Worlds, crew: Crew, robot: int) -> None:
    """Writes a robot's own seed into the settings of its world, which robots share."""
    worlds.settings[crew.world[robot], layout.SET_SEED] = crew.run[robot]


@kernel
def _robot(crew: Crew, robot: int) -> Robot:
    return Robot(
        row(crew.state, robot), row(crew.odometry, robot), crew.chain, row(crew.counts, robot), row(crew.sums, robot)
    )


@kernel
def _room(crew: Crew) -> Room:
    return Room(crew.memory, crew.words, crew.seen, crew.command, crew.search)


@kernel
def choice_of_world(seed: int, episode: int, count: int) -> int:
    """Which of so many worlds an episode is in."""
    return min(int(random_draw(seed, 2 * episode) * count), count - 1)


@kernel
def run_of_episode(seed: int, episode: int) -> int:
    """Seed of an episode's run, from which noise is drawn: 53 bits."""
    return int(random_draw(seed, 2 * episode + 1) * 2.0**53)


@kernel
def _direction(angle: float, out: Singles, first: int) -> int:
    """Writes the cosine and sine of an angle; where the next number stands."""
    out[first], out[first + 1] = cos(angle), sin(angle)
    return first + 2


@kernel
def _share(value: float, whole: float) -> float:
    """A length as a share of another, -1 to 1."""
    return min(max(value / whole, -1.0), 1.0)


@kernel
def encode(seen: Floats, sensors: Ints, rules: Floats, out: Singles) -> None:
    """Writes an environment's observation: what the sensors show of the simulator's.

    Args:
        seen: (OBS_SIZE + beams,) ``OBS_``.
        sensors: What is shown, in this order.
        rules: ``RULE_``.
        out: (size,) float32, filled.
    """
    k, extent, heading = 0, rules[at.RULE_EXTENT], seen[layout.OBS_HEADING]
    for index in range(sensors.size):
        sensor = sensors[index]
        if sensor == at.BUMP:
            out[k] = seen[layout.OBS_BUMP]
            k += 1
        elif sensor == at.BUMP_DIRECTION:
            if seen[layout.OBS_BUMP] != 0.0:
                k = _direction(seen[layout.OBS_BUMP_BEARING], out, k)
            else:
                out[k], out[k + 1] = 0.0, 0.0
                k += 2
        elif sensor == at.SIGNAL:
            out[k] = seen[layout.OBS_SIGNAL]
            k += 1
        elif sensor == at.SIGNAL_DIRECTION:
            k = _direction(seen[layout.OBS_SIGNAL_HEADING] - heading, out, k)
        elif sensor == at.TARGET_DIRECTION:
            k = _direction(seen[layout.OBS_TARGET_HEADING] - heading, out, k)
        elif sensor == at.TARGET_DISTANCE:
            out[k] = _share(seen[layout.OBS_TARGET_DISTANCE], extent)
            k += 1
        elif sensor == at.HEADING:
            k = _direction(heading, out, k)
        elif sensor == at.POSITION:
            out[k], out[k + 1] = _share(seen[layout.OBS_X], extent), _share(seen[layout.OBS_Y], extent)
            k += 2
        elif sensor == at.ODOMETRY:
            out[k] = _share(seen[layout.OBS_ODOMETRY_X], extent)
            out[k + 1] = _share(seen[layout.OBS_ODOMETRY_Y], extent)
            k = _direction(seen[layout.OBS_ODOMETRY_HEADING], out, k + 2)
        else:
            for beam in range(layout.OBS_SIZE, seen.size):
                out[k] = _share(seen[beam], rules[at.RULE_BEAM_RANGE])
                k += 1


@kernel  # the worlds and the crew are some 300 numbers: to hand them on in each step would take longer than the step
def _advance(worlds: Worlds, crew: Crew, robot: int) -> bool:
    """A robot's move and what it senses then, also at its last pose; whether a wall stopped or bent the move."""
    _take_seed(worlds, crew, robot)
    settings, scales = row(worlds.settings, crew.world[robot]), row(worlds.scales, crew.world[robot])
    crew.clock[robot] += 1
    now = crew.clock[robot]
    arena, room, driver = _arena(worlds, crew, robot), _room(crew), _robot(crew, robot)
    event, _, nx, ny = move_and_sense(arena, settings, scales, room, driver, now, crew.event[robot])
    crew.event[robot] = event
    if driver.counts[layout.OUT_ENDING] != layout.LIMIT:
        contact = (nx, ny)
        sense(
            arena.cells, arena.headings, settings, scales, driver.state, driver.odometry, contact, now,
            room.observation,
        )  # fmt: skip
    return nx != 0.0 or ny != 0.0


@rare_kernel
def _look(worlds: Worlds, crew: Crew, robot: int) -> None:
    """What a robot senses that does not move."""
    _take_seed(worlds, crew, robot)
    settings, scales = row(worlds.settings, crew.world[robot]), row(worlds.scales, crew.world[robot])
    arena = _arena(worlds, crew, robot)
    sense(
        arena.cells, arena.headings, settings, scales, row(crew.state, robot), row(crew.odometry, robot), (0.0, 0.0),
        crew.clock[robot], crew.seen,
    )  # fmt: skip


@rare_kernel
def _way(worlds: Worlds, world: int, x: int, y: int) -> float:
    """Length of the way to the target, m: straight to one of the four nodes around, then the shortest; or inf."""
    place, best = row(worlds.place, world), math.inf
    columns = 2 * place[at.PLACE_WIDTH] + 1
    for corner in range(4):
        i = min(x // _HALF + (corner & 1), 2 * place[at.PLACE_WIDTH])
        j = min(y // _HALF + (corner >> 1), 2 * place[at.PLACE_HEIGHT])
        dx, dy = i * _HALF - x, j * _HALF - y
        aside = math.sqrt(float(dx * dx + dy * dy)) * worlds.scales[world, layout.SCALE_METRES]
        best = min(best, aside + float(worlds.way[place[at.PLACE_WAY] + j * columns + i]))
    return float(best)


@kernel
def _distance(worlds: Worlds, crew: Crew, robot: int) -> float:
    """How far a robot is from the target, m: by the shortest way where those are known, else straight."""
    world = crew.world[robot]
    settings = row(worlds.settings, world)
    x, y = crew.state[robot, layout.STATE_X], crew.state[robot, layout.STATE_Y]
    if worlds.place[world, at.PLACE_WAY] >= 0:
        away = _way(worlds, world, x, y)
        if away < math.inf:
            return away
    dx, dy = settings[layout.SET_TARGET_X] - x, settings[layout.SET_TARGET_Y] - y
    return float(math.sqrt(float(dx * dx + dy * dy)) * worlds.scales[world, layout.SCALE_METRES])


@rare_kernel
def begin(worlds: Worlds, crew: Crew, robot: int, world: int, out: Singles) -> None:
    """Puts a robot at the start of its next episode, and observes.

    Args:
        worlds: The worlds.
        crew: The robots.
        robot: Which.
        world: Where.
        out: (size,) float32, filled.
    """
    crew.run[robot] = run_of_episode(crew.seed[robot], crew.episode[robot])
    crew.world[robot] = world
    place = row(worlds.place, world)
    first, size = place[at.PLACE_CELLS], place[at.PLACE_HEIGHT] * place[at.PLACE_WIDTH]
    if worlds.events.shape[0] == 0:
        crew.page[robot] = first
    else:
        for k in range(size):
            crew.cells[crew.page[robot] + k] = worlds.cells[first + k]
            crew.near[crew.page[robot] + k] = worlds.near[first + k]
    set_out(row(worlds.settings, world), row(worlds.scales, world), crew.memory, _room(crew), _robot(crew, robot), 0)
    crew.clock[robot], crew.event[robot], crew.elapsed[robot] = 0, 0, 0
    _advance(worlds, crew, robot)
    encode(crew.seen, crew.sensors, crew.rules, out)
    crew.distance[robot] = _distance(worlds, crew, robot)
    crew.over[robot] = False


@kernel
def _begin_next(worlds: Worlds, crew: Crew, robot: int, out: Singles) -> None:
    """The next episode, in a world that the robot's seed chooses."""
    crew.episode[robot] += 1
    world = choice_of_world(crew.seed[robot], crew.episode[robot], worlds.place.shape[0])
    begin(worlds, crew, robot, world, out)


@rare_kernel
def begin_many(worlds: Worlds, crew: Crew, which: Bools, told: Told) -> None:
    """Puts robots at the starts of their episodes, each in the world that its seed chooses.

    Args:
        worlds: The worlds.
        crew: The robots; seeds and numbers of episodes are as they shall be.
        which: (n,) whose episodes begin.
        told: Their observations are filled.
    """
    for robot in range(which.size):
        if which[robot]:
            world = choice_of_world(crew.seed[robot], crew.episode[robot], worlds.place.shape[0])
            begin(worlds, crew, robot, world, row(told.observation, robot))


@kernel
def _command(worlds: Worlds, crew: Crew, robot: int, turn: float, speed: float) -> None:
    """Obeys an action: shares of the turn rate and of the top speed."""
    command, rules = crew.command, crew.rules
    scales = row(worlds.scales, crew.world[robot])
    command[layout.CMD_TURN_RATE] = min(max(turn, -1.0), 1.0) * rules[at.RULE_TURN_RATE]
    command[layout.CMD_SPEED] = min(max(speed, rules[at.RULE_SLOWEST]), 1.0) * scales[layout.SCALE_TOP_SPEED]
    command[layout.CMD_DRAW] = 0.0
    _take_seed(worlds, crew, robot)
    obey(row(worlds.settings, crew.world[robot]), scales, command, crew.clock[robot], _robot(crew, robot))


@kernel
def _reward(worlds: Worlds, crew: Crew, robot: int, touched: bool, ending: int) -> float:
    """What a step is worth; notes the new distance."""
    rules, before = crew.rules, crew.distance[robot]
    now = _distance(worlds, crew, robot)
    crew.distance[robot] = now
    reward = rules[at.RULE_PROGRESS] * (before - now)
    reward += rules[at.RULE_TIME] * worlds.scales[crew.world[robot], layout.SCALE_TIME_STEP]
    if touched:
        reward += rules[at.RULE_CONTACT]
    if ending == layout.REACHED:
        reward += rules[at.RULE_REACHED]
    elif ending == layout.BURNED:
        reward += rules[at.RULE_BURNED]
    return float(reward)


@rare_kernel
def step(worlds: Worlds, crew: Crew, chosen: Ints, moves: Singles, told: Told) -> None:
    """One action of each robot.

    Args:
        worlds: The worlds.
        crew: The robots.
        chosen: (n,) int64, discrete actions, or none.
        moves: (n, 2) float32, continuous ones, or none.
        told: Filled.
    """
    counts, mode, limit = crew.counts, int(crew.rules[at.RULE_AUTORESET]), int(crew.rules[at.RULE_LIMIT])
    for robot in range(crew.world.size):
        out = row(told.observation, robot)
        told.reward[robot], told.began[robot], told.reached[robot] = 0.0, False, False
        told.terminated[robot], told.truncated[robot] = False, False
        if crew.over[robot] and mode == at.NEXT_STEP:
            _begin_next(worlds, crew, robot, out)
            told.began[robot] = True
            continue
        touched = False
        if counts[robot, layout.OUT_ENDING] == layout.LIMIT:
            if crew.choices.shape[0] > 0:
                _command(worlds, crew, robot, crew.choices[chosen[robot], 0], crew.choices[chosen[robot], 1])
            else:
                _command(worlds, crew, robot, float(moves[robot, 0]), float(moves[robot, 1]))
            touched = _advance(worlds, crew, robot)
        else:  # it began where episodes end
            _look(worlds, crew, robot)
        encode(crew.seen, crew.sensors, crew.rules, out)
        ending = counts[robot, layout.OUT_ENDING]
        crew.elapsed[robot] += 1
        told.reward[robot] = _reward(worlds, crew, robot, touched, ending)
        told.terminated[robot] = ending != layout.LIMIT
        told.reached[robot] = ending == layout.REACHED
        told.truncated[robot] = limit > 0 and crew.elapsed[robot] >= limit
        crew.over[robot] = told.terminated[robot] or told.truncated[robot]
        if crew.over[robot] and mode == at.SAME_STEP:
            for k in range(out.size):
                told.last[robot, k] = out[k]
            _begin_next(worlds, crew, robot, out)
            told.began[robot] = True

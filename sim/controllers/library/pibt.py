"""Priority inheritance with backtracking (PIBT), as a controller that each robot runs for itself.

The robots drive on a grid whose nodes are half a cell apart. All of them take the same number of
steps from node to node. Before each move, a robot works out the moves of all the robots that it
sees, in order of priority: each takes the free move that brings it closest to its target, and any
robot in its way inherits its priority and must move first. All robots have the same information, so
they compute the same plan, and each drives its own part of it.

It knows the map at the start, and the robots' targets and priorities by message. Unlike in the
paper, robots may be wider than the grid's edges, so moves are compared as motions of discs; a
robot that has arrived stays where it is; and priorities are fixed: the farther from its target a
robot starts, the higher.

Two robots may touch if one of them is off the grid, where it starts or where its target is, if they
differ in speed, or if there are more robots than a robot can sense.

Source: Keisuke Okumura, Manao Machida, Xavier Defago and Yasumasa Tamura, "Priority inheritance
    with backtracking for iterative multi-agent path finding", Artificial Intelligence 310 (2022).
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from sim.controllers.base import Command, Memory, Neighbour, Observation
from sim.controllers.memory_view import MemoryField
from sim.options.robot import RobotOptions
from worldgen.lattice import radius_in_cells
from worldgen.reach.still.grid_search import steps_from
from worldgen.reach.still.lattice_graph import build_graph
from worldgen.support.arrays import Bools
from worldgen.world import World

Node = tuple[int, int]
NodeStep = tuple[int, int]

# Nodes per cell side. The families' starts and targets are in the middle of cells or on their
# corners, so both are nodes.
_PER_CELL = 2
# Moves in the order in which equally good ones are preferred.
_STAY: NodeStep = (0, 0)
_MOVES: tuple[NodeStep, ...] = ((1, 0), (0, 1), (-1, 0), (0, -1), _STAY)
# Distance, in edges, within which a robot counts as standing on a node.
_NEAR = 0.02
# Numbers in a message.
_MESSAGE = 5
# Bits of the map in one number of the memory; a float holds 53.
_BITS = 52
# Numbers in the memory that precede the map.
_LEFT, _STEPS, _X, _Y, _PRIORITY, _TARGET_X, _TARGET_Y, _WITHIN, _EDGE, _COLUMNS = range(10)
_MAP = 10


class _Map(NamedTuple):
    """The map as it is kept in a robot's memory.

    Args:
        words: ``_BITS`` nodes each, row by row; a bit is 1 if the robot is clear of walls there.
        columns: Nodes per row.
    """

    words: tuple[float, ...]
    columns: int


class _Target(NamedTuple):
    """A robot's target, in edges."""

    x: float
    y: float
    radius: float


class _Agent(NamedTuple):
    """A robot that takes part in the plan.

    Args:
        priority: Higher ones choose first.
        node: Where it stands.
        radius: In edges.
        target: Its preferred destination.
    """

    priority: float
    node: Node
    radius: float
    target: _Target

    def after(self, move: NodeStep) -> Node:
        """Return the node to which a move leads."""
        return self.node[0] + move[0], self.node[1] + move[1]


class _Bystander(NamedTuple):
    """A robot that does not take part: it has arrived, is off the grid, or runs something else.

    Args:
        x: In edges.
        y: In edges.
        radius: In edges.
        has_arrived: True if it will stay there.
    """

    x: float
    y: float
    radius: float
    has_arrived: bool = False


@dataclass(frozen=True)
class Pibt:
    """Moves from node to node by PIBT."""

    about = "Know the map, and plan each move together with the robots nearby."
    senses = ("heading", "x", "y", "time_step", "top_speed", "radius", "neighbours")
    needs = RobotOptions(neighbour_range=1e6, neighbours=64, message=_MESSAGE)
    memory_fields = (MemoryField("steps left", _LEFT),)

    def reset(self, world: World) -> Memory:
        """Return the memory: the move in progress, what the robot sends to others, and the map."""
        edge = world.cell_size / _PER_CELL
        clear = build_graph(world.walls, radius_in_cells(world), _PER_CELL).clear
        bits = clear.ravel().tolist()
        words = tuple(
            float(sum(bit << k for k, bit in enumerate(bits[first : first + _BITS])))
            for first in range(0, len(bits), _BITS)
        )
        grid = _Map(words, clear.shape[1])
        wanted = world.target
        target = _Target(wanted.x / edge, wanted.y / edge, wanted.radius / edge)
        x = world.start.x / edge
        y = world.start.y / edge
        start = _nearest(x, y, _clear_nodes(grid)) or (round(x), round(y))
        # The start makes priorities differ, unless two robots start off the grid at the same node.
        to_go = _edges_from(start, _distances(grid, target)) or 0
        priority = to_go * len(bits) + start[1] * grid.columns + start[0]
        move = (0.0, 0.0, *map(float, start))
        sent = (float(priority), *target)
        return (*move, *sent, edge, float(grid.columns), *words)

    def act(self, observation: Observation, memory: Memory) -> tuple[Command, Memory]:
        """Return the command for the next step, and the new memory."""
        now = list(memory)
        edge = memory[_EDGE]
        x = observation.x / edge
        y = observation.y / edge
        if memory[_STEPS] == 0.0:
            # In the first step no robot has received a message yet.
            reach = observation.top_speed * observation.time_step
            now[_STEPS] = float(max(1, math.ceil(edge / reach - 1e-9)))
            return Command(message=_message(now)), tuple(now)
        if memory[_LEFT] == 0.0:
            now[_X], now[_Y] = self._next_place(observation, memory, x, y)
            now[_LEFT] = memory[_STEPS]
        # Divide the remaining edge by the remaining steps, so that rounding does not add up.
        ahead = now[_X] - x
        left = now[_Y] - y
        speed = math.hypot(ahead, left) * edge / (now[_LEFT] * observation.time_step)
        turn = 0.0
        if math.hypot(ahead, left) > 1e-6:
            turn = math.remainder(math.atan2(left, ahead) - observation.heading, 2 * math.pi)
        now[_LEFT] -= 1.0
        command = Command(speed, turn / observation.time_step, message=_message(now))
        return command, tuple(now)

    def _next_place(
        self, observation: Observation, memory: Memory, x: float, y: float
    ) -> tuple[float, float]:
        """Return where to drive next, in edges; the robot is at (x, y)."""
        grid = _Map(memory[_MAP:], int(memory[_COLUMNS]))
        target = _target(memory)
        node = _nearest(x, y, _clear_nodes(grid))
        if node is None:
            return x, y
        # The last part of the path leads off the grid, unless a node lies in the target.
        if _edges_from(node, _distances(grid, target)) == 0:
            return target.x, target.y
        # Something pushed the robot off the grid, or it started there.
        if math.hypot(x - node[0], y - node[1]) > _NEAR:
            return node
        me = _Agent(memory[_PRIORITY], node, observation.radius / memory[_EDGE], target)
        agents = [me]
        obstacles = []
        for other in observation.neighbours:
            seen = _seen(other, observation, memory)
            if isinstance(seen, _Agent):
                agents.append(seen)
            else:
                obstacles.append(seen)
        plan = _plan(grid, tuple(sorted(agents, reverse=True)), tuple(sorted(obstacles)))
        return me.after(plan[me])


pibt = Pibt()


def _target(memory: Sequence[float]) -> _Target:
    return _Target(memory[_TARGET_X], memory[_TARGET_Y], memory[_WITHIN])


def _message(memory: Sequence[float]) -> tuple[float, ...]:
    """Return the message: the target, the priority, and the steps that a move takes."""
    return (*_target(memory), memory[_PRIORITY], memory[_STEPS])


def _seen(other: Neighbour, observation: Observation, memory: Memory) -> _Agent | _Bystander:
    """Return another robot as an agent of the plan, or as an obstacle."""
    edge = memory[_EDGE]
    cos = math.cos(observation.heading)
    sin = math.sin(observation.heading)
    # Rounded, because each robot computes the others' positions from its own.
    x = round((observation.x + cos * other.x - sin * other.y) / edge, 6)
    y = round((observation.y + sin * other.x + cos * other.y) / edge, 6)
    if len(other.message) < _MESSAGE:
        return _Bystander(x, y, other.radius / edge)
    *numbers, priority, steps = other.message[:_MESSAGE]
    target = _Target(*numbers)
    columns = memory[_COLUMNS]
    rows = len(memory[_MAP:]) * _BITS / columns
    is_on_map = 0 <= target.x <= columns and 0 <= target.y <= rows and 0 < target.radius < columns
    if not is_on_map:
        # Another controller's message.
        return _Bystander(x, y, other.radius / edge)
    node = (round(x), round(y))
    is_off = math.hypot(x - node[0], y - node[1]) > _NEAR
    has_arrived = math.hypot(x - target.x, y - target.y) <= target.radius + 1e-6
    if steps != memory[_STEPS] or is_off or has_arrived:
        return _Bystander(x, y, other.radius / edge, has_arrived)
    return _Agent(priority, node, other.radius / edge, target)


@functools.lru_cache(maxsize=256)
def _plan(
    grid: _Map, agents: tuple[_Agent, ...], obstacles: tuple[_Bystander, ...]
) -> dict[_Agent, NodeStep]:
    """Return the agents' moves. Robots that see the same share the work.

    Args:
        grid: The map.
        agents: The agents, in descending order of priority.
        obstacles: Their obstacles.
    """
    plan = _JointMove(grid, agents, obstacles)
    for agent in agents:
        if agent not in plan.decided:
            plan.choose(agent)
    plan.make_way()
    return plan.decided


class _JointMove:
    """A plan in the making.

    No decided move touches another one. Unless an agent is about to push, none touches an undecided
    agent that stays where it is, either.
    """

    def __init__(
        self, grid: _Map, agents: Sequence[_Agent], obstacles: Sequence[_Bystander]
    ) -> None:
        self._grid = grid
        self._parked = tuple(one for one in obstacles if one.has_arrived)
        self._agents = agents
        self._obstacles = obstacles
        self.decided: dict[_Agent, NodeStep] = {}
        # Agents that could not leave in time, and the node that another one wanted.
        self._late: dict[_Agent, Node] = {}

    def choose(self, agent: _Agent, giving_way: Node | None = None) -> bool:
        """Decide an agent's move, and the moves of those in its way.

        Args:
            agent: The agent.
            giving_way: A node that another agent wants; the moves that lead away from it then come
                first.

        Returns:
            False if no move is free, so that whoever pushes it must look for another move.
        """
        field = _distances(self._grid, agent.target, agent.radius, self._parked)
        if _edges_from(agent.node, field) is None:
            # Arrived robots block its path; get as close as possible.
            field = _distances(self._grid, agent.target)
        to_go = {move: _edges_from(agent.after(move), field) for move in _MOVES}
        moves = sorted(
            (move for move in _MOVES if to_go[move] is not None), key=lambda move: to_go[move] or 0
        )
        if giving_way is not None:
            moves.sort(key=lambda move: -math.dist(agent.after(move), giving_way))
        for move in moves:
            if not self._is_free(agent, move):
                continue
            before = dict(self.decided)
            self.decided[agent] = move
            failed = self._push(agent, move)
            if failed is None:
                return True
            # The agent that found no way out stays; the others that it pushed may choose again.
            self.decided = before
            if not self._is_free(failed, _STAY):
                # It also blocks an agent that pushes this one, so this one fails too.
                break
            self.decided[failed] = _STAY
            self._late.setdefault(failed, agent.after(move))
        self.decided[agent] = _STAY
        return False

    def make_way(self) -> None:
        """Let agents that could not make room in time start to do so.

        A wide robot cannot leave around a corner while another one follows closely.
        """
        for agent, node in list(self._late.items()):
            if self.decided[agent] == _STAY:
                del self.decided[agent]
                self.choose(agent, giving_way=node)

    def _push(self, agent: _Agent, move: NodeStep) -> _Agent | None:
        """Let those in an agent's way choose; return the first that fails."""
        for other in self._agents:
            is_in_the_way = other not in self.decided and _touch(agent, move, other, _STAY)
            if is_in_the_way and not self.choose(other):
                return other
        return None

    def _is_free(self, agent: _Agent, move: NodeStep) -> bool:
        """Return True if a move touches neither an obstacle nor a decided move."""
        for one in self._obstacles:
            x = one.x - agent.node[0]
            y = one.y - agent.node[1]
            if _touch_at(x, y, -move[0], -move[1], agent.radius + one.radius):
                return False
        return not any(_touch(agent, move, one, other) for one, other in self.decided.items())


def _touch(one: _Agent, move: NodeStep, other: _Agent, other_move: NodeStep) -> bool:
    """Return True if two agents that move at the same time come nearer than their radii."""
    return _touch_at(
        other.node[0] - one.node[0],
        other.node[1] - one.node[1],
        other_move[0] - move[0],
        other_move[1] - move[1],
        one.radius + other.radius,
    )


def _touch_at(x: float, y: float, dx: float, dy: float, together: float) -> bool:
    """Return True if a moving point comes within ``together`` edges of the origin.

    Args:
        x: Where it begins.
        y: Where it begins.
        dx: How far it moves.
        dy: How far it moves.
        together: Sum of two radii; to touch exactly is allowed.
    """
    squared = dx * dx + dy * dy
    # When it is nearest, from 0 to 1.
    at = min(1.0, max(0.0, -(x * dx + y * dy) / squared)) if squared else 0.0
    return math.hypot(x + at * dx, y + at * dy) < together - 1e-9


def _edges_from(node: Node, steps: npt.NDArray[np.int32]) -> int | None:
    """Return the edges from a node to a target; ``None`` if there is no path, or no such node.

    Args:
        node: The node.
        steps: (rows, columns) edges from each node, -1 where no path leads to the target.
    """
    x, y = node
    rows, columns = steps.shape
    found = int(steps[y, x]) if 0 <= x < columns and 0 <= y < rows else -1
    return None if found < 0 else found


@functools.lru_cache(maxsize=16)
def _clear_nodes(grid: _Map) -> Bools:
    """Return (rows, columns) where a robot alone is clear of walls."""
    words = np.array(grid.words).astype(np.uint64)
    bits = (words[:, np.newaxis] >> np.arange(_BITS, dtype=np.uint64)) & np.uint64(1)
    flat = bits.ravel().astype(np.bool_)
    return flat[: flat.size // grid.columns * grid.columns].reshape(-1, grid.columns)


@functools.lru_cache(maxsize=128)
def _distances(
    grid: _Map, target: _Target, radius: float = 0.0, parked: tuple[_Bystander, ...] = ()
) -> npt.NDArray[np.int32]:
    """Return the edges from each node to the clear node nearest to a target.

    Args:
        grid: The map.
        target: The target.
        radius: Radius of the robot, in edges; needed only if others are parked.
        parked: Robots to go around.
    """
    clear = _clear_nodes(grid).copy()
    y, x = np.indices(clear.shape)
    for one in parked:
        clear &= np.hypot(x - one.x, y - one.y) >= radius + one.radius - 1e-9
    source = _nearest(target.x, target.y, clear)
    if source is None:
        return np.full(clear.shape, -1, np.int32)
    steps, _ = steps_from(clear, source[1] * grid.columns + source[0])
    return steps.reshape(clear.shape)


def _nearest(x: float, y: float, clear: Bools) -> Node | None:
    """Return the clear node nearest to a place; ``None`` if no node is clear."""
    rows, columns = clear.shape
    rounded = (round(x), round(y))
    if 0 <= rounded[0] < columns and 0 <= rounded[1] < rows and clear[rounded[1], rounded[0]]:
        return rounded
    ys, xs = np.nonzero(clear)
    if len(xs) == 0:
        return None
    k = int(np.argmin((xs - x) ** 2 + (ys - y) ** 2))
    return int(xs[k]), int(ys[k])

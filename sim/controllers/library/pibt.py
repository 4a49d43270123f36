"""Priority inheritance with backtracking (PIBT), as a controller that each robot runs for itself.

The robots drive on a grid whose nodes are half a cell apart. All of them take the same number of
steps from node to node. Before each move, a robot works out the moves of all the robots that it
sees, in order of priority: each takes the free move that leads nearest to its target, and whoever
is in its way inherits its priority and must move first. Since the robots know the same, they come
to the same plan, and each drives its own part of it.

It knows the map at the start, and the robots' targets and priorities by message. Unlike in the
paper, robots may be wider than the grid's edges, so moves are compared as motions of discs; a
robot that has arrived stays where it is; and priorities are fixed: the farther from its target a
robot starts, the higher.

Source: Keisuke Okumura, Manao Machida, Xavier Defago and Yasumasa Tamura, "Priority inheritance
    with backtracking for iterative multi-agent path finding", Artificial Intelligence 310 (2022).
"""

from __future__ import annotations

import functools
import math
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from sim.controllers.base import Command, Memory, Neighbour, Observation
from sim.controllers.memory_view import MemoryField
from sim.options.robot import RobotOptions
from worldgen.lattice import radius_in_cells
from worldgen.reach.still.lattice_graph import build_graph
from worldgen.world import World

__all__ = ["Pibt", "pibt"]

Node = tuple[int, int]
Move = tuple[int, int]

# Nodes per cell side. Starts and targets of the families lie in the middle of cells or on their
# corners, so both are nodes.
_PER_CELL = 2
# Moves in the order in which equally good ones are preferred.
_STAY: Move = (0, 0)
_MOVES: tuple[Move, ...] = ((1, 0), (0, 1), (-1, 0), (0, -1), _STAY)
# Distance, in edges, within which a robot counts as standing on a node.
_NEAR = 0.02
# Bits of the map in one number of the memory; a float holds 53.
_BITS = 52
# Places in the memory before the map.
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
        priority: Higher ones choose first; no two robots have the same.
        node: Where it stands.
        radius: In edges.
        target: Where it wants to go.
    """

    priority: float
    node: Node
    radius: float
    target: _Target

    def after(self, move: Move) -> Node:
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

    senses = ("heading", "x", "y", "time_step", "top_speed", "radius", "neighbours")
    needs = RobotOptions(neighbour_range=1e6, neighbours=64, message=5)
    memory_fields = (MemoryField("steps left", _LEFT),)

    def reset(self, world: World) -> Memory:
        """Return the memory: the move in progress, what the robot tells others, and the map."""
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
        distances = _distances(grid, target)
        start = _nearest(world.start.x / edge, world.start.y / edge, distances)
        # The start makes priorities differ: no two robots stand on the same node.
        priority = distances.get(start, 0) * len(bits) + start[1] * grid.columns + start[0]
        return (
            0.0,
            0.0,
            *map(float, start),
            float(priority),
            *target,
            edge,
            float(grid.columns),
            *words,
        )

    def act(self, observation: Observation, memory: Memory) -> tuple[Command, Memory]:
        """Return the command for the next step, and the new memory."""
        now = list(memory)
        edge = memory[_EDGE]
        x = observation.x / edge
        y = observation.y / edge
        if memory[_STEPS] == 0.0:
            # In the first step nobody knows anything about the others.
            reach = observation.top_speed * observation.time_step
            now[_STEPS] = float(max(1, math.ceil(edge / reach - 1e-9)))
            return Command(message=_told(now)), tuple(now)
        if memory[_LEFT] == 0.0:
            now[_X], now[_Y] = self._next_place(observation, memory, x, y)
            now[_LEFT] = memory[_STEPS]
        # Divide what is left of the edge by the steps left, so that rounding does not add up.
        ahead = now[_X] - x
        left = now[_Y] - y
        speed = math.hypot(ahead, left) * edge / (now[_LEFT] * observation.time_step)
        turn = 0.0
        if math.hypot(ahead, left) > 1e-6:
            turn = _shortest(math.atan2(left, ahead) - observation.heading)
        now[_LEFT] -= 1.0
        command = Command(speed, turn / observation.time_step, message=_told(now))
        return command, tuple(now)

    def _next_place(
        self, observation: Observation, memory: Memory, x: float, y: float
    ) -> tuple[float, float]:
        """Return where to drive next, in edges; the robot is at (x, y)."""
        grid = _Map(memory[_MAP:], int(memory[_COLUMNS]))
        target = _target(memory)
        distances = _distances(grid, target)
        node = _nearest(x, y, distances)
        # The last part of the path leads off the grid, unless a node lies in the target.
        if distances.get(node) == 0:
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
        return me.after(plan[me.priority])


pibt = Pibt()


def _target(memory: Sequence[float]) -> _Target:
    return _Target(memory[_TARGET_X], memory[_TARGET_Y], memory[_WITHIN])


def _told(memory: Sequence[float]) -> tuple[float, ...]:
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
    *numbers, priority, steps = other.message
    target = _Target(*numbers)
    node = (round(x), round(y))
    is_off = math.hypot(x - node[0], y - node[1]) > _NEAR
    has_arrived = math.hypot(x - target.x, y - target.y) <= target.radius + 1e-6
    if steps != memory[_STEPS] or is_off or has_arrived:
        return _Bystander(x, y, other.radius / edge, has_arrived)
    return _Agent(priority, node, other.radius / edge, target)


@functools.lru_cache(maxsize=256)
def _plan(
    grid: _Map, agents: tuple[_Agent, ...], obstacles: tuple[_Bystander, ...]
) -> dict[float, Move]:
    """Return the agents' moves, by priority. Robots that see the same share the work.

    Args:
        grid: The map.
        agents: The agents, in descending order of priority.
        obstacles: What stands in their way.
    """
    plan = _JointMove(grid, agents, obstacles)
    for agent in agents:
        if agent not in plan.decided:
            plan.choose(agent)
    plan.make_way()
    return {agent.priority: move for agent, move in plan.decided.items()}


class _JointMove:
    """A plan in the making.

    Whatever has been decided touches neither another decided move nor an undecided agent that
    stays.
    """

    def __init__(
        self, grid: _Map, agents: Sequence[_Agent], obstacles: Sequence[_Bystander]
    ) -> None:
        self._grid = grid
        self._parked = tuple(one for one in obstacles if one.has_arrived)
        self._agents = agents
        self._obstacles = obstacles
        self.decided: dict[_Agent, Move] = {}
        # Agents that could not leave in time, and the node that another one wanted.
        self._late: dict[_Agent, Node] = {}

    def choose(self, agent: _Agent, giving_way: Node | None = None) -> bool:
        """Decide an agent's move, and the moves of those in its way.

        Args:
            agent: The agent.
            giving_way: A node that another agent wants; the moves that lead away from it then come
                first.

        Returns:
            False if it must stay, and has not been able to do so freely.
        """
        distances = _distances(self._grid, agent.target, agent.radius, self._parked)
        if agent.node not in distances:
            # Robots that have arrived close its way; get near.
            distances = _distances(self._grid, agent.target)
        moves = [move for move in _MOVES if agent.after(move) in distances]
        moves.sort(key=lambda move: distances[agent.after(move)])
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
            # Whoever found no way out stays; the others it pushed may choose again.
            self.decided = before
            self.decided[failed] = _STAY
            self._late.setdefault(failed, agent.after(move))
        self.decided[agent] = _STAY
        return False

    def make_way(self) -> None:
        """Let agents that could not get out of the way in time begin to do so.

        A wide robot cannot leave around a corner while another one follows closely.
        """
        for agent, node in list(self._late.items()):
            if self.decided[agent] == _STAY:
                del self.decided[agent]
                self.choose(agent, giving_way=node)

    def _push(self, agent: _Agent, move: Move) -> _Agent | None:
        """Let those in an agent's way choose; return the first that fails."""
        for other in self._agents:
            is_in_the_way = other not in self.decided and _touch(agent, move, other, _STAY)
            if is_in_the_way and not self.choose(other):
                return other
        return None

    def _is_free(self, agent: _Agent, move: Move) -> bool:
        """Return True if a move touches neither an obstacle nor a decided move."""
        return not any(
            _touch_at(
                one.x - agent.node[0],
                one.y - agent.node[1],
                -move[0],
                -move[1],
                agent.radius + one.radius,
            )
            for one in self._obstacles
        ) and not any(_touch(agent, move, one, other) for one, other in self.decided.items())


def _touch(one: _Agent, move: Move, other: _Agent, other_move: Move) -> bool:
    """Return True if two agents that move at the same time come nearer than their radii."""
    return _touch_at(
        other.node[0] - one.node[0],
        other.node[1] - one.node[1],
        other_move[0] - move[0],
        other_move[1] - move[1],
        one.radius + other.radius,
    )


def _touch_at(x: float, y: float, dx: float, dy: float, together: float) -> bool:
    """Return True if a point passes the origin at less than ``together`` edges.

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


@functools.lru_cache(maxsize=64)
def _clear_nodes(grid: _Map) -> frozenset[Node]:
    return frozenset(
        ((place * _BITS + k) % grid.columns, (place * _BITS + k) // grid.columns)
        for place, word in enumerate(grid.words)
        for k in range(_BITS)
        if int(word) >> k & 1
    )


@functools.lru_cache(maxsize=1024)
def _distances(
    grid: _Map, target: _Target, radius: float = 0.0, parked: tuple[_Bystander, ...] = ()
) -> dict[Node, int]:
    """Return the edges from each node to a target; nodes that do not reach it are missing.

    They count from the nodes inside the target, or from the nearest one if there is none.

    Args:
        grid: The map.
        target: The target.
        radius: Radius of the robot, in edges; needed only if others are parked.
        parked: Robots to go around.
    """
    clear = {
        node
        for node in _clear_nodes(grid)
        if all(math.dist(node, one[:2]) >= radius + one.radius - 1e-9 for one in parked)
    }
    reach = range(-math.ceil(target.radius) - 1, math.ceil(target.radius) + 2)
    near = [(round(target.x) + i, round(target.y) + j) for i in reach for j in reach]
    sources = [
        node
        for node in near
        if node in clear and math.dist(node, target[:2]) <= target.radius + 1e-9
    ]
    if not sources and clear:
        sources = [_nearest(target.x, target.y, clear)]
    found = dict.fromkeys(sources, 0)
    waiting = deque(sources)
    while waiting:
        node = waiting.popleft()
        for move in _MOVES:
            after = (node[0] + move[0], node[1] + move[1])
            if after in clear and after not in found:
                found[after] = found[node] + 1
                waiting.append(after)
    return found


def _nearest(x: float, y: float, nodes: Iterable[Node]) -> Node:
    """Return the nearest of some nodes, in edges; the rounded point if there are none."""
    rounded = (round(x), round(y))
    if rounded in nodes:
        return rounded
    return min(nodes, key=lambda one: ((one[0] - x) ** 2 + (one[1] - y) ** 2, one), default=rounded)


def _shortest(turn: float) -> float:
    """Return an equivalent turn of at most half a circle, rad."""
    return (turn + math.pi) % (2 * math.pi) - math.pi

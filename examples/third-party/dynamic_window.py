"""The dynamic window approach of ``dynamic-window-approach`` (C with Python bindings, MIT licence).

Its author is goktug97. ``pip install dynamic-window-approach``; README.md next to this file has the
details.
"""

import math
from dataclasses import dataclass
from typing import ClassVar

import dwa
import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from sim import Command, RobotOptions

# Angle between two beams, rad.
FIELD = 2.0 * math.pi / 36


@dataclass(frozen=True)
class DynamicWindow:
    """Drives with the (speed, turn rate) of least cost over the next second and a half."""

    needs: ClassVar = RobotOptions(beams=36)
    # Top speed, robot radii per second.
    pace: float = 6.0
    # Top speed near the target, 1/s, so that the robot can still turn to it.
    approach: float = 1.0
    # Seconds.
    look_ahead: float = 1.0
    # Weights of an error of 1 rad,
    heading: float = 0.05
    # of standing still,
    velocity: float = 1.0
    clearance: float = (
        # and of a robot radius from the nearest point; below 1 / radius, see README.md.
        0.1
    )

    def reset(self):
        # Speed, turn rate.
        return (0.0, 0.0)

    def act(self, seen, memory):
        r = seen.radius
        top = min(seen.top_speed, self.pace * seen.radius, self.approach * seen.target_distance)
        ahead = min(self.look_ahead, seen.target_distance / top)
        config = dwa.Config(
            max_speed=top, min_speed=0.0, max_accel=4.0 * top,
            velocity_resolution=min(top / 8, 1.3 * top * seen.time_step),
            max_yawrate=2.0, max_dyawrate=8.0, yawrate_resolution=0.2, dt=seen.time_step, predict_time=ahead,
            heading=self.heading, clearance=self.clearance * r, velocity=self.velocity / top, base=[r, r, -r, -r],
        )  # fmt: skip
        near = [
            (d, seen.heading + k * FIELD)
            for k, d in enumerate(seen.beams)
            if d < top * ahead + 4.0 * r
        ]
        points = [(seen.x + d * math.cos(a), seen.y + d * math.sin(a)) for d, a in near]
        cloud = np.array(points, np.float32).reshape(-1, 2)
        velocity = (min(memory[0], top), memory[1])
        chosen = dwa.planning(
            (seen.x, seen.y, seen.heading), velocity, self.goal(seen, memory), cloud, config
        )
        return Command(*chosen), (*chosen, *memory[2:])

    def goal(self, seen, memory):
        return (
            seen.x + seen.target_distance * math.cos(seen.target_heading),
            seen.y + seen.target_distance * math.sin(seen.target_heading),
        )


@dataclass(frozen=True)
class PlannedWindow(DynamicWindow):
    """The same behind a planner, as in Nav2.

    It is sent to a point of the planned path a little way ahead.
    """

    # Robot radii along the path.
    ahead: float = 6.0

    def reset(self, world):
        return (0.0, 0.0, *np.ravel(plan(world)).tolist())

    def goal(self, seen, memory):
        path = np.reshape(memory[2:], (-1, 2))
        nearest = int(np.argmin(np.hypot(*(path - (seen.x, seen.y)).T)))
        way = np.cumsum(np.hypot(*np.diff(path[nearest:], axis=0).T))
        k = nearest + int(np.searchsorted(way, self.ahead * seen.radius)) + 1
        return tuple(map(float, path[min(k, len(path) - 1)]))


def plan(world):
    """Return a shortest path to the target over cells whose centre is clear by the radius.

    The result has places (n, 2), m.
    """
    # Cells from a centre to the nearest wall.
    room = distance_transform_edt(np.pad(~world.walls, 1))[1:-1, 1:-1] - 0.5
    clear = room * world.cell_size >= world.robot_radius
    number = np.arange(world.walls.size).reshape(world.walls.shape)
    edges = []
    for here, there, length in (
        (np.s_[:, :-1], np.s_[:, 1:], 1.0),
        (np.s_[:-1], np.s_[1:], 1.0),
        (np.s_[:-1, :-1], np.s_[1:, 1:], math.sqrt(2.0)),
        (np.s_[:-1, 1:], np.s_[1:, :-1], math.sqrt(2.0)),
    ):
        both = clear[here] & clear[there]
        edges.append((number[here][both], number[there][both], np.full(int(both.sum()), length)))
    rows, columns, lengths = (np.concatenate(parts) for parts in zip(*edges, strict=True))
    graph = coo_array((lengths, (rows, columns)), shape=(number.size, number.size)).tocsr()
    start, target = (
        number[int(p.y / world.cell_size), int(p.x / world.cell_size)]
        for p in (world.start, world.target)
    )
    _, before = dijkstra(graph, directed=False, indices=target, return_predecessors=True)
    cells = [start]
    while before[cells[-1]] >= 0:
        cells.append(before[cells[-1]])
    places = np.column_stack(np.unravel_index(np.array(cells[1:-1:2], int), world.walls.shape))[
        :, ::-1
    ]
    return np.vstack([(places + 0.5) * world.cell_size, [(world.target.x, world.target.y)]])

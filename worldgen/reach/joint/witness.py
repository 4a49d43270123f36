"""Convert a joint plan over nodes to a joint witness: legs, true times, few points, clearances."""

from __future__ import annotations

import itertools

import numpy as np

from worldgen.lattice import UNIT, exact
from worldgen.reach.joint.apart import stay_apart
from worldgen.reach.joint.question import JointQuestion
from worldgen.reach.still.path import clearance_sq, metres, root_down, travel_ticks
from worldgen.reach.still.walls import ExactPoint, Walls
from worldgen.reach.timed.spans import ChangingWalls
from worldgen.support.arrays import Ints
from worldgen.world import JointWitness, Witness


def make_joint_witness(question: JointQuestion, nodes: Ints) -> JointWitness | None:
    """Return the witness of a plan; None if the last legs to the targets conflict.

    Args:
        question: Robots, nodes and ticks.
        nodes: (ticks + 1, robots) int64, the plan.
    """
    moments = _places(question, nodes)
    if moments is None:
        return None
    times = _times(question, moments)
    tracks = [
        _merged(times, [places[robot] for places in moments]) for robot in range(len(question.ends))
    ]
    end = max(track[0][-1] for track in tracks)
    return JointWitness(
        tuple(_path(question, robot, *track, end) for robot, track in enumerate(tracks))
    )


def _places(question: JointQuestion, nodes: Ints) -> list[list[ExactPoint]] | None:
    """Return where each robot is after each tick, lu."""
    moments = [[question.point(node) for node in row] for row in nodes.tolist()]
    if question.has_first_leg:
        moments.insert(0, [end.start for end in question.ends])
    if any(end.goal is not None for end in question.ends):
        last = moments[-1]
        goals = [
            here if end.goal is None else end.goal
            for here, end in zip(last, question.ends, strict=True)
        ]
        for one, other in itertools.combinations(range(len(goals)), 2):
            legs = ((last[one], goals[one]), (last[other], goals[other]))
            if not stay_apart(*legs, question.apart_sq(one, other)):
                return None
        moments.append(goals)
    return moments


def _times(question: JointQuestion, moments: list[list[ExactPoint]]) -> list[int]:
    """Return the time of each moment; in a static world, no tick is longer than its steps need."""
    if question.spans is not None:
        return [index * question.tick for index in range(len(moments))]
    size = question.world.cell_size
    known: dict[tuple[object, float], int] = {}
    times = [0]
    for before, after in itertools.pairwise(moments):
        longest = 0
        for robot, here, there in zip(question.world.robots, before, after, strict=True):
            length_sq = (there[0] - here[0]) ** 2 + (there[1] - here[1]) ** 2
            if (length_sq, robot.speed) not in known:
                known[length_sq, robot.speed] = travel_ticks(
                    here, there, size, robot.speed, question.ticks
                )
            longest = max(longest, known[length_sq, robot.speed])
        times.append(times[-1] + longest)
    return times


def _merged(times: list[int], places: list[ExactPoint]) -> tuple[list[int], list[ExactPoint]]:
    """Remove points at which the velocity does not change, and the wait at the end."""
    kept_times = [times[0]]
    kept = [places[0]]
    for time, place in zip(times[1:], places[1:], strict=True):
        if time == kept_times[-1]:  # a tick in which no robot moves takes no time
            continue
        if len(kept) > 1 and _is_straight(kept_times[-2:], kept[-2:], time, place):
            kept_times.pop()
            kept.pop()
        kept_times.append(time)
        kept.append(place)
    if len(kept) > 1 and kept[-1] == kept[-2]:
        kept_times.pop()
        kept.pop()
    return kept_times, kept


def _is_straight(times: list[int], places: list[ExactPoint], time: int, place: ExactPoint) -> bool:
    """Return True if the next piece has the same velocity as the last one."""
    before = times[1] - times[0]
    after = time - times[1]
    return all(
        (places[1][axis] - places[0][axis]) * after == (place[axis] - places[1][axis]) * before
        for axis in (0, 1)
    )


def _path(
    question: JointQuestion, robot: int, times: list[int], places: list[ExactPoint], end: int
) -> Witness:
    world = question.world
    x, y = metres(places, world.cell_size)
    if question.spans is None:
        square = clearance_sq(Walls(world.walls, question.radii[robot]), places)
    else:
        # The place where it waits has to be safe until the last robot has arrived.
        walls = ChangingWalls(world, question.spans, question.radii[robot])
        square = walls.clearance_sq([*places, places[-1]], [*times, max(end, times[-1])])
    clearance = root_down(square * (exact(world.cell_size) / UNIT) ** 2)
    seconds = np.array([time / question.ticks for time in times])
    return Witness(seconds, np.array(x), np.array(y), clearance)

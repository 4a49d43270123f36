"""Turn a run into things to draw over its world."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from sim.controllers.base import Controller
from sim.drawing.wall_penetrations import penetrated_cells
from sim.episode import Episode
from sim.evidence import BudgetEvidence, Evidence, JointLoopEvidence, LoopEvidence, WallEvidence
from sim.options.disturbances import decoys_of, pushes_of, pushing_places_of
from sim.options.run import COVER
from sim.outcome import Ran
from sim.trace import Trace
from sim.verdict import Verdict
from worldgen.lattice import exact
from worldgen.plugins.registry import user_code
from worldgen.reach import reachable_cells
from worldgen.render import Drive, EventMark, Trail, draw_png
from worldgen.render.overlay import Disturbances, MarkKind, Remembered, Shove
from worldgen.support.arrays import Bools, Floats, Ints
from worldgen.world import World

# Limit on the marks of bumps; more of them would hide the picture.
_MOST_BUMPS = 400

# Share of the extent of a run: bumps nearer to each other touch the same walls.
_SAME_PLACE = 0.002

# Strength of the tint of a cell that the robot considers occupied.
_OCCUPIED = 0.6

# Limit on the marks of pushes.
_MOST_PUSHES = 100


def trail_of(episode: Episode, world: World | None = None) -> Trail | None:
    """Return the line that a recorded episode drove, with its loop, bumps and broken walls.

    Args:
        episode: The run.
        world: The world that it drove in; without it, the walls that the robot went into are not
            marked.

    Returns:
        The line; ``None`` without a recording.
    """
    trace = episode.trace
    if trace is None:
        return None

    # Find the point of the path at which the loop begins, or from which nothing new is reached.
    evidence = episode.evidence
    loop_from = stays_from = None
    if isinstance(evidence, LoopEvidence | JointLoopEvidence) and evidence.entry < trace.steps:
        loop_from = _row_at(trace, evidence.entry)
    # Leave out how it got there: what it does there is the second half of the run.
    half = trace.steps // 2
    if isinstance(evidence, BudgetEvidence) and evidence.last_new_cell <= half:
        stays_from = _row_at(trace, half)

    # Mark where it touches something, where it enters a wall, and where a run without a loop ends.
    marks = [
        EventMark(float(trace.x[k]), float(trace.y[k]), "bump", float(trace.heading[k]))
        for k in _bumps(trace, evidence)
    ]
    if isinstance(evidence, WallEvidence) and 0 <= evidence.step <= trace.steps:
        step = evidence.step
        kind: MarkKind = "tunnel" if episode.verdict == Verdict.TUNNEL else "overlap"
        marks.append(EventMark(float(trace.x[step]), float(trace.y[step]), kind))
    if loop_from is None and stays_from is None:
        marks.append(EventMark(float(trace.x[-1]), float(trace.y[-1]), "end"))
    return Trail(
        trace.path_x,
        trace.path_y,
        loop_from,
        marks,
        () if world is None else penetrated_cells(episode, world),
        disturbances_in(trace),
        _missed(trace, world),
        headings=headings_along(trace),
        stays_from=stays_from,
    )


def _row_at(trace: Trace, step: int) -> int:
    """Return the index of the path's point at which a step ends."""
    return int(np.searchsorted(trace.path_step, step, side="right")) - 1


def _bumps(trace: Trace, evidence: Evidence | None) -> Ints:
    """Return steps with a bump, each place once: of a loop those that it repeats, if there are any."""
    steps = np.flatnonzero(trace.bump)
    if isinstance(evidence, LoopEvidence | JointLoopEvidence):
        repeated = steps[steps > evidence.entry]
        steps = repeated if len(repeated) else steps
    grain = max(_SAME_PLACE * float(np.ptp(trace.x) + np.ptp(trace.y)), 1e-9)
    places = np.rint(np.column_stack((trace.x[steps], trace.y[steps])) / grain)
    _, first = np.unique(places, axis=0, return_index=True)
    found: Ints = steps[np.sort(first)]
    return found[:: max(1, -(-len(found) // _MOST_BUMPS))]


def headings_along(trace: Trace) -> Floats:
    """Return the heading at each point of a recorded path, rad: a turn comes after its step's move."""
    headings = np.array(trace.heading[np.maximum(trace.path_step - 1, 0)])
    ends = np.searchsorted(trace.path_step, np.arange(len(trace.heading)), side="right") - 1
    headings[ends] = trace.heading
    return headings


def remembered_at_the_end(episode: Episode, controller: Controller) -> Remembered | None:
    """Return the contents of a controller's memory at the end of a recorded run.

    Args:
        episode: The run.
        controller: The controller, whose own code reads its memory.

    Returns:
        ``None`` without a recording, or if the controller does not show its memory.

    Raises:
        InvalidParameter: If the controller's code fails.
    """
    trace = episode.trace
    read = getattr(controller, "memory_map", None)
    if trace is None or read is None or not trace.memory_size:
        return None
    with user_code("reading the controller's memory"):
        shown = read(trace.memory(trace.steps))
        cells = np.asarray(shown.cells, np.float64).reshape(-1, 4)
        degrees = np.array(shown.degrees, np.float64).reshape(-1, 5)
        # Occupied cells look like medium ones; the worse the other cells, the stronger their tint.
        degrees[:, 4] = 0.05 + 0.95 * (1.0 - degrees[:, 4])
        occupied = np.column_stack((cells, np.full(len(cells), _OCCUPIED)))
        return Remembered(
            np.concatenate((occupied, degrees)),
            np.asarray(shown.blocked, np.float64).reshape(-1, 4),
            np.asarray(shown.edges, np.float64).reshape(-1, 4),
            np.asarray(shown.plan, np.float64).reshape(-1, 2),
            np.asarray(shown.nodes, np.float64).reshape(-1, 2),
            dict(shown.places),
        )


def trails_of(episode: Episode, world: World) -> list[Trail]:
    """Return the line that each robot of a recorded episode drove."""
    found: list[Trail] = []
    for number, one in enumerate(episode.robots):
        trail = trail_of(one, world.alone(number + 1))
        if trail is not None:
            found.append(replace(trail, blocked_by=episode.blockers(number + 1)))
    return found


def drives_of(episode: Episode, world: World) -> list[Drive]:
    """Return what each robot did and when."""
    return [
        drive_of(
            one, world.alone(number), f"robot {number}: {one.verdict}" if world.is_fleet else ""
        )
        for number, one in enumerate(episode.robots, start=1)
    ]


def _missed(trace: Trace, world: World | None) -> Bools | None:
    """Return the cells of a coverage task that the robot missed."""
    if trace.task != COVER or world is None:
        return None
    missed = reachable_cells(world)
    side = world.cell_size
    columns = np.clip(np.floor(trace.x / side + 1e-9).astype(np.int64), 0, world.width - 1)
    rows = np.clip(np.floor(trace.y / side + 1e-9).astype(np.int64), 0, world.height - 1)
    missed[rows, columns] = False
    return missed


def disturbances_in(trace: Trace) -> Disturbances:
    """Return what disturbed a recorded robot, with each push at its actual length."""
    robot = trace.robot
    if robot is None:
        return Disturbances()
    pushes = []
    for push in sorted(pushes_of(robot), key=lambda push: push.time)[:_MOST_PUSHES]:
        step = max(1, math.ceil(exact(push.time) / exact(trace.time_step)))
        if step > trace.steps:
            break
        # The push is the last part of its step's path. It began at the point that gives the best
        # match with the requested displacement.
        last = int(np.searchsorted(trace.path_step, step, side="right")) - 1
        first = max(int(np.searchsorted(trace.path_step, step)) - 1, 0)
        dx = trace.path_x[last] - trace.path_x[first : last + 1]
        dy = trace.path_y[last] - trace.path_y[first : last + 1]
        best = int(np.argmin(np.hypot(dx - push.dx, dy - push.dy)))
        x = float(trace.path_x[first + best])
        y = float(trace.path_y[first + best])
        pushes.append(Shove(x, y, float(dx[best]), float(dy[best])))
    places = (Shove(one.x, one.y, one.dx, one.dy) for one in pushing_places_of(robot))
    return Disturbances(
        pushes=tuple(pushes),
        places=tuple(places),
        decoys=tuple((decoy.x, decoy.y) for decoy in decoys_of(robot)),
        drift_heading=robot.drift_heading if robot.drift > 0.0 else None,
    )


def drive_of(episode: Episode, world: World, name: str = "") -> Drive:
    """Return the robot's actions with their times; without a recording, it stays at its start."""
    trace = episode.trace
    trail = trail_of(episode, world)
    if trace is None or trail is None:
        start = world.start
        trail = Trail(np.array([start.x]), np.array([start.y]))
        return Drive(name, trail, np.zeros(1), np.array([start.heading]), 1.0)
    times = np.maximum(trace.path_step - 1 + trace.path_share, 0.0) * trace.time_step
    return Drive(name, trail, times, trace.heading, trace.time_step)


def picture_of(episode: Episode, ran: Ran) -> bytes:
    """Return a recorded episode as the PNG that a notebook shows."""
    title = f"{ran.name}, {ran.options.motion}: {episode.verdict}"
    return draw_png(
        replace(ran.world, failure=None), trail=trails_of(episode, ran.world), title=title
    )

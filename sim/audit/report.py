"""Present an audit to people as text, to programs as data, and as a picture."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict

import numpy as np

from sim.audit.judge import KINDS, Audit, Finding
from worldgen import render
from worldgen.logs.trajectory import Trajectory
from worldgen.render.overlay import MarkKind
from worldgen.support.arrays import Floats
from worldgen.world import World

_MOST_LINES = 40
# Limit on marks of one kind; more of them would hide the picture.
_MOST_MARKS = 400
_MARKS: dict[str, MarkKind] = {
    "tunnel": "tunnel",
    "outside": "tunnel",
    "overlap": "overlap",
    "burned": "overlap",
}
# Pixels. Points of the path that are nearer to each other than this are drawn as one.
_SHARE_OF_A_PIXEL = 0.125
_NOUNS = {
    "tunnel": ("tunnel", "tunnels"),
    "overlap": ("overlap", "overlaps"),
    "outside": ("way outside", "ways outside"),
    "jump": ("jump", "jumps"),
    "burned": ("touch of fire", "touches of fire"),
    "start": ("other start", "other starts"),
}


def as_object(audit: Audit, tolerance: float) -> dict[str, object]:
    """Return the audit as the object that ``--json`` prints."""
    t, x, y = audit.nearest
    return {
        "ok": audit.ok,
        **asdict(audit),
        "findings": [_as_object(finding) for finding in audit.findings],
        "nearest": {"t": t, "x": x, "y": y},
        "tolerance": tolerance,
    }


def _as_object(finding: Finding) -> dict[str, object]:
    """Return a finding without its speed, which only its sentence tells, and a disc's heading."""
    names = {"begin": "t_begin", "end": "t_end"}
    plain = asdict(finding)
    del plain["speed"]
    if finding.heading is None:
        del plain["heading"]
    return {names.get(name, name): value for name, value in plain.items()}


def as_lines(world: World, audit: Audit) -> list[str]:
    """Return a line for each finding and each note, and then a summary."""
    lines = [_line(world, audit, finding) for finding in audit.findings[:_MOST_LINES]]
    if len(audit.findings) > _MOST_LINES:
        lines.append(f"... and {len(audit.findings) - _MOST_LINES} more; --json prints all")
    lines += [f"note: {note}" for note in audit.notes]
    return [*lines, f"{_verdict(audit)}: {_figures(world, audit)}"]


def fleet_lines(world: World, audits: Mapping[int, Audit]) -> list[str]:
    """Return the lines of each robot, by number, and a summary."""
    lines = [
        f"robot {robot}: {line}"
        for robot, audit in audits.items()
        for line in as_lines(world.alone(robot), audit)
    ]
    wrong = [str(robot) for robot, audit in audits.items() if not audit.ok]
    verdict = f"not possible: {_listed('robot', wrong)}" if wrong else "possible"
    return [*lines, f"{verdict}; contacts between robots are not judged"]


def _listed(noun: str, numbers: Sequence[str]) -> str:
    """Return "robot 1", or "robots 1, 2 and 4"."""
    if len(numbers) == 1:
        return f"{noun} {numbers[0]}"
    return f"{noun}s {', '.join(numbers[:-1])} and {numbers[-1]}"


def fleet_object(audits: Mapping[int, Audit], tolerance: float) -> dict[str, object]:
    """Return the audits of several robots as the object that ``--json`` prints."""
    return {
        "ok": all(audit.ok for audit in audits.values()),
        "robots": [
            {"robot": robot} | as_object(audit, tolerance) for robot, audit in audits.items()
        ],
    }


def _line(world: World, audit: Audit, finding: Finding) -> str:
    until = f" to {finding.end:.6g}" if finding.end > finding.begin else ""
    span = f"{finding.begin:.6g}{until} s"
    if audit.is_plan:
        span = f"pose {finding.begin:.6g}{until}"
    where = f"at {_time(audit, finding.t)}, ({finding.x:.6g}, {finding.y:.6g}) m"
    if finding.heading is not None:
        where += f", heading {math.degrees(finding.heading):.4g} degrees"
    return f"{finding.kind} {span}: {_words(world, finding)}, {where}"


def _time(audit: Audit, t: float) -> str:
    """Return a time, or the place of a plan that has none, in words."""
    return f"pose {t:.6g}" if audit.is_plan else f"t = {t:.6g} s"


def _words(world: World, finding: Finding) -> str:
    depth = f"{finding.depth:.4g} m"
    cell = finding.cell
    what = "" if cell is None else f"cell ({cell[0]}, {cell[1]})"
    if cell is not None and not (0 <= cell[0] < world.width and 0 <= cell[1] < world.height):
        what = "the outside of the grid"
    if finding.kind == "tunnel":
        return f"the centre is up to {depth} deep in {what}"
    if finding.kind in ("overlap", "burned"):
        return (
            f"the {'disc' if world.robots[0].is_disc else 'body'} is up to {depth} deep in "
            f"{'burning ' if finding.kind == 'burned' else ''}{what}"
        )
    if finding.kind == "outside":
        return f"the centre is up to {depth} outside the grid"
    if finding.kind == "jump":
        speed = "in no time, at infinite speed"
        if finding.speed < math.inf:
            speed = f"at {finding.speed:.6g} m/s"
        return f"up to {depth} farther in one step than {world.robot_speed:g} m/s allow, {speed}"
    return f"the first sample is {depth} away from the world's start"


def _verdict(*audits: Audit) -> str:
    if all(audit.ok for audit in audits):
        return "possible"
    counts = Counter(finding.kind for audit in audits for finding in audit.findings)
    return "not possible, " + ", ".join(
        f"{counts[kind]} {_NOUNS[kind][counts[kind] > 1]}" for kind in KINDS if counts[kind]
    )


def _figures(world: World, audit: Audit) -> str:
    reached = "target not reached"
    if audit.reached is not None:
        time = f"{audit.reached:.6g} s"
        reached = f"target reached at {_time(audit, audit.reached) if audit.is_plan else time}"
    t, x, y = audit.nearest
    size = f"{audit.samples} poses" if audit.is_plan else f"{audit.samples} samples"
    if audit.duration is not None:
        size += f", {audit.duration:.6g} s"
    robot = world.robots[0]
    body = f"radius {robot.radius:g} m" if robot.is_disc else "of the body"
    return (
        f"{size}, {audit.path_length:.6g} m, {reached}; smallest clearance {audit.clearance:.6g} m "
        f"at {_time(audit, t)}, ({x:.6g}, {y:.6g}) m, {body}"
    )


def draw(world: World, recorded: Mapping[int, tuple[Trajectory, Audit]], name: str) -> bytes:
    """Draw the world, the trajectories and the findings; return the bytes of a PNG file.

    Anything outside the world is drawn on its border. A robot that was not recorded stays at its
    start.
    """
    trails = []
    for number, robot in enumerate(world.robots, start=1):
        if number in recorded:
            trails.append(_trail(world, *recorded[number]))
        else:
            here = np.array([robot.start.x] * 2), np.array([robot.start.y] * 2)
            trails.append(render.Trail(*here, None, []))
    audits = [audit for _, audit in recorded.values()]
    return render.draw_png(world, trail=trails, title=f"{name}: {_verdict(*audits)}")


def _trail(world: World, trajectory: Trajectory, audit: Audit) -> render.Trail:
    """Return a trajectory and its findings as they are drawn."""
    # Positions are clipped to the middle of the frame around the world.
    frame = render.Frame.of(world)
    border = 0.5 * frame.band / frame.scale
    width = world.width * world.cell_size + border
    height = world.height * world.cell_size + border
    marks = []
    for kind, mark in _MARKS.items():
        for at in [finding for finding in audit.findings if finding.kind == kind][:_MOST_MARKS]:
            place = min(max(at.x, -border), width), min(max(at.y, -border), height)
            marks.append(render.EventMark(*place, mark, at.heading))
    headings = trajectory.headings
    turned = np.zeros(len(trajectory.x)) if headings is None else np.unwrap(headings)
    x, y, turned = _cut_off(trajectory.x, trajectory.y, turned, (-border, width), (-border, height))

    # Drop points that fall on the same spot as the one before; a long recording has many.
    grain = _SHARE_OF_A_PIXEL / frame.scale
    pixels = np.round(np.stack([x, y]) / grain)
    fresh = np.concatenate([[True], (np.diff(pixels, axis=1) != 0).any(axis=0)])
    fresh[-1] = True
    aims = None if headings is None else turned[fresh]
    return render.Trail(x[fresh], y[fresh], None, marks, headings=aims)


def _cut_off(
    x: Floats,
    y: Floats,
    headings: Floats,
    x_range: tuple[float, float],
    y_range: tuple[float, float],
) -> tuple[Floats, Floats, Floats]:
    """Return a path clipped to a box, with a point added wherever it crosses a side.

    Outside the box, the clipped path runs along its sides.
    """
    places = [np.arange(len(x), dtype=np.float64)]
    for values, ends in ((x, x_range), (y, y_range)):
        for end in ends:
            rows = np.flatnonzero((values[:-1] < end) != (values[1:] < end))
            places.append(rows + (end - values[rows]) / (values[rows + 1] - values[rows]))
    at = np.sort(np.concatenate(places))
    samples = places[0]
    return (
        np.clip(np.interp(at, samples, x), *x_range),
        np.clip(np.interp(at, samples, y), *y_range),
        np.interp(at, samples, headings),
    )

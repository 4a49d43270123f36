"""``worldgen verify``: check the proof in a file or, if there is none, decide the world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any

import click

from worldgen.cli.output import PATH, emit_json, json_option, note, say, skip_bad_file
from worldgen.cli.robot_options import note_axle, robot_options, warn_of_start_in_target
from worldgen.cli.usage import Instead
from worldgen.robot_overrides import RobotOverrides, describe_body
from worldgen.support.plain_text import shown, stacked
from worldgen.support.progress import working

if TYPE_CHECKING:
    from worldgen.errors import InvalidParameter
    from worldgen.world import World

# Unsolvable worlds that a summary names.
_FIRST = 10
# Why the largest disc of a world is not defined, by the code of the error.
_NO_WIDEST = {"several-robots": "it has several robots", "world-changes": "the world changes"}

EXAMPLES = (
    "\b\n  worldgen verify w.grid\n  worldgen verify failures/ --json\n  worldgen verify mazes.zip\n"
    "  worldgen verify w.grid --footprint 0.62x0.9 --drive car --turning-radius 0.5 --reverse"
)


@click.command(epilog=EXAMPLES)
@click.argument("paths", metavar="PATH...", nargs=-1, required=True, type=PATH)
@click.option(
    "--radius",
    type=float,
    metavar="R",
    help="Use a disc of this radius, m, instead of the robot's body.",
)
@robot_options
@click.option(
    "--widest", is_flag=True, help="Also report the largest disc that could get to the target."
)
@click.option(
    "--deadline", type=float, metavar="T", help="Require the robot to arrive within T seconds."
)
@json_option
def verify(
    paths: tuple[Path, ...],
    radius: float | None,
    widest: bool,
    deadline: float | None,
    as_json: bool,
    **robot: Any,
) -> None:
    """Check a world's proof, or decide whether a target can be reached.

    A file's certificate is checked by code that shares nothing with the code that made it. A map
    without a certificate is decided, as is one whose certificate does not cover the requested
    radius or robot; the result is then checked in the same way.

    For a folder, a set or an archive, its .grid files are checked. A summary of several worlds
    states the share whose target can be reached, with its 95 % interval, and names the first worlds
    in which it cannot.

    For a world that changes, it also reports how late the robot can set out: on the witness (its
    margin), and on any path (the latest start).

    A world of whose map something was not read, as its provenance records, is undecided.

    Exits with 0 if every certificate is valid or every map could be decided (blocked is an answer
    too), with 1 if a certificate is invalid or a map remains undecided, with 2 if a file, or a part
    of the map that it was imported from, cannot be read.
    """
    from worldgen.difficulty.bottleneck import bottleneck
    from worldgen.files.worlds import read_worlds
    from worldgen.reach.verifying import verify_world

    overrides = _overrides(radius, robot)
    # Verify one world after the other.
    results: list[dict[str, Any]] = []
    unjudged: InvalidParameter | None = None
    lines: list[str] = []
    interrupted = False
    try:
        with working("verifying") as work:
            for path, stored in read_worlds(paths, skip_bad_file):
                work.say(f"{path}, world {len(results) + 1}")
                world = overrides.applied_to(_as_disc(stored, radius))
                warn_of_start_in_target(overrides, world, f"{path}: ")
                result = {
                    "path": str(path),
                    **verify_world(world, radius, deadline),
                    **_body(world),
                }
                fault = _without_widest(world, path) if widest else None
                if fault is not None:
                    result["widest_unknown"] = fault.code
                    unjudged = None if results else fault
                elif widest and not world.unread:
                    work.say(f"{path}: looking for the largest disc that could pass")
                    result["widest"] = bottleneck(world, world.walls)
                results.append(result)
                lines.append(_line(result))
                # Each result is printed as soon as it is known, since one can take minutes. That of
                # a world without a widest disc is an error unless other worlds follow.
                if not as_json and (len(results) > 1 or unjudged is None):
                    say(stacked(lines))
                    lines.clear()
    # What many worlds gave so far is worth keeping.
    except KeyboardInterrupt:
        if len(results) < 2:
            raise
        interrupted = True
    if unjudged is not None and len(results) == 1:
        raise unjudged
    # Report, and fail if a proof does not hold.
    summary = _summary(results)
    if interrupted:
        summary["interrupted"] = True
    if as_json:
        files = {"files": results, "summary": summary}
        emit_json(results[0] if len(results) == 1 else files)
    elif len(results) > 1:
        say(stacked(_summary_lines(summary)))
    if interrupted:
        note(f"interrupted; the summary covers the {len(results)} worlds so far", always=True)
        raise click.exceptions.Exit(130)
    if not all(result["certificate_valid"] or "unread" in result for result in results):
        raise click.exceptions.Exit(1)
    if any("unread" in result for result in results):
        raise click.exceptions.Exit(2)


def _overrides(radius: float | None, robot: dict[str, Any]) -> RobotOverrides:
    """Return the robot to ask about, after checking that there is only one."""
    overrides = RobotOverrides.of(robot)
    if radius is not None and overrides.footprint is not None:
        raise Instead("use --radius or --footprint, not both", "--radius")
    note_axle(overrides)
    return overrides


def _as_disc(world: World, radius: float | None) -> World:
    """Return the world with a disc in place of a footprint, if a radius is asked about."""
    if radius is None or all(robot.is_disc for robot in world.robots):
        return world
    robots = tuple(replace(one, footprint=(), radius=radius) for one in world.robots)
    return replace(world.bare, robots=robots, provenance=world.provenance)


def _body(world: World) -> dict[str, Any]:
    """Return what moves, if it is not one disc that turns on the spot."""
    robot = world.robots[0]
    if world.is_fleet or robot.is_round:
        return {}
    footprint = {"footprint": [list(corner) for corner in robot.footprint]}
    drive = {"turning_radius": robot.drive.turning_radius, "reverse": robot.drive.reverse}
    return {
        "body": describe_body(robot),
        **({} if robot.is_disc else footprint),
        **(drive if robot.drive.is_car else {}),
    }


def _without_widest(world: World, path: PurePath) -> InvalidParameter | None:
    """Return why the widest disc of a world is not defined; None if it is."""
    from worldgen.errors import InvalidParameter

    if world.is_fleet:
        return InvalidParameter(
            "several-robots",
            "{path} has {count} robots, but the widest disc is computed only for worlds with one "
            "robot",
            "use --radius R to find out whether discs of that radius get through",
            at_terminal=True,
            path=str(path),
            count=len(world.robots),
        )
    if world.is_dynamic:
        return InvalidParameter(
            "world-changes",
            "{path} changes, but the largest disc that could pass is defined only for static "
            "worlds",
            path=str(path),
        )
    return None


def _summary(results: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Count the answers about many worlds, and name the first in which the target is unreachable.

    A proof that does not hold counts as undecided.
    """
    from worldgen.support.intervals import interval_95

    total = len(results)
    if total < 2:
        return {}
    names = {
        answer: [result["path"] for result in results if result["result"] == answer]
        for answer in ("reachable", "blocked", "undecided")
    }
    reachable = len(names["reachable"])
    return {
        "worlds": total,
        **{answer: len(paths) for answer, paths in names.items()},
        "share": reachable / total,
        "interval": interval_95(reachable, total),
        "first_blocked": names["blocked"][:_FIRST],
    }


def _summary_lines(summary: dict[str, Any]) -> list[str]:
    low, high = (100 * end for end in summary["interval"])
    text = (
        f"{summary['worlds']} worlds: {summary['reachable']} reachable, "
        f"{100 * summary['share']:.1f} % (95 % interval {low:.1f} to {high:.1f}), "
        f"{summary['blocked']} blocked, {summary['undecided']} undecided"
    )
    first = summary["first_blocked"]
    if not first:
        return [text]
    more = summary["blocked"] - len(first)
    names = ", ".join(shown(path) for path in first)
    return [text, f"blocked: {names}" + (f" and {more} more" if more else "")]


def _line(result: dict[str, Any]) -> str:
    if result["certificate"] is None:
        verdict = f"undecided{_within(result)}: {result['reason']}"
    elif not result["certificate_valid"]:
        verdict = f"{result['certificate']} does not hold: {result['reason']}"
    else:
        how = "decided again and checked" if result["decided"] else "checked"
        disc = "a " + result.get("body", f"disc of {result['radius']:g} m")
        if "robots" in result:
            disc = f"the {result['robots']} robots together"
        disc += _within(result)
        verdict = (
            f"{result['result']} for {disc}, {result['certificate']} {how}: {result['reason']}"
        )
    if "margin" in result:
        late = result["margin"]
        latest = result["latest_start"]
        verdict += "; the witness may begin " + (
            "at any time" if late is None else f"up to {late:g} s late"
        )
        verdict += ", and on some path the robot may wait " + (
            "forever" if latest is None else f"until {latest:g} s"
        )
    at_all = (
        f"; the largest disc that could pass at all: {result['widest']:.6g} m"
        if "widest" in result
        else ""
    )
    if "widest_unknown" in result:
        why = _NO_WIDEST[result["widest_unknown"]]
        at_all = f"; the largest disc that could pass at all is not defined: {why}"
    return f"{shown(result['path'])}: {verdict}{at_all}"


def _within(result: dict[str, Any]) -> str:
    return f" within {result['deadline']:g} s" if "deadline" in result else ""

"""``worldgen verify``: check the proof in a file or, if there is none, decide the world."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from worldgen.cli.output import emit_json, json_option, say, shown
from worldgen.support.progress import working

if TYPE_CHECKING:
    from worldgen.world import Witness, World

__all__ = ["verify", "verify_world"]


@click.command(epilog="\b\n  worldgen verify w.grid\n  worldgen verify failures/ --json")
@click.argument(
    "paths", metavar="PATH...", nargs=-1, required=True, type=click.Path(path_type=Path)
)
@click.option(
    "--radius",
    type=float,
    metavar="R",
    help="Use a disc of this radius, m, instead of the robot's.",
)
@click.option(
    "--widest",
    is_flag=True,
    help="Also report the largest disc that could get to the target.",
)
@click.option(
    "--deadline",
    type=float,
    metavar="T",
    help="Require the robot to arrive within T seconds.",
)
@json_option
def verify(
    paths: tuple[Path, ...],
    radius: float | None,
    widest: bool,
    deadline: float | None,
    as_json: bool,
) -> None:
    """Check a world's proof, or decide whether a target can be reached.

    A file's certificate is checked by code that shares nothing with the code that made it. A map
    without a certificate is decided, as is one whose certificate does not cover the requested
    radius; the result is then checked in the same way. A folder or an archive stands for the .grid
    files in it.

    For a world that changes, it also reports how late the robot may set out: on the witness (its
    margin), and on any path (the latest start).

    Exits with 0 if every certificate is valid or every map could be decided (blocked is an answer
    too), with 1 if a certificate is invalid or a map remains undecided, with 2 if a file cannot be
    read.
    """
    from worldgen.errors import InvalidParameter
    from worldgen.files.worlds import read_worlds
    from worldgen.reach import widest_disc

    results: list[dict[str, Any]] = []
    with working("verifying") as work:
        for path, world in read_worlds(paths):
            work.say(f"{path}, world {len(results) + 1}")
            results.append({"path": str(path), **verify_world(world, radius, deadline)})
            if widest and world.others:
                raise InvalidParameter(
                    "several-robots",
                    "{path} has {count} robots, and the widest disc is looked for one robot only",
                    "ask with --radius R whether discs of R get through",
                    at_terminal=True,
                    path=str(path),
                    count=len(world.robots),
                )
            if widest:
                work.say(f"{path}: looking for the largest disc that could pass")
                results[-1]["widest"] = widest_disc(world)
            # Each result is printed as soon as it is known, since one can take minutes.
            if not as_json:
                say(_line(results[-1]))
    if as_json:
        emit_json(results[0] if len(results) == 1 else {"files": results})
    if not all(result["certificate_valid"] for result in results):
        raise click.exceptions.Exit(1)


def verify_world(
    world: World, radius: float | None = None, deadline: float | None = None
) -> dict[str, Any]:
    """Check a world's certificate, or decide the world and check that.

    Args:
        world: The world.
        radius: Radius of the disc, m; the robot's if omitted.
        deadline: Time, s, by which the robot must be in the target; None for any time.

    Returns:
        ``result``, ``certificate`` (witness, cut, confinement, swap or None), ``certificate_valid``,
        ``decided`` (again, or read from the file), ``clearance``, ``radius`` and ``reason``;
        ``deadline`` if there is one; ``robots``, their number, if there are several, and then
        ``radius`` is the largest of theirs; of a witness in a world that changes, or under a deadline,
        also ``margin`` and ``latest_start``: s by which it may begin later, and until which the
        robot may wait at the start if it may take any path; None for any time.

    Raises:
        InvalidParameter: If the radius or the deadline isn't a finite number above 0.
    """
    from worldgen.reach import (
        BLOCKED,
        REACHABLE,
        UNDECIDED,
        check_certificate,
        check_confinement,
        check_swap,
        decide_in_time,
        until,
    )
    from worldgen.reach.decision import Decision, check_deadline, check_radius
    from worldgen.world import Cut, Witness

    # Use the file's own certificate if it is about this question; otherwise decide.
    asked = max(robot.radius for robot in world.robots) if radius is None else radius
    check_radius(asked, world.cell_size)
    check_deadline(deadline)
    decision = Decision(UNDECIDED, world.certificate, "")
    afresh = False
    if not _answers(world, radius, deadline):
        decision = decide_in_time(world, deadline, radius=radius)
        afresh = True
    # Begin with an answer for the case that nothing is proved.
    certificate = decision.certificate
    answer: dict[str, Any] = {
        "result": UNDECIDED,
        "certificate": None,
        "certificate_valid": False,
        "decided": afresh,
    }
    answer |= {"clearance": None, "radius": asked, "reason": decision.reason}
    answer |= {} if deadline is None else {"deadline": deadline}
    answer |= {"robots": len(world.robots)} if world.others else {}
    # Check the proof, with code that shares nothing with the prover.
    ahead = world if deadline is None else until(world, deadline)
    if certificate is not None:
        report = check_certificate(
            world if certificate is world.certificate else ahead, certificate, radius=radius
        )
        kind, claim = ("cut", BLOCKED) if isinstance(certificate, Cut) else ("witness", REACHABLE)
        answer |= {
            "result": claim if report.valid else UNDECIDED,
            "certificate": kind,
            "clearance": report.clearance,
        }
        answer |= {"certificate_valid": report.valid, "reason": report.reason}
        if (
            report.valid
            and isinstance(certificate, Witness)
            and (world.is_dynamic or deadline is not None)
        ):
            answer |= _lateness(world, certificate, asked, deadline)
    elif decision.confinement is not None:
        report = check_confinement(ahead, decision.confinement, radius=asked)
        answer |= {"result": BLOCKED if report.valid else UNDECIDED, "certificate": "confinement"}
        answer |= {"certificate_valid": report.valid, "reason": report.reason}
    elif decision.swap is not None:
        report = check_swap(world, decision.swap, radius=radius)
        answer |= {"result": BLOCKED if report.valid else UNDECIDED, "certificate": "swap"}
        answer |= {"certificate_valid": report.valid, "reason": report.reason}
    return answer


def _answers(world: World, radius: float | None, deadline: float | None) -> bool:
    """Return True if the certificate in the file is about the question.

    It may still be invalid.
    """
    from worldgen.reach import check_certificate
    from worldgen.world import Cut

    certificate = world.certificate
    is_other = radius is not None and any(radius != robot.radius for robot in world.robots)
    if certificate is None or (is_other and not check_certificate(world, radius=radius).valid):
        return False
    return deadline is None or isinstance(certificate, Cut) or certificate.duration <= deadline


def _lateness(
    world: World, witness: Witness, radius: float, deadline: float | None
) -> dict[str, float | None]:
    """Return how much later the witness may begin, and any path."""
    from worldgen.reach import latest_start, witness_margin

    margin = witness_margin(world, witness, radius=radius) if world.is_dynamic else math.inf
    if deadline is not None:
        margin = min(margin, deadline - witness.duration)
    latest = max(latest_start(world, deadline, radius=radius) or 0.0, margin)
    return {"margin": _finite(margin), "latest_start": _finite(latest)}


def _finite(seconds: float) -> float | None:
    return round(seconds, 9) if math.isfinite(seconds) else None


def _line(result: dict[str, Any]) -> str:
    if result["certificate"] is None:
        verdict = f"undecided{_within(result)}: {result['reason']}"
    elif not result["certificate_valid"]:
        verdict = f"{result['certificate']} does not hold: {result['reason']}"
    else:
        how = "decided again and checked" if result["decided"] else "checked"
        disc = f"a disc of {result['radius']:g} m"
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
        f"; the largest disc that could pass at all: {result['widest']:.9g} m"
        if "widest" in result
        else ""
    )
    return f"{shown(result['path'])}: {verdict}{at_all}"


def _within(result: dict[str, Any]) -> str:
    return f" within {result['deadline']:g} s" if "deadline" in result else ""

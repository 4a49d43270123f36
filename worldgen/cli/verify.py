"""``worldgen verify``: is the proof in the file true; and if there is none, what is true."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from worldgen.cli.output import emit_json, json_option

if TYPE_CHECKING:
    from worldgen.world import World

__all__ = ["verify", "verify_world"]


@click.command()
@click.argument("paths", metavar="PATH...", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--radius", type=float, metavar="R", help="Ask for a disc of this radius, m, instead of the robot's.")
@click.option("--widest", is_flag=True, help="Say too which is the largest disc that could get to the target at all.")
@json_option
def verify(paths: tuple[Path, ...], radius: float | None, widest: bool, as_json: bool) -> None:
    """Check a world's proof, or decide a map afresh.

    A file's certificate is checked by code that shares nothing with the code that made it. A map without a
    certificate is decided afresh, and so is a certificate that says nothing about the radius asked for; what
    was decided is then checked in the same way. A folder or an archive stands for the
    .grid files in it.

    Exits with 0 if every certificate holds or every map could be decided (blocked is an answer too), with 1
    if a certificate does not hold or a map stays undecided, with 2 if a file cannot be read.
    """
    from worldgen.reach import widest_disc
    from worldgen.world_files import read_worlds

    results = []
    for path, world in read_worlds(paths):
        results.append({"path": str(path), **verify_world(world, radius)})
        if widest:
            results[-1]["widest"] = widest_disc(world)
        if not as_json:
            click.echo(_line(results[-1]))
    if as_json:
        emit_json(results[0] if len(results) == 1 else {"files": results})
    if not all(result["certificate_valid"] for result in results):
        raise click.exceptions.Exit(1)


def verify_world(world: World, radius: float | None = None) -> dict[str, Any]:
    """Checks a world's certificate, or decides the world and checks that.

    Args:
        world: The world.
        radius: Radius of the disc, m; the robot's where left out.

    Returns:
        ``result``, ``certificate`` (witness, cut or None), ``certificate_valid``, ``decided`` (afresh,
        or read from the file), ``clearance``, ``radius`` and ``reason``; of a witness in a world that changes
        also ``margin``: s by which it may begin later, None for any time.

    Raises:
        InvalidParameter: If the radius is not a finite number above 0.
    """
    from worldgen.reach import BLOCKED, REACHABLE, UNDECIDED, check_certificate, decide, witness_margin
    from worldgen.reach.decision import check_radius
    from worldgen.world import Witness

    asked = world.robot_radius if radius is None else radius
    check_radius(asked)
    certificate, afresh, reason = world.certificate, False, ""
    fits = asked == world.robot_radius or check_certificate(world, radius=asked).valid
    if certificate is None or not fits:
        decision = decide(world, radius=asked)
        certificate, afresh, reason = decision.certificate, True, decision.reason
    answer: dict[str, Any] = {"result": UNDECIDED, "certificate": None, "certificate_valid": False, "decided": afresh}
    answer |= {"clearance": None, "radius": asked, "reason": reason}
    if certificate is not None:
        report = check_certificate(world, certificate, radius=asked)
        kind, claim = ("witness", REACHABLE) if isinstance(certificate, Witness) else ("cut", BLOCKED)
        answer |= {"result": claim if report.valid else UNDECIDED, "certificate": kind}
        answer |= {"certificate_valid": report.valid, "clearance": report.clearance, "reason": report.reason}
        if world.is_dynamic and report.valid and isinstance(certificate, Witness):
            answer["margin"] = _finite(witness_margin(world, certificate, radius=asked))
    return answer


def _finite(seconds: float) -> float | None:
    return round(seconds, 9) if math.isfinite(seconds) else None


def _line(result: dict[str, Any]) -> str:
    if result["certificate"] is None:
        verdict = f"undecided: {result['reason']}"
    elif not result["certificate_valid"]:
        verdict = f"{result['certificate']} does not hold: {result['reason']}"
    else:
        how = "decided afresh and checked" if result["decided"] else "checked"
        disc = f"a disc of {result['radius']:g} m"
        verdict = f"{result['result']} for {disc}, {result['certificate']} {how}: {result['reason']}"
    if "margin" in result:
        verdict += ", if it begins " + (
            "at any time" if result["margin"] is None else f"up to {result['margin']:g} s late"
        )
    at_all = f"; the largest disc that could pass at all: {result['widest']:.9g} m" if "widest" in result else ""
    return f"{result['path']}: {verdict}{at_all}"

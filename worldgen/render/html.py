"""Render a picture as one self-contained HTML page: no script, no font, no external address."""

from __future__ import annotations

import html

from worldgen.render.body_parts import spare_words
from worldgen.render.caption import facts, printable
from worldgen.render.frame import DEFAULT_PIXELS
from worldgen.render.marks import DARK, hue
from worldgen.render.overlay import Trails
from worldgen.render.scene import compose
from worldgen.render.svg import svg_element
from worldgen.robot_overrides import describe_body
from worldgen.support.plain_text import describe_value
from worldgen.world import JointWitness, Witness, World

STYLE = f"""
body {{ font: 15px/1.5 system-ui, Helvetica, Arial, sans-serif; margin: 2rem auto; max-width: 60rem;
       padding: 0 1rem; color: {hue("ink")}; background: {hue("paper")}; }}
h1 {{ font-size: 1.25rem; }}
figure {{ margin: 0; }}
svg {{ width: 100%; height: auto; max-height: 85vh; background: {hue("paper")}; }}
table {{ border-collapse: collapse; margin-top: 1.5rem; }}
th, td {{ text-align: left; vertical-align: top; padding: .2rem 1.2rem .2rem 0;
         border-top: 1px solid {hue("rule")}; }}
th {{ font-weight: 600; white-space: nowrap; }}
td {{ overflow-wrap: anywhere; }}
@media (prefers-color-scheme: dark) {{
  body {{ color: {hue("ink", DARK)}; background: {hue("paper", DARK)}; }}
  th, td {{ border-color: {hue("rule", DARK)}; }}
}}
"""


def draw_html(
    world: World,
    *,
    trail: Trails = None,
    signal: bool = True,
    witness: bool = True,
    title: str = "",
    pixels: int = DEFAULT_PIXELS,
) -> str:
    """Return the picture of a world as an HTML page, with a table of facts about it.

    Args:
        world: What to draw.
        trail: A robot's trail; for several robots, one trail for each.
        signal: True to tint the floor by the strength of the target's signal.
        witness: True to draw the certificate's path, or its cut.
        title: The page's title, and the first line of the caption.
        pixels: Longer side of the map in the SVG's units; the page scales it to the window.

    Raises:
        InvalidParameter: If ``pixels`` is out of range.
    """
    scene = compose(world, trail, signal=signal, witness=witness, title=title, pixels=pixels)
    name = html.escape(printable(title)) or "A world"
    rows = "\n".join(
        f"<tr><th>{html.escape(printable(key))}</th><td>{html.escape(printable(value))}</td></tr>"
        for key, value in _known(world)
    )
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta name="viewport" content="width=device-width, '
        f'initial-scale=1">\n<title>{name}</title>\n'
        f"<style>{STYLE}</style>\n</head>\n<body>\n<h1>{name}</h1>\n"
        f"<figure>\n{svg_element(scene, standalone=False)}</figure>\n"
        f"<table>\n{rows}\n</table>\n</body>\n</html>\n"
    )


def _known(world: World) -> list[tuple[str, str]]:
    start = world.start
    target = world.target
    robot = world.robots[0]
    body = f"radius {robot.radius:.6g} m"
    if not robot.is_disc or robot.drive.is_car:
        body = describe_body(robot)
    # Describe the world.
    rows = [
        ("world", facts(world)),
        ("cells", f"{world.width} x {world.height}, {world.solid_cells} solid"),
        ("start", f"({start.x:.6g}, {start.y:.6g}) m, heading {start.heading:.6g} rad"),
        ("target", f"({target.x:.6g}, {target.y:.6g}) m, radius {target.radius:.6g} m"),
        ("robot", f"{body}, speed {world.robot_speed:.6g} m/s"),
    ]
    if world.is_dynamic:
        rows.append(("changes", f"{len(world.timeline)} until {world.timeline.last_time:.6g} s"))
    # Describe its proof.
    proof = world.certificate
    if isinstance(proof, Witness):
        spare = spare_words(world, proof)
        spare = f"lets {proof.clearance:.6g} m through" if spare is None else f"fits: {spare}"
        rows.append(("proof", f"a path of {proof.length:.6g} m that {spare}"))
    elif isinstance(proof, JointWitness):
        rows.append(
            (
                "proof",
                f"{len(proof.paths)} paths, the last of which arrives after {proof.duration:.6g} s",
            )
        )
    elif proof is not None:
        rows.append(
            (
                "proof",
                f"a cut of {len(proof.cells)} cells that stops discs above {proof.clearance:.6g} m",
            )
        )
    # Describe its origin and its failure.
    made = world.provenance
    if made is not None:
        rows.append(("made by", f"{made.family}, version {made.version}, seed {made.seed}"))
        rows += [
            (f"{made.family}: {key}", describe_value(value)) for key, value in made.params.items()
        ]
    failure = world.failure
    if failure is not None:
        rows.append(
            (
                "failure",
                f"{failure.controller} under {failure.motion}, seed {failure.seed}: "
                f"{failure.outcome}",
            )
        )
        rows.append(("trace digest", failure.trace_digest))
        for words in (failure.evidence, failure.parameters, failure.details):
            rows += [(key, describe_value(value)) for key, value in words.items()]
    return rows

"""``worldgen export``: write a world in another program's format."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from worldgen.cli.output import PATH, emit_json, force_option, json_option, note, say
from worldgen.support.progress import working

if TYPE_CHECKING:
    from worldgen import interop

EXAMPLES = (
    "\b\n  worldgen export w.grid --to ros --out office.yaml\n"
    "  worldgen export w.grid --to movingai --out arena.map\n"
    "  worldgen export fire.grid --to thesis+noise=on --at 0 --out old.gex"
)


@click.command(epilog=EXAMPLES)
@click.argument("world", type=PATH)
@click.option(
    "--to",
    "name",
    metavar="FORMAT[+OPTION=VALUE]",
    help=(
        "Format to write, as listed by `worldgen formats`; if omitted, the ending of --out decides."
    ),
)
@click.option("--out", "-o", type=PATH, required=True, help="The file to write.")
@click.option(
    "--at",
    type=float,
    metavar="SECONDS",
    help="Export the cells at this time, for a world that changes.",
)
@click.option(
    "--origin",
    metavar="X,Y",
    help="Position of the grid's lower-left corner, m.  [default: as imported, or 0,0]",
)
@click.option(
    "--sidecar/--no-sidecar",
    default=True,
    help="Keep facts that the format cannot store in a file next to it.",
)
@force_option
@json_option
def export(
    world: Path,
    name: str | None,
    out: Path,
    at: float | None,
    origin: str | None,
    sidecar: bool,
    force: bool,
    as_json: bool,
) -> None:
    """Write a world in another program's format.

    WORLD is a .grid file. A world that the format cannot express is an error. Facts that it cannot
    store are listed on stderr and kept in a sidecar (OUT.worldgen.grid), from which `worldgen
    import` restores them.
    """
    from worldgen import interop
    from worldgen.files.worlds import read_whole_world

    with working(f"exporting {world}"):
        export = interop.export_world(
            read_whole_world(world),
            name or interop.guess_format(out.name),
            file=out.name,
            at=at,
            origin=None if origin is None else _origin(origin),
            sidecar=sidecar,
        )
    paths = interop.write_export(export, out.parent, force=force)
    kept = [f"the exact values are in {export.sidecar}"] if export.sidecar else []
    for sentence in (*export.lost, *kept, *export.notes):
        note(sentence)
    if as_json:
        emit_json(_as_json(paths, export))
    else:
        for path, data in zip(paths, export.files.values(), strict=True):
            say(f"{path}: {len(data)} bytes for {export.format.name}")


def _origin(text: str) -> tuple[float, float]:
    from worldgen.errors import InvalidParameter
    from worldgen.interop import parse_point

    point = parse_point("origin", text, "YAW")
    if len(point) != 2:
        raise InvalidParameter(
            "wrong-form",
            "origin={text!r} has three numbers",
            "use only X,Y: worlds are not turned",
            text=text[:60],
        )
    return point[0], point[1]


def _as_json(paths: list[Path], export: interop.Export) -> dict[str, object]:
    import hashlib

    return {
        "file": str(paths[0]),
        "format": export.format.name,
        "bytes": len(export.data),
        "sha256": hashlib.sha256(export.data).hexdigest(),
        "files": [str(path) for path in paths],
        "lost": list(export.lost),
        "notes": list(export.notes),
    }

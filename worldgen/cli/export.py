"""``worldgen export``: a world becomes a file of some other program."""

from __future__ import annotations

from pathlib import Path

import click

from worldgen.cli.output import emit_json, force_option, json_option, note, write_bytes

__all__ = ["export"]


EXAMPLES = "\b\n  worldgen export w.grid --to thesis --out old.gex"


@click.command(epilog=EXAMPLES)
@click.argument("path", type=click.Path(path_type=Path))
@click.option("--to", "name", metavar="FORMAT", required=True, help="thesis, package.module:name, or ./file.py:name.")
@click.option("--out", "-o", type=click.Path(path_type=Path), required=True, help="The file to write.")
@click.option(
    "--noise/--no-noise",
    default=None,
    help="Pass a thesis map through the noise filter.  [default: as it was imported]",
)
@force_option
@json_option
def export(path: Path, name: str, out: Path, noise: bool | None, force: bool, as_json: bool) -> None:
    """Write a world in another program's format.

    PATH is a .grid file. What the format cannot hold is an error; what it leaves out is said on stderr.
    """
    import hashlib

    from worldgen import interop
    from worldgen.grid_file import read_world

    exported = interop.export_world(read_world(path), name, interop.ExportOptions(noise))
    write_bytes(out, exported.data, force=force)
    for sentence in exported.notes:
        note(sentence)
    if as_json:
        digest = hashlib.sha256(exported.data).hexdigest()
        size, notes = len(exported.data), list(exported.notes)
        emit_json({"file": str(out), "format": name, "bytes": size, "sha256": digest, "notes": notes})
    else:
        click.echo(f"{out}: {len(exported.data)} bytes for {name}")

"""``worldgen families``: list the families of worlds."""

from __future__ import annotations

import click

from worldgen.cli.output import emit_list, json_option

EXAMPLES = "\b\n  worldgen families\n  worldgen maze --help"


@click.command(epilog=EXAMPLES)
@json_option
def families(as_json: bool) -> None:
    """List the families of worlds.

    Each is a command: `worldgen maze --help` describes its options.
    """
    from worldgen.family import FAMILIES

    rows = []
    for name in FAMILIES:
        one = FAMILIES.get(name)
        parameters = [
            {"name": each.name, "default": each.default, "choices": list(each.choices), "help": each.note}
            for each in one.parameters
        ]  # fmt: skip
        about = one.description.partition("\n\n")[0]
        rows.append(
            {"name": name, "about": about, "changes": one.changes, "parameters": parameters}
        )
    emit_list("families", rows, {"name": "family", "about": "what it does"}, as_json=as_json)

"""``worldgen oracles``: list the oracles that ``fuzz --oracle`` adds."""

from __future__ import annotations

import inspect

import click

from worldgen.cli.output import emit_list, json_option

EXAMPLES = (
    "\b\n  worldgen oracles\n"
    "  worldgen fuzz --controller bug2 --oracle detour=5 --budget 60s --out failures/"
)


@click.command(epilog=EXAMPLES)
@json_option
def oracles(as_json: bool) -> None:
    """List the oracles that fuzz --oracle adds to the verdict.

    docs/reference/verdicts.md explains what each one objects to, and how to write your own.
    """
    from fuzz.oracles import ORACLES

    rows = []
    for name in ORACLES:
        function = ORACLES.get(name)
        about = (inspect.getdoc(function) or "").partition("\n\n")[0].replace("``", "")
        number = list(inspect.signature(function).parameters.values())[1:]
        form = "".join("=NUMBER" if one.default is one.empty else "[=NUMBER]" for one in number)
        rows.append({"name": name, "written": name + form, "about": about})
    emit_list("oracles", rows, {"written": "oracle", "about": "what it does"}, as_json=as_json)

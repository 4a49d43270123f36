"""``worldgen formats``: list what ``import`` reads and ``export`` writes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from worldgen.cli.output import emit_list, json_option, say

if TYPE_CHECKING:
    from worldgen.interop import Format
    from worldgen.parameters import Parameter

EXAMPLES = "\b\n  worldgen formats\n  worldgen formats ros"


@click.command(epilog=EXAMPLES)
@click.argument("name", required=False)
@json_option
def formats(name: str | None, as_json: bool) -> None:
    """List the formats that import and export know.

    With NAME, list the options of that format.
    """
    from worldgen.interop import FORMATS, HELD

    names = FORMATS.names() if name is None else [name]
    known = [FORMATS.get(one) for one in names]
    if name is not None and not as_json:
        _print_one(known[0])
        return
    rows = [
        {
            "name": one.name, "direction": one.direction, "files": one.summary, "suffixes": list(one.suffixes),
            "holds": [held for held in HELD if held in one.holds], "changes": one.changes, "client": one.client,
            "read_options": _options(one.read_options), "write_options": _options(one.write_options),
        }
        for one in known
    ]  # fmt: skip
    columns = {"name": "format", "direction": "way", "files": "files"}
    emit_list("formats", rows, columns, as_json=as_json)


def _options(parameters: tuple[Parameter, ...]) -> list[dict[str, object]]:
    return [
        {"name": one.name, "default": one.default, "choices": list(one.choices), "help": one.help}
        for one in parameters
    ]


def _print_one(known: Format) -> None:
    from worldgen.interop import HELD

    say(
        f"{known.name} ({known.direction}): {known.summary}; for "
        f"{known.client or 'any program that reads it'}"
    )
    held = [HELD[name] for name in HELD if name in known.holds]
    say(
        f"holds the "
        f"cells{''.join(f', {one}' for one in held)}{', changes' if known.changes else ''}"
    )
    for flag, parameters in (("--from", known.read_options), ("--to", known.write_options)):
        for one in parameters:
            values = "|".join(one.choices) or type(one.default).__name__
            say(f"{flag} {known.name}+{one.name}={values}  {one.help}  [default: {one.default}]")

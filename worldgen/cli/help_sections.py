"""The sections of a command's help: its own options first, and those of many commands below."""

from __future__ import annotations

from collections.abc import Sequence

import click

SECTIONS: dict[str, tuple[str, ...]] = {
    "Runs": ("motion", "task", "steps", "time_step", "vary", "oracles"),
    "Robot and goal": (
        "footprint",
        "drive",
        "turning_radius",
        "reverse",
        "steering_rate",
        "arrival",
        "target_radius",
        "target_heading",
        "contact",
        "waypoints",
    ),
    "Search": ("strategies", "shrink", "pace", "examples", "epoch", "workers", "scheduler"),
    "Known failures and CI": (
        "baseline",
        "strict",
        "count_hazards",
        "accept_no_answer",
        "no_code",
        "junit",
        "sarif",
        "summary",
    ),
    "Sets of worlds": ("count", "blocked", "metrics", "where", "difficulty"),
}
"""Names of the options in each section below the first, by its title."""

COMMON = "Common options"
_COMMON = ("as_json", "force", "quiet", "verbose", "trust")

# A section of fewer would be harder to read than a longer first one.
_FEWEST = 3


def sections_of(
    command: click.Command, context: click.Context
) -> list[tuple[str, Sequence[click.Option]]]:
    """Return a command's options, each in one section, with the sections' titles in their order."""
    options = [one for one in command.get_params(context) if isinstance(one, click.Option)]
    by_name = {one.name: one for one in options}
    below = []
    for title, names in SECTIONS.items():
        members = [by_name[name] for name in names if name in by_name]
        if len(members) >= _FEWEST:
            below.append((title, members))
    # click's own --help has a name of click's own.
    help_option = command.get_help_option(context)
    common = [one for one in options if one.name in _COMMON or one is help_option]
    elsewhere = {id(one) for _, members in (*below, (COMMON, common)) for one in members}
    first = [one for one in options if id(one) not in elsewhere]
    return [("Options", first), *below, (COMMON, common)]


def format_options(
    command: click.Command, context: click.Context, formatter: click.HelpFormatter
) -> None:
    """Write the options of a command in sections, as :meth:`click.Command.format_options` does."""
    for title, options in sections_of(command, context):
        rows = [row for one in options if (row := one.get_help_record(context)) is not None]
        if rows:
            with formatter.section(title):
                formatter.write_dl(rows)

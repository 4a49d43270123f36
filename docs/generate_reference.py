"""Write the reference pages that come from the code: the command line and the Python API.

``conf.py`` calls this at the start of every build, so that the site cannot disagree with the code.
The pages are not kept in the repository.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from pathlib import Path

import click

WIDTH = 96
"""Columns of the help texts, which fit the site's text column."""

MODULES = (
    "worldgen",
    "worldgen.families",
    "worldgen.compose",
    "worldgen.sets",
    "worldgen.difficulty",
    "worldgen.gym",
    "sim",
    "sim.audit",
    "fuzz",
    "fuzz.corpus",
)


def write_pages(folder: Path) -> None:
    """Write every generated page into a folder, leaving a page alone that is already the same."""
    folder.mkdir(parents=True, exist_ok=True)
    pages = {"command-line.md": command_line_page(), "python-api.md": python_page()}
    for name, text in pages.items():
        file = folder / name
        if not file.exists() or file.read_text(encoding="utf-8") != text:
            file.write_text(text, encoding="utf-8")


def command_line_page() -> str:
    """Return the page of all commands, each with its help text as ``--help`` prints it."""
    from worldgen.cli.main import cli

    parts = [
        "# Command line",
        "Every command with its options, as `worldgen COMMAND --help` prints them.",
        _fenced(_help_of(cli, "worldgen", None)),
    ]
    for name, command, parent in _commands_of(cli, "worldgen"):
        parts.append(f"## {name}")
        parts.append(_fenced(_help_of(command, name, parent)))
    return "\n\n".join(parts) + "\n"


def python_page() -> str:
    """Return the page of the public modules, which Sphinx fills from their docstrings."""
    parts = [
        "# Python API",
        "What each module lists in its `__all__`. Everything else may change without notice.",
    ]
    for name in MODULES:
        module = importlib.import_module(name)
        parts.append(f"## {name}")
        parts.append((module.__doc__ or "").partition("\n")[0])
        lines: list[str] = []
        for member in sorted(module.__all__):
            value = getattr(module, member)
            directive = _directive_for(value)
            lines += ["", f".. {directive}:: {name}.{member}"]
            if directive == "autoclass":
                lines.append("   :members:")
            elif directive == "autodata":
                lines.append("   :no-value:")
        parts.append("```{eval-rst}\n" + "\n".join(lines) + "\n```")
    return "\n\n".join(parts) + "\n"


def _directive_for(value: object) -> str:
    """Return the directive of autodoc that documents a public name with this value."""
    if isinstance(value, type):
        return "autoclass"
    return "autofunction" if callable(value) else "autodata"


def _commands_of(
    group: click.Group, prefix: str
) -> Iterator[tuple[str, click.Command, click.Context]]:
    """Yield every command below a group: its full name, itself and the context of its parent."""
    context = click.Context(group, info_name=prefix, terminal_width=WIDTH, max_content_width=WIDTH)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        if command is None or command.hidden:
            continue
        yield f"{prefix} {name}", command, context
        if isinstance(command, click.Group):
            yield from _commands_of(command, f"{prefix} {name}")


def _help_of(command: click.Command, name: str, parent: click.Context | None) -> str:
    context = click.Context(
        command,
        info_name=name.rsplit(" ", 1)[-1],
        parent=parent,
        terminal_width=WIDTH,
        max_content_width=WIDTH,
    )
    return command.get_help(context)


def _fenced(text: str) -> str:
    return f"```text\n{text}\n```"

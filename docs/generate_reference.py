"""Write the reference that comes from the code.

The command line and the Python API are pages. The tables of families, options, controllers,
behaviours, shrinking, metrics and the CI action are parts, which other pages include. ``conf.py``
calls this at the start of every build, so that the site cannot disagree with the code. The pages are
not kept in the repository.
"""

from __future__ import annotations

import importlib
import json
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import click
import draw_gallery
import yaml
from click.testing import CliRunner

from worldgen.family import FAMILIES, Family
from worldgen.parameters.declared import Parameter, parameters_of_fields

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


_BOUNDLESS = 1e6  # a limit from which it only excludes nonsense
_EVERY_COMMAND = re.compile(
    r"^  (?:-q, --quiet|-v, --verbose|--trust|-h, --help) .*\n(?: {6,}.*\n)*", re.MULTILINE
)
_ROBOT = re.compile(r"^Robot and goal:\n(?:  .*\n)+\n", re.MULTILINE)
"""The section of help that is the same in every command."""
SHARED = ("size", "cell_size", "robot_radius", "robot_speed")
"""Parameters of every family; all but the first are explained once."""


def write_pages(folder: Path) -> None:
    """Write every generated page and part into a folder, leaving alone what is already the same."""
    (folder / "parts").mkdir(parents=True, exist_ok=True)
    pages = {"command-line.md": command_line_page(), "python-api.md": python_page()}
    pages |= {f"parts/{name}.md": text for name, text in parts().items()}
    for name, text in pages.items():
        file = folder / name
        if not file.exists() or file.read_text(encoding="utf-8") != text:
            file.write_text(text, encoding="utf-8")


def command_line_page() -> str:
    """Return the page of all commands, each with its help text as ``--help`` prints it."""
    from worldgen.cli.main import cli

    parts = [
        "# Command line",
        "Every command with its options, as `worldgen COMMAND --help` prints them. Each also has "
        "`--quiet` (only results and errors), `--verbose` (when slow steps begin and end), `--trust`"
        " (run all code that the files name, even if you have not run it before) and `--help`. The "
        "options of robot and goal are those of [`worldgen run`](#worldgen-run) everywhere.",
        _fenced(_help_of(cli, "worldgen", None)),
    ]
    for name, command, parent in _commands_of(cli, "worldgen"):
        family = name.removeprefix("worldgen ")
        if family in FAMILIES.names() and family != "maze":
            continue
        parts.append(f"## {name}")
        if family == "maze":
            parts.append(
                "Every [family](../families.md) is a command like this one, with parameters of its own."
            )
        text = _help_of(command, name, parent)
        parts.append(_fenced(text if name == "worldgen run" else _ROBOT.sub("", text)))
    return "\n\n".join(parts) + "\n"


def parts() -> dict[str, str]:
    """Return the tables that other pages include, by name."""
    from fuzz.commands.help import NOT_PROVED, PROVED
    from fuzz.shrink import ORDER, PASSES
    from sim.options.robot import RobotOptions
    from sim.options.thesis import ThesisOptions

    made = {f"family-{name}": _family_part(FAMILIES.get(name)) for name in FAMILIES.names()}
    shared = [known for known in FAMILIES.get("trap").parameters if known.name in SHARED]
    made["gallery"] = draw_gallery.section()
    made["family-all"] = _parameter_table(shared)
    made["robot-options"] = _option_table(RobotOptions)
    made["thesis-options"] = _option_table(ThesisOptions)
    made["controllers"] = _controllers_table()
    made["behaviours"] = _behaviours_table()
    made["shrink-measures"] = _table(("measure", "less of"), _named(ORDER))
    made["shrink-passes"] = _table(("pass", "what it does"), _named(PASSES))
    made["metrics"] = _metrics_table()
    made["proved"] = _table(("claim", "why you can rely on it"), PROVED)
    made["not-proved"] = _table(("result", "what it means"), NOT_PROVED)
    made["import-options"] = _command_options_table("import")
    made |= _action_tables()
    return made


def _family_part(family: Family) -> str:
    """Return what a family is for, and its own parameters."""
    own = (known for known in family.parameters if known.name not in SHARED)
    return f"{family.description}\n\n{_parameter_table(own)}"


def _parameter_table(parameters: Iterable[Parameter]) -> str:
    """Return a table of parameters as Python names them, with their defaults and limits."""
    rows = ((f"`{one.name}`", f"`{one.python_default}`", _meaning(one)) for one in parameters)
    return _table(("parameter", "default", "meaning"), rows)


def _option_table(options: type) -> str:
    """Return a table of the fields of a dataclass of options, by their groups."""
    fields = sorted(parameters_of_fields(options), key=lambda one: one.group)
    rows = ((one.group, f"`{one.name}`", f"`{_default(one)}`", _meaning(one)) for one in fields)
    return _table(("", "option", "default", "meaning"), rows)


def _default(one: Parameter) -> str:
    if one.kind is bool:
        return "on" if one.default else "off"
    if one.kind is tuple:
        return "none"
    return f"{one.default:.4g}" if one.kind is float else str(one.default)


def _meaning(one: Parameter) -> str:
    """Return what a parameter means, with its words or its limits where its help lacks them."""
    text = one.help.replace("``", "`")
    explained = any(f"{word}:" in text or f"`{word}`" in text for word in one.choices)
    if one.choices and not explained:
        text = f"{text.rstrip('.')}: {', '.join(f'`{word}`' for word in one.choices)}."
    bounds = one.bounds
    if bounds is None or (bounds.high is not None and bounds.high >= _BOUNDLESS):
        return text
    rule = bounds.rule
    if not rule or rule.removesuffix(bounds.unit).strip() in text:
        return text
    return f"{text} {rule[0].upper()}{rule[1:]}."


def _controllers_table() -> str:
    rows = (
        (f"`{row['name']}`", row["in_words"], row["about"])
        for row in _listed("controllers")["controllers"]
    )
    return _table(("controller", "senses", "what it does"), rows)


def _behaviours_table() -> str:
    rows = (
        (f"`{row['name']}`", row["when"], row["does"], _options(row["options"]))
        for row in _listed("behaviours")["behaviours"]
    )
    return _table(("behaviour", "applies when", "what the robot does", "options"), rows)


def _named(listed: Iterable[Any]) -> Iterator[tuple[str, str]]:
    """Yield the name of each measure or pass of the shrinker, and what it says of itself."""
    return ((f"`{one.name}`", one.says) for one in listed)


def _metrics_table() -> str:
    from worldgen.difficulty import METRICS

    harder = {1: "more", -1: "less", 0: ""}
    rows = (
        (f"`{name}`", one.unit, harder[one.harder], one.meaning) for name, one in METRICS.items()
    )
    return _table(("metric", "unit", "harder", "meaning"), rows)


def _command_options_table(name: str) -> str:
    """Return a table of a command's own options, with what ``--help`` says about each."""
    from worldgen.cli.main import cli

    command = cli.get_command(click.Context(cli), name)
    assert command is not None
    options = (one for one in command.params if isinstance(one, click.Option) and one.help)
    rows = (
        (", ".join(f"`{known}`" for known in one.opts if known.startswith("--")), one.help or "")
        for one in options
        if not {"--quiet", "--verbose", "--trust"} & set(one.opts)
    )
    return _table(("option", "meaning"), rows)


def _action_tables() -> dict[str, str]:
    """Return the tables of what the CI action takes and gives."""
    plan = yaml.safe_load((Path(__file__).parents[1] / "action.yml").read_text(encoding="utf-8"))
    inputs = (
        (f"`{name}`", f"`{one['default']}`" if one.get("default") else "", one["description"])
        for name, one in plan["inputs"].items()
    )
    outputs = ((f"`{name}`", one["description"]) for name, one in plan["outputs"].items())
    return {
        "action-inputs": _table(("input", "default", "meaning"), inputs),
        "action-outputs": _table(("output", "meaning"), outputs),
    }


def _options(defaults: dict[str, object]) -> str:
    return " ".join(f"`+{name}={value}`" for name, value in defaults.items())


def _listed(command: str) -> dict[str, list[dict[str, Any]]]:
    """Return what a command that lists something prints with ``--json``."""
    from worldgen.cli.main import cli

    listed: dict[str, list[dict[str, Any]]] = json.loads(
        CliRunner().invoke(cli, [command, "--json"]).stdout
    )
    return listed


def _table(heads: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a table in Markdown."""
    lines = [heads, *rows]
    texts = [
        f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |" for line in lines
    ]
    columns = texts[0].count("|") - 1
    return "\n".join([texts[0], f"|{' --- |' * columns}", *texts[1:]]) + "\n"


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
    """Return a command's help without the options that every command has."""
    context = click.Context(
        command,
        info_name=name.rsplit(" ", 1)[-1],
        parent=parent,
        terminal_width=WIDTH,
        max_content_width=WIDTH,
    )
    return _EVERY_COMMAND.sub("", command.get_help(context))


def _fenced(text: str) -> str:
    return f"```text\n{text}\n```"

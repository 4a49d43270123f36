"""``worldgen compose``: make worlds from a recipe, with its own options."""

from __future__ import annotations

import click


class _Recipes(click.Group):
    """A group whose commands are recipes, each with its own parameters."""

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return the command of a recipe."""
        from worldgen.cli.family_command import family_command
        from worldgen.errors import InvalidParameter

        if cmd_name.startswith("-"):
            return None
        if not cmd_name.endswith(".toml"):
            raise InvalidParameter(
                "wrong-suffix",
                "{file}: a recipe's name ends in .toml",
                "rename it, or choose another file",
                file=cmd_name,
            )
        return family_command(cmd_name)

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return None, because any file may be a recipe."""
        return []


EXAMPLES = (
    "\b\n  worldgen compose recipe.toml --seed 7 --out w.grid\n  worldgen compose recipe.toml "
    "--help\n"
    "  worldgen compose recipe.toml --count 20 --out worlds/\n\n"
    "RECIPE --help lists the recipe's own parameters. docs/howto/compose.md explains recipes."
)


@click.group(
    cls=_Recipes,
    epilog=EXAMPLES,
    subcommand_metavar="RECIPE [OPTIONS]",
    context_settings={"help_option_names": ["-h", "--help"]},
)
def compose() -> None:
    """Make worlds from parts with a recipe, such as a trap in a maze.

    RECIPE is a TOML file; its parameters are options, like those of a family.
    """

"""Faults of a command line that click has no error for; ``mending`` mends them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import click


class ExtraWords(click.UsageError):
    """A command got more words than it has arguments."""

    def __init__(self, words: Sequence[str], context: click.Context) -> None:
        super().__init__(f"unexpected {' '.join(words)!r}", context)
        self.words = list(words)


class GivenTwice(click.UsageError):
    """An option that takes one value was given twice."""

    def __init__(self, option: click.Parameter, flag: str, context: click.Context) -> None:
        several = "; worldgen compare runs several" if flag == "--controller" else ""
        super().__init__(f"{flag} is given twice; give it once{several}", context)
        self.option = option


class UnknownCommand(click.UsageError):
    """No command has this name."""

    def __init__(self, name: str, known: Iterable[str], context: click.Context) -> None:
        super().__init__(f"no command is called {name!r}", context)
        self.name = name
        self.known = list(known)


class Instead(click.UsageError):
    """A word of the command is refused by a command that knows what to write instead.

    Args:
        message: What came, and the rule.
        came: The word.
        meant: What to write; empty to drop the option of this name, with its value.
    """

    def __init__(
        self, message: str, came: str, meant: str = "", context: click.Context | None = None
    ) -> None:
        super().__init__(message, context or click.get_current_context())
        self.came = came
        self.meant = meant


def missing(name: str, why: str) -> click.MissingParameter:
    """Return the error for an option that the running command needs under a condition.

    Args:
        name: Name of its parameter.
        why: The condition, such as ``--count 3 writes several files``.
    """
    context = click.get_current_context()
    option = next(one for one in context.command.params if one.name == name)
    return click.MissingParameter(why, ctx=context, param=option)


class ConditionalCommand(click.Command):
    """A command some of whose options are required under a condition.

    Args:
        needs: By name of the parameter, a function that takes all values by name and returns why it
            is needed; empty if it is not.
    """

    def __init__(
        self, *arguments: Any, needs: Mapping[str, Callable[[dict[str, Any]], str]], **settings: Any
    ) -> None:
        super().__init__(*arguments, **settings)
        self._needs = needs

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Refuse a command without an option that it needs."""
        rest = super().parse_args(ctx, args)
        for name, why in self._needs.items():
            reason = "" if ctx.params.get(name) or ctx.resilient_parsing else why(ctx.params)
            if reason:
                option = next(one for one in self.params if one.name == name)
                raise click.MissingParameter(reason, ctx=ctx, param=option)
        return rest

"""The message about a name that does not exist, which suggests the nearest one that does."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Any

from worldgen.errors import Message

# Names longer than this are not compared, because that takes quadratic time.
_LONGEST = 200


def nearest(name: str, names: Iterable[str]) -> str:
    """Return the name that a misspelt one means; empty if none is near.

    Case, underscores and a plural make no difference.
    """
    plain = {_plain(one): one for one in names}
    key = _plain(name)
    for other in (key, key.removesuffix("s"), f"{key}s"):
        if other in plain:
            return plain[other]
    close = difflib.get_close_matches(key, plain, n=1) if len(name) <= _LONGEST else []
    return plain[close[0]] if close else ""


def _plain(name: str) -> str:
    return name.casefold().replace("_", "-").strip("-")


def unknown_name(
    problem: str, name: str, known: Iterable[str], remedy: str = "known: {known!l}", **facts: Any
) -> Message:
    """Return the message; its facts are ``name``, ``near`` (empty if none is near) and ``known``.

    Args:
        problem: Template of the problem: ``"no key is called {name!q}"``.
        name: The name.
        known: The names that exist.
        remedy: Template of the remedy, after the suggestion.
        facts: Further facts.
    """
    names = list(known)
    near = nearest(name, names)
    suggestion = "did you mean {near!r}? " if near else ""
    given = {"name": name, "near": near, "known": names, **facts}
    return Message("unknown-name", problem, suggestion + remedy, **given)

"""File names for failures: valid on every file system, and different for different classes."""

from __future__ import annotations

import hashlib
import re

from fuzz.corpus.entry import Facts

__all__ = ["name_of"]

_MOST = 80  # characters of a name that come from the text itself
_DIGITS = 8  # hex digits of the digest that follows a shortened name


def name_of(facts: Facts, number: int = 1) -> str:
    """Return a path without suffix, such as ``turn-right/swept/loop-1bump-end-turn-near-away``.

    Further failures of the same class get ``~2`` and so on appended.
    """
    controller, motion, bucket = (_plain(word) for word in facts.key)
    return f"{controller}/{motion}/{bucket}" + (f"~{number}" if number > 1 else "")


def _plain(text: str) -> str:
    """Return the text if it is a valid file name, else a shortened form and a digest."""
    plain = re.sub(r"[^A-Za-z0-9._+=-]+", "-", text).strip(".-")[:_MOST]
    if plain and plain == text:
        return text
    digest = hashlib.sha256(text.encode(errors="surrogatepass")).hexdigest()[:_DIGITS]
    return f"{plain}-{digest}" if plain else digest

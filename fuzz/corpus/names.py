"""Names of failures: fit for every file system and archive, different for different classes."""

from __future__ import annotations

import hashlib
import re

from fuzz.corpus.entry import Facts

__all__ = ["name_of"]

_MOST = 80  # characters of a name that come from the text itself
_DIGITS = 8  # hex, of the digest behind a name that says less than the text


def name_of(facts: Facts, number: int = 1) -> str:
    """``turn-right/swept/loop-1bump-end-turn-near-away``, a path without ending.

    Others of the class have ``~2`` behind it.
    """
    controller, motion, kind = (_plain(word) for word in facts.key)
    return f"{controller}/{motion}/{kind}" + (f"~{number}" if number > 1 else "")


def _plain(text: str) -> str:
    """The text, if it can be a file's name; else what can be of it, and a digest."""
    plain = re.sub(r"[^A-Za-z0-9._+=-]+", "-", text).strip(".-")[:_MOST]
    if plain and plain == text:
        return text
    digest = hashlib.sha256(text.encode(errors="surrogatepass")).hexdigest()[:_DIGITS]
    return f"{plain}-{digest}" if plain else digest

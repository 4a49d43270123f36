"""Style sheets and ``style`` attributes of SVG: which properties they give to what.

Source: W3C, "CSS Syntax Module Level 3", 2021.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

INHERITED = (
    "fill", "stroke", "stroke-width", "fill-opacity", "stroke-opacity", "fill-rule",
    "stroke-linecap", "stroke-linejoin", "stroke-miterlimit", "visibility", "color", "clip-rule",
)  # fmt: skip
PROPERTIES = frozenset({
    *INHERITED, "display", "opacity", "clip-path", "mask", "marker", "marker-start", "marker-mid",
    "marker-end", "transform", "stroke-dasharray", "vector-effect", "transform-origin",
})  # fmt: skip
# A word in quotes, an address or a comment of CSS; the end of the text closes an open one.
_CSS_WORD = re.compile(
    r"""(?s)(?P<word>"(?:[^"\\\n]|\\.)*+"?|'(?:[^'\\\n]|\\.)*+'?|url\(\s*+[^"'()\s]++)"""
    r"""|/\*.*?(?:\*/|\Z)|<!--|-->"""
)
_CSS_SIGN = re.compile(r"[{};,!@]|/\*")
_CSS_TOKEN = re.compile(r"[{};]|[^{};]+")


def css_rules(text: str) -> Iterator[tuple[str, str]]:
    """Yield what is before the braces of each rule of a style sheet, and what is in them.

    A rule such as ``@import``, which has no braces, has no body.
    """
    before: list[str] = []
    body: list[str] = []
    depth = 0
    for token in _CSS_TOKEN.findall(_without_css_comments(text)):
        is_end = token == "}" and depth == 1
        if token == ";" and not depth and before:
            is_end = before[0].lstrip().startswith("@")
        if is_end:
            yield "".join(before).strip(), "".join(body)
            before, body, depth = [], [], 0
        elif token == "{" and not depth:
            depth = 1
        else:
            (body if depth else before).append(token)
            if depth and token in "{}":
                depth += 1 if token == "{" else -1
    # The end of the sheet closes what is open.
    if before:
        yield "".join(before).strip(), "".join(body)


def _without_css_comments(text: str) -> str:
    """Return CSS without comments, and without words whose signs would look like CSS."""

    def kept(found: re.Match[str]) -> str:
        word = found["word"] or ""
        return '""' if _CSS_SIGN.search(word) else word

    return _CSS_WORD.sub(kept, text)


def declarations(text: str) -> tuple[dict[str, str], dict[str, str]]:
    """Return the properties of a style that matter here, and those that are ``!important``."""
    values: dict[str, str] = {}
    important: dict[str, str] = {}
    for word in _without_css_comments(text).split(";"):
        name, colon, value = word.partition(":")
        name = name.strip().lower()
        if colon and name in PROPERTIES:
            value, mark, _ = value.partition("!")
            (important if mark else values)[name] = value.strip()
    return values, important

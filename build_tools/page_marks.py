"""Write the marks of all pictures for the pages: a style with the colours, and a module with the rest.

``python -m build_tools.page_marks`` writes ``marks.css`` and ``picture/marks.js`` in
``fuzz/player/page`` from ``worldgen/render/marks.json``.
"""

from __future__ import annotations

import json
from pathlib import Path

import msgspec

from worldgen.render.marks import SPECIFICATION

_PAGE = Path(__file__).parents[1] / "fuzz/player/page"
STYLE = _PAGE / "marks.css"
MODULE = _PAGE / "picture/marks.js"
_HEAD = "Written by `python -m build_tools.page_marks` from worldgen/render/marks.json; not edited."


def page_style() -> str:
    """Return the text of the style."""
    light, dark = (
        " ".join(f"--{name}: {hues[theme]};" for name, hues in SPECIFICATION.colours.items())
        for theme in (0, 1)
    )
    verdicts = [
        f'[data-verdict="{verdict}"] {{ --verdict: var(--{colour}); }}'
        for verdict, (colour, _) in SPECIFICATION.verdicts.items()
    ]
    themes = [
        f":root {{ {light} color-scheme: light; }}",
        f':root[data-theme="dark"] {{ {dark} color-scheme: dark; }}',
    ]
    return "\n".join([f"/* {_HEAD} */", *themes, *verdicts, ""])


def page_module() -> str:
    """Return the text of the module."""
    marks = {
        name: {key: value for key, value in msgspec.to_builtins(mark).items() if key != "label"}
        | {"label": mark.label}
        for name, mark in SPECIFICATION.marks.items()
    }
    rows = ",\n".join(f"  {json.dumps(name)}: {json.dumps(mark)}" for name, mark in marks.items())
    signs = {verdict: sign for verdict, (_, sign) in SPECIFICATION.verdicts.items()}
    robots = sum(name.startswith("robot-") for name in SPECIFICATION.colours)
    card = msgspec.to_builtins(SPECIFICATION.card)
    return f"""\
// {_HEAD}

/** By name, the lowest first. @type {{Record<string, MarkLook>}} */
export const MARKS = {{
{rows},
}};

/** Names of the marks in a legend, in its order. @type {{string[]}} */
export const LEGEND = {json.dumps(SPECIFICATION.legend)};

/** What a small picture shows of a large world. */
export const CARD = {json.dumps(card)};

/** Signs of the verdicts. @type {{Record<string, string>}} */
export const SIGNS = {json.dumps(signs, ensure_ascii=False)};

/** Number of colours of robots. */
export const ROBOTS = {robots};
"""


if __name__ == "__main__":
    STYLE.write_text(page_style(), "utf-8")
    MODULE.write_text(page_module(), "utf-8")

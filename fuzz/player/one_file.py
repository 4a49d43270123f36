"""A page in one file: text, style, script and data, and nothing that a browser could load from elsewhere."""

from __future__ import annotations

import base64
import hashlib
import html
import json
from importlib.resources import files
from typing import Any

from fuzz.player.sources import script, style

__all__ = ["one_file"]


def one_file(body: str, title: str, *, styles: str, scripts: str, data: dict[str, Any]) -> bytes:
    """The page, which lets a browser run this very script and use this style, and load nothing at all.

    Args:
        body: What the page shows, as HTML; ``@@TITLE@@`` in it is the title.
        title: Of the page, as plain text.
        styles: CSS beside the player's.
        scripts: JavaScript after the player's, in one scope with it.
        data: What the script reads as JSON.
    """
    styles = style() + styles
    scripts = "(() => {\n'use strict';\n" + script() + "\n" + scripts + "\n})();\n"
    filled = {
        "POLICY": "default-src 'none'; base-uri 'none'; form-action 'none'; img-src data:; "
        f"script-src {_source(scripts)}; style-src {_source(styles)}",
        "TITLE": html.escape(title.encode("utf-8", "replace").decode("utf-8")),
        "STYLE": styles,
        "SCRIPT": scripts,
        "DATA": json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c"),
    }
    template = (files("fuzz.player") / "one_file.html").read_text("utf-8").replace("@@BODY@@", body)
    return "".join(filled.get(piece, piece) for piece in template.split("@@")).encode("utf-8")


def _source(text: str) -> str:
    """How the policy names a script or style of the page: by its SHA-256."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode('utf-8')).digest()).decode('ascii')}'"
